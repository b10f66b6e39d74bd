"""The command itself: help, hints, global options, exit codes, start-up."""

import json
import math
import os
import subprocess
import sys
from importlib import metadata
from pathlib import Path

import click
import pytest

import vibsim
from tests.command_line.made import call, process, refused, told
from tests.results.made import short_run
from vibsim.cases import CaseError, Problem
from vibsim.command_line.main import COMMANDS, exit_code_of, group
from vibsim.command_line.options import _remember
from vibsim.command_line.text import case_lines, metres, seconds
from vibsim.engine.errors import EngineError, State
from vibsim.plots.subject import PlotError
from vibsim.results import ResultFileError


def test_help_lists_every_command():
    shown = told("--help")
    for name, (_, line) in COMMANDS.items():
        assert f"{name} " in shown and line in shown


@pytest.mark.parametrize("name", COMMANDS)
def test_every_help_ends_with_examples(name):
    shown = told(name, "--help")
    _, _, examples = shown.partition("Examples:\n")
    lines = examples.strip("\n").splitlines()
    assert lines and all(line.startswith("    ") for line in lines)
    assert any(f"vibsim {name}" in line for line in lines)


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_takes_the_global_options(name):
    options, _, _ = call(name, "--help").stdout.partition("Examples:")
    for option in ("--verbose ", "--quiet ", "--json ", "--color "):
        assert options.count(option) == 1


@pytest.mark.parametrize(
    ("word", "hint"),
    [
        ("rnu", "did you mean run?"),
        ("INFO", "did you mean info?"),
        ("my.yaml", "to run the case: vibsim run my.yaml"),
        ("II-B.h5", "to see what it holds: vibsim info II-B.h5"),
        ("xyzzy", "commands are cases, new, check, schema, run, sweep"),
    ],
)
def test_an_unknown_command_gets_a_hint(word, hint):
    assert hint in refused(word)


@pytest.mark.parametrize(
    ("words", "meant"),
    [
        *(((name, "--jsn"), "--json") for name in COMMANDS),
        (("--jsn", "cases"), "--json"),
        (("run", "--plt", "x"), "--plot"),
        (("run", "II-B", "--digts", "30"), "--digits"),
    ],
)
def test_an_unknown_option_gets_a_hint(words, meant):
    (wrong,) = (word for word in words if word.startswith("--"))
    assert refused(*words).endswith(f"Error: no option {wrong}; did you mean {meant}?\n")


def test_no_command_prints_help():
    assert "Motions:" in call().output


def test_global_options_count_before_and_after_the_command():
    before, after = call("--json", "cases").stdout, call("cases", "--json").stdout
    assert before == after
    assert json.loads(before)


@pytest.mark.parametrize(
    ("words", "environment", "colored"),
    [
        (["--color", "always"], {}, True),
        (["--color", "always"], {"NO_COLOR": "1"}, True),
        (["--color", "never"], {}, False),
        (["--color", "auto"], {}, False),  # no terminal here
    ],
)
def test_color(words, environment, colored, tmp_path):
    done = process("run", "I-A", "--dry-run", *words, cwd=tmp_path, env=environment)
    assert done.returncode == 0
    assert ("\x1b[" in done.stdout) == colored


def test_no_color_holds_on_a_terminal():
    with click.Context(group) as ctx, pytest.MonkeyPatch.context() as patch:
        patch.setenv("NO_COLOR", "1")
        _remember(ctx, group.params[0], None)
        assert ctx.color is False
        patch.delenv("NO_COLOR")
        _remember(ctx, group.params[0], None)
        assert ctx.color is None


def test_version():
    assert call("--version").stdout == f"vibsim {vibsim.__version__}\n"
    assert metadata.version("vibsim") == vibsim.__version__


STATE = State(1.0, [0.0], [0.0], 0.0, 0.0, 0.0)
USERS_ERRORS = [
    (CaseError([Problem("a.yaml", 1, 2, "k1", "must be >= 0")]), 3, "a.yaml:1:2: k1: must be >= 0\n"),
    (EngineError("diverged", STATE), 4, "Error: t = 1.0 s: the state is no longer finite"),
    (ResultFileError("a.h5: is empty"), 6, "Error: a.h5: is empty\n"),
    (PlotError("no such kind"), 2, "Error: no such kind\n"),
    (click.UsageError("wrong"), 2, "Error: wrong\n"),
    (KeyboardInterrupt(), 130, "interrupted\n"),
]


