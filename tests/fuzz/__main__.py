"""Mutants of case files, command lines and result files: `python -m tests.fuzz --count 3000 --seed 1`.

A mutant fails that ends in a traceback, a signal or an exit code that its kind does not allow, that goes on
for more than two seconds after Ctrl-C, fails without a word, or sends control characters to the terminal.
What failed stays in the folder of --keep, with its command; the same seed makes the same mutants.
"""

import argparse
import random
import shutil
import sys
import tempfile
from collections import Counter
from pathlib import Path

from tests.fuzz import case_mutants, file_mutants, option_mutants
from tests.fuzz.running import PATIENCE, control_characters, preload, run

INTERRUPTED = {130, -2}  # -2: by the signal itself, which a shell calls 130
CODES = {"case": {0, 3, 4}, "options": {0, 2, 3, 4, 5, 6}, "file": {0, 2, 3, 4, 6}}
ON_CASES = [["check", "case.yaml"], ["run", "case.yaml", "--t-end", "0.2s", "--force", "-o", "out.h5"]]
ON_CASES += [["run", "case.yaml", "--force", "-o", "out.h5"], ["check", "case.yaml", "--json"]]
ON_FILES = [
    "info mutant.h5", "info mutant.h5 --json", "info mutant.h5 --case", "analyse mutant.h5",
    "compare mutant.h5 run.h5", "plot mutant.h5 --list", "plot mutant.h5 -o p.png --force",
    "plot mutant.h5 -o p.html --force", "export mutant.h5 -o out.csv --force",
    "export mutant.h5 --ro-crate -o crate --force", "animate mutant.h5 -o film.html --force",
    "run mutant.h5 --dry-run -o o.h5", "run mutant.h5 --t-end 0.1s -o o.h5", "orbit mutant.h5 -o o.h5",
    "orbit I-A --from mutant.h5 -o o.h5", "continue mutant.h5 --omega0 3:9 --max-points 4 -o o.h5",
    "continue mutant.h5 --switch PD2 --max-points 4 -o o.h5",
    "continue mutant.h5 --locus NS1 --param c=0.02:0.04 --max-points 4 -o o.h5",
]  # fmt: skip
WHOLE = {
    "run": "run II-B --t-end 1s",
    "digits": "run I-A --t-end 0.1s --digits 20",
    "exponents": "run II-B --t-end 2s --lyapunov 2",
    "sweep": "sweep II-B --omega0 3:5:1 --t-end 1s --section 5",
    "ensemble": "sweep II-B --ensemble 3 --compute all --t-end 1s",
    "orbit": "orbit I-A --digits 20",
    "branch": "continue II-B -s c=0.03 -s Omega0=3.8Hz --omega0 3:9 --max-points 80",
    "locus": "continue branch.h5 --locus NS1 --param c=0.02:0.04 --max-points 4",
    "fit": "fit II-B --free J=1:2gm^2 --want captured --t-end 1s --candidates 4 --ensemble 1 --fresh 1",
    "bench": "bench I-A --t-end 0.5s --methods taylor",
}


def main(words=None):
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz", description=__doc__)
    parser.add_argument("--count", type=int, default=3000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--kinds", default="case,options,file")
    parser.add_argument("--patience", type=float, default=PATIENCE)
    parser.add_argument("--keep", type=Path, default=Path("fuzz-failures"))
    options = parser.parse_args(words)
    preload()
    failed = Counter()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (wholes := folder / "whole").mkdir()
        for number in range(options.count):
            kind = options.kinds.split(",")[number % len(options.kinds.split(","))]
            problem = one(f"{options.seed}/{number}", kind, folder / "scratch", wholes, options)
            if problem:
                failed[kind] += 1
                print(f"{kind} {options.seed}/{number}: {problem}", flush=True)
    print(f"{options.count} mutants, {sum(failed.values())} failed")
    return 1 if failed else 0


def with_wholes(words, wholes, folder):
    """The words; the whole files that they name are put into the folder, made when they are named first."""
    for name in [each for each in WHOLE if f"{each}.h5" in words]:
        if not (wholes / f"{name}.h5").exists():
            command = with_wholes(WHOLE[name].split(), wholes, wholes)
            outcome = run([*command, "-o", f"{name}.h5"], wholes, limit=1200)
            if outcome.code:
                raise SystemExit(f"{WHOLE[name]}: {outcome.stderr}")
        if folder != wholes:
            shutil.copy(wholes / f"{name}.h5", folder)
    return words


def case_files():
    return sorted((Path(__file__).parents[2] / "cases").rglob("*.yaml"))


def one(seed, kind, scratch, wholes, options):
    """Make a mutant and run a command on it; what is wrong with how it ended, or None."""
    draw = random.Random(f"{seed}/{kind}")
    shutil.rmtree(scratch, ignore_errors=True)
    scratch.mkdir()
    words = MAKERS[kind](draw, scratch, wholes)
    outcome = run(words, scratch, patience=options.patience)
    problem = judged(outcome, CODES[kind], options.patience)
    if problem:
        kept = options.keep / f"{kind}-{seed.replace('/', '-')}"
        shutil.rmtree(kept, ignore_errors=True)
        shutil.copytree(scratch, kept)
        (kept / "words").write_text(repr(words))
        return f"{problem}: {words!r}"
    return None


def judged(outcome, codes, patience):
    """What is wrong with an outcome, in words; None where nothing is."""
    last = outcome.stderr.strip().rpartition("\n")[2]
    swallowed = (
        outcome.ending is not None and "Exception ignored" in outcome.stderr
    )  # by Python, in a callback
    if "Traceback" in outcome.stderr and not swallowed:
        return f"traceback, {last}"
    if outcome.ending is not None:
        ended = outcome.ending <= patience and outcome.code in INTERRUPTED | codes
        return None if ended else f"{outcome.ending:.1f} s to end after SIGINT, code {outcome.code}"
    if outcome.code not in codes:
        return f"exit code {outcome.code}, {last}"
    if outcome.code and not (last or outcome.stdout):
        return f"exit code {outcome.code} without a word"
    if found := control_characters(outcome.stdout + outcome.stderr):
        return f"control characters {sorted(found)!r}"
    return None


def of_a_case(draw, scratch, wholes):
    source = draw.choice(case_files())
    (scratch / "case.yaml").write_bytes(case_mutants.mutant(source.read_text(encoding="utf-8"), draw))
    return draw.choice(ON_CASES)


def of_options(draw, scratch, wholes):
    shutil.copy(case_files()[0], scratch / "case.yaml")
    return with_wholes(option_mutants.mutant(draw), wholes, scratch)


def of_a_file(draw, scratch, wholes):
    """A command on a mutant, or the one that made the file, once more: it may go on from what is there."""
    name = draw.choice(list(WHOLE))
    with_wholes([f"{name}.h5"], wholes, scratch)
    file_mutants.mutant(scratch / f"{name}.h5", scratch / "mutant.h5", draw)
    again = f"{WHOLE[name]} -o mutant.h5"
    words = again if draw.random() < 0.1 else draw.choice(ON_FILES)
    return with_wholes(words.split(), wholes, scratch)


MAKERS = {"case": of_a_case, "options": of_options, "file": of_a_file}

if __name__ == "__main__":
    sys.exit(main())
