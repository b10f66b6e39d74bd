"""What begins so flat that its first derivatives are zero, under forces that rise as high powers of time."""

from dataclasses import replace
from fractions import Fraction
from math import cos, factorial, pi

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tests.engine.runs import run, scene_of, whole
from vibsim.cases.case import load_case_text
from vibsim.engine.truth import open_truth
from vibsim.physics.parts import EVENT_NAMES, GROUND, Body, Force, Harmonic, Link, Scene

SPRING = "links: {s: {between: [b, ground], k: 100 N/m}}"
TOUCHING = "stops: {s: {between: [b, ground], gap: 0 m, acts: compression, k: 100 N/m}}"
RIGID = "stops: {s: {between: [b, ground], gap: 0 m, acts: compression, law: rigid, e: 0.5}}"


def pushed(force, part):
    return f"""
        bodies: {{b: 1 kg}}
        {part}
        forces: {{F: {{on: b, force: "{force}"}}}}
        run: {{t_end: 3 s, every: 0.25 s}}"""


def displacement(n, t):
    """x [m] of x'' = t^n - 100 x from rest: sum of n! (-100)^j t^(n + 2 + 2 j) / (n + 2 + 2 j)!, exactly."""
    t = Fraction(t)
    powers = range(n + 2, n + 130, 2)
    return float(sum(factorial(n) * (-100) ** ((p - n - 2) // 2) * t**p / factorial(p) for p in powers))


def kinds(events):
    return [EVENT_NAMES[kind] for kind in events["kind"]]


@pytest.mark.parametrize("n", [3, 6, 10])
@pytest.mark.parametrize("part", [SPRING, TOUCHING])
def test_a_force_that_begins_as_a_power_of_the_time_moves_a_body_as_theory_says(n, part):
    """The rate begins with the power n + 1; a stop that just touches is pressed from the start on."""
    found = run(scene_of(pushed(f"t**{n}*1 N/s^{n}", part)))
    expected = [displacement(n, t) for t in found.samples["time"].tolist()]
    assert np.abs(found.samples["x_b"] / [max(x, 1e-30) for x in expected] - 1)[1:].max() < 1e-13
    assert kinds(found.events) == ["start", "end"]
    assert found.totals["uncertified"] == 0


@pytest.mark.parametrize("part", [SPRING, TOUCHING])
def test_many_digits_move_it_so_too(part):
    case = load_case_text(pushed("t**6*1 N/s^6", part))
    samples = whole([block.samples for block in open_truth(case.exact_scene, 40).blocks()])
    expected = [displacement(6, t) for t in samples["time"].tolist()]
    np.testing.assert_allclose(samples["x_b"], expected, rtol=1e-15)


def test_harmonics_that_begin_so_do_as_in_closed_form():
    """(1 - cos t)^3 as four harmonics: the rate begins with t^7."""
    terms = [(-15 / 4, 1.0), (1.5, 2.0), (-0.25, 3.0)]
    force = Force("F", 0, 2.5, tuple(Harmonic(A, w, w / (2 * pi), 0.0, pi / 2) for A, w in terms))
    link = Link("s", 0, GROUND, 100.0, 0.0)
    scene = Scene((Body("b", 1.0, 0.0, 0.0),), (link,), forces=(force,), t_end=3.0)
    one, other = (run(replace(scene, method=method)).samples["x_b"] for method in ("closed_form", "taylor"))
    assert one.max() > 0.05 and np.abs(one - other).max() < 1e-15


@pytest.mark.parametrize(
    ("force", "part", "happens"),
    [
        ("t**8*1 N/s^8", RIGID, []),
        ("-t**8*1 N/s^8", RIGID, []),
        ("-t**8*1 N/s^8", TOUCHING, []),
        ("where(t > 1 s, (t - 1 s)**7*1 N/s^7, 0 N)", TOUCHING, ["contact_begin"]),
        ("t**8*(2 s - t)*1 N/s^9", RIGID, ["rest_end"]),
    ],
)
def test_what_just_touches_goes_where_a_late_derivative_leads(force, part, happens):
    """More derivatives are zero than a scene of one body is asked for where forces are harmonic."""
    assert kinds(run(scene_of(pushed(force, part))).events) == ["start", *happens, "end"]


@pytest.mark.parametrize("n", [3, 5, 7, 9])
def test_a_limit_that_is_passed_flat_is_in_doubt(n):
    """Friction lets go where 1 N + (t - 1 s)^n passes its limit, 1 N: at 1 s, where rounding hides it."""
    friction = "friction: {f: {between: [b, ground], N: 2 N, mu: 0.5}}"
    found = run(scene_of(pushed(f"1 N + (t - 1 s)**{n}*1 N/s^{n}", friction)))
    assert kinds(found.events) == ["start", "stick_end", "end"]
    assert found.events["t"][1] == pytest.approx(1.0, abs=3 * (64 * 2.0**-52) ** (1 / n))
    assert found.totals["uncertified"] > 0


def test_what_touches_at_the_start_is_asked_on_the_sides_that_springs_go_to():
    """Two bodies that touch and rest at the kink of a spring: b moves ahead of a and presses on it from the
    start. On the other side of the kink it would stay behind, and the run began so, free until 0.107 s.
    """
    text = """
bodies: {a: 1 kg, b: 1 kg}
links:
  s: {between: [a, ground], k: 100 N/m}
  kinked: {between: [b, ground], force: "k*max(d, 0) + 2*k*min(d, 0)", k: 100 N/m}
stops: {touch: {between: [a, b], gap: 0 m, acts: extension, k: 500 N/m}}
forces:
  Fa: {on: a, A: 1 N, omega: 10 rad/s, phase: 90 deg}
  Fb: {on: b, A: 1 N, omega: 5 rad/s, phase: 90 deg}
run: {t_end: 0.5 s, every: 20 ms}
"""

    def rates(t, y):
        push = 500 * max(y[1] - y[0], 0)
        spring = 100 * max(y[1], 0) + 200 * min(y[1], 0)
        return [y[2], y[3], cos(10 * t) - 100 * y[0] + push, cos(5 * t) - spring - push]

    result = run(scene_of(text))
    assert kinds(result.events) == ["start", "end"] and result.row(0)["touch"] == 1
    other = solve_ivp(rates, (0, 0.5), [0] * 4, "DOP853", t_eval=[0.5], rtol=1e-11, atol=1e-14, max_step=1e-3)
    ours = [result.final(name) for name in ("x_a", "x_b", "v_a", "v_b")]
    np.testing.assert_allclose(ours, other.y[:, -1], rtol=0, atol=1e-9)  # a step of it goes over the kink