@pytest.mark.parametrize(("error", "code", "message"), USERS_ERRORS, ids=lambda value: type(value).__name__)
def test_exit_codes(error, code, message, capsys):
    def fail():
        raise error

    assert exit_code_of(fail) == code
    assert message in capsys.readouterr().err


def test_a_bug_is_raised_on():
    with pytest.raises(ZeroDivisionError):
        exit_code_of(lambda: 1 / 0)
    with pytest.raises(FileNotFoundError):
        exit_code_of(Path("/no/such/file").read_text)


IMPORTED = """
import sys
from vibsim.command_line.main import main
sys.argv[1:] = {words!r}
try:
    main()
finally:
    print(*sorted(sys.modules), file=sys.stderr)
"""


def modules_after(*words, **options):
    command = [sys.executable, "-c", IMPORTED.format(words=list(words))]
    done = subprocess.run(command, capture_output=True, text=True, check=False, **options)
    assert done.returncode == 0, done.stderr
    return set(done.stderr.split())


def test_help_imports_nothing_heavy():
    assert not modules_after("--help") & {
        "numpy", "yaml", "h5py", "vibsim.cases", "vibsim.results", "difflib",
    }  # fmt: skip


def test_run_imports_no_more_than_it_needs(tmp_path):
    found = modules_after("run", "I-A", "--t-end", "1s", "-q", cwd=tmp_path)
    assert "h5py" in found
    assert not found & {
        "scipy", "matplotlib", "pandas", "xarray", "netCDF4", "concurrent.futures", "multiprocessing",
        "html", "vibsim.orbits.branches", "vibsim.orbits",
    }  # fmt: skip


def test_a_plain_sweep_imports_no_verdicts_and_no_other_processes(tmp_path):
    words = ["sweep", "I-A", "--omega", "3:4:1", "--t-end", "2s", "-q"]
    imported = modules_after(*words, cwd=tmp_path)
    assert "vibsim.sweeps.points" in imported
    verdicts = ("vibsim.analysis.regime", "vibsim.analysis.capture", "vibsim.orbits.")
    assert not {name for name in imported if name.startswith(verdicts)}
    assert not imported & {"scipy", "matplotlib", "multiprocessing", "pandas"}


THREADS = """
import gc, os, sys
from vibsim.command_line.main import main
sys.argv[1:] = ["run", "I-A", "--t-end", "1s", "--no-trust", "-q"]
try:
    main()
finally:
    threads, setting = len(os.listdir("/proc/self/task")), os.environ.get("OPENBLAS_NUM_THREADS")
    print(threads, setting, gc.get_freeze_count() > 0)
"""


@pytest.mark.skipif(not Path("/proc/self/task").is_dir(), reason="counts threads as Linux shows them")
@pytest.mark.parametrize("asked", [None, "2"])
def test_a_run_starts_no_threads_for_matrices_unless_asked_to(tmp_path, asked):
    inherited = {name: value for name, value in os.environ.items() if name != "OPENBLAS_NUM_THREADS"}
    environment = inherited | ({"OPENBLAS_NUM_THREADS": asked} if asked else {})
    told = subprocess.check_output([sys.executable, "-c", THREADS], text=True, cwd=tmp_path, env=environment)
    threads, setting, frozen = told.split()
    assert asked or threads == "1"
    assert setting == (asked or "1") and frozen == "True"


def test_importing_vibsim_imports_nothing_else():
    code = "import sys, vibsim; print({'numpy', 'h5py', 'yaml', 'click'} & set(sys.modules))"
    assert subprocess.check_output([sys.executable, "-c", code], text=True) == "set()\n"


def test_everything_public_is_there():
    for name in vibsim.__all__:
        assert getattr(vibsim, name) is not None
    assert set(vibsim.__all__) <= set(dir(vibsim))
    with pytest.raises(AttributeError, match="no attribute 'runn'"):
        vibsim.__getattr__("runn")


def test_a_reader_that_goes_away_is_no_error(tmp_path):
    command = f"{sys.executable} -m vibsim schema | true; echo ${{PIPESTATUS[0]}}"
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True, check=False)
    assert done.stderr == ""
    assert done.stdout in ("0\n", "141\n")  # 0 where all was written before `true` ended


def test_a_closed_pipe_ends_quietly():
    reading, writing = os.pipe()
    os.close(reading)
    with open(writing, "w") as closed:
        command = [sys.executable, "-m", "vibsim", "cases"]
        done = subprocess.run(command, stdout=closed, stderr=subprocess.PIPE, check=False)
    assert (done.returncode, done.stderr) == (141, b"")


