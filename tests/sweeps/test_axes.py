"""Axes, transients and plans: exact values, and what is refused."""

import math
from fractions import Fraction

import h5py
import numpy as np
import pytest

import vibsim
from tests.sweeps.made import (
    OMEGA0,
    assert_same_points,
    batches_of_one,
    run_stored,
    short_case,
    short_plan,
    swept,
    until,
)
from vibsim.analysis.cycles import parse_discard
from vibsim.cases import CaseError, RangeError, UnknownKeyError
from vibsim.results.simulation import open_result
from vibsim.sweeps import describe, sweep
from vibsim.sweeps.axes import Members, SpreadError, read_axis, read_members, read_spread
from vibsim.sweeps.points import share, summary
from vibsim.sweeps.sweep_file import SweepStore
from vibsim.sweeps.sweep_plan import PlanError
from vibsim.sweeps.sweep_result import axis_text, sweep_lines
from vibsim.sweeps.sweeping import make_plan


def test_the_81_values():
    axis = read_axis(short_case(), "Omega0", "3:7:0.05", "Hz")
    assert (axis.key, axis.name, axis.unit, len(axis)) == (OMEGA0, "omega0", "Hz", 81)
    assert axis.numbers().tolist() == [round(3 + i / 20, 2) for i in range(81)]
    assert axis.text(1) == "3.05 Hz"


@pytest.mark.parametrize(
    ("key", "text", "unit", "values"),
    [
        ("c", "0.01:0.05/9", "N s/m", [0.01, 0.015, 0.02, 0.025, 0.03, 0.035, 0.04, 0.045, 0.05]),
        ("stop.G", "2, 0.5, 1 mm", "mm", [2.0, 0.5, 1.0]),
        ("G", "1 mm, 0.2 cm", "cm", [0.1, 0.2]),
        ("k2", "log 1:1000/4 kN/m", "kN/m", [1.0, 10.0, 100.0, 1000.0]),
        ("Omega0", "240:300:30 rpm", "rpm", [240.0, 270.0, 300.0]),
        ("initial.phi", "0:90:45 deg", "deg", [0.0, 45.0, 90.0]),
    ],
)
def test_axes_of_any_number(key, text, unit, values):
    axis = read_axis(short_case(), key, text)
    assert axis.unit == unit and axis.numbers().tolist() == values


@pytest.mark.parametrize(
    ("text", "by_ratio"),
    [("log 1e3:1e6/31 N/m", True), ("log 5000:4000/100 N/m", True), ("1, 2, 4, 8 N/m", True),
     ("1000:5000/3 N/m", False), ("1, 2, 4, 9 N/m", False), ("1, 10 N/m", False)],
)  # fmt: skip
def test_values_spaced_by_ratio(text, by_ratio):
    axis = read_axis(short_case(), "k2", text)
    assert axis.by_ratio == by_ratio
    assert ("by ratio" in axis_text(axis)) == by_ratio


@pytest.mark.parametrize(
    ("key", "text", "error", "message"),
    [
        ("Omega", "3:4:1 Hz", UnknownKeyError, "did you mean"),
        ("run.method", "1,2", UnknownKeyError, "is no number"),
        ("Omega0", "3:4:1", CaseError, "axes excitation.Omega0: needs a unit"),
        ("c", "-1:1:1", CaseError, "must be >= 0, got -1"),
        ("c", "1,1.0", RangeError, "has the value 1 twice"),
        ("Omega0", "3 Hz, 20 rad/s", RangeError, "do not go together"),
    ],
)
def test_axes_that_are_refused(key, text, error, message):
    with pytest.raises(error) as caught:
        read_axis(short_case(), key, text)
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("text", "time"), [("1 s", 1.0), ("500ms", 0.5), ("0.25", 1.0), ("25%", 1.0), ("25 %", 1.0), ("0", 0.0)]
)
def test_transients(text, time):
    assert parse_discard(text).time(4.0) == time
    assert parse_discard(str(parse_discard(text))) == parse_discard(text)


@pytest.mark.parametrize("text", ["", "%", "1.5", "-1 s", "100%", "x", "5 mm", "2 %%"])
def test_transients_that_are_refused(text):
    with pytest.raises(ValueError):
        parse_discard(text)


