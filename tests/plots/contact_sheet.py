"""Every kind of picture of every kind of subject, in one folder and on contact sheets: to be looked at.

    python -m tests.plots.contact_sheet FOLDER [--only WORD] [--grey]

Subjects are made once and kept in FOLDER/results. Sheets, of 400 pixels to a column,
are FOLDER/sheet-<subject>-<n>.png.
"""

from __future__ import annotations

import argparse
import shlex
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from PIL import Image, ImageDraw

from vibsim.plots.picture import draw_files
from vibsim.plots.registry import choose
from vibsim.plots.subject import WIDTHS_CM, PlotError, View, open_subjects

RUNS = {  # subject: arguments of `vibsim run`
    "ideal-stop": "I-C --t-end 30s",
    "motor-stop": "II-B --t-end 30s",
    "no-stop-no-friction": "I-B -s stop=none -s friction=none --t-end 20s",
    "motor-no-stop": "II-B -s stop=none --t-end 20s",
    "ramp": "II-B -s c=0.03 --ramp Omega0=3:7:3Hz --over 200s",
    "base": "gallery/cantilever --t-end 10s",
    "rigid-stops": "gallery/impact-oscillator --t-end 60s",
    "impact-damper": "gallery/impact-damper --t-end 30s",
    "free-ball": "gallery/impact-pair",
    "friction": "gallery/friction-oscillator --t-end 100s",
    "belt": "gallery/belt-oscillator --t-end 60s",
    "formula": "gallery/duffing-two-well --t-end 300s",
    "free-formula": "gallery/duffing-hardening",
    "rotors": "gallery/two-exciters",
    "states": "gallery/captured-motor",
    "torsional": "gallery/driven-pendulum",
    "gears": "gallery/gear-pair",
    "pendulum-on-cart": "gallery/pendulum-on-cart",
    "many-bodies": "gallery/coupled-clutches",
    "chain": "gallery/chain-with-gaps",
    "capsule": "gallery/drifting-capsule --t-end 10s",
    "drill": "gallery/percussive-drill --t-end 5s",
    "stack": "gallery/stack-of-blocks --t-end 10s",
    "drop": "gallery/two-balls-and-a-spring",
    "stuck": "cases/hard/held-by-friction.yaml",
}
UP_DOWN = "--direction both --carry-state"
OTHERS = {  # subject: arguments of vibsim, without the output file
    "speeds": "sweep II-B --omega0 3:7:0.1 --t-end 60s --compute power,regime,capture",
    "up-down": f"sweep II-B --omega0 3:7:0.1 --param c=0.01,0.05 {UP_DOWN} --t-end 60s --compute power",
    "frequencies": f"sweep I-A -s c=0.05 --omega 2:8:0.1 {UP_DOWN} --t-end 40s --compute power",
    "nine-values": "sweep I-A --omega 3:7:0.1 --param c=0.01:0.09/9 --t-end 30s",
    "exponents": "sweep I-A --omega 3:7:0.1 --t-end 60s --compute lyapunov,orbit",
    "map": "sweep II-B --omega0 3:7:0.5 --param c=0.01,0.02,0.05,0.1 --t-end 60s --compute capture,regime",
    "ratio-map": "sweep II-B --omega0 3:7:0.5 --param k2='log 1e3:1e6/7N/m' --t-end 40s --compute regime",
    "ensemble": "sweep II-B --omega0 5.5:6.1:0.1 --ensemble 20 --seed 1 --spread phi=0:360deg -s c=0.03 "
    "--t-end 60s --compute capture,power",
    "basin": "sweep gallery/cantilever --param tip.x=-5:5/21mm --param tip.v=-500:500/21mm/s --section 0 "
    "--compute attractor",
    "end-states": "sweep gallery/belt-oscillator --param belt.belt=1,1.5,1.8m/s --ensemble 40 --spread "
    "block.x=-2:2m --spread block.v=0:2m/s --t-end 300s --discard 200s --section 0 --compute end-state",
    "starts": "sweep gallery/belt-oscillator -s belt.belt=1.5m/s --ensemble 200 --spread "
    "block.x=-2:2m --spread block.v=0:2m/s --t-end 300s --discard 200s --section 0 --compute end-state",
    "duffing-sweep": f"sweep gallery/ueda-oscillator --param drive.A=5:8/60N {UP_DOWN} --t-end 300s",
    "oscillator-sweep": f"sweep gallery/impact-oscillator --omega 0.42:0.7:0.005 {UP_DOWN} --t-end 200s",
    "damper-sweep": "sweep gallery/impact-damper --param left.k=right.k=10:50/5kN/m",
    "orbit": "orbit I-A",
    "motor-orbit": "orbit II-B -s c=0.03 -s Omega0=5Hz",
    "motor-branch": "continue II-B -s c=0.03 -s Omega0=5Hz --omega0 3:9",
    "ideal-branch": "continue I-A -s c=0.05 --omega 2:8 --max-points 400",
    "oscillator-branch": "continue gallery/impact-oscillator --omega 0.42:0.7 --max-points 300",
    "backbone": "continue I-A -s excitation=none -s c=0 -s friction=none -s x1=5mm --energy 1e-5:0.1 "
    "--max-points 300",
    "fit": "fit II-B --t-end 60s --want captured --free c='log 0.003:0.1' --free k2='log 5000:20000' "
    "--ensemble 2 --candidates 32 --confirm 1 --fresh 4",
    "bench": "bench I-C --t-end 5s --methods closed-form,taylor,dop853,lsoda",
}
LOCI = {"locus": ("motor-branch", "F1 --param c=0.02:0.05 --max-points 60")}
TOGETHER = {  # sheets of several files over each other, and the kinds
    "two-runs": (("ideal-stop", "motor-stop"), None),
    "branch-over-sommerfeld": (("up-down", "motor-branch"), ("sommerfeld",)),
    "branch-over-amplitude": (("frequencies", "ideal-branch"), ("amplitude", "orbit")),
    "branch-over-orbits": (("oscillator-sweep", "oscillator-branch"), ("amplitude", "orbit")),
    "motor-branch-over-all": (("speeds", "motor-branch"), ("amplitude", "orbit")),
    "run-up-over-sweep": (("ramp", "up-down"), ("run-up",)),
    "locus-over-map": (("map", "locus"), ("capture",)),
    "two-branches": (("motor-branch", "motor-branch"), ("branch",)),
}
CASES = ("I-C", "II-B", "gallery/duffing-two-well", "gallery/impact-damper", "gallery/driven-pendulum")
THUMB = {"column": 400, "page": 810}  # pixels across
SHEET = 1640, 1700  # width, and height at which another sheet begins
MARGIN, HEADING = 10, 20


