"""`vibsim plot` as typed."""

import json
import subprocess
import sys

import pytest
from click.testing import CliRunner

from vibsim.command_line.commands.plot import KIND_NAMES
from vibsim.command_line.main import group


@pytest.fixture
def plot(tmp_path, monkeypatch):
    """Runs `vibsim plot ...` in an empty folder."""
    monkeypatch.chdir(tmp_path)
    return lambda *words: CliRunner().invoke(group, ["plot", *words])


def test_overview_is_the_default(plot, runs, tmp_path):
    outcome = plot(runs["quiet"])
    assert (outcome.exit_code, outcome.stdout) == (0, "quiet-overview.png\n")
    assert (tmp_path / "quiet-overview.png").exists()


def test_kinds_window_detail_and_width(plot, runs):
    words = "--kind displacement,relative --window 5:15 --detail 7:8 --width page -o x.pdf"
    assert plot(runs["motor"], *words.split()).stdout == "x.pdf\n"


def test_json_and_quiet(plot, runs):
    assert json.loads(plot(runs["quiet"], "--kind", "stiffness", "--json").stdout) == {
        "written": ["quiet-stiffness.png"]
    }
    assert plot(runs["quiet"], "--kind", "stiffness", "--force", "-q").stdout == ""


def test_list(plot, runs):
    everything = plot("--list").stdout
    assert "motor-speed" in everything
    assert "(needs a motor)" in everything
    assert "motor-speed" not in plot("--list", runs["ideal"]).stdout
    assert {"kind", "name"} & set(json.loads(plot("--list", "--json").stdout)[0])


@pytest.mark.parametrize(
    ("words", "code", "message"),
    [
        ((), 2, "give at least one FILE"),
        (("{ideal}", "--kind", "relativ"), 2, "did you mean relative?"),
        (("{ideal}", "--kind", "motor-speed"), 2, "it needs a motor"),
        (("{ideal}", "--window", "400:410"), 2, "lies outside"),
        (("{ideal}", "--window", "400"), 2, "write FIRST:LAST in seconds"),
        (("{ideal}", "-o", "x.jpg"), 2, "pictures are .png, .pdf or .svg; a page is .html"),
        (("{ideal}", "-o", "nowhere/x.png"), 6, "does not exist"),
        (("missing.h5",), 6, "missing.h5"),
        (("no-such-case",), 3, "no-such-case"),
    ],
)
def test_mistakes(plot, runs, words, code, message):
    outcome = plot(*(word.format(**runs) for word in words))
    assert outcome.exit_code == code
    assert message in outcome.stderr
    assert "Traceback" not in outcome.output


def test_help_has_examples(plot):
    assert "vibsim plot II-B.h5 --kind relative -o II-B.pdf" in plot("--help").stdout


def test_matplotlib_is_imported_only_to_draw():
    code = (
        "import sys, vibsim.plots, vibsim.command_line.commands.plot;"
        "sys.exit('matplotlib' in sys.modules or 'numpy' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_completion():
    items = KIND_NAMES.shell_complete(None, None, "phase,mot")
    assert [item.value for item in items] == ["phase,motor-speed", "phase,motor"]
