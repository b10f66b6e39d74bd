"""Files that are not there, or must not be read: one rule for every argument and option that takes one."""

import builtins
import errno
import os
from pathlib import Path

import click
import h5py
import pytest

import vibsim
from tests.command_line.made import call
from vibsim.command_line.main import group
from vibsim.command_line.options import FILE, CaseSource

CASE_MISSING, RESULT_MISSING, NO_STYLE = 3, 6, 2
EITHER = {"gone.yaml": CASE_MISSING, "gone": CASE_MISSING, "gone.h5": RESULT_MISSING}
CASES = dict.fromkeys(EITHER, CASE_MISSING)
RESULTS = dict.fromkeys(EITHER, RESULT_MISSING)
STYLES = dict.fromkeys(EITHER, NO_STYLE)

# (command, parameter): what it takes, and command lines that read it
INPUTS = {
    ("run", "sources"): (EITHER, ["run {}"]),
    ("sweep", "source"): (EITHER, ["sweep {} --omega0 3,4"]),
    ("orbit", "source"): (EITHER, ["orbit {}", "orbit {} --search 2"]),
    ("edge", "source"): (EITHER, ["edge {} --between a.h5,a.h5"]),
    ("orbit", "start"): (RESULTS, ["orbit I-A --from {}"]),
    ("continue", "source"): (
        EITHER,
        [
            "continue {} --omega0 3:9",
            "continue {} --energy 1:2",
            "continue {} --switch PD1",
            "continue {} --locus NS1 --param c=0.1:0.2",
        ],
    ),
    ("fit", "sources"): (EITHER, ["fit {} --want captured"]),
    ("plot", "files"): (EITHER, ["plot {} -o a.png", "plot {} -o a.html"]),
    ("plot", "sheet"): (STYLES, ["plot II-B --kind stiffness -o a.png --style {}"]),
    ("animate", "file"): (EITHER, ["animate {} -o a.gif"]),
    ("info", "files"): (RESULTS, ["info {}", "info {} --case"]),
    ("analyse", "sources"): (EITHER, ["analyse {}"]),
    ("bench", "source"): (EITHER, ["bench {}"]),
    ("bench", "truth"): (RESULTS, ["bench I-A --truth {}"]),
    ("compare", "a"): (RESULTS, ["compare {} a.h5"]),
    ("compare", "b"): (RESULTS, ["compare a.h5 {}"]),
    ("export", "file"): (RESULTS, ["export {} -o a.csv"]),
    ("new", "source"): (CASES, ["new a --from {}"]),
    ("cases", "names"): (CASES, ["cases {}", "cases {} --resolved", "cases {} --draw"]),
    ("check", "sources"): (CASES, ["check {}"]),
}
OUTPUTS = {"output", "out", "picture", "folder"}
LINES = [(line, takes) for takes, lines in INPUTS.values() for line in lines]


def _names_a_file(parameter):
    words = f"{parameter.metavar or ''}"
    is_file = isinstance(parameter.type, CaseSource | click.Path) or "FILE" in words or "CASE" in words
    return is_file or parameter.type is FILE


def test_every_parameter_that_takes_a_file_is_in_the_table():
    ctx = click.Context(group)
    files = {
        (command, parameter.name)
        for command in group.list_commands(ctx)
        for parameter in group.get_command(ctx, command).params
        if _names_a_file(parameter) and parameter.name not in OUTPUTS
    }
    assert files - {("new", "name")} == set(INPUTS)  # of `new` NAME is what it writes


@pytest.fixture(scope="module")
def stored(tmp_path_factory):
    """A run that is there, for commands that read two."""
    path = tmp_path_factory.mktemp("runs") / "a.h5"
    vibsim.simulate("I-A", trust=False, overrides={"run.t_end": "1 s"}).save(path)
    return path


