"""Families of curves: rounded names, a colour bar for many values, panels that do not hide each other."""

import numpy as np
import pytest

from tests.plots.artists import laid_out, letters, lines, on_paper
from vibsim.cases import load_case
from vibsim.plots.capture_pictures import speed_classes
from vibsim.plots.registry import fitting, kind_named
from vibsim.plots.subject import View, open_subject
from vibsim.plots.sweep_axes import along, label_of, plane_of, value_texts
from vibsim.plots.sweep_curves import curves
from vibsim.plots.sweep_pictures import absorbed_powers, source_power
from vibsim.sweeps import sweep
from vibsim.sweeps.axes import read_axis

SWEEPS = {
    "fractions": ({"Omega0": "3, 4 Hz", "c": "0.001:0.1/8"}, {}),
    "both": ({"Omega0": "3, 4 Hz"}, {"carry_state": True, "direction": "both"}),
    "families": ({"Omega0": "3, 4 Hz", "c": "0.01:0.09/9"}, {"carry_state": True, "direction": "both"}),
    "few": ({"Omega0": "3, 4 Hz", "c": "0.01, 0.02, 0.03"}, {}),
    "one": ({"Omega0": "5 Hz", "c": "0.01, 0.02, 0.03"}, {}),
}


@pytest.fixture(scope="module")
def paths(tmp_path_factory):
    folder = tmp_path_factory.mktemp("families")
    for name, (axes, settings) in SWEEPS.items():
        sweep(load_case("II-B", {"run.t_end": "2 s"}), axes, out=folder / f"{name}.h5", **settings)
    return {name: str(folder / f"{name}.h5") for name in SWEEPS}


def test_values_are_rounded_decimals(paths):
    axis = open_subject(paths["fractions"]).result.axes[1]
    assert value_texts(axis)[:3] == ["$c$ = 0.001 N s/m", "$c$ = 0.0151 N s/m", "$c$ = 0.0293 N s/m"]
    assert not any("/7000" in text or "/3500" in text for text in value_texts(axis))


CURVES = {"sommerfeld": "mean", "amplitude": "x1"}


@pytest.mark.parametrize(("kind", "gid"), CURVES.items())
def test_many_values_have_a_colour_bar(paths, kind, gid):
    figure = laid_out(kind, paths["fractions"])
    (bar,) = [axes for axes in figure.axes if axes.get_label() == "<colorbar>"]
    assert bar.get_xlabel() == "Damping $c$ (N s/m)"
    assert bar.get_xlim() == pytest.approx((0.001, 0.1))
    assert not figure.legends
    assert len({tuple(line.get_color()) for line in lines(figure, gid)}) == 8


def test_up_and_down_have_orbits_of_their_own(paths):
    result = open_subject(paths["both"]).result
    figure = laid_out("orbit", paths["both"])
    up, down = lines(figure, "section_speed")
    assert up.axes is not down.axes and up.axes.get_ylim() == down.axes.get_ylim()
    for d, line in enumerate((up, down)):
        np.testing.assert_array_equal(line.get_ydata(), result["section_speed"][:, d].ravel())
    assert letters(figure) == ["(a)", "(b)", "(c)", "(d)"]
    assert up.get_markersize() >= 1.5  # points: few columns have room for dots that are seen


@pytest.mark.parametrize("kind", ["sommerfeld", "orbit"])
def test_no_picture_is_taller_than_a_page(paths, kind):
    figure = laid_out(kind, paths["families"])
    assert figure.get_figheight() * 2.54 < 25
    assert any(" of " in axes.get_title(loc="right") for axes in figure.axes)
    titles = [axes.get_title(loc="left") for axes in figure.axes if axes.get_title(loc="left")]
    assert len(titles) == len(set(titles))


def test_a_single_motor_constant_is_not_drawn_along(paths):
    subject = open_subject(paths["one"])
    assert subject.result.axes[along(subject.result)].key == "coupling.c"
    assert "sommerfeld" not in {kind.name for kind in fitting([subject])}
    (line,) = lines(laid_out("amplitude", paths["one"]), "x1")
    np.testing.assert_array_equal(line.get_xdata(), [0.01, 0.02, 0.03])


def test_cells_do_not_reach_below_zero(paths):
    _, up = plane_of(open_subject(paths["fractions"])).spans()
    assert up[0, 0] == 0.0 and (np.diff(up) > 0).all()
    np.testing.assert_array_equal(up[1:, 0], up[:-1, 1])  # even values touch


def test_equal_steps_of_colour_are_equal_steps_of_speed():
    """Most are held about one resonance: its range has the steps, what lies beyond has the end's colour."""
    near = np.linspace(3.601, 3.679, 161)
    edges, extend = speed_classes(np.concatenate([near, [4.9, 5.5]]))
    steps = np.diff(edges)
    assert len(steps) >= 5 and np.ptp(steps) < 1e-12
    assert extend == "max" and edges[0] <= 3.605 and 3.675 <= edges[-1] < 4.9
    for speeds, low, high in ((near, 3.601, 3.679), (np.array([3.6, 3.6]), 3.6, 3.6), (np.empty(0), 0, 1)):
        edges, extend = speed_classes(speeds)
        assert extend == "neither" and np.ptp(np.diff(edges)) < 1e-12
        assert edges[0] <= low and edges[-1] >= high