@pytest.mark.parametrize(
    ("axes", "settings", "message"),
    [
        ({OMEGA0: "3 Hz"}, {"discard": "4 s"}, "leaves nothing of a run of 4 s"),
        ({OMEGA0: "3 Hz", "Omega0": "4 Hz"}, {}, "omega0 is given twice"),
        ({"x1": "0:1:1 mm"}, {"carry_state": True}, "cannot be swept first"),
        ({OMEGA0: "3 Hz"}, {"section": -1}, "negative"),
        ({OMEGA0: "3 Hz"}, {"direction": "left"}, "up, down or both"),
        ({OMEGA0: "3 Hz"}, {"every": "0 s"}, "positive"),
    ],
)
def test_plans_that_are_refused(axes, settings, message):
    with pytest.raises(PlanError, match=message):
        short_plan(axes, **settings)


def test_a_chain_goes_up_and_back_down_along_the_first_axis():
    plan = short_plan({"Omega0": "3, 4 Hz", "c": "0.1, 0.2"}, carry_state=True, direction="both")
    assert list(plan.chains()) == [
        [(0, 0, 0), (1, 0, 0), (1, 0, 1), (0, 0, 1)],
        [(0, 1, 0), (1, 1, 0), (1, 1, 1), (0, 1, 1)],
    ]


def test_the_python_call():
    found = vibsim.sweep(short_case(), {"Omega0": "3:4:0.5 Hz", "c": "0.001, 0.1"}, jobs=2, section=5)
    assert found["omega0"].tolist() == [3.0, 3.5, 4.0] and found["c"].tolist() == [0.001, 0.1]
    assert found["mean_speed"].shape == (3, 2, 1) and found["section_speed"].shape == (3, 2, 1, 5)
    assert found.complete and found.case_at((2, 1, 0)).quantity("c").value == Fraction(1, 10)
    assert np.isfinite(found["amplitude_x1"]).all()
    with pytest.raises(KeyError, match="no speed; this sweep has omega0, c, mean_speed"):
        found["speed"]


def test_a_sweep_over_the_length_of_runs_says_how_long_they_are():
    """It told that of the case, which no point had."""
    result = vibsim.sweep(short_case(), {"run.t_end": "1:2/2 s"}, discard="50 %", section=1, jobs=1)
    lines = dict(sweep_lines(result))
    assert lines["run"] == "1, 2 s, 2 values, transient of 50 % left out of the statistics"


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"discard": 0.5}, "discard must be a text with its unit, such as '100 s' or '50 %', got 0.5"),
        ({"every": 0.001}, "every must be a text with its unit, such as '5 ms', got 0.001"),
        ({"ensemble": 2, "spread": {"x1": 0.001}}, "spread of x1 must be a text .*, got 0.001"),
    ],
)
def test_what_needs_a_unit_is_no_bare_number(settings, message):
    """They ended in an AttributeError."""
    with pytest.raises(TypeError, match=message):
        vibsim.sweep(short_case(), {"c": "0.001, 0.1"}, **settings)


# Ensembles: what varies and by how much, the same member whatever else is computed, and statistics.


CARRIED = {"carry_state": True, "direction": "both"}
SPREAD = {"phi": "0:360 deg", "x1": "normal 0.1 mm"}


def ensemble_plan(count=6, seed=1, axes=((OMEGA0, "3, 4 Hz", ""),), spread=SPREAD, **settings):
    case = short_case(t_end="1 s")
    return make_plan(case, axes, ensemble=(read_members(case, count, seed, spread),), **settings)


@pytest.mark.parametrize(
    ("key", "text", "ends"),
    [("x1", "1mm", (-1, 1)), ("phi", "0:360 deg", (0, 360)), ("phi", "-1 rad:2 rad", (-1, 2)),
     ("v1", "1:3", (1, 3)), ("m1", "10 g", (287, 307)), ("Omega0", "0.5 Hz", (5, 6))],
)  # fmt: skip
def test_uniform_draws_fill_the_span_that_was_asked_for(key, text, ends):
    """Of n uniform draws the mean is within 4 sigma = 4 width / sqrt(3 n) of the centre; none is outside."""
    drawn = read_spread(short_case(), key, text).draw(seed=5, first=0, count=4000)
    low, high = ends
    assert low < drawn.min() and drawn.max() < high
    assert abs(drawn.mean() - (low + high) / 2) < 4 * (high - low) / 2 / math.sqrt(3 * 4000)
    assert drawn.max() - drawn.min() > 0.99 * (high - low)


