"""Pages of which the commands are run: their blocks, their output, and the pictures that they draw.

A build runs the commands of every page that draws something, each page in a folder of its own, and sets each
picture below the block that drew it. What was run stays in `build/pages` until the page or vibsim changes.

    PYTHONPATH=docs python -m from_code.page_runs docs/start.md

brings the output that a page shows up to date.
"""

import hashlib
import json
import os
import re
import shlex
import shutil
import sys
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from click.testing import CliRunner

ROOT = Path(__file__).resolve().parents[2]
STORE = ROOT / "build" / "pages"
PICTURES = (".png", ".gif")
BLOCK = re.compile(r"^```(console|python)\n(.*?)^```$", flags=re.DOTALL | re.MULTILINE)
PRINTED = re.compile(r"\d[\d.,]* (?:ms|s|kB|MB)\b")  # times and sizes, which differ from run to run


def blocks(text: str, language: str) -> list[str]:
    """The code blocks of a language on a page, in order."""
    return re.findall(rf"```{language}\n(.*?)```", text, flags=re.DOTALL)


def commands(block: str) -> list[tuple[str, list[str]]]:
    """(command, lines of output) of a console block, in order."""
    pairs: list[tuple[str, list[str]]] = []
    for line in block.splitlines():
        if line.startswith("$ "):
            pairs.append((line[2:].split("  #")[0].strip(), []))
        else:
            pairs[-1][1].append(line)
    return pairs


def files(text: str) -> dict[str, str]:
    """Name and text of the files that a page shows: YAML blocks whose first line is a comment with a name."""
    named = (re.match(r"# (\S+\.yaml)\n", block) for block in blocks(text, "yaml"))
    return {match[1]: match.string for match in named if match}


def draws(text: str) -> bool:
    """Whether a command or a block of Python on a page draws a picture."""
    lines = [command for block in blocks(text, "console") for command, _ in commands(block)]
    drawn = any(word in line for line in lines for word in (" plot ", " animate ", "--draw", "--plot"))
    return drawn or any("plot" in block for block in blocks(text, "python"))


def output(command: str) -> list[str]:
    """The lines that a `vibsim` command prints, run inside this process; both streams."""
    from vibsim.command_line.main import group

    done = CliRunner().invoke(group, shlex.split(command)[1:], catch_exceptions=False, prog_name="vibsim")
    return str(done.output).splitlines()


# One page.


def run_blocks(text: str) -> Iterator[tuple[list[list[str]], list[str]]]:
    """Run a page's blocks in the current folder, one after the other.

    Yields for each the output of its commands, and the pictures that it left in the folder.
    """
    for name, content in files(text).items():
        Path(name).write_text(content, encoding="utf-8")
    if "matplotlib.pyplot" in sys.modules:
        sys.modules["matplotlib.pyplot"].close("all")  # figures that are not of this page
    names: dict[str, Any] = {}
    before: dict[str, int] = {}
    for number, match in enumerate(BLOCK.finditer(text)):
        printed = []
        if match[1] == "console":
            for command, _ in commands(match[2]):
                printed.append(output(command) if command.startswith("vibsim ") else [])
        else:
            exec(compile(match[2], "page", "exec"), names)
            save_figures(number)
        now = {path.name: path.stat().st_mtime_ns for path in Path().iterdir() if path.suffix in PICTURES}
        yield printed, sorted((name for name in now if now[name] != before.get(name)), key=now.__getitem__)
        before = now


def save_figures(number: int) -> None:
    """Save the figures that a block of Python left open in pyplot."""
    pyplot = sys.modules.get("matplotlib.pyplot")
    for figure in pyplot.get_fignums() if pyplot else ():
        pyplot.figure(figure).savefig(f"python-{number}-{figure}.png", dpi=150)
        pyplot.close(figure)


