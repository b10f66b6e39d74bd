"""What rests, and sweeps that go up as they come down, as pictures and verdicts show them."""

import numpy as np
import pytest

import vibsim

CAM = """
name: cam
bodies: {follower: 0.5 kg}
links: {spring: {between: [follower, ground], force: "k*(d + d0)", k: 1 kN/m, d0: 5 mm}}
stops: {cam: {between: [base, follower], law: rigid, gap: 0 m, acts: compression, e: 0.3}}
base: {a: 4 mm, omega: 10 Hz, phase: -90 deg}
initial: {follower: {x: -4 mm}}
run: {t_end: 2 s, every: 2 ms}
"""
FRAME = """
bodies: {frame: 1 kg}
links: {spring: {between: [frame, ground], k: 1 kN/m, c: 20 N s/m}}
motor: {on: frame, m3: 10 g, e: 10 mm, J: 1 kg mm^2, M0: 0.08 N m, Omega0: 7 Hz}
run: {t_end: 5 s, every: 5 ms}
"""


@pytest.fixture(scope="module")
def cam():
    return vibsim.simulate(CAM)


def test_a_follower_that_stays_on_its_cam_has_no_relative_motion(cam):
    """m a w^2 = 7.9 N is less than the spring's 9 N at the top: no separation, and no picture of rounding."""
    axes = vibsim.plot(cam, "relative")
    (line,) = [each for each in axes.lines if each.get_gid() == "relative"]
    assert not np.any(line.get_xydata())
    assert "no relative motion" in axes.get_title(loc="right")
    frequencies = vibsim.analyse(cam, what=["frequencies"]).frequencies
    assert (frequencies["cam"].verdict, frequencies["spring"].verdict) == ("still", "lines")


def test_events_are_drawn_against_time_by_either_name(cam):
    for x in ("events/time", "events/t"):
        assert vibsim.plot(cam, x=x, y="events/x_follower").get_xlabel() == "t (s)"


def test_curves_up_and_down_that_agree_have_no_hysteresis_in_the_legend():
    result = vibsim.sweep(FRAME, {"motor.Omega0": "3:5:1 Hz"}, carry_state=True, direction="both", jobs=1)
    axes = vibsim.plot(result, "sommerfeld")
    assert not [each for each in axes.collections if each.get_gid() == "hysteresis"]


DRILL = """
bodies: {bit: 374 kg m^2}
links: {string: {between: [bit, ground], k: 473 N m/rad, c: 23 N m s/rad}}
friction: {rock: {between: [bit, ground], N: 1 kN m, law: stribeck exponential, mu_d: 1, mu_s: 2.2,
                  v0: 1 rad/s, belt: -2 rad/s}}
run: {t_end: 120 s, every: 20 ms}
"""


def test_a_branch_without_source_lies_on_the_amplitudes_of_its_sweep():
    """A drill string seen from its table; a sweep of runs without a period measures the whole of them."""
    sweep = vibsim.sweep(DRILL, {"rock.belt": "-3:-2:1 rad/s"}, jobs=1)
    branch = vibsim.continue_branch(DRILL, {"rock.belt": "-3:-2 rad/s"})
    axes = vibsim.plot([sweep, branch], "amplitude")
    (line,) = [each for each in axes.lines if each.get_gid() == "stable"]
    x, y = line.get_xdata(), line.get_ydata()
    assert np.interp([-3, -2], x, y) == pytest.approx(np.ravel(sweep["amplitude_x_bit"]), rel=1e-4)
