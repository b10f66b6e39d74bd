"""End states: rest and vibration where theory says so."""

import numpy as np
import pytest

from vibsim.cases import load_case
from vibsim.cases.case import load_case_text
from vibsim.sweeps import sweep
from vibsim.sweeps.contact_computations import VERDICTS
from vibsim.sweeps.sweep_plan import PlanError

NAMES = {code: name for name, code in VERDICTS.items()}
OSCILLATOR = """
bodies: {a: 1 kg}
links: {s: {between: [a, ground], k: 4 N/m, c: 0.1 N s/m}}
initial: {a: {x: 1 m}}
run: {t_end: 40 s}
"""


def ends(case, axes, **settings):
    """The verdicts of a sweep, in words."""
    result = sweep(case, axes, compute=["end-state"], jobs=1, **settings)
    return [NAMES[int(code)] for code in result["end_state"].ravel()]


def test_a_damped_oscillator_rests_and_an_undamped_one_is_undecided():
    case = load_case_text(OSCILLATOR, name="oscillator")
    assert ends(case, {"s.c": "0, 0.01, 0.1, 5 N s/m"}) == ["undecided", "rest", "rest", "rest"]


def test_what_friction_holds_rests():
    case = load_case_text(OSCILLATOR + "friction: {f: {between: [a, ground], N: 1 N, mu: 0.5}}", name="held")
    assert ends(case, {"f.mu": "0.3, 0.5"}) == ["rest", "rest"]


def test_a_ball_that_chatters_to_rest_and_one_that_loses_nothing():
    case = load_case("gallery/bouncing-ball", {"run.t_end": "20 s"})
    (stop,) = case.scene().stops
    assert ends(case, {f"{stop.name}.e": "0.5, 1"}) == ["rest", "vibration"]


@pytest.mark.parametrize(
    ("speed", "states"), [(1.1, {"vibration"}), (1.5, {"rest", "vibration"}), (1.85, {"rest"})]
)
def test_the_belt_oscillator_is_bistable_between_its_two_bounds(speed, states):
    """Rest is stable above ln(10)/2 = 1.151 m/s, the stick-slip cycle lives up to 1.8366 m/s."""
    spread = {"block.x": "-2:2 m", "block.v": "0:2 m/s"}
    case = load_case("gallery/belt-oscillator", {"run.t_end": "300 s"})
    axes = {"belt.belt": f"{speed} m/s"}
    found = ends(case, axes, ensemble=12, spread=spread, discard="200 s")
    assert set(found) == states


def test_the_verdict_agrees_with_the_amplitude():
    """Rest and cycle are far apart: the cycle swings by about the belt speed."""
    case = load_case("gallery/belt-oscillator", {"run.t_end": "300 s"})
    spread = {"block.x": "-2:2 m", "block.v": "0:2 m/s"}
    result = sweep(
        case, {"belt.belt": "1.4:1.8:0.2 m/s"}, compute=["end-state"], ensemble=8, spread=spread,
        discard="200 s", jobs=1,
    )  # fmt: skip
    np.testing.assert_array_equal(
        result["end_state"] == VERDICTS["vibration"], result["amplitude_x_block"] > 0.5
    )


def test_a_source_leaves_it_to_the_regime():
    wanted = (
        "end-state is for cases that move freely, under constant forces alone; impact-pair is another kind"
    )
    with pytest.raises(PlanError, match=wanted):
        sweep(load_case("gallery/impact-pair"), {"base.a": "1, 2 mm"}, compute=["end-state"])


def test_a_limit_cycle_with_sharp_peaks_is_no_rest():
    """Van der Pol's oscillator swings for ever at one amplitude; its period of 6.6633 s is 20 samples but
    for 0.05 %, which come to the peak of its speed in one half of the time and miss it in the other.
    """
    found = ends(
        "gallery/van-der-pol", {"mass.x": "-3, 3 m"}, overrides={"run.t_end": "2000 s"}, discard="90 %"
    )
    assert found == ["undecided"] * 2
