"""Births and deaths of attractors against closed forms, and against numbers of other solvers."""

import numpy as np
import pytest

from tests.sweeps.made import complete, short_plan
from vibsim.cases.case import load_case, load_case_text
from vibsim.sweeps.attractor_changes import attractor_changes
from vibsim.sweeps.sweep_plan import PlanError

ESCAPE = """
bodies: {mass: 1 kg}
links:
  spring: {between: [mass, ground], force: "k1*d - k2*d**2 + c0*v", k1: 1 N/m, k2: 1 N/m^2, c0: 0.1 N s/m}
forces:
  drive: {on: mass, A: 0.06 N, omega: 0.85 rad/s}
run: {t_end: 400 s, every: 50 ms}
"""


def changes_of(axes, case, path, **settings):
    return attractor_changes(
        complete(short_plan(axes, case, compute="attractor", section=0, **settings), path)[0]
    )


def test_rest_on_a_belt_is_born_in_a_hopf_point_and_its_cycle_dies_in_a_corner(tmp_path):
    """Rest is stable above ln(10) / 2, where damping and the slope of the friction are equal; the cycle is
    there up to 1.836600972207926 m/s.
    """
    case = load_case("gallery/belt-oscillator", {"run.t_end": "400 s"})
    axes = {"belt.belt": "1.1,1.4,1.9 m/s", "block.x": "0.3:1.5/3 m", "block.v": "0:1.5/2 m/s"}
    born, dies = changes_of(axes, case, tmp_path / "belt.h5")
    assert born.birth and born.parameter == pytest.approx(np.log(10) / 2, abs=1e-8)
    assert "Hopf" in born.cause
    assert not dies.birth and dies.parameter == pytest.approx(1.836600972207926, abs=1e-9)


def test_the_resonant_motion_of_an_escape_equation_dies_in_a_fold(tmp_path):
    """At the fold a multiplier is 1; the orbit that DOP853 and Newton's method find just in front of it has
    one near 1, and none is there just behind it.
    """
    from scipy.integrate import solve_ivp
    from scipy.optimize import root

    axes = {"drive.A": "0.06,0.07 N", "mass.x": "-0.4:0.4/4 m", "mass.v": "-0.3:0.3/4 m/s"}
    changes = changes_of(axes, load_case_text(ESCAPE), tmp_path / "escape.h5")
    (fold,) = [change for change in changes if change.cause == "a fold"]
    assert not fold.birth and 0.06 < fold.parameter < 0.07

    def mapped(y, A):
        def rates(t, y):
            x, v, *D = y
            D = np.array(D).reshape(2, 2)
            slopes = np.array([[0, 1], [-1 + 2 * x, -0.1]]) @ D
            return [v, A * np.sin(0.85 * t) - x + x * x - 0.1 * v, *slopes.ravel()]

        end = solve_ivp(
            rates, (0, 2 * np.pi / 0.85), [*y, 1, 0, 0, 1], method="DOP853", rtol=1e-12, atol=1e-13
        ).y[:, -1]
        return end[:2], end[2:].reshape(2, 2)

    def at_fold(unknowns):
        """A fixed point one of whose multipliers is 1: det(D - 1) = 0."""
        *y, A = unknowns
        image, D = mapped(y, A)
        return [*(image - y), np.linalg.det(D - np.eye(2))]

    start = [*_orbit_near(fold, axes, tmp_path), fold.parameter]
    solution = root(at_fold, start, tol=1e-11)
    assert solution.success
    assert fold.parameter == pytest.approx(solution.x[2], abs=1e-8)


def _orbit_near(fold, axes, tmp_path):
    """Where the dying orbit meets the section at the last point that has it."""
    plan = short_plan(axes, load_case_text(ESCAPE), compute="attractor", section=0)
    sweep, _ = complete(plan, tmp_path / "escape.h5")
    return sweep.attractors["state"][fold.attractor]


@pytest.mark.slow
def test_chaos_between_two_wells_dies_in_a_boundary_crisis(tmp_path):
    """x'' = x - x^3 - 0.25 x' + A sin t: of 60 starts run on in fixed steps of the fourth order, all stay on
    the set 0.01 N below, and most leave it 0.03 N above.
    """
    case = load_case("gallery/duffing-two-well", {"run.t_end": "3000 s"})
    axes = {"drive.A": "0.4,0.5 N", "mass.x": "-1:1/3 m", "mass.v": "0,0.5 m/s"}
    changes = changes_of(axes, case, tmp_path / "wells.h5")
    (crisis,) = [change for change in changes if "crisis" in change.cause]
    assert not crisis.birth and 0.4 < crisis.parameter < 0.5

    def large(A, periods):
        """Share of starts on the motion of one period, by its distance from itself a period before."""

        def rates(t, y):
            return np.array([y[1], A * np.sin(t) + y[0] - y[0] ** 3 - 0.25 * y[1]])

        y, h, before = np.array([np.linspace(-0.4, 0.4, 60), np.zeros(60)]), 2 * np.pi / 120, None
        for step in range(periods * 120):
            if step == (periods - 1) * 120:
                before = y
            k1 = rates(step * h, y)
            k2 = rates((step + 0.5) * h, y + h / 2 * k1)
            k3 = rates((step + 0.5) * h, y + h / 2 * k2)
            k4 = rates((step + 1) * h, y + h * k3)
            y = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        return (np.abs(y - before).max(axis=0) < 1e-6).mean()

    assert large(crisis.parameter - 0.01, 400) == 0
    assert large(crisis.parameter + 0.03, 400) > 0.5


def test_births_are_those_of_a_parameter(tmp_path):
    plan = short_plan({"tip.x": "-4:4/4 mm"}, load_case("gallery/cantilever"), compute="attractor", section=0)
    sweep, _ = complete(plan, tmp_path / "plane.h5")
    with pytest.raises(PlanError, match="are those of a sweep over one parameter"):
        attractor_changes(sweep)