def test_shell_completion():
    environment = {"_VIBSIM_COMPLETE": "bash_complete", "COMP_WORDS": "vibsim run II-", "COMP_CWORD": "2"}
    done = process(env=environment)
    assert "plain,II-A\nplain,II-B\nplain,II-B-captured\nplain,II-C\nplain,II-C-escape\n" in done.stdout
    source = process(env={"_VIBSIM_COMPLETE": "bash_source"})
    assert "complete -o nosort -F _vibsim_completion vibsim" in source.stdout


# Commands whose standard streams the caller closed.


RUN = ["run", "I-A", "--t-end", "0.1s", "-o", "a.h5"]


@pytest.mark.parametrize("closed", ["<&-", ">&-", "2>&-", "<&- >&- 2>&-"])
def test_a_command_does_its_work_without_standard_streams(tmp_path, closed):
    outcome = shell(tmp_path, RUN, closed)
    assert (outcome.returncode, outcome.stderr) == (0, "")
    assert vibsim.open_result(tmp_path / "a.h5").complete


def test_a_case_from_a_closed_input_is_empty(tmp_path):
    outcome = shell(tmp_path, ["check", "-"], "<&-")
    assert outcome.returncode == 3
    assert (outcome.stdout + outcome.stderr).startswith("stdin:1:1: is empty")


def shell(folder, words, redirection):
    command = f'exec "$0" -m vibsim {" ".join(words)} {redirection}'
    return subprocess.run(["sh", "-c", command, sys.executable], cwd=folder, capture_output=True, text=True)


# What is printed is what was meant: no empty output, no signed zero, no file that was not judged.


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    return short_run("II-B").save(tmp_path_factory.mktemp("answers") / "II-B.h5")


def test_a_run_with_changes_is_not_said_to_be_the_file(file):
    found = call("analyse", file, "-s", "c=0.03", "--what", "impacts")
    assert f"{file} run with c=0.03, not saved" in found.stdout
    assert "run with" not in call("analyse", file, "--what", "impacts").stdout
    read = json.loads(call("analyse", file, "-s", "c=0.03", "--what", "impacts", "--json").stdout)
    assert read["changes"] == {"c": "0.03"}


@pytest.mark.parametrize("window", ["500:600", "2.001:2.002"])
@pytest.mark.parametrize("name", ["out.csv", "out.mat"])
def test_nothing_is_no_export(file, tmp_path, window, name):
    found = call("export", file, "--window", window, "-o", tmp_path / name)
    assert found.exit_code == 2 and f"--window {window}: nothing of" in found.stderr
    assert not list(tmp_path.iterdir())


def test_a_stretch_without_events_has_none(file, tmp_path):
    told("export", file, "--events", "--window", "0.1:0.2", "-o", tmp_path / "a.csv")
    assert len((tmp_path / "a.csv").read_text().splitlines()) == 1


def test_nothing_is_no_picture(file, tmp_path):
    found = call("plot", file, "--window", "2.001:2.0011", "-o", tmp_path / "a.png")
    assert found.exit_code != 0 and "too short" in found.stderr
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("tolerance", ["nan", "inf", "-1"])
def test_a_tolerance_is_a_number(file, tolerance):
    assert "--tolerance" in refused("compare", file, file, "--tolerance", tolerance)


def test_lengths_and_durations_in_words():
    assert [metres(x) for x in (-0.0, 0.0, -2e-6, math.nan)] == ["0 m", "0 m", "-2 um", "nan nm"]
    texts = [seconds(t) for t in (0.0, 1.0, 0.005, 2e-6, 3e-9, 1e-20)]
    assert texts == ["0 s", "1 s", "5 ms", "2 us", "3 ns", "1e-20 s"]
    (span,) = (text for label, text in case_lines(short_run("I-A", "1 ms").case) if label == "span")
    assert span == "1 ms, a sample every 5 ms: 1 sample"


@pytest.mark.parametrize(
    ("words", "name"),
    [
        (["sweep", "II-B", "--omega0", "", "--param", "c=0.01:0.02/2"], "--omega0"),
        (["plot", "run.h5", "--kind", ""], "--kind"),
        (["bench", "--methods", ""], "--methods"),
        (["export", "run.h5", "-o", "run.csv", "--along", ""], "--along"),
        (["sweep", "II-B", "--param", "c=1:2/2", "--compute", ""], "--compute"),
        (["info", ""], "FILE..."),
        (["run", "II-B", ""], "CASE..."),
    ],
)
def test_an_empty_value_is_not_taken_for_none(words, name):
    assert f"Error: {name} is empty: give it a value" in refused(*words)
