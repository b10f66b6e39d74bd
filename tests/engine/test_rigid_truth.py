"""Runs with rigid stops against the exact flow in 40 digits: none missed, none invented where certified."""

import numpy as np
import pytest
from hypothesis import given, settings

from tests.engine.random_parts import LENGTH, rigid_scenes
from tests.engine.runs import Run, outcome
from tests.engine.test_truth import exact_parts, truth
from vibsim.physics.modes import EVENT_NAMES

pytest.importorskip("flint")
CLOSE = 1e-12 * LENGTH  # as for scenes without rigid stops
HOPS = 1e-5  # s before the end of a chatter, whose infinite sequence of hops doubles end sooner


def told(events):
    """(kind, part) of the events but for impacts and reversals in the last hops of a chatter."""
    kinds = [EVENT_NAMES[kind] for kind in events["kind"].tolist()]
    times = events["t"].tolist()
    ends = [t for t, kind in zip(times, kinds, strict=True) if kind == "chatter"]
    hops = [any(end - HOPS < t <= end for end in ends) for t in times]
    rows = zip(kinds, events["part"].tolist(), hops, strict=True)
    return [(kind, part) for kind, part, hop in rows if not (hop and kind in ("impact", "reversal"))]


@settings(max_examples=25)
@given(rigid_scenes(radians=4.0))
def test_doubles_follow_the_truth(scene):
    doubles = outcome(scene, "auto")
    if not isinstance(doubles, Run) or doubles.totals["uncertified"]:
        return  # rounding may decide, and the run says so
    samples, events, _, _ = truth(exact_parts(scene), 40)
    assert told(doubles.events) == told(events)
    for name in (column for column in samples if column.startswith("x_")):
        assert np.abs(doubles.samples[name] - samples[name]).max() < CLOSE


@pytest.mark.slow
@pytest.mark.timeout(7200)
@settings(max_examples=4000)
@given(rigid_scenes(radians=4.0))
def test_doubles_follow_the_truth_often(scene):
    test_doubles_follow_the_truth.hypothesis.inner_test(scene)
