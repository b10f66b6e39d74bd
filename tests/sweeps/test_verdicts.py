"""Verdicts and exponents in a sweep are those of `vibsim.analysis` on the whole run."""

import math

import h5py
import numpy as np
import pytest
from scipy.optimize import brentq

import vibsim
from tests.sweeps import made
from tests.sweeps.made import OMEGA0, assert_same_points, short_case, short_plan
from vibsim.analysis import capture, judge_capture, judge_regime
from vibsim.analysis.analysis import StreamedVerdicts
from vibsim.analysis.sections import Exponent
from vibsim.cases import load_case
from vibsim.cases.case import load_case_text
from vibsim.engine.trajectory import open_trajectory
from vibsim.physics.parts import EVENT_KINDS
from vibsim.results.simulation import open_result
from vibsim.sweeps import computations, sweep
from vibsim.sweeps.contact_computations import VERDICTS
from vibsim.sweeps.quantities import KINDS
from vibsim.sweeps.sweep_plan import PlanError


def swept(case, *names, key="c", values=None, **settings):
    values = values or str(case.quantity(key))
    return made.swept(short_plan({key: values}, case, compute=names, **settings), jobs=1)


def only(result, name):
    return float(result[name].ravel()[0])


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("II-B", {}),
        ("II-B", {"coupling__c": "0.03 N s/m"}),
        ("II-C", {"coupling__c": "0.046 N s/m"}),
        ("II-B", {"stop": "none", "excitation__Omega0": "6 Hz"}),
        ("II-A", {"excitation__Omega0": "2.5 Hz"}),
    ],
)
@pytest.mark.parametrize("discard", ["50 %", "10 s", "0"])
def test_capture(name, changes, discard):
    """The transient is run apart and counts all the same: captures happen in it."""
    case = short_case(name, t_end="120 s", **changes)
    result = swept(case, "capture", discard=discard)
    expected = judge_capture(vibsim.simulate(case, trust=False))
    assert only(result, "capture") == computations.CAPTURE_VERDICTS[expected.verdict]
    for column, value in [
        ("capture_since", expected.since),
        ("capture_until", expected.until),
        ("capture_speed", expected.speed_hz),
        ("final_speed", expected.final_speed_hz),
        ("passage_time", max((passage.time for passage in expected.passages), default=None)),
    ]:
        # the run's turns are read off samples, those of the sweep are exact
        wanted = math.nan if value is None else pytest.approx(value, rel=1e-4, abs=0.02)
        assert only(result, column) == wanted or (value is None and math.isnan(only(result, column))), column


@pytest.mark.parametrize("changes", [{}, {"stop": "none", "friction": "none"}], ids=["events", "no events"])
@pytest.mark.parametrize("discard", ["50 %", "0"])
def test_capture_is_shown_every_turn_and_impact_once(monkeypatch, changes, discard):
    """What was run twice, from the last event in the transient to its end, counts once."""
    told = []

    def judge(turns, impacts, *rest):
        told.append((turns, impacts))
        return real(turns, impacts, *rest)

    real = capture.capture_of_turns
    monkeypatch.setattr(capture, "capture_of_turns", judge)
    case = short_case("II-B", t_end="30 s", **changes)
    swept(case, "capture", discard=discard)
    blocks = list(open_trajectory(case.scene(), section=True).blocks())
    begun = [block.events["t"][block.events["kind"] == EVENT_KINDS["contact_begin"]] for block in blocks]
    np.testing.assert_array_equal(told[0][0], np.concatenate([block.section["time"] for block in blocks]))
    np.testing.assert_array_equal(told[0][1], np.concatenate(begun))


@pytest.mark.parametrize("name", ["I-A", "I-C", "II-B", "II-C"])
def test_regime(name):
    case = short_case(name, t_end="120 s")
    result = swept(case, "regime")
    expected = judge_regime(vibsim.simulate(case, trust=False))
    assert only(result, "regime") == computations.REGIME_VERDICTS[expected.verdict]
    if expected.period is not None:
        assert only(result, "regime_period") == expected.period


def test_a_chaotic_motion_with_its_exponent():
    """The exponent is that of vibsim.lyapunov over the same span, and the verdict takes it into account."""
    case = short_case("II-B", t_end="60 s")
    result = swept(case, "lyapunov", "regime", "lyapunov-spectrum")
    known = vibsim.lyapunov(case)
    assert only(result, "lyapunov") == pytest.approx(vibsim.lyapunov(case, count=1).exponents[0], rel=1e-12)
    spectrum = result["lyapunov_spectrum"][0, 0]
    np.testing.assert_array_equal(spectrum, known.exponents)
    np.testing.assert_array_equal(result["lyapunov_spectrum_half_width"][0, 0], known.half_widths)
    assert only(result, "rank_losses") == known.rank_losses
    assert only(result, "volume_residual") == known.volume_residual


def test_an_exponent_decides_where_the_section_does_not(monkeypatch):
    told = []

    def judge(self, exponent=None):
        told.append(exponent)
        return real(self, exponent)

    real = StreamedVerdicts.regime
    monkeypatch.setattr(StreamedVerdicts, "regime", judge)
    case = short_case("II-B", t_end="60 s")
    result = swept(case, "regime", "lyapunov")
    swept(case, "regime")
    assert told == [Exponent(only(result, "lyapunov"), only(result, "lyapunov_half_width")), None]


