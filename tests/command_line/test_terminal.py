"""What reaches a terminal: user text as text, JSON as JSON, errors in both."""

import json

import click
import pytest

from tests.command_line.made import call, process, told
from vibsim.command_line.terminal import print_json, say, style

HOSTILE = "x\x1b[2J\x1b]0;PWN\x07\x9b31m\u202e"
SHOWN = "x\\x1b[2J\\x1b]0;PWN\\x07\\x9b31m\\u202e"
CASE = 'extends: II-B\ntitle: "x\\e[2J\\e]0;PWN\\a\\x9b31m\\u202e"\nrun: {t_end: 1 s}\n'


@pytest.fixture(autouse=True)
def folder(here):
    (here / "nasty.yaml").write_text(CASE, encoding="utf-8")
    return here


def obeyed(text):
    """The characters of an output that a terminal obeys."""
    return [ch for ch in text if not ch.isprintable() and ch != "\n"]


def test_only_own_colours_are_printed(capsys):
    with click.Context(click.Command("x")) as ctx:
        ctx.color = True
        say(f"{HOSTILE} \x1b[31m{style(HOSTILE, fg='red')}")
    assert capsys.readouterr().out == f"{SHOWN} \\x1b[31m\x1b[31m{SHOWN}\x1b[0m\n"


def test_json_is_json_whatever_it_holds(capsys):
    value = {"text": HOSTILE + "\udcff", "number": float("nan"), "list": (1.5, float("inf"))}
    print_json(value)
    printed = capsys.readouterr().out
    assert obeyed(printed) == []
    read = json.loads(printed)
    assert read == {"text": HOSTILE + "\udcff", "number": None, "list": [1.5, None]}


@pytest.mark.parametrize(
    "words",
    [("check", "nasty.yaml"), ("check", "-v", "nasty.yaml"), ("run", "nasty.yaml", "--dry-run"),
     ("run", "nasty.yaml", "--color", "never"), ("cases", "./nasty.yaml"),
     ("sweep", "nasty.yaml", "--omega0", "5,6", "--section", "0"), ("run", f"{HOSTILE}.yaml"),
     ("run", "nasty.yaml", "-s", f"{HOSTILE}=1"), ("info", f"{HOSTILE}.h5"),
     ("plot", "nasty.yaml", "--kind", HOSTILE), (HOSTILE,), ("run", f"--{HOSTILE}"), ("verify", HOSTILE),
     ("export", HOSTILE, "-o", f"{HOSTILE}.csv"), ("compare", HOSTILE, HOSTILE),
     ("analyse", f"{HOSTILE}.h5", "--window", HOSTILE)],
    ids=lambda words: " ".join(words[:2]).encode("unicode_escape").decode()[:30],
)  # fmt: skip
def test_no_command_lets_a_terminal_obey_user_text(words):
    done = call(*words)
    assert obeyed(done.stdout) == obeyed(done.stderr) == []
    assert "Traceback" not in done.stderr


BROKEN = "a\nError: b"


@pytest.mark.parametrize(
    "words",
    [
        ("run", "I-A", "-o", f"{BROKEN}.h5"),
        ("run", f"{BROKEN}.yaml"),
        ("plot", f"{BROKEN}.h5", "-o", f"{BROKEN}.png"),
        ("animate", f"{BROKEN}.h5", "--window", "0:0.1", "-o", f"{BROKEN}.html"),
        ("export", f"{BROKEN}.h5", "-o", f"{BROKEN}.csv"),
        ("new", BROKEN),
        ("cases", "--draw", "I-A", "-o", f"{BROKEN}.svg"),
        ("sweep", "I-A", "--omega", "3,4", "--t-end", "1s", "--section", "0", "-o", f"{BROKEN}.sweep.h5"),
    ],
    ids=lambda words: words[0],
)
def test_a_line_end_in_a_name_begins_no_line(words):
    """Neither where the command does its work nor where it finds the file in the way."""
    assert call("run", "I-A", "--t-end", "1s", "-o", f"{BROKEN}.h5", "-q", "--force").exit_code == 0
    for done in (call(*words), call(*words)):
        lines = f"{done.stdout}{done.stderr}".splitlines()
        assert any("a\\nError: b" in line for line in lines)
        assert not any(line.startswith("Error: b") for line in lines)


def test_runs_and_files_of_hostile_cases():
    assert call("run", "nasty.yaml", "-q").exit_code == 0
    for words in ("info -v", "info --case", "info --json", "analyse", "analyse --json"):
        assert obeyed(told(*words.split(), "nasty.h5")) == []


