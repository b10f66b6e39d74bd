"""All verdicts on a run at once."""

from dataclasses import asdict, replace
from json import dumps

import numpy as np
import pytest

import vibsim
from tests.engine.runs import opened
from tests.results.made import short_run
from vibsim.analysis import analyse, judge_capture, judge_regime
from vibsim.analysis.analysis import StreamedVerdicts
from vibsim.analysis.cycles import cycle_ends
from vibsim.analysis.drift import count_impacts, words_of


def test_a_motor_run_has_every_verdict():
    run = short_run("II-B", "120 s")
    found = vibsim.analyse(run)
    assert found.case == "II-B"
    assert found.span.window == (0, 120)
    assert found.steady.window == (60, 120)
    assert found.capture.span == found.span
    assert (
        found.drift.span == found.impacts.span == found.regime.span == found.frequencies.span == found.steady
    )
    assert found.span.trust_horizon == run.trust_horizon
    assert not found.steady.trusted


def test_what_the_scene_has_not_got_has_no_verdict():
    found = analyse(short_run("I-A", blocks__m2="fixed", friction="none", stop="none"))
    assert (found.capture, found.drift, found.impacts) == (None, None, None)
    assert found.regime is not None


def test_only_what_is_asked_is_worked_out():
    found = analyse(short_run("II-B", "20 s"), what=["drift"])
    assert [name for name, value in asdict(found).items() if value is None] == [
        "capture",
        "impacts",
        "regime",
        "frequencies",
    ]


@pytest.mark.parametrize(
    ("window", "discard", "steady"),
    [
        (None, None, (10, 20)),
        (None, 5.0, (5, 20)),
        ((4.0, 12.0), None, (4, 12)),
        ((4.0, 12.0), 2.0, (6, 12)),
        ((4.0, np.inf), 0.0, (4, 20)),
    ],
)
def test_the_transient_is_left_out_of_the_window(window, discard, steady):
    found = analyse(short_run("II-B", "20 s"), window=window, discard=discard)
    assert found.steady.window == steady
    assert found.drift.span.window == steady
    judged = (0.0, 20.0) if window is None else (window[0], min(window[1], 20.0))
    assert found.capture.span.window == judged


def test_spans_are_read_as_on_the_command_line():
    run = short_run("II-B", "20 s")
    assert analyse(run, window="5:15", discard="40 %", what="drift").steady.window == (9.0, 15.0)
    assert analyse(run, discard="4 s", what="drift").steady.window == (4.0, 20.0)
    assert analyse(run, window="5:", what="drift").steady.window == (5.0, 20.0)


def test_what_cannot_be_judged_is_said():
    run = short_run("II-B", "20 s")
    with pytest.raises(ValueError, match="lies outside the run, 0 to 20 s"):
        analyse(run, window=(30.0, 40.0))
    with pytest.raises(ValueError, match="leaves nothing of 0 to 20 s"):
        analyse(run, discard=20.0)
    with pytest.raises(ValueError, match="discard: must be a time or a fraction"):
        analyse(run, discard="soon")
    with pytest.raises(TypeError, match="discard must be a time in s, or a text such as '100 s'"):
        analyse(run, discard=[5.0])
    with pytest.raises(ValueError, match="'5' is not a span: write FIRST:LAST"):
        analyse(run, window="5")
    with pytest.raises(ValueError, match="what must be among capture, drift"):
        analyse(run, what=["drifts"])


@pytest.mark.parametrize("t_end", ["0.005 s", "0.1 s", "2 s"])
@pytest.mark.parametrize("name", ["I-A", "II-B"])
def test_runs_too_short_to_judge_are_undecided(name, t_end):
    found = analyse(short_run(name, t_end))
    judged = [found.capture, found.drift, found.regime, found.frequencies, found.impacts]
    if t_end != "2 s":
        assert {one.verdict for one in judged if one is not None} == {"undecided"}
    assert all(one.reason for one in judged if one is not None)


def test_everything_goes_into_json():
    dumps(asdict(analyse(short_run("II-B", "60 s"))), allow_nan=False)


def test_one_verdict_does_not_hang_on_samples_taken_more_often():
    """The same motion sampled every 5 and every 2 ms."""
    found = [analyse(short_run("I-C", "300 s", run__every=every)) for every in ("5 ms", "2 ms")]
    assert found[0].regime.step == pytest.approx(found[1].regime.step, rel=1e-3)
    assert replace(found[0].regime, step=0) == replace(found[1].regime, step=0)
    assert found[0].impacts == found[1].impacts
    assert found[0].drift.rate == pytest.approx(found[1].drift.rate, rel=1e-4)
    assert found[0].frequencies.lines[0].hz == pytest.approx(found[1].frequencies.lines[0].hz, rel=1e-6)


# Verdicts gathered block by block are those on the whole run.


def streamed(run, begin):
    scene = run.case.scene()
    verdicts = StreamedVerdicts(scene, begin)
    for block in opened(scene, section=True).blocks():
        verdicts.update(block)
    return verdicts


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("II-B", {}),
        ("II-C", {"coupling__c": "0.046 N s/m"}),
        ("II-B", {"stop": "none"}),
        ("I-A", {}),
        ("I-C", {}),
    ],
)
def test_as_from_the_whole_run(name, changes):
    run = short_run(name, "300 s", **changes)
    found, expected = streamed(run, 150.0), judge_regime(run)
    regime = found.regime()
    assert (regime.verdict, regime.period) == (expected.verdict, expected.period)
    assert regime.step == pytest.approx(expected.step, rel=1e-4, abs=1e-11)
    if name.startswith("II"):
        capture, whole = found.capture(), judge_capture(run)
        assert capture.verdict == whole.verdict
        assert capture.since == (whole.since and pytest.approx(whole.since, abs=0.01))
        assert capture.final_speed_hz == pytest.approx(whole.final_speed_hz, rel=1e-4)
        assert capture.span == replace(whole.span, trust_horizon=None)
    else:
        assert found.capture() is None


def test_nothing_taken():
    scene = short_run("II-B").case.scene()
    assert StreamedVerdicts(scene).capture().verdict == "undecided"
    assert StreamedVerdicts(scene).regime().verdict == "undecided"


# Impacts, sticks and words per cycle, against counts made by hand.


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