@pytest.mark.parametrize(("kind", "gid"), CURVES.items())
def test_a_few_families_differ_in_their_marks_too(paths, kind, gid):
    """In grey print; a family swept both ways has one mark, closed and open."""
    few, both, many = (lines(laid_out(kind, paths[name]), gid) for name in ("few", "both", "fractions"))
    assert [line.get_marker() for line in few] == ["o", "s", "^"]
    assert [line.get_marker() for line in both] == ["o", "o"]
    assert len({line.get_markerfacecolor() for line in both}) == 2
    assert {line.get_marker() for line in many} == {"o"}  # of which colours tell the value


# Pictures of sweeps of scenes of named parts: what fits is drawn, with the names of bodies and parts.


OF_PARTS = {
    "drill": ("percussive-drill", {"feed.A": "50, 60, 70 N"}, {"compute": ["power", "lyapunov"]}),
    "map": ("impact-damper", {"left.k": "20, 50 kN/m", "drive.omega": "0.9, 1 Hz"}, {"compute": "regime"}),
    "stack": ("stack-of-blocks", {"base.omega": "3, 4 Hz"}, {"compute": "power", "ensemble": 3,
              "spread": {"table.mu": "0.01"}}),
}  # fmt: skip
KINDS_OF_PARTS = {
    "drill": {"amplitude", "orbit", "power", "lyapunov"},
    "map": {"amplitude", "orbit", "regime"},
    "stack": {"amplitude", "orbit", "power"},
}


@pytest.fixture(scope="module")
def subjects(tmp_path_factory):
    folder, opened = tmp_path_factory.mktemp("parts"), {}
    for name, (case, axes, settings) in OF_PARTS.items():
        short = load_case(f"gallery/{case}", {"run.t_end": {"map": "6 s"}.get(name, "1 s")})
        sweep(short, axes, out=folder / f"{name}.h5", jobs=2, **settings)
        opened[name] = open_subject(str(folder / f"{name}.h5"))
    return opened


@pytest.mark.parametrize("name", OF_PARTS)
def test_what_fits_parts_is_drawn_and_fit_to_print(subjects, name):
    assert {kind.name for kind in fitting([subjects[name]])} == KINDS_OF_PARTS[name]
    for kind in KINDS_OF_PARTS[name]:
        on_paper(kind_named(kind).draw([subjects[name]], View()))


def test_panels_have_the_names_of_coordinates(subjects):
    figure = kind_named("amplitude").draw([subjects["drill"]], View())
    labels = [axes.get_ylabel() for axes in figure.axes[:2]]
    assert labels == [r"$x_\mathrm{hammer} - x_\mathrm{bit}$ (mm)", r"$x_\mathrm{hammer}$ (mm)"]
    (line,) = lines(figure.axes[0], "relative_shank")
    shown = subjects["drill"].result["amplitude_relative_shank"][:, 0]
    np.testing.assert_allclose(line.get_ydata() / line.get_ydata()[0], shown / shown[0], rtol=1e-14)
    assert figure.axes[-1].get_xlabel() == "Amplitude $A$ of feed (N)"
    orbit = kind_named("orbit").draw([subjects["drill"]], View())
    assert r"x_\mathrm{hammer} - x_\mathrm{bit}" in orbit.axes[0].get_ylabel()


@pytest.mark.parametrize("name", ["drill", "stack"])
def test_what_is_taken_and_stored_adds_up_to_what_is_given(subjects, name):
    (curve,) = curves([subjects[name]])
    total = sum(absorbed_powers(curve).values())
    assert (source_power(curve) > 0).all() and len(absorbed_powers(curve)) >= 3 - (name == "stack")
    np.testing.assert_allclose(total, source_power(curve), rtol=1e-9)


def test_axes_are_labelled_with_what_they_belong_to():
    case = load_case("gallery/percussive-drill")
    labels = {
        "stops.shank.gap": ("1, 2 mm", "Gap of shank (mm)"),
        "bodies.bit": ("1, 2 kg", "Mass $m$ of bit (kg)"),
        "feed.omega": ("10, 20 Hz", r"Excitation frequency $\omega/2\pi$ of feed (Hz)"),
        "rock.mu": ("0.1, 0.2", r"Coefficient of friction $\mu$ of rock"),
        "initial.bit.v": ("0, 1 m/s", "Velocity at the start $v(0)$ of bit (m/s)"),
        "run.t_end": ("1, 2 s", "t_end (s)"),
    }
    for key, (values, label) in labels.items():
        assert label_of(read_axis(case, key, values)) == label
    assert value_texts(read_axis(case, "bodies.bit", "1, 2 kg")) == ["$m$ of bit = 1 kg", "$m$ of bit = 2 kg"]
