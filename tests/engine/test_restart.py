"""A run can be taken up at any stored event: the rest of it comes out bit for bit."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings

from tests.engine.random_parts import part_scenes
from tests.engine.runs import Run, outcome, run, same_bits
from tests.scenes import CASE_NAMES, paper
from vibsim.engine.trajectory import open_trajectory, state_at


def rows_at_each_instant(events):
    """All rows of each instant, in their order."""
    rows = [dict(zip(events, values, strict=True)) for values in zip(*events.values(), strict=True)]
    for t in sorted(set(events["t"].tolist())):
        yield [row for row in rows if row["t"] == t]


def assert_restarts(scene, engine="auto"):
    whole = outcome(scene, engine)
    if not isinstance(whole, Run):
        return
    for rows in rows_at_each_instant(whole.events):
        t = rows[-1]["t"]
        if t == scene.t_end or rows[0]["kind"] == 0:
            continue
        rest = run(scene, engine, resume=rows)
        after, later = whole.samples["time"] >= t, whole.events["t"] > t
        for name, values in rest.samples.items():
            assert same_bits(values, whole.samples[name][after]), (name, t)
        for name, values in rest.events.items():
            assert same_bits(values[1:], whole.events[name][later]), (name, t)


@settings(max_examples=60)
@given(part_scenes())
def test_random_scenes_go_on_from_every_event(scene):
    assert_restarts(scene)
    assert_restarts(replace(scene, method="taylor"))


@settings(max_examples=15)
@given(part_scenes())
def test_the_python_engine_goes_on_from_every_event(scene):
    assert_restarts(scene, "python")


@pytest.mark.parametrize("engine", ("c", "python"))
@pytest.mark.parametrize("name", CASE_NAMES)
def test_states_between_events_are_those_of_the_run(name, engine):
    scene = paper(name, t_end=3.0).as_parts()
    whole = run(scene, engine)
    times = whole.samples["time"]
    rows = list(rows_at_each_instant(whole.events))
    for one, following in pairwise(rows):
        t, end = one[-1]["t"], following[0]["t"]
        between = (times >= t) & (times < end)
        found = state_at(scene, one[-1], times[between].tolist(), engine)
        for name_of_column, values in found.items():
            assert same_bits(values, whole.samples[name_of_column][between])


@pytest.mark.parametrize("engine", ("c", "python"))
@pytest.mark.parametrize(
    ("column", "value", "sentence"),
    [
        ("t", -1.0, "t must be 0 to"),
        ("t", np.nan, "t must be finite"),
        ("x1", np.inf, "x1 must be finite"),
        ("kind", 77, "kind must be one of"),
        ("contact", 5, "contact must be one of"),
        ("friction", 3, "friction must be one of"),
    ],
)
def test_no_run_goes_on_from_a_row_that_there_is_not(engine, column, value, sentence):
    scene = paper("I-A", t_end=1.0).as_parts()
    row = {name: values[0] for name, values in run(scene).events.items()}
    with pytest.raises(ValueError, match=sentence):
        open_trajectory(scene, engine, resume=row | {column: value})