def run_page(path: Path, folder: Path) -> None:
    """Run a page in a new folder, and keep there what pictures each of its blocks drew."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    shutil.copytree(ROOT / "cases", folder / "cases")
    os.environ["MPLBACKEND"] = "agg"
    here = os.getcwd()
    os.chdir(folder)
    try:
        drawn = [pictures for _, pictures in run_blocks(path.read_text(encoding="utf-8"))]
    finally:
        os.chdir(here)
    for left in folder.iterdir():
        if left.is_dir():
            shutil.rmtree(left)
        elif left.suffix not in PICTURES:
            left.unlink()
    (folder / "drawn.json").write_text(json.dumps(drawn), encoding="utf-8")


# The build.


def setup_page_runs(app: Any) -> None:
    """Run the pages when a build begins, and set the pictures below their blocks when a page is read."""
    app.connect("builder-inited", run_pages)
    app.connect("source-read", place_pictures)


def run_pages(app: Any) -> None:
    """Run all pages that draw something and have changed since they were run, two at a time."""
    docs = Path(app.srcdir)
    version = sources_digest()
    with fresh_processes() as pool:
        running = []
        for path in sorted(docs.rglob("*.md")):
            name = str(path.relative_to(docs).with_suffix(""))
            text = path.read_text(encoding="utf-8")
            if name.startswith("generated/") or not draws(text):
                continue
            folder = STORE / name
            stamp = hashlib.sha256((version + text).encode()).hexdigest()
            running.append((folder, stamp, pool.submit(run_once, path, folder, stamp)))
        for _, _, each in running:
            each.result()


def fresh_processes() -> ProcessPoolExecutor:
    """Two processes that inherit nothing from the build, such as what it logs."""
    return ProcessPoolExecutor(2, mp_context=get_context("spawn"))


def run_once(path: Path, folder: Path, stamp: str) -> None:
    """Run a page unless its folder is of this very page and program; lay its pictures beside the pages."""
    stamped = folder / "stamp"
    if not stamped.exists() or stamped.read_text() != stamp:
        run_page(path, folder)
        stamped.write_text(stamp)
    shown = ROOT / "docs" / "generated" / "pages" / folder.relative_to(STORE)
    shown.mkdir(parents=True, exist_ok=True)
    for picture in folder.iterdir():
        if picture.suffix in PICTURES:
            shutil.copy2(picture, shown / picture.name)


def sources_digest() -> str:
    """A digest of the program and the shipped cases: what a page draws may change with them."""
    digest = hashlib.sha256()
    for folder, ending in (("vibsim", ".py"), ("vibsim/engine", ".c"), ("cases", ".yaml")):
        for path in sorted((ROOT / folder).rglob(f"*{ending}")):
            digest.update(path.read_bytes())
    return digest.hexdigest()


def place_pictures(app: Any, page: str, content: list[str]) -> None:
    """Set below each block the pictures that it drew."""
    listed = STORE / page / "drawn.json"
    if not listed.exists() or not draws(content[0]):
        return
    pictures = iter(json.loads(listed.read_text(encoding="utf-8")))
    content[0] = BLOCK.sub(lambda match: with_pictures(match, page, next(pictures, [])), content[0])


def with_pictures(match: re.Match[str], page: str, pictures: list[str]) -> str:
    """A block, and below it what it drew."""
    caption = "Drawn by the commands above" if match[1] == "console" else "Drawn by the lines above"
    shown = [f"![{caption}: {name}](/generated/pages/{page}/{name})" for name in pictures]
    return "\n\n".join([match[0], *shown])


# Bringing a page up to date.


def refreshed(text: str) -> str:
    """A page with the output that its commands have now; where only times and sizes differ, as it was."""
    ran = iter([printed for printed, _ in run_blocks(text)])
    return BLOCK.sub(lambda match: refreshed_block(match, next(ran)), text)


def refreshed_block(match: re.Match[str], printed: list[list[str]]) -> str:
    if match[1] != "console":
        return match[0]
    lines = iter([line for line in match[2].splitlines() if line.startswith("$ ")])
    new = []
    for (command, shown), now in zip(commands(match[2]), printed, strict=True):
        same = [PRINTED.sub("", line) for line in shown] == [PRINTED.sub("", line) for line in now]
        new += [next(lines), *(shown if same or not command.startswith("vibsim ") else now)]
    return "```console\n" + "\n".join(line.rstrip() for line in new) + "\n```"


if __name__ == "__main__":
    import tempfile

    for argument in sys.argv[1:]:
        target = Path(argument).resolve()
        with tempfile.TemporaryDirectory() as scratch:
            shutil.copytree(ROOT / "cases", Path(scratch) / "cases")
            os.environ["MPLBACKEND"] = "agg"
            os.chdir(scratch)
            target.write_text(refreshed(target.read_text(encoding="utf-8")), encoding="utf-8")
            os.chdir(ROOT)
