"""Verdicts gathered block by block are those on the whole run."""

from dataclasses import replace

import pytest

from tests.results.made import short_run
from tests.trajectories import opened
from vibsim.analysis import judge_capture, judge_regime
from vibsim.analysis.analysis import StreamedVerdicts


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
