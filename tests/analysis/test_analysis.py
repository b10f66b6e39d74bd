"""All verdicts on a run at once."""

from dataclasses import asdict, replace
from json import dumps

import numpy as np
import pytest

import vibsim
from tests.results.made import short_run
from vibsim.analysis import analyse


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
