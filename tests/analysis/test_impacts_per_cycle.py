"""Impacts, sticks and words per cycle, against counts made by hand."""

import numpy as np
import pytest

from tests.results.made import short_run
from vibsim.analysis.cycles import cycle_ends
from vibsim.analysis.drift import count_impacts, words_of


def test_counts_against_the_published_ones():
    """I-A has 630 impacts and 419 sticks in 1050 cycles (60-digit integration); none at their ends."""
    found = count_impacts(short_run("I-A", "300 s"), (0.0, 300.0))
    assert found.cycles == 1050
    assert found.impacts == 630 / 1050
    assert found.sticks == 419 / 1050
    assert sum(found.impact_counts.values()) == 1050
    assert sum(number * cycles for number, cycles in found.impact_counts.items()) == 630
    assert found.velocity.count == 630
    assert found.verdict == "some cycles"


def test_a_period_of_five_cycles_has_its_words_in_turn():
    found = count_impacts(short_run("I-A", "300 s"))
    assert found.words == {"rcro": 210, "sgrco": 105, "rsg": 105, "rr": 105}
    assert (found.impacts, found.sticks, found.distinct_words) == (0.6, 0.4, 4)


def test_an_impact_in_every_cycle():
    found = count_impacts(short_run("I-C", "300 s"))
    assert (found.verdict, found.impacts, found.impact_counts) == ("every cycle", 1.0, {1: 975})


def test_speeds_at_impact_are_those_of_the_events():
    run = short_run("II-B", "20 s")
    found = count_impacts(run, (0.0, 20.0))
    rows = run.events["kind"] == 1
    expected = np.abs(run.events["v1"][rows] - run.events["v2"][rows])
    assert found.velocity.count == 115  # 50-digit integration
    assert found.velocity.greatest == expected.max()
    assert found.velocity.least == expected.min()
    assert found.velocity.mean == pytest.approx(expected.mean())


def test_turns_of_a_motor_are_its_cycles():
    run = short_run("II-B", "20 s")
    found = count_impacts(run, (0.0, 20.0))
    assert found.cycles == int(run["phi"][-1] / (2 * np.pi))


def test_impacts_are_counted_where_contact_begins():
    """Contacts of II-B last across the ends of turns."""
    run = short_run("II-B", "60 s")
    found = count_impacts(run, (30.0, 45.0))
    ends = cycle_ends(run, (30.0, 45.0))
    begun = run.events["t"][run.events["kind"] == 1]
    counts = np.histogram(begun, ends)[0]
    ended = np.histogram(run.events["t"][run.events["kind"] == 2], ends)[0]
    assert counts.sum() != ended.sum()
    assert found.impacts == counts.sum() / len(counts)
    assert found.impact_counts == {n: int(np.sum(counts == n)) for n in np.unique(counts)}


def test_an_event_at_the_end_of_a_cycle_belongs_to_the_next():
    run = short_run("II-B", "20 s")
    contact = float(run.events["t"][run.events["kind"] == 1][5])
    before, after = words_of(run, np.array([contact - 0.03, contact, contact + 0.03]))
    assert after.startswith("c")
    assert "c" not in before


def test_a_motion_without_impacts():
    found = count_impacts(short_run("I-A", "60 s", stop="none"))
    assert (found.verdict, found.impacts, found.velocity) == ("no impacts", 0.0, None)


def test_without_a_source_there_is_no_cycle():
    found = count_impacts(short_run("I-A", "5 s", excitation="none", initial__x1="20 mm"), (0.0, 5.0))
    assert (found.verdict, found.impacts, found.cycles) == ("undecided", None, 0)
    assert found.velocity.count > 3
