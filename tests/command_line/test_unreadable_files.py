"""Files that are there and must not be read: which, why, and the exit code of files, in every command."""

import builtins
import errno
import os
from pathlib import Path

import pytest

import vibsim
from tests.command_line.made import call

COMMANDS = [
    "run a.h5",
    "sweep a.h5 --omega0 3,4",
    "orbit a.h5",
    "orbit I-A --from a.h5",
    "continue a.h5 --omega0 3:9",
    "continue a.h5 --switch PD1",
    "fit a.h5 --want captured",
    "plot a.h5",
    "animate a.h5 -o a.gif",
    "info a.h5",
    "analyse a.h5",
    "bench I-A --truth a.h5",
    "compare a.h5 a.h5",
    "export a.h5 -o a.csv",
    "sweep II-B --omega0 3,4 --t-end 1s -o a.h5",
]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with a run and a style sheet that this user must not read; root may read everything."""
    monkeypatch.chdir(tmp_path)
    vibsim.simulate("I-A", trust=False, overrides={"run.t_end": "1 s"}).save("a.h5")
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


@pytest.mark.parametrize("words", COMMANDS)
def test_a_file_that_must_not_be_read(folder, words):
    done = call(*words.split())
    assert (done.exit_code, done.stderr) == (6, "Error: a.h5: Permission denied\n")


def test_an_output_that_must_not_be_read_is_there_all_the_same(folder):
    done = call("run", "I-A", "-o", "a.h5")
    assert (done.exit_code, done.stderr) == (6, "Error: a.h5: exists; kept (--force replaces it)\n")


def test_a_style_sheet_that_must_not_be_read(folder):
    done = call("plot", "I-A", "--style", "a.mplstyle", "-o", "a.png")
    said = "a.mplstyle is no style sheet of matplotlib: Permission denied"
    assert (done.exit_code, done.stderr) == (2, f"Error: {said}\n")


@pytest.mark.parametrize("words", [words for words in COMMANDS if " -o a.h5" not in words])
def test_a_result_that_is_not_there(tmp_path, monkeypatch, words):
    monkeypatch.chdir(tmp_path)
    done = call(*words.split())
    assert (done.exit_code, done.stderr) == (6, "Error: a.h5: No such file or directory\n")


@pytest.mark.parametrize("words", ["run a.yaml", "sweep a.yaml --omega0 3,4", "orbit a.yaml", "plot a.yaml"])
def test_a_case_that_is_not_there(tmp_path, monkeypatch, words):
    monkeypatch.chdir(tmp_path)
    done = call(*words.split())
    assert (done.exit_code, done.stderr) == (3, "a.yaml: no such file\n")