def test_verdicts_on_file(tmp_path):
    computed = ["capture", "lyapunov-spectrum", "regime"]
    plan = short_plan({OMEGA0: "3, 5 Hz"}, short_case(t_end="30 s"), compute=computed)
    result = made.swept(plan, tmp_path / "s.h5")
    assert_same_points(open_result(tmp_path / "s.h5").table, result.table)
    with h5py.File(tmp_path / "s.h5") as file:
        attrs = file["capture"].attrs
        assert attrs["flag_meanings"].split() == ["undecided", "not_met", "passed", "escaped", "captured"]
        assert attrs["flag_values"].tolist() == [0, 1, 2, 3, 4]
        assert file["exponent"][:].tolist() == list(range(1, len(file["exponent"]) + 1))
        assert file["lyapunov_spectrum"].dims[2].keys() == ["exponent"]


def test_capture_needs_a_motor():
    with pytest.raises(PlanError, match="capture is for cases with a motor; I-B is another kind of case"):
        short_plan({"c": "0.1"}, short_case("I-B"), compute=["capture"])


# End states: rest and vibration where theory says so.


OSCILLATOR = """
bodies: {a: 1 kg}
links: {s: {between: [a, ground], k: 4 N/m, c: 0.1 N s/m}}
initial: {a: {x: 1 m}}
run: {t_end: 40 s}
"""


def ends(case, axes, **settings):
    """The verdicts of a sweep, in words."""
    result = sweep(case, axes, compute=["end-state"], jobs=1, **settings)
    return result.verdict("end_state").ravel().tolist()


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
    """Rest is stable above ln(10)/2 = 1.151 m/s, the stick-slip cycle lives up to 1.8366 m/s; it swings by
    about the belt speed.
    """
    case = load_case("gallery/belt-oscillator", {"run.t_end": "300 s"})
    spread = {"block.x": "-2:2 m", "block.v": "0:2 m/s"}
    settings = {"ensemble": 12, "spread": spread, "discard": "200 s", "jobs": 1}
    result = sweep(case, {"belt.belt": f"{speed} m/s"}, compute=["end-state"], **settings)
    assert set(result.verdict("end_state").ravel()) == states
    large = result["amplitude_x_block"] > 0.5
    np.testing.assert_array_equal(result["end_state"] == VERDICTS["vibration"], large)


def test_a_source_leaves_it_to_the_regime():
    needs = "cases that move freely, under constant forces alone"
    with pytest.raises(PlanError, match=f"end-state is for {needs}; impact-pair is another kind"):
        sweep(load_case("gallery/impact-pair"), {"base.a": "1, 2 mm"}, compute=["end-state"])


def test_a_limit_cycle_with_sharp_peaks_is_no_rest():
    """Van der Pol's oscillator swings for ever at one amplitude; its period of 6.6633 s is 20 samples but
    for 0.05 %, which come to the peak of its speed in one half of the time and miss it in the other.
    """
    case = load_case("gallery/van-der-pol", {"run.t_end": "2000 s"})
    assert ends(case, {"mass.x": "-3, 3 m"}, discard="90 %") == ["undecided"] * 2


# The map of Shaw and Holmes (1983): motions with one impact in n periods before a wall at x = 0.


CASE = "gallery/impact-oscillator"


def trace(w, e, n):
    """Sum of both multipliers, whose product is e^2, of x'' + x = cos wt, x <= 0: one impact in n periods."""
    c = np.cos(2 * np.pi * n / w)
    return -2 * e * c + (1 + e) ** 2 * (1 - w * w) * (1 + c) / 2


def doubling(w, e, n):
    return 1 + trace(w, e, n) + e * e


@pytest.mark.parametrize(("n", "low", "high"), [(1, 2.6, 2.7), (2, 4.6, 4.7), (3, 5.3, 5.4)])
def test_labels_on_both_sides_of_a_doubling(n, low, high):
    """Inside the motion has the closed form's multipliers; 0.02 rad/s outside it is another one."""
    edge = brentq(doubling, low, high, args=(0.6, n), xtol=1e-14)
    inside = float(np.sign(doubling(high, 0.6, n)))  # on which side it is stable
    values = ", ".join(f"{edge + side * 0.02 * inside!r} rad/s" for side in (1, -1)).replace(" rad/s,", ",")
    found = vibsim.sweep(
        CASE, {"drive.omega": values}, overrides={"wall.e": "0.6", "run.t_end": "600 s"}, section=0,
        compute="attractor", jobs=1,
    )  # fmt: skip
    names = ("kind", "period", "multiplier")
    kind, period, multiplier = (found[f"attractor_{name}"].ravel() for name in names)
    word = found.attractors["word"][found["attractor"].ravel()[0]]
    assert (kind[0], period[0], word) == (KINDS["periodic"], n, "i")
    t = trace(edge + 0.02 * inside, 0.6, n)
    assert multiplier[0] == pytest.approx(np.abs(np.roots([1, -t, 0.36])).max(), rel=1e-11)
    assert kind[1] != KINDS["periodic"] or period[1] != n


def test_the_curve_of_doublings():
    orbit = vibsim.orbit(CASE, {"drive.omega": "3.7 rad/s"})
    branch = vibsim.continue_branch(orbit, "drive.omega", "3.34:3.7 rad/s")
    locus = vibsim.continue_locus(branch, {"wall.e": "0.7:0.9"}, label="PD1")
    exact = [brentq(doubling, 3.3, 3.4, args=(e, 2), xtol=1e-15) for e in locus["second"]]
    np.testing.assert_allclose(locus["parameter"], exact, rtol=1e-12)