def test_normal_draws_have_the_deviation_that_was_asked_for():
    """Of n draws the deviation is within 4 sigma / sqrt(2 n) of sigma, the mean within 4 sigma / sqrt(n)."""
    drawn = read_spread(short_case(), "v1", "normal 2 mm/s").draw(seed=5, first=0, count=4000)
    assert abs(drawn.std() - 2) < 4 * 2 / math.sqrt(8000) and abs(drawn.mean()) < 4 * 2 / math.sqrt(4000)


def test_a_member_depends_on_seed_key_and_number_alone():
    spread = read_spread(short_case(), "x1", "1 mm")
    whole = spread.draw(seed=9, first=0, count=50)
    for first in (0, 1, 3, 4, 17):
        assert spread.draw(9, first, 10).tolist() == whole[first : first + 10].tolist()
    assert not np.isin(spread.draw(10, 0, 50), whole).any()
    other = read_spread(short_case(), "x2", "1 mm")
    assert not np.isin(other.draw(9, 0, 50), whole).any()


def test_draws_do_not_change_from_version_to_version():
    """They are the words of Philox 4x64-10, here written from its definition."""
    drawn = read_spread(short_case(), "x1", "1 mm").draw(seed=1, first=0, count=2)
    key = np.random.SeedSequence([1, *b"initial.x1"]).generate_state(2, np.uint64)
    words = philox(tuple(map(int, key)))
    expected = [2 * (((word >> 12) + 0.5) / 2**52) - 1 for word in words[:2]]
    assert drawn.tolist() == expected


def philox(key, counter=(1, 0, 0, 0)):
    """Philox 4x64-10 from its definition (Salmon et al., SC11): ten rounds of two multiplications."""
    mask = 2**64 - 1
    x, k = list(counter), list(key)
    for _ in range(10):
        high0, low0 = divmod(0xD2E7470EE14C6C93 * x[0], 2**64)
        high1, low1 = divmod(0xCA5A826395121157 * x[2], 2**64)
        x = [high1 ^ x[1] ^ k[0], low1, high0 ^ x[3] ^ k[1], low0]
        k = [(k[0] + 0x9E3779B97F4A7C15) & mask, (k[1] + 0xBB67AE8584CAA73B) & mask]
    return x


def test_the_motor_turns_by_default_and_other_sources_must_say():
    (spread,) = read_members(short_case(), 3, 0, {}).spreads
    assert str(spread) == "phi uniform from 0 to 1 turn"
    with pytest.raises(SpreadError, match="say what varies"):
        read_members(short_case("I-B"), 3, 0, {})


@pytest.mark.parametrize(
    ("key", "text", "error", "message"),
    [
        ("xx", "1 mm", SpreadError, "unknown key"),
        ("x1", "1 kg", SpreadError, "must be a length"),
        ("x1", "0 mm", SpreadError, "wider than 0"),
        ("x1", "normal -1 mm", SpreadError, "wider than 0"),
        ("x1", "gaussian 1 mm", SpreadError, "a spread is WIDTH, FROM:TO or normal"),
        ("x1", "1 mm:1 mm", SpreadError, "write FROM:TO"),
        ("phi", "1:0", SpreadError, "initial.phi=1:0: FROM is above TO; write FROM:TO, such as 0:360 deg"),
        ("phi", "360:0 deg", SpreadError, "FROM is above TO"),
        ("phi", "0:1:2 rad", SpreadError, "a spread has two ends; write FROM:TO"),
        ("phi", "0:a", SpreadError, "initial.phi=0:a: 0:a is no range; write FROM:TO"),
        ("m1", "1 kg", CaseError, "spread blocks.m1: must be > 0"),
        ("Omega0", "1 rad/s", SpreadError, "turns and radians"),
    ],
)
def test_spreads_that_are_refused(key, text, error, message):
    with pytest.raises(error, match=message):
        read_spread(short_case(), key, text)


def test_ensembles_that_are_refused():
    with pytest.raises(PlanError, match="both swept and spread"):
        ensemble_plan(axes=(("x1", "0, 1 mm", ""),))
    with pytest.raises(PlanError, match="a state is carried along a range"):
        ensemble_plan(axes=(), carry_state=True)
    with pytest.raises(PlanError, match="needs an ensemble"):
        vibsim.sweep(short_case(), {OMEGA0: "3, 4 Hz"}, spread={"x1": "1 mm"})