WRONG = [
    (2, ("nosuch",)),
    (2, ("run", "II-B", "--digts", "30")),
    (2, ("run",)),
    (3, ("run", "nosuch")),
    (3, ("run", "II-B", "-s", "mu=-1")),
    (6, ("info", "none.h5")),
    (6, ("export", "none.h5", "-o", "a.csv")),
    (2, ("export", "none.h5", "-o", "a.txt")),
    (2, ("run", "II-B", "-o", "a.csv")),
    (2, ("sweep", "II-B")),
    (2, ("plot",)),
    (6, ("compare", "a.h5", "b.h5")),
]


@pytest.mark.parametrize(("code", "words"), WRONG, ids=str)
@pytest.mark.parametrize("before", [True, False])
def test_errors_are_json_where_json_is_asked_for(code, words, before):
    done = call(*(("--json", *words) if before else (*words, "--json")))
    error = json.loads(done.stdout)["error"]
    assert done.exit_code == error["exit_code"] == code
    assert error["message"] and error["message"] in done.stderr
    if code == 3:
        assert {"file", "line", "column", "key", "message"} == set(error["problems"][0])


def test_a_failed_run_is_json_too():
    done = process("--json", "run", "nosuch.yaml", "--", "--json")
    assert json.loads(done.stdout)["error"]["exit_code"] == 3
    assert process("run", "--", "--json").stdout == ""


def test_export_and_stored_cases_are_json():
    call("run", "nasty.yaml", "-q")
    done = call("--json", "export", "nasty.h5", "-o", "a.csv")
    assert json.loads(done.stdout) == {"file": "nasty.h5", "written": ["a.csv"]}
    assert json.loads(call("--json", "info", "--case", "nasty.h5").stdout)["case_yaml"] == CASE


@pytest.mark.parametrize(
    ("words", "told"),
    [(("run", "II-B", "--method", "tailor"), "(did you mean taylor?)"),
     (("sweep", "--omega0", "5,6", "--direction", "dwon"), "(did you mean down?)"),
     (("--color", "nevr", "cases"), "(did you mean never?)"),
     (("plot", "II-B", "--kind", "stifness"), "did you mean stiffness?"),
     (("sweep", "I-A", "--omega0", "1:2:1"), "--omega0: the source of I-A is harmonic; use --omega 1:2:1"),
     (("sweep", "II-B", "--omega", "1:2:1"), "--omega: the source of II-B is motor; use --omega0 1:2:1"),
     (("sweep", "II-B", "--param", "foo=1:2:1"), "--param foo: unknown key"),
     (("sweep", "II-B", "--param", "c=1:2"), "--param c: 1:2 has no step"),
     (("sweep", "II-B", "--omega0", "1e400:2:1"), "--omega0: 1e400:2:1 has 1.00e+400 values"),
     (("sweep", "II-B", "--omega0", "-1,5"), "--omega0 excitation.Omega0: must be > 0, got -1 Hz")],
)  # fmt: skip
def test_what_was_meant_is_said(words, told):
    done = call(*words)
    assert done.exit_code in (2, 3) and told in done.stderr


@pytest.mark.parametrize("words", [("run", "II-B"), ("sweep", "--omega0", "5,6"), ("bench", "I-A")])
@pytest.mark.parametrize("name", ["out.csv", "out", "out.txt"])
def test_results_are_not_written_under_other_suffixes(words, name, folder):
    done = call(*words, "-o", name)
    assert done.exit_code == 2
    assert "results are HDF5 files, .h5 or .hdf5" in done.stderr
    assert ("vibsim export" in done.stderr) == name.endswith("csv")
    assert not (folder / name).exists()


def test_a_dry_run_needs_no_free_name():
    assert call("run", "nasty.yaml", "-q").exit_code == 0
    shown = told("run", "nasty.yaml", "--dry-run")
    assert "nasty.h5 (not written: dry run; it exists, and --force would replace it)" in shown
    assert json.loads(call("run", "nasty.yaml", "--dry-run", "--json").stdout)["file_exists"] is True
    assert json.loads(told("run", "II-B", "--dry-run", "--json", "-o", "new.h5"))["file_exists"] is False


def test_verbose_info_tells_every_number_of_a_file():
    call("run", "nasty.yaml", "-q")
    call("sweep", "nasty.yaml", "--omega0", "5,6", "-o", "sweep.h5", "-q")
    for name, attribute in (("nasty.h5", "taylor_order = 20"), ("sweep.h5", "points_done = 2")):
        assert attribute in call("info", "-v", name).stdout
        assert attribute not in call("info", name).stdout
