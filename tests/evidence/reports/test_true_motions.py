"""The motions kept are those of runs of many digits, whole, and made again from few states."""

from dataclasses import replace

import numpy as np
import pytest

from vibsim.cases import load_case
from vibsim.evidence.reports.paper import (
    CHAOTIC,
    keep,
    motion_path,
    obtain,
    read_motion,
    restarted,
    rows_to_keep,
    true_motion,
)
from vibsim.physics.parts import EVENT_KINDS
from vibsim.results import simulate

COUNTED = {"impacts": "contact_begin", "sticks": "stick_begin", "reversals": "reversal"}
EPS = 2.0**-52
SIZES = {"x1": 0.1, "x2": 0.1, "v1": 1.0, "v2": 1.0, "phi": 100.0, "phidot": 30.0, "phase": 1.0, "t": 1.0}
# Runs of 50 and more digits by a program of its own: x2 at 300 s to the digits given, impacts, sticks
KNOWN = {"II-B": (0.27441205, 5e-9, 2141, 87), "II-C": (-0.04755217, 5e-9, 1913, 1)}


@pytest.fixture(scope="module", params=CHAOTIC)
def kept(request):
    """A case and what is kept of its motion."""
    case = load_case(request.param)
    return case, read_motion(case)


def test_every_motion_that_doubles_do_not_know_is_kept():
    assert {path.stem for path in motion_path("II-B").parent.glob("*.json")} == set(CHAOTIC)
    sizes = [motion_path(name).stat().st_size for name in CHAOTIC]
    assert sum(sizes) < 1_000_000


def test_each_motion_is_that_of_its_case_and_right_to_the_end(kept):
    case, motion = kept
    assert motion is not None, "the case has changed; make true-motions"
    assert motion.case == case.name
    assert motion.made["digits_right"] >= 10
    assert motion.totals["uncertified"] == 0
    assert np.diff(motion.times)[1:].max() < 3.0  # the first piece lasts until the first impacts


def test_a_motion_is_made_again_without_a_seam(kept):
    """Each piece, run in doubles, ends at the row that the next one begins with, the last at the state that
    the digits have at 300 s; and all events are there."""
    case, motion = kept
    errors = [error for _, _, error in restarted(case, motion)]
    assert max(errors) <= max(2 * motion.made["error"], 1e-12)
    again = true_motion(case, motion)
    assert len(again) == 60_001 and np.array_equal(again.time, np.arange(60_001) * 5 / 1000)
    for total, kind in COUNTED.items():
        assert np.count_nonzero(again.events["kind"] == EVENT_KINDS[kind]) == motion.totals[total]
    assert len(again.events["t"]) == motion.totals["events"] + 2  # start and end
    assert np.all(np.diff(again.events["t"]) >= 0)
    assert again.trust_horizon == 300.0


def test_a_row_that_is_wrong_makes_a_seam():
    case = load_case("II-C")
    motion = read_motion(case)
    rows = {**motion.rows, "v1": [v + 1e-7 * (i == 70) for i, v in enumerate(motion.rows["v1"])]}
    errors = [error for _, _, error in restarted(case, replace(motion, rows=rows))]
    assert max(errors) > 1e-9
    assert sum(error > 1e-11 for error in errors) == 1  # of the piece that begins there


@pytest.mark.parametrize("name", ["II-B", "I-B-eq211"])
def test_the_first_rows_are_those_of_a_fresh_run_of_many_digits(name):
    """The rows of the first seconds, to the rounding of doubles."""
    fresh = keep(simulate(name, overrides={"run.t_end": "7 s"}, digits=30))
    stored = read_motion(load_case(name))
    count = sum(t < 6.9 for t in fresh.times)
    assert count >= 3
    for column, values in fresh.rows.items():
        size = SIZES.get(column, 0.0)
        for value, other in zip(values[:count], stored.rows[column], strict=False):
            assert abs(value - other) <= 2 * EPS * max(size, abs(value)), column


def test_an_ordinary_run_agrees_until_its_trust_horizon_and_no_longer():
    case = load_case("II-B")
    ordinary, truth = simulate(case), true_motion(case, read_motion(case))
    apart = np.maximum(*(np.abs(ordinary[name] - truth[name]) for name in ("x1", "x2")))
    within = ordinary.time <= ordinary.trust_horizon
    assert 60 < ordinary.trust_horizon < 120
    assert apart[within].max() <= case.number("run.trust_tolerance")
    assert apart[-1] > 1e-3


@pytest.mark.parametrize("name", KNOWN)
def test_ends_are_those_known_from_elsewhere(name):
    x2, within, impacts, sticks = KNOWN[name]
    motion = read_motion(load_case(name))
    assert abs(float(motion.end["x2"]) - x2) <= within
    assert (motion.totals["impacts"], motion.totals["sticks"]) == (impacts, sticks)


def test_one_impact_in_each_turn_of_ii_c():
    """In the second half, by counting alone: whole turns of the rotor, and an impact in each."""
    case = load_case("II-C")
    motion = true_motion(case, read_motion(case))
    struck = motion.events["kind"] == EVENT_KINDS["contact_begin"]
    angles = motion.events["phi"][struck] / (2 * np.pi)
    late = angles[motion.events["t"][struck] > 150]
    assert np.all(np.diff(np.floor(late - late[0] + 0.5)) == 1)
    assert len(late) >= 956


def test_a_changed_case_has_no_motion():
    assert read_motion(load_case("II-B", {"coupling.c": "0.0011 N s/m"})) is None
    assert read_motion(load_case("I-A")) is None


def test_rows_are_alone_at_their_time():
    begin, end = EVENT_KINDS["contact_begin"], EVENT_KINDS["contact_end"]
    times = np.array([0.0, 1.0, 2.5, 2.5001, 2.6, 3.0, 9.0])
    kinds = np.array([EVENT_KINDS["start"], begin, begin, end, end, begin, EVENT_KINDS["end"]])
    assert rows_to_keep(times, kinds) == [0, 5]


def test_the_true_motion_stands_in_the_place_of_the_run(tmp_path):
    """It is made once, and an ordinary run of the same case on file is not taken for it."""
    case = load_case("II-C")
    simulate(case).save(tmp_path / "II-C.h5")
    first, anew = obtain(case, tmp_path)
    again, once_more = obtain(case, tmp_path)
    assert (anew, once_more) == (True, False)
    assert "30 digits" in again.attrs["comment"]
    assert np.array_equal(first["x2"], again["x2"])
    short = load_case("II-C", {"run.t_end": "2 s"})
    assert "comment" not in obtain(short, tmp_path)[0].attrs