@pytest.mark.parametrize("settings", [{}, CARRIED], ids=["fresh", "carried"])
def test_any_number_of_jobs_and_resuming_give_the_same_bits(tmp_path, settings):
    plan, path = ensemble_plan(**settings), tmp_path / "e.h5"
    one = swept(plan, jobs=1)
    assert_same_points(swept(plan, jobs=3).table, one.table)
    with batches_of_one():
        run_stored(SweepStore(plan, path), 2, until(2))
    assert open_result(path).attrs["complete"] == 0
    assert_same_points(swept(plan, path).table, one.table)
    assert open_result(path).plan.fingerprint == plan.fingerprint


def test_a_member_is_the_run_with_its_start():
    result = swept(ensemble_plan())
    case = result.case_at((1, 4, 0))
    assert case.number("x1") == pytest.approx(result["member_x1"][4] * 1e-3, rel=1e-15)
    assert case.number("phi") == pytest.approx(math.radians(result["member_phi"][4]), rel=1e-15)
    assert vibsim.simulate(case, trust=False).attrs["impacts"] == result["impacts"][1, 4, 0]
    larger = swept(ensemble_plan(count=8, axes=((OMEGA0, "4 Hz", ""),)))
    assert larger["end_x1"][0, :6].tobytes() == result["end_x1"][1].tobytes()


def test_an_ensemble_alone_and_its_file(tmp_path):
    result = sweep(short_case(t_end="1 s"), ensemble=3, seed=2, out=tmp_path / "e.h5")
    assert result["mean_speed"].shape == (3, 1) and result["member"].tolist() == [0, 1, 2]
    with h5py.File(tmp_path / "e.h5") as file:
        assert file["member_phi"][:].tolist() == result["member_phi"].tolist()
        assert file["member_phi"].dims[0].keys() == ["member"] and file["member_phi"].attrs["units"] == "turn"
        assert file["mean_speed"].dims[0].keys() == ["member"]
    lines, _ = describe(tmp_path / "e.h5")
    assert dict(lines)["member"] == "3 members, seed 2: phi uniform from 0 to 1 turn"
    again = open_result(tmp_path / "e.h5")
    assert isinstance(again.members, Members) and "member_phi" in again


def test_summaries_count_what_is_there():
    values = np.array([[1.0, 2.0, 3.0, math.nan], [math.nan] * 4, [5.0, math.nan, math.nan, math.nan]])
    found = summary(values, 1)
    assert found.count.tolist() == [3, 0, 1]
    np.testing.assert_equal(found.mean, [2.0, np.nan, 5.0])
    np.testing.assert_equal(found.deviation, [1.0, np.nan, np.nan])
    np.testing.assert_equal(found.least, [1.0, np.nan, 5.0])
    np.testing.assert_equal(found.median, [2.0, np.nan, 5.0])
    np.testing.assert_equal(found.greatest, [3.0, np.nan, 5.0])


def test_wilson_intervals():
    """Agresti and Coull (1998): 0 of 10 gives [0, 0.278], 5 of 10 gives [0.237, 0.763]."""
    condition = np.array([[False] * 10, [True] * 5 + [False] * 5, [True] * 10])
    found = share(condition, np.ones_like(condition), 1)
    np.testing.assert_allclose(found.low, [0.0, 0.2366, 0.7225], atol=5e-5)
    np.testing.assert_allclose(found.high, [0.2775, 0.7634, 1.0], atol=5e-5)
    none = share(condition, np.zeros_like(condition), 1)
    assert np.isnan(none.estimate).all() and (none.low == 0).all() and (none.high == 1).all()


def test_probabilities_of_a_sweep():
    result = swept(ensemble_plan())
    fast = result["mean_speed"] > np.median(result["mean_speed"])
    found = result.probability(fast)
    assert found.estimate.shape == (2, 1) and (found.count == 6).all()
    assert found.estimate.tolist() == fast.mean(axis=1).tolist()
    assert result.over_members("impacts").mean.tolist() == result["impacts"].mean(axis=1).tolist()
    alone = swept(short_plan({OMEGA0: "3 Hz"}, short_case(t_end="1 s")))
    with pytest.raises(ValueError, match="no ensemble"):
        alone.over_members("impacts")