def make(folder: Path, name: str, arguments: str) -> str:
    """The result file of a subject, made once."""
    path = folder / "results" / f"{name}.h5"
    if not path.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        words = [sys.executable, "-m", "vibsim", "-q", *shlex.split(arguments), "-o", str(path)]
        done = subprocess.run(words, capture_output=True, text=True)
        if not path.exists():
            print(f"{name}: {arguments}: {done.stderr.strip()}")
    return str(path)


def pictures(folder: Path, name: str, paths: Sequence[str], kinds: Sequence[str] | None) -> list[Path]:
    """All kinds of pictures that fit the files together, at both widths."""
    drawn = []
    if kinds is None:
        kinds = [kind.name for kind in choose(["all"], open_subjects(paths))]
    for kind in kinds:
        for width in WIDTHS_CM:
            target = folder / name / f"{kind}-{width}.png"
            target.parent.mkdir(parents=True, exist_ok=True)
            try:
                draw_files(paths, [kind], View(width=width), str(target), force=True)
                drawn.append(target)
            except PlotError as error:
                print(f"{name} {kind} {width}: {error}")
    return drawn


def sheets(paths: Sequence[Path], stem: str, grey: bool) -> None:
    """Sheets of the pictures, those of one width at the same scale, their names above them."""
    columns = SHEET[0] // (THUMB["column"] + MARGIN)
    heights = [0] * columns
    page, count = _page(), 0
    for path in paths:
        picture = Image.open(path).convert("L" if grey else "RGB").convert("RGB")
        wide = path.stem.endswith("page")
        width = THUMB["page" if wide else "column"]
        picture = picture.resize(
            (width, round(picture.height * width / picture.width)), Image.Resampling.LANCZOS
        )
        needed = 2 if wide else 1
        starts = range(columns - needed + 1)
        at = min(starts, key=lambda i: (max(heights[i : i + needed]), i))
        y = max(heights[at : at + needed])
        if y + picture.height > SHEET[1] and y:
            page.crop((0, 0, SHEET[0], max(heights))).save(f"{stem}-{count}.png")
            page, count, heights, at, y = _page(), count + 1, [0] * columns, 0, 0
        x = at * (THUMB["column"] + MARGIN)
        ImageDraw.Draw(page).text((x + 4, y + 2), f"{path.parent.name}/{path.stem}", "red", font_size=12)
        page.paste(picture, (x, y + HEADING))
        heights[at : at + needed] = [y + picture.height + HEADING + MARGIN] * needed
    page.crop((0, 0, SHEET[0], max(max(heights), 1))).save(f"{stem}-{count}.png")


def _page() -> Image.Image:
    return Image.new("RGB", (SHEET[0], 3 * SHEET[1]), "white")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--only", default="")
    parser.add_argument("--grey", action="store_true")
    chosen = parser.parse_args()
    commands = {name: f"run {arguments}" for name, arguments in RUNS.items()} | OTHERS
    commands |= {
        name: f"continue {chosen.folder / 'results' / branch}.h5 --locus {arguments}"
        for name, (branch, arguments) in LOCI.items()
    }
    subjects = {name: ((name,), None) for name in commands} | TOGETHER
    subjects |= {f"case-{case.rpartition('/')[2]}": ((case,), None) for case in CASES}
    for name, (parts, kinds) in subjects.items():
        if chosen.only and not any(word in name for word in chosen.only.split(",")):
            continue
        paths = [make(chosen.folder, part, commands[part]) if part in commands else part for part in parts]
        try:
            drawn = pictures(chosen.folder, name, paths, kinds)
        except Exception as error:  # one that cannot be drawn: said, and on to the next
            print(f"{name}: {error!r}")
            continue
        if drawn:
            sheets(drawn, str(chosen.folder / f"sheet-{name}"), chosen.grey)


if __name__ == "__main__":
    main()
