"""Verdicts and exponents in a sweep are those of `vibsim.analysis` on the whole run."""

import math

import h5py
import numpy as np
import pytest

import vibsim
from tests.sweeps.made import OMEGA0, assert_same_points, run_stored, short_case, short_plan
from vibsim.analysis import capture, judge_capture, judge_regime
from vibsim.analysis.analysis import StreamedVerdicts
from vibsim.engine.trajectory import open_trajectory
from vibsim.physics.parts import EVENT_KINDS
from vibsim.results.simulation import open_result
from vibsim.sweeps import computations
from vibsim.sweeps.sweep_file import SweepStore
from vibsim.sweeps.sweep_plan import PlanError


def swept(case, *names, key="c", values=None, **settings):
    values = values or str(case.quantity(key))
    return run_stored(SweepStore(short_plan({key: values}, case, compute=names, **settings)), 1)[0]


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
    from vibsim.analysis.sections import Exponent

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
    plan = short_plan(
        {OMEGA0: "3, 5 Hz"}, short_case(t_end="30 s"), compute=["capture", "lyapunov-spectrum", "regime"]
    )
    result = run_stored(SweepStore(plan, tmp_path / "s.h5"), 2)[0]
    assert_same_points(open_result(tmp_path / "s.h5").table, result.table)
    with h5py.File(tmp_path / "s.h5") as file:
        flags = dict(
            zip(
                file["capture"].attrs["flag_meanings"].split(),
                file["capture"].attrs["flag_values"],
                strict=True,
            )
        )
        assert flags == {"undecided": 0, "not_met": 1, "passed": 2, "escaped": 3, "captured": 4}
        assert file["exponent"][:].tolist() == list(range(1, len(file["exponent"]) + 1))
        assert file["lyapunov_spectrum"].dims[2].keys() == ["exponent"]


def test_capture_needs_a_motor():
    with pytest.raises(PlanError, match="capture is for cases with a motor; I-B is another kind of case"):
        short_plan({"c": "0.1"}, short_case("I-B"), compute=["capture"])
