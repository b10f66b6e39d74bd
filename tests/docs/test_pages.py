"""Commands on README and the pages run as printed, and print what is shown to the last digit, but for times
and sizes of files.
"""

import ast
import re
import shlex
import shutil
from pathlib import Path

import pytest

import vibsim
from tests.command_line.made import call
from tests.docs.pages import PAGES, README, ROOT, WRITTEN, blocks, commands, files, name_of
from tests.docs.reading_ease import measure

VARIES = re.compile(r"\([\d.]+ [kM]?B\), [\d.]+ s$|(?<=within their bounds )\([\d.]+ s\)$")
INVALID_CASE = 3
WITH_COMMANDS = [path for path in PAGES if any(command.startswith("vibsim") for command, _ in commands(path))]
IN_AN_EMPTY_FOLDER = [README, ROOT / "docs" / "start.md"]  # as somebody who has installed it begins
LONG = {
    "run-up", "base-and-stop", "study", "formulas", "motor", "sections-and-diagrams", "sweeps",
    "sweep-and-resume", "orbits-and-branches",
}  # fmt: skip
WITH_PYTHON = [path for path in PAGES if blocks(path, "python")]


def lasting(lines):
    """The lines without what differs by machine: sizes of files, and how long a command took."""
    return [VARIES.sub("", line) for line in lines]


def run(command):
    """Run one `vibsim` command of a page here; its lines of output, both streams."""
    _, *words = shlex.split(command)
    done = call(*words)
    assert done.exit_code == (INVALID_CASE if "wrong" in command else 0), f"{command}\n{done.output}"
    return done.output.splitlines()


def test_pages_with_commands_are_tested():
    names = {name_of(path) for path in WITH_COMMANDS}
    assert {"README.md", "docs/start.md", "docs/tutorials/own-case.md", "docs/tutorials/trust.md"} <= names


def marked(path):
    """Pages whose commands take long are run by `make verify`, and when the site is built."""
    return pytest.param(path, marks=pytest.mark.slow if path.stem in LONG else (), id=name_of(path))


@pytest.mark.parametrize("path", [marked(path) for path in WITH_COMMANDS])
def test_the_commands_run_as_printed(path, here):
    if path not in IN_AN_EMPTY_FOLDER:
        shutil.copytree(ROOT / "cases", here / "cases")
    for name, text in files(path).items():
        (here / name).write_text(text, encoding="utf-8")
    for command, shown in commands(path):
        if command.startswith("vibsim"):
            said = run(command)
            assert lasting(said) == lasting(shown), command
    run_python(path)


@pytest.mark.parametrize("path", [path for path in WITH_PYTHON if path not in WITH_COMMANDS], ids=name_of)
def test_the_python_runs(path, here):
    run_python(path)


def run_python(path):
    """Run the Python blocks of a page one after the other, in one namespace."""
    names = {}
    for code in blocks(path, "python"):
        exec(compile(code, name_of(path), "exec"), names)


@pytest.mark.slow
def test_the_commands_in_the_text_of_readme_run_in_an_empty_folder(here):
    for name, text in files(README).items():
        Path(name).write_text(text, encoding="utf-8")
    run("vibsim run II-B --t-end 20s")
    text = " ".join(re.sub(r"```.*?```", "", README.read_text(encoding="utf-8"), flags=re.DOTALL).split())
    inline = [each for each in re.findall(r"`(vibsim \w+ [^`]+)`", text) if "COMMAND" not in each]
    assert {"vibsim run II-B.h5", "vibsim plot II-B.h5 -o II-B.html", "vibsim run hammer.yaml"} <= set(inline)
    for command in inline:
        run(command)
    again = vibsim.open_result("II-B-again.h5")
    assert again["x1"].tobytes() == vibsim.open_result("II-B.h5")["x1"].tobytes()


def test_make_run_and_make_test_are_shown_and_exist():
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    for target in ("run", "test", "docs"):
        assert f"$ make {target}" in README.read_text(encoding="utf-8")
        assert re.search(rf"^{target}:", makefile, flags=re.MULTILINE)


def test_readme_is_a_newcomers_page():
    """Two screens, two pictures: a machine, and its bifurcation diagram."""
    text = README.read_text(encoding="utf-8")
    assert len(text.splitlines()) <= 92
    assert len(re.findall(r"!\[", text)) == 2


EASY = ["README.md"]
EASY += [f"docs/{name}.md" for name in ("index", "start", "limits", "laws", "scenes", "orbits", "pictures")]
EASY += [f"docs/{name}.md" for name in ("accuracy", "basins", "branches", "engine")]
FIRST_READ = [path for path in PAGES if name_of(path) in EASY or path.parent.name == "tutorials"]


@pytest.mark.parametrize("path", FIRST_READ, ids=name_of)
def test_what_is_read_first_is_easy_to_read(path):
    """Sentences of 20 words at most on average, and one in twenty of more than 30 words."""
    number, words, share = measure(path)
    assert number > 3 and words <= 20 and share <= 0.05


@pytest.mark.parametrize("path", WRITTEN, ids=name_of)
def test_long_pages_begin_with_a_summary_and_have_sections(path):
    """Of more than 1,800 words: a summary of at most 80 words, and sections of at most 1,100."""
    text = path.read_text(encoding="utf-8")
    if len(text.split()) <= 1800:
        return
    first = text.split("\n\n")[1]
    assert first.startswith("**In short.**") and len(first.split()) <= 80
    sections = re.split(r"(?m)^###? ", text)[1:]
    assert len(sections) >= 4
    assert max(len(section.split()) for section in sections) <= 1100


# Penalty, impact, a grazing, a stick phase, reported.
ODD = re.compile(r"\b(blows?|prices?|told|(the|a) graze|a stick|\d sticks?)\b(?! phase)", re.IGNORECASE)


def test_messages_have_the_words_of_mechanics():
    """All texts of the program of several words; names of columns and keys have one."""
    odd = []
    for path in sorted((ROOT / "vibsim").rglob("*.py")):
        nodes = list(ast.walk(ast.parse(path.read_text(encoding="utf-8"))))
        docstrings = {id(node.value) for node in nodes if isinstance(node, ast.Expr)}
        for node in nodes:
            if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in docstrings:
                found = ODD.search(node.value) if " " in node.value.strip() else None
                odd += [f"{path.name} {node.lineno}: {found[0]}"] if found else []
    assert odd == []
