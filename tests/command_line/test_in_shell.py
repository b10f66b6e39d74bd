"""Errors name arguments of Python to those who call Python, and options to those who call a command."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import vibsim
from tests.command_line.made import call, refused

PACKAGE = Path(vibsim.__file__).parent
COMMANDS = {PACKAGE / "plots" / "picture.py", PACKAGE / "plots" / "animated_machine.py"}  # of commands alone


def raised_texts():
    """(file, text) of each literal inside a `raise` of the library."""
    for path in sorted(PACKAGE.rglob("*.py")):
        if path.relative_to(PACKAGE).parts[0] in ("command_line", "evidence") or path in COMMANDS:
            continue
        text = path.read_text("utf-8")
        for node in ast.walk(ast.parse(text)) if "--" in text else ():  # trees take their time
            if isinstance(node, ast.Raise):
                for part in ast.walk(node):
                    if isinstance(part, ast.Constant) and isinstance(part.value, str):
                        yield path, part.value


def test_no_error_of_the_library_speaks_of_options():
    texts = list(raised_texts())
    assert len(texts) > 50
    plain = [(str(path), f" {text.replace('vibsim fit --list', '')}") for path, text in texts]
    assert [(path, text) for path, text in plain if " --" in text] == []


def test_a_file_in_the_way(here):
    case = vibsim.load_case("I-A", {"run.t_end": "0.1 s"})
    result = vibsim.simulate(case)
    result.save("I-A.h5")
    with pytest.raises(vibsim.ResultFileError, match=r"^I-A.h5: exists; kept \(force=True replaces it\)$"):
        result.save("I-A.h5")
    done = call("run", "I-A", "--t-end", "0.1s")
    assert (done.exit_code, done.stderr) == (6, "Error: I-A.h5: exists; kept (--force replaces it)\n")


def test_a_value_that_is_not_allowed():
    with pytest.raises(vibsim.CaseError, match=r"^overrides friction\.mu: must be >= 0, got -1$"):
        vibsim.load_case("II-B", {"mu": -1})
    assert call("run", "II-B", "-s", "mu=-1").stderr == "--set friction.mu: must be >= 0, got -1\n"


@pytest.mark.parametrize("words", ["run", "sweep --param c=1,2", "bench", "fit --free c=1:2 --want captured"])
def test_a_value_that_an_option_of_its_own_brings(words):
    name, *rest = words.split()
    wrong = "must be a time in s, ms, us, min or h, got 5kg"
    assert refused(name, "II-B", *rest, "--t-end", "5kg", code=3) == f"--t-end: {wrong}\n"
    assert refused(name, "II-B", *rest, "-s", "t_end=5kg", code=3) == f"--set run.t_end: {wrong}\n"
    done = call(name, "II-B", *rest, "-s", "t_end=5s", "--t-end", "6s")
    assert done.exit_code == 2 and "--t-end and --set t_end say the same" in done.stderr


def test_a_range_that_is_not_allowed():
    with pytest.raises(vibsim.CaseError, match=r"^axes coupling\.c: must be >= 0, got -1"):
        vibsim.sweep("II-B", {"c": "-1,1 N s/m"})
    assert call("sweep", "II-B", "--param", "c=-1,1 N s/m").stderr.startswith(
        "--param coupling.c: must be >= 0"
    )


def test_a_picture_that_needs_another_sweep(tmp_path):
    short = {"run.t_end": "1 s"}
    sweep = vibsim.sweep("II-B", {"Omega0": "5,6 Hz"}, jobs=1, overrides=short, out=tmp_path / "s.h5")
    with pytest.raises(Exception, match=r"it needs regimes \(sweep with compute='regime'\)"):
        sweep.plot(kind="regime")
    done = call("plot", str(tmp_path / "s.h5"), "--kind", "regime")
    assert "(sweep with --compute regime)" in done.stderr


def test_starts_without_a_spread():
    with pytest.raises(
        vibsim.FitError, match=r'such as spread=\{"x1": "1 mm"\}, or ask for none: ensemble=0$'
    ):
        vibsim.fit("gallery/impact-oscillator", {"drive.omega": "3:5 rad/s"}, ["chaotic"], ensemble=4)
    done = call("fit", "gallery/impact-oscillator", "--free", "drive.omega=3:5 rad/s", "--want", "chaotic")
    assert done.stderr.endswith("such as --spread x1=1mm, or ask for none: --ensemble 0\n")


def test_no_command_shows_the_help_alone():
    done = subprocess.run([sys.executable, "-m", "vibsim"], capture_output=True, text=True)
    assert done.returncode in (0, 2)  # click before 8.2 takes it for a question
    text = done.stderr + done.stdout
    assert text.startswith("Usage: vibsim") and text.count("Usage:") == 1 and "Error:" not in text