@pytest.mark.parametrize(("line", "takes"), LINES, ids=[line for line, _ in LINES])
def test_a_missing_file_ends_by_what_is_asked_for(stored, tmp_path, monkeypatch, line, takes):
    monkeypatch.chdir(tmp_path)
    Path("a.h5").symlink_to(stored)
    for name, code in takes.items():
        done = call(*line.format(name).split())
        told = done.stderr + done.stdout
        assert (done.exit_code, name in told) == (code, True), told
        if name == "gone.h5" and code == RESULT_MISSING:
            assert told == "Error: gone.h5: No such file or directory\n"
        assert [path.name for path in Path().iterdir()] == ["a.h5"]


@pytest.fixture
def unreadable(stored, tmp_path, monkeypatch):
    """A folder with a run and a style sheet that this user must not read; root may read everything."""
    monkeypatch.chdir(tmp_path)
    Path("a.h5").write_bytes(stored.read_bytes())
    Path("a.mplstyle").write_text("lines.linewidth: 3")
    access, opened = os.access, builtins.open

    def may(path, mode, **options):
        return mode != os.R_OK and access(path, mode, **options)

    def refuse(file, mode="r", *more, **options):
        if str(file) in ("a.h5", "a.mplstyle") and "r" in mode and "+" not in mode:
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), file)
        return opened(file, mode, *more, **options)

    monkeypatch.setattr(os, "access", may)
    monkeypatch.setattr(builtins, "open", refuse)
    return tmp_path


READ = [line for (takes, lines) in INPUTS.values() if takes in (EITHER, RESULTS) for line in lines]


@pytest.mark.parametrize("line", READ)
def test_a_result_that_must_not_be_read(unreadable, line):
    done = call(*line.format("a.h5").split())
    assert (done.exit_code, done.stderr) == (6, "Error: a.h5: Permission denied\n")


def test_a_file_to_go_on_with_that_must_not_be_read(unreadable):
    done = call("sweep", "II-B", "--omega0", "3,4", "--t-end", "1s", "-o", "a.h5")
    assert (done.exit_code, done.stderr) == (6, "Error: a.h5: Permission denied\n")


def test_an_output_that_must_not_be_read_is_there_all_the_same(unreadable):
    done = call("run", "I-A", "-o", "a.h5")
    assert (done.exit_code, done.stderr) == (6, "Error: a.h5: exists; kept (--force replaces it)\n")


def test_a_style_sheet_that_must_not_be_read(unreadable):
    done = call("plot", "I-A", "--style", "a.mplstyle", "-o", "a.png")
    said = "a.mplstyle is no style sheet of matplotlib: Permission denied"
    assert (done.exit_code, done.stderr) == (2, f"Error: {said}\n")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (
            "lines.linewidth: many\n",
            "line 1 ('lines.linewidth: many'): Key lines.linewidth: Could not convert",
        ),
        ("font.size: 9\nfoo.bar: 3\n", "Bad key foo.bar in file a.mplstyle, line 2 ('foo.bar: 3')"),
        ("font.size 9\n", "line 1"),
    ],
)
def test_a_style_sheet_of_which_a_part_would_be_left_out(tmp_path, monkeypatch, text, said):
    monkeypatch.chdir(tmp_path)
    Path("a.mplstyle").write_text(text)
    done = call("plot", "I-A", "--style", "a.mplstyle", "-o", "a.png")
    assert done.exit_code == 2 and not Path("a.png").exists()
    assert done.stderr.startswith("Error: a.mplstyle is no style sheet of matplotlib: ")
    assert said in done.stderr and done.stderr.count("\n") == 1


@pytest.mark.parametrize("line", [line for line in READ if "--truth" not in line])  # which is a bench's
def test_a_result_of_a_later_kind_is_named_by_every_command(stored, tmp_path, monkeypatch, line):
    monkeypatch.chdir(tmp_path)
    Path("a.h5").write_bytes(stored.read_bytes())
    with h5py.File("a.h5", "r+") as file:
        file.attrs["vibsim_kind"] = "spiral"
    done = call(*line.format("a.h5").split())
    said = "Error: a.h5: holds a 'spiral', which this vibsim does not read\n"
    assert (done.exit_code, done.stderr) == (6, said)
