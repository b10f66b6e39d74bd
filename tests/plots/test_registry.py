"""Kinds of pictures, views, and quantities with their units."""

import json
import math
import re
import shutil
import subprocess
import sys
from dataclasses import replace
from string import ascii_lowercase

import numpy as np
import pytest
from click.testing import CliRunner
from matplotlib.text import Text

from tests.plots.artists import letters, on_paper
from tests.plots.conftest import RUNS
from vibsim.cases import load_case
from vibsim.command_line.commands.plot import KIND_NAMES
from vibsim.command_line.main import group
from vibsim.plots.registry import KINDS, NEEDS, choose, fitting, kind_named
from vibsim.plots.sheet import amount, rounded, scale_for, symbol
from vibsim.plots.subject import PlotError, View, open_subject, open_subjects, parse_span
from vibsim.results import simulate_to_file

SPECTRA = {"spectrum", "spectrogram", "waterfall"}
ALWAYS = {"overview", "displacement", "velocity", "phase", "relative", "stiffness"} | SPECTRA
OF_FORMULAS = {"rotor-speed", "states"}  # of rotors and states, which none of these runs has
PERIODIC = {"impact-velocity", "stroboscopic", "phase-drift-free", "power"}
FITTING = {
    "ideal": ALWAYS | PERIODIC,
    "motor": {"power"}
    | {kind.name for kind in KINDS if kind.reads in ("trajectory", "case")}
    - {"orbit-portrait", *OF_FORMULAS},
    "fixed": (ALWAYS | PERIODIC) - {"phase-drift-free"},  # a spring to the wall
    "bare": ALWAYS,
    "quiet": ALWAYS | PERIODIC,
}


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)
def test_every_kind_can_be_drawn_and_its_needs_are_known(kind):
    assert callable(kind.draw)
    assert set(kind.needs) <= set(NEEDS)
    assert kind.reads in ("trajectory", "case", "sweep", "branch", "locus", "fit", "bench")


@pytest.mark.parametrize("name", FITTING)
def test_which_kinds_fit(subject, name):
    assert {kind.name for kind in fitting([subject(name)])} == FITTING[name]


def test_together_only_what_fits_both(subject):
    both = {kind.name for kind in fitting([subject("bare"), subject("motor")])}
    assert both == FITTING["bare"] - {"spectrogram"}


def test_unknown_kind_names_the_nearest():
    with pytest.raises(
        PlotError, match=r"unknown kind 'motor_sped': did you mean motor-speed\? The kinds are overview,"
    ):
        kind_named("motor_sped")
    with pytest.raises(PlotError, match="unknown kind 'zzzz': the kinds are overview,"):
        kind_named("zzzz")


def test_unfit_kind_names_those_that_fit(subject):
    with pytest.raises(PlotError) as caught:
        choose(["motor-speed"], [subject("bare")])
    assert "kind motor-speed: it needs a motor" in str(caught.value)
    assert "bare.h5 has none; kinds that fit: overview, displacement," in str(caught.value)


def test_choices(subject):
    one = [subject("ideal")]
    assert [kind.name for kind in choose(None, one)] == ["overview"]
    assert [kind.name for kind in choose(["phase", "relative", "phase"], one)] == ["phase", "relative"]
    assert {kind.name for kind in choose(["all"], one)} == FITTING["ideal"]


def test_a_case_has_no_trajectory():
    case = open_subject("II-B")
    assert [kind.name for kind in choose(None, [case])] == ["stiffness", "motor"]
    with pytest.raises(
        PlotError, match="it shows a trajectory, and II-B is a case; kinds that fit: stiffness, motor"
    ):
        choose(["phase"], [case])


@pytest.mark.parametrize(
    ("text", "span"),
    [("100:110", (100, 110)), (":20", (-math.inf, 20)), ("1.5:", (1.5, math.inf)), ("1e2:2e2", (100, 200))],
)
def test_spans(text, span):
    assert parse_span(text) == span


@pytest.mark.parametrize(
    ("message", "texts"),
    [("write FIRST:LAST in seconds", ["100", "a:b", "nan:3", "1:2:3", ""]), ("is empty", ["3:3", "5:2"])],
)
def test_what_is_no_span(message, texts):
    for text in texts:
        with pytest.raises(PlotError, match=message):
            parse_span(text)


@pytest.mark.parametrize(
    ("largest", "unit", "label"),
    [(0.0868, "m", "mm"), (0.352, "m", "mm"), (1.0, "m", "m"), (0.001, "m", "mm"), (0.000999, "m", "µm"),
     (5.0, "m", "m"), (12e3, "N", "kN"), (0.112, "m/s", "mm/s"), (2.2, "m/s", "m/s"), (0.005, "N m", "mN m"),
     (0.0, "m", "m"), (3e-13, "m", "fm"), (3e-22, "m", "am")],
)  # fmt: skip
def test_prefix_puts_the_largest_magnitude_between_1_and_1000(largest, unit, label):
    scale = scale_for(unit, [0.0, -largest], np.empty(0))
    assert scale.unit == label
    assert 1 <= scale(largest) < 1000 or largest in (0.0, 3e-22)


