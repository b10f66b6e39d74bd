"""Pictures of runs with rotors, further states and formulas show the numbers of their columns."""

import re

import numpy as np
import pytest

from tests.formula_cases import CURRENT, DRIVE, MACHINE, case_of, fading, machine_file, turned
from tests.plots.artists import lines, points
from tests.plots.html_data import data_of
from vibsim.physics.connections import joined_pairs
from vibsim.plots.html_pages import write_page
from vibsim.plots.overview import motions_of, spring_force, stiffness_characteristic
from vibsim.plots.picture import columns_picture
from vibsim.plots.registry import choose, fitting
from vibsim.plots.subject import View, open_subject, subject_of
from vibsim.results import simulate_to_file

__all__ = ["machine_file"]


@pytest.fixture(scope="module")
def run(machine_file, tmp_path_factory):
    return stored(machine_file[0], tmp_path_factory)


@pytest.fixture(scope="module")
def drive(tmp_path_factory):
    return stored(case_of(DRIVE), tmp_path_factory)


def stored(case, tmp_path_factory):
    path = tmp_path_factory.mktemp("run") / f"{case.name}.h5"
    simulate_to_file(case, path)
    return open_subject(str(path))


def figure_of(kind, subjects, **view):
    (chosen,) = choose([kind], subjects)
    return chosen.draw(subjects, View(**{"width": "column", **view}))


def labels(figure):
    return [text for axes in figure.axes for text in (axes.get_xlabel(), axes.get_ylabel())]


def test_kinds_fit_what_a_run_has(run, drive):
    kinds = {kind.name for kind in fitting([run])}
    assert {"overview", "displacement", "phase", "rotor-speed", "states", "stiffness"} <= kinds
    assert not {"motor", "motor-speed", "displacement-frequency"} & kinds
    assert not {"rotor-speed", "states"} & {kind.name for kind in fitting([drive])}


def test_speeds_of_rotors(run):
    """w/(2 pi) in Hz, by the closed form."""
    figure = figure_of("rotor-speed", [run])
    t, hertz = points(lines(figure, "w_left")[0])
    assert hertz == pytest.approx([turned(each)[1] / (2 * np.pi) for each in t], rel=1e-12)
    assert "Rotor speed (Hz)" in labels(figure)


def test_states(run):
    figure = figure_of("states", [run])
    t, values = points(lines(figure, "i")[0])
    assert values == pytest.approx([1000 * fading(each) for each in t], rel=1e-12)
    assert labels(figure) == ["Time (s)", "i (mA)"]
    figure = figure_of("states", [run, run])
    assert len(figure.axes) == 1 and len(lines(figure, "i")) == 2


def test_only_bodies_have_displacements_and_velocities(run):
    for kind, names in (("displacement", {"x_cart"}), ("velocity", {"v_cart"}), ("phase", {"x_cart"})):
        gids = {line.get_gid() for axes in figure_of(kind, [run]).axes for line in axes.get_lines()}
        assert {gid for gid in gids if gid in run.tables.states} == names


def test_any_column_goes_against_any(run):
    figure = figure_of_columns(run, "phi_left", "w_left")
    x, y = points(lines(figure, "columns")[0])
    assert y**2 == pytest.approx(25 + 10 * (x - np.pi / 2), rel=1e-12)  # w^2 = w0^2 + 2 alpha (phi - phi0)
    assert labels(figure) == ["phi_left (rad)", "w_left (rad/s)"]
    assert labels(figure_of_columns(run, "time", "i")) == ["time (s)", "i (A)"]


def figure_of_columns(run, x, y):
    return columns_picture([run], View(width="column", x=x, y=y))


def test_a_torsional_scene_is_labelled_in_radians_and_newton_metres(drive):
    texts = labels(figure_of("overview", [drive]))
    assert all(re.search(r"\((m|µ)?rad(/s)?\)|Time", text) for text in texts if text)
    assert any("rad/s)" in text for text in texts)
    stiffness = labels(figure_of("stiffness", [drive]))
    assert "rad)" in stiffness[0] and stiffness[1].endswith("N m)")
    slopes = [text.get_text() for axes in figure_of("stiffness", [drive]).axes for text in axes.texts]
    assert "slope 300 N m/rad" in slopes


def test_the_overview_has_the_machine_and_the_speed(run):
    figure = figure_of("overview", [run], width="page")
    assert lines(figure, "w_left") and lines(figure, "x_cart")
    gids = {patch.get_gid() for axes in figure.axes for patch in axes.patches}
    assert {"bodies.cart", "rotors.left"} <= gids


def test_the_characteristic_of_a_formula_is_the_formula():
    """k y + k3 y^3, and the stop's k2 (y - gap) beyond 2 mm, at rest."""
    scene = case_of(MACHINE).scene()
    (pair,) = joined_pairs(scene)
    y, force = stiffness_characteristic(scene, pair, 0.01)
    assert len(y) > 100 and 0.002 in y
    assert force == pytest.approx(400 * y + 1e5 * y**3 + 1e4 * np.maximum(y - 0.002, 0), rel=1e-12)
    assert motions_of([subject_of(case_of(MACHINE))]) == ["$x_\\mathrm{cart}$"]


def test_the_characteristic_of_a_formula_from_the_other_end():
    """A link written from ground to body pulls the body back as well."""
    text = MACHINE.replace("between: [cart, ground], force", "between: [ground, cart], force")
    scene = case_of(text).scene()
    pair = joined_pairs(scene)[0]
    assert spring_force(scene, pair, np.array([0.01])) == pytest.approx([400 * 0.01 + 1e5 * 1e-6])


def test_a_page_has_rotors_and_states(run, drive, tmp_path):
    write_page([run], str(tmp_path / "run.html"))
    data = data_of(tmp_path / "run.html")
    panels = {panel["label"]: [curve["column"] for curve in panel["curves"]] for panel in data["panels"]}
    assert panels["rotor speed (Hz)"] == ["w_left"] and panels["i (A)"] == ["i"]
    assert data["parts"] == ["wall", "push"] and data["kinds"]["14"] == "switch"
    write_page([drive], str(tmp_path / "drive.html"))
    assert "14" not in data_of(tmp_path / "drive.html")["kinds"]  # which has no switches


def test_impacts_have_the_phase_of_the_rotor_that_turns_the_scene(tmp_path):
    wall = "stops: {wall: {between: [cart, ground], gap: 0 mm, acts: compression, k: 1e4 N/m}}\n"
    simulate_to_file(case_of(CURRENT + wall), tmp_path / "current.h5")
    figure = figure_of("impact-velocity", [open_subject(str(tmp_path / "current.h5"))])
    phases = points(lines(figure, "impacts")[-1])[0]
    assert len(phases) and phases.min() >= 0 and phases.max() <= 360
    assert "Phase of the source at impact (°)" in labels(figure)
