"""Pictures of sweeps: what is drawn where, what fits what, nothing clipped or covered."""

import re
from functools import lru_cache

import numpy as np
import pytest

from tests.plots.artists import legend, lines, on_paper
from vibsim import orbit
from vibsim.cases import load_case
from vibsim.orbits.branches.continuing import continue_branch
from vibsim.plots.picture import draw_files
from vibsim.plots.registry import choose, fitting, kind_named
from vibsim.plots.subject import PlotError, View, open_subject
from vibsim.plots.sweep_curves import leaps
from vibsim.sweeps import sweep

UNIT = re.compile(r"\((s|Hz|[kmµn]?(m|m/s|N|N m|N s/m))\)$")
KINDS = ("sommerfeld", "amplitude", "orbit")
SWEEPS = {
    "motor": ({"Omega0": "3:4:0.25 Hz"}, {}),
    "carried": ({"Omega0": "3:4:0.5 Hz"}, {"carry_state": True, "direction": "both"}),
    "family": ({"Omega0": "3, 4 Hz", "c": "0.01:0.03/3"}, {"carry_state": True, "direction": "both"}),
    "grid": ({"c": "0.01:0.08/8", "Omega0": "3, 4 Hz"}, {}),
    "damping": ({"c": "0.01, 0.02"}, {"section": 0}),
    "ideal": ({"omega": "20, 25 rad/s"}, {}),
}


@pytest.fixture(scope="module")
def paths(tmp_path_factory):
    folder = tmp_path_factory.mktemp("sweeps")
    for name, (axes, settings) in SWEEPS.items():
        case = load_case("I-B" if name == "ideal" else "II-B", {"run.t_end": "4 s"})
        sweep(case, axes, out=folder / f"{name}.h5", **settings)
    return {name: str(folder / f"{name}.h5") for name in SWEEPS}


@lru_cache(maxsize=32)
def drawn(kind, *paths):
    """The picture of a kind, which is only read."""
    return kind_named(kind).draw([open_subject(path) for path in paths], View())


FITTING = {name: set(KINDS) for name in SWEEPS} | {"damping": {"amplitude"}, "ideal": {"amplitude", "orbit"}}


@pytest.mark.parametrize("name", SWEEPS)
def test_what_fits_is_drawn_and_fit_to_print(paths, name):
    subject = open_subject(paths[name])
    assert {kind.name for kind in fitting([subject])} == FITTING[name]
    for kind in FITTING[name]:
        figure = on_paper(drawn(kind, paths[name]))
        assert figure.axes[0].get_ylabel()
        for label in (label for axes in figure.axes for label in (axes.get_xlabel(), axes.get_ylabel())):
            assert not label or UNIT.search(label), label


def test_the_default_suits_the_sweep(paths):
    for name, kind in {"motor": "sommerfeld", "ideal": "amplitude", "damping": "amplitude"}.items():
        assert [found.name for found in choose(None, [open_subject(paths[name])])] == [kind]


def test_sommerfeld_says_what_it_needs(paths):
    for name, message in (
        ("ideal", r"it needs a motor, and .*ideal\.h5 has none; kinds that fit: amplitude"),
        ("damping", r"it needs a sweep over Omega0, or .*, and .*damping\.h5 has none"),
    ):
        with pytest.raises(PlotError, match=message):
            choose(["sommerfeld"], [open_subject(paths[name])])


def test_sommerfeld_draws_the_speeds(paths):
    result = open_subject(paths["motor"]).result
    axes = drawn("sommerfeld", paths["motor"]).axes[0]
    (mean,) = lines(axes, "mean")
    np.testing.assert_array_equal(mean.get_xdata(), result["omega0"])
    np.testing.assert_array_equal(mean.get_ydata(), result["mean_speed"][:, 0])
    (no_load,) = lines(axes, "no-load")
    np.testing.assert_array_equal(no_load.get_xdata(), no_load.get_ydata())
    levels = {round(float(line.get_ydata()[0]), 2) for line in lines(axes, "level")}
    assert 3.68 in levels  # half bilinear: 7.37 / 2


@pytest.mark.parametrize("rotor", ["left", "right"])
def test_sommerfeld_draws_and_names_the_rotor_that_was_swept(tmp_path, rotor):
    """Of two exciters each has a speed of its own; the one whose no-load speed is the axis is drawn."""
    case, path = load_case("gallery/two-exciters", {"run.t_end": "1 s"}), str(tmp_path / "two.h5")
    result = sweep(case, {f"rotors.{rotor}.Omega0": "10, 14 Hz"}, out=path)
    axes = drawn("sommerfeld", path).axes[0]
    (mean,) = lines(axes, "mean")
    np.testing.assert_array_equal(mean.get_ydata(), result[f"mean_speed_{rotor}"][:, 0])
    assert axes.get_ylabel() == f"Steady speed of {rotor} (Hz)"


def test_sommerfeld_has_fractions_of_the_bilinear_frequency(tmp_path):
    sweep(load_case("II-B", {"run.t_end": "4 s"}), {"Omega0": "3, 7 Hz"}, out=tmp_path / "x.h5")
    axes = drawn("sommerfeld", str(tmp_path / "x.h5")).axes[0]
    levels = {round(float(line.get_ydata()[0]), 2) for line in lines(axes, "level")}
    assert {4.91, 5.53} <= levels  # 2/3 and 3/4 of 7.37