def test_numbers_with_units_and_symbols_as_texts():
    assert scale_for("m", [0.02]).label("Displacement") == "Displacement (mm)"
    assert scale_for("m", [np.nan, 0.02], [np.nan]).unit == "mm"  # nan is no magnitude
    assert scale_for("m", [3e7]).unit == "km"
    assert amount(12600, "N/m") == "12.6 kN/m" and amount(1.00022e6, "N/m") == "1 MN/m"
    assert amount(200, "N/m") == "200 N/m"
    assert symbol("x1") == "$x_{1}$" and symbol("v_drill") == r"$v_\mathrm{drill}$"


def test_rounded_decimals_tell_values_apart():
    assert rounded([0.001, 53 / 3500, 0.1]) == ["0.001", "0.0151", "0.1"]
    assert rounded([1.00001, 1.00002]) == ["1.00001", "1.00002"]
    assert rounded([2.5, 2.5]) == ["2.5", "2.5"]
    assert rounded([12345.6]) == ["12300"]
    assert rounded([]) == []


# Every kind on every make of scene: it is drawn, its axes carry units, nothing is clipped or covered.


UNIT = re.compile(r"\((s|Hz|°|[kmµn]?(m|m/s|N|N m|W))\)$")
SINGLE = [kind for kind in KINDS if kind.name in FITTING["motor"]]


def drawn(kind, subjects, view=None):
    view = view or View()
    return kind.draw(subjects, replace(view, width=view.width or kind.width))


def assert_fit_to_print(figure):
    for axes in figure.axes:
        for label in (axes.get_xlabel(), axes.get_ylabel()):
            assert not label or label in ("Count", "Run") or UNIT.search(label), label
    assert any(axes.get_xlabel() for axes in figure.axes)
    assert any(axes.get_ylabel() for axes in figure.axes)
    panels = [axes for axes in figure.axes if axes.get_label() not in ("<colorbar>", "<machine>")]
    expected = [f"({letter})" for letter in ascii_lowercase[: len(panels)]] if len(panels) > 1 else []
    assert sorted(letters(figure)) == expected
    on_paper(figure)


@pytest.mark.parametrize(("run", "name"), [(run, name) for run in RUNS for name in sorted(FITTING[run])])
def test_single_runs(subject, run, name):
    assert_fit_to_print(drawn(kind_named(name), [subject(run)]))


@pytest.fixture(scope="module")
def two_motors(runs, tmp_path_factory):
    """Two runs of one name in files whose names matplotlib would read as mathematics."""
    paths = [tmp_path_factory.mktemp("two") / f"{name}.h5" for name in ("a$\\frac$", "b_{$")]
    shutil.copy(runs["motor"], paths[0])
    simulate_to_file(load_case("II-B", {"Omega0": "6.5 Hz", "run.t_end": "12 s"}), paths[1])
    return open_subjects([str(path) for path in paths])


@pytest.mark.parametrize("kind", SINGLE, ids=lambda kind: kind.name)
def test_two_motors_in_a_window(two_motors, kind):
    """Nothing of their names is taken for mathematics, which fails where it is none."""
    figure = drawn(kind, two_motors[:1] if kind.alone else two_motors, View(window=(8.0, 11.0)))
    assert_fit_to_print(figure)
    said = {text.get_text() for text in figure.findobj(Text)}
    for name in () if kind.alone else (r"a\$\frac\$", r"b_{\$"):
        assert any(name in text for text in said)


@pytest.mark.parametrize("kind", ["overview", "displacement", "velocity", "phase", "relative", "stiffness"])
def test_all_makes_in_one_picture(subject, kind):
    assert_fit_to_print(drawn(kind_named(kind), [subject(run) for run in RUNS]))


@pytest.mark.parametrize(
    ("name", "width"), [("overview", "column"), ("phase", "page"), ("motor-speed", "page")]
)
def test_the_other_width(subject, name, width):
    assert_fit_to_print(drawn(kind_named(name), [subject("motor"), subject("motor2")], View(width=width)))


@pytest.mark.parametrize(
    "kind", [kind for kind in SINGLE if kind.name not in SPECTRA], ids=lambda kind: kind.name
)
def test_a_window_of_a_few_samples(subject, kind):
    assert_fit_to_print(drawn(kind, [subject("motor")], View(window=(10.0, 10.012))))


# `vibsim plot` as typed.


@pytest.fixture
def plot(here):
    """Runs `vibsim plot ...` in an empty folder."""
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


def test_matplotlib_is_imported_only_to_draw():
    code = (
        "import sys, vibsim.plots, vibsim.command_line.commands.plot;"
        "sys.exit('matplotlib' in sys.modules or 'numpy' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_completion():
    items = KIND_NAMES.shell_complete(None, None, "phase,mot")
    assert [item.value for item in items] == ["phase,motor-speed", "phase,motor"]
