"""What a completed chatter leaves out counts as error: the companion leaves it out too."""

import pytest

from vibsim import simulate
from vibsim.cases.loading import load_case_text


def test_the_estimate_covers_what_chatter_leaves_out():
    result = simulate("gallery/pile-driver")
    left_out = result.attrs["chatter_distance"]
    assert result.attrs["chatters"] > 0 and left_out > 1e-14
    assert result.error_estimate[-1] >= left_out


RUBBED = """
bodies: {a: 2.598 kg, b: 0.5684 kg}
links:
  la: {between: [a, base], k: 462.8 N/m}
  ab: {between: [a, b], k: 266.1 N/m, c: 2.486 N s/m}
stops: {wall: {between: [ground, b], law: rigid, gap: 5.478 mm, acts: extension, e: 0.6127}}
friction: {rub: {between: [a, b], N: 1.698 N, mu: 0.3578, static: 1.282}}
base:
  terms:
  - {a: 1.696 mm, omega: 0.6284 Hz, phase: 2.76722382455 rad}
  - {a: 4.237 mm, omega: 2.032 Hz, phase: 2.62508340958 rad}
forces:
  drive:
    on: a
    terms:
    - {A: 1.405 N, omega: 1.373 Hz, phase: 0.805682437623 rad}
    - {A: 1.701 N, omega: 1.099 Hz, phase: 5.95644492161 rad}
initial:
  a: {x: 6.34896768997 mm, v: 16.3543497299 mm/s}
  b: {x: 5.46274685816 mm, v: -8.27399518885 mm/s}
run: {t_end: 40 ms, every: 10 ms}
"""


def test_the_estimate_covers_the_velocity_that_chatter_leaves_out():
    """b strikes the wall and rubs on a, which goes on: what a lacks when the hops end early is not given
    back. It is 2e-9 m/s, and grows far beyond the height of the hops. The truth has 30 digits.
    """
    pytest.importorskip("flint")
    case = load_case_text(RUBBED)
    result, truth = simulate(case), simulate(case, digits=30)
    error = max(abs(result[name][-1] - truth[name][-1]) for name in ("x_a", "x_b"))
    assert result.attrs["chatters"] == 1
    assert error > 1e3 * result.attrs["chatter_distance"]
    assert error < result.error_estimate[-1] < 1e2 * error