def test_up_and_down_are_told_apart(paths):
    result = open_subject(paths["carried"]).result
    figure = drawn("sommerfeld", paths["carried"])
    up, down = lines(figure.axes[0], "mean")
    named = {line.get_label(): line.get_color() for line in figure.axes[0].lines}
    assert (named["up"], named["down"]) == (up.get_color(), down.get_color())
    np.testing.assert_array_equal(down.get_ydata(), result["mean_speed"][:, 1])
    assert up.get_color() != down.get_color() and up.get_markerfacecolor() != down.get_markerfacecolor()
    assert legend(figure) == ["no-load speed", "up", "down", "hysteresis"]


def test_hysteresis_is_shaded_between_up_and_down_but_not_across_leaps(paths):
    result = open_subject(paths["carried"]).result
    (shade,) = drawn("sommerfeld", paths["carried"]).axes[0].collections
    corners = [{(x, y) for x, y in path.vertices.tolist()} for path in shade.get_paths()]
    x, speeds = result["omega0"], result["mean_speed"]
    assert {*leaps(speeds[:, 0]), *leaps(speeds[:, 1])} == {0}  # from 3 Hz to 3.5 Hz, of steps that get less
    assert corners[-1] == {(x[i], y) for i in (1, 2) for y in speeds[i]}
    assert not any({3.0, 3.5} <= {across for across, _ in area} for area in corners)


@pytest.mark.parametrize("width", ["column", "page"])
def test_up_and_down_of_several_have_panels_of_their_own(paths, width):
    result = open_subject(paths["family"]).result
    figure = kind_named("sommerfeld").draw([open_subject(paths["family"])], View(width=width))
    titles = [axes.get_title(loc="left") for axes in figure.axes]
    assert titles == ["$c$ = 0.01 N s/m", "$c$ = 0.02 N s/m", "$c$ = 0.03 N s/m"]
    for i, axes in enumerate(figure.axes):
        for d, line in enumerate(lines(axes, "mean")):
            np.testing.assert_array_equal(line.get_ydata(), result["mean_speed"][:, i, d])
    on_paper(figure)


def test_a_grid_has_a_curve_per_other_value(paths):
    result = open_subject(paths["grid"]).result
    means = lines(drawn("sommerfeld", paths["grid"]).axes[0], "mean")
    assert [line.get_label() for line in means][:2] == ["$c$ = 0.01 N s/m", "$c$ = 0.02 N s/m"]
    for i, line in enumerate(means):
        np.testing.assert_array_equal(line.get_ydata(), result["mean_speed"][i, :, 0])


def test_amplitudes_are_drawn_in_hertz_and_millimetres(paths):
    result = open_subject(paths["ideal"]).result
    figure = drawn("amplitude", paths["ideal"])
    (line,) = lines(figure.axes[1], "x1")
    np.testing.assert_allclose(line.get_xdata(), np.array([20, 25]) / (2 * np.pi), rtol=1e-15)
    factor = {"mm": 1e3, "µm": 1e6}[figure.axes[1].get_ylabel()[-3:-1]]
    np.testing.assert_allclose(line.get_ydata(), factor * result["amplitude_x1"][:, 0], rtol=1e-15)


def test_orbit_draws_every_point(paths):
    result = open_subject(paths["motor"]).result
    axes = drawn("orbit", paths["motor"]).axes[1]
    (points,) = lines(axes, "section_speed")
    np.testing.assert_array_equal(points.get_ydata(), result["section_speed"].ravel())
    assert set(points.get_xdata()) == set(result["omega0"])


def test_sweeps_over_different_things_do_not_go_together(paths):
    with pytest.raises(PlotError, match="do not go into one picture"):
        drawn("amplitude", paths["motor"], paths["ideal"])


def test_a_window_outside_the_sweep(paths):
    for kind in KINDS:
        with pytest.raises(PlotError, match="the window 1:2 lies outside the sweep"):
            kind_named(kind).draw([open_subject(paths["motor"])], View(window=(1, 2)))


def test_two_sweeps_in_one_picture(paths, tmp_path):
    out = tmp_path / "two.pdf"
    assert draw_files([paths["motor"], paths["carried"]], None, View(), str(out)) == [str(out)]
    assert len(lines(drawn("sommerfeld", paths["motor"], paths["carried"]).axes[0], "mean")) == 3


def test_a_branch_over_a_sommerfeld_picture_has_the_speed_of_the_rotor_drawn(tmp_path):
    """Exciters that turn against each other: the second one's turns are backwards."""
    against = {"rotors.right.M0": "-0.3 N m", "rotors.right.Omega0": "-10 Hz", "run.t_end": "6 s"}
    case, key = load_case("gallery/two-exciters", against), "rotors.right.Omega0"
    swept, branched = str(tmp_path / "swept.h5"), str(tmp_path / "branch.h5")
    sweep(case, {key: "-10.1, -10, -9.9 Hz"}, out=swept)
    continue_branch(orbit(case), {key: "-10.05:-9.95 Hz"}, out=branched)
    axes = drawn("sommerfeld", swept, branched).axes[0]
    (mean,), branch = lines(axes, "mean"), [*lines(axes, "stable"), *lines(axes, "unstable")]
    assert mean.get_ydata()[1] == pytest.approx(-10, abs=0.02)
    assert branch
    for line in branch:
        np.testing.assert_allclose(line.get_ydata(), -10, atol=0.1)
