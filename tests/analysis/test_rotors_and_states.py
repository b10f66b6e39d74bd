"""Verdicts on runs with rotors, further states and formulas."""

import numpy as np
import pytest

import vibsim
from tests.formula_cases import CURRENT, DRIVE, MACHINE, case_of
from vibsim.analysis.comparison import block_values, compare, unit_of
from vibsim.analysis.cycles import cycle_ends
from vibsim.analysis.drift import displacement, drifting
from vibsim.analysis.sections import SectionCoordinates
from vibsim.plots.poincare_sections import turn_times


@pytest.fixture(scope="module")
def run():
    return vibsim.simulate(case_of(CURRENT, {"run.t_end": "3 s"}))


def test_cycles_are_turns_of_the_rotor(run):
    """The angle passes whole turns there, to the line between two samples, and exactly where it is drawn."""
    for times, error in ((cycle_ends(run, (1.0, 3.0)), 1e-3), (turn_times(run, (1.0, 3.0)), 1e-7)):
        angles = run.at(times)["phi_left"] / (2 * np.pi)
        assert len(times) > 15 and np.abs(angles - np.round(angles)).max() < error


def test_the_regime_of_a_motor_with_its_current(run):
    verdicts = vibsim.analyse(run)
    assert verdicts.regime.verdict == "periodic" and verdicts.regime.period == 1
    assert len(verdicts.regime.multipliers) == 4
    assert verdicts.capture is None and verdicts.frequencies.verdict == "lines"


def test_coordinates_of_a_section_have_speeds_angles_and_states():
    """Of the machine, which a push drives: y, u, speed of the rotor, state; its angle no force feels."""
    at = SectionCoordinates(case_of(MACHINE).scene())
    assert at.names == ("x_cart", "v_cart", "w_left", "i")
    states = {name: np.array([1.0, 2.0]) for name in ("time", *at.names)}
    sizes = at.sizes(np.array([-1.0, -2.0, 3.0, 4.0]), np.array([1.0, 2.0, 5.0, 4.0]))
    assert sizes.tolist() == [1.0, 2.0, 1.0, 0.004]  # what hardly changes counts by a thousandth of itself
    assert at.points(states, sizes).shape == (2, 4)


def test_the_angle_of_a_further_rotor_counts_by_sine_and_cosine():
    text = MACHINE.replace("e: 0 m", "e: 0.01 m")
    at = SectionCoordinates(case_of(text).scene())
    states = {name: np.array([0.0]) for name in ("time", *at.names)} | {"phi_left": np.array([np.pi / 3])}
    points = at.points(states, np.ones(4))
    assert points[0, 4:] == pytest.approx([0.5, np.sqrt(0.75)])


def test_runs_are_compared_by_speeds_and_states_too(run):
    values = block_values(run, [(0.5, 1.0), (1.0, 1.5)])
    assert set(values) == {"amplitude", "rotor speed", "mean i"}
    speed = run["phi_left"][300] - run["phi_left"][200]
    assert values["rotor speed"][1] == pytest.approx(speed / 0.5 / (2 * np.pi), rel=1e-2)
    scene = run.case.scene()
    assert [unit_of(name, scene) for name in ("amplitude", "rotor speed", "mean i")] == ["m", "Hz", "A"]
    assert unit_of("drift rate", case_of(DRIVE).scene()) == "rad/s"


def test_states_alone_do_not_make_runs_differ():
    """Another state that no force reads: the displacements agree to the end."""
    one, other = (
        vibsim.simulate(case_of(MACHINE, {"states.i.start": start})) for start in ("0.5 A", "0.7 A")
    )
    assert compare(one, other, 1e-9).verdict == "agree"
    assert float(one["i"][-1]) != float(other["i"][-1])


def test_the_centre_of_mass_has_unbalances_in_it():
    """m x + m_r e cos(phi), by the mass of all."""
    case = case_of(
        MACHINE.replace("e: 0 m", "e: 0.02 m").replace(
            "between: [cart, ground], force", "between: [cart, ground], force"
        )
    )
    run = vibsim.simulate(case)
    expected = (1.1 * run["x_cart"] + 0.1 * 0.02 * np.cos(run["phi_left"])) / 1.1
    assert displacement(run, slice(None), "centre") == pytest.approx(expected, abs=1e-16)


def test_what_drifts_is_on_the_line():
    assert drifting(case_of(DRIVE).scene()) == {"load": "x_load"}
    assert drifting(case_of(MACHINE).scene()) == {}
    verdicts = vibsim.analyse(case_of(DRIVE), what=["drift", "impacts"], exponent=False)
    assert verdicts.drift.of == "x_load"
    assert verdicts.impacts.velocity is None or verdicts.impacts.velocity.unit == "rad/s"


def test_exponents_leave_out_what_no_force_feels():
    """x, v of the cart, w of the rotor and the state: the angle and the x of the state are none."""
    spectrum = vibsim.lyapunov(case_of(MACHINE, {"run.t_end": "0.5 s"}))
    assert len(spectrum.exponents) == 4
    assert spectrum.exponents.sum() == pytest.approx(
        -2 / 1.1 - 2, rel=1e-9
    )  # c/m of the cart, 1/T of the state
