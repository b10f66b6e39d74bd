"""The table of events tells the sides of all switches of formulas: a run goes on from every row, and files
without these columns are read as before.
"""

import h5py
import numpy as np
import pytest

import vibsim
from tests.engine.runs import run, same_bits, scene_of
from vibsim.cases.case import load_case_text
from vibsim.engine.resume import resume_point, rows_to_resume
from vibsim.engine.trajectory import open_trajectory
from vibsim.engine.truth import open_truth
from vibsim.physics.parts import EVENT_KINDS
from vibsim.results import columns, simulate_to_file

# One of each kind: what abs and the kinks of the table turn is no row of the events, what step and mod do is.
TEXT = """
name: switches
bodies: {a: 1 kg}
links:
  damper: {between: [a, ground], force: "c*v*abs(d)", c: 100 N s/m^2}
  spring:
    between: [a, ground]
    force: 'table(d, [[-200 mm, -20 N], [-30 mm, -4 N], [0 mm, 0 N], [20 mm, 1 N], [300 mm, 30 N]], "linear")'
stops: {wall: {between: [a, ground], gap: 12 mm, acts: compression, k: 3 kN/m, c: 1 N s/m}}
forces:
  push: {on: a, force: "2 N*sin(5 1/s*t) + 0.3 N*step(x_a + 4 mm)"}
  saw: {on: a, force: "1 N*mod(t, 0.37 s)/(1 s)"}
initial: {a: {x: 3 mm, v: 0.2 m/s}}
run: {t_end: 6 s, every: 20 ms}
"""
NAMES = ("push.1", "saw.1", "damper.1", "spring.1")
SIDES = [f"side.{name}" for name in NAMES]


@pytest.fixture(scope="module")
def case():
    return load_case_text(TEXT)


@pytest.fixture(scope="module")
def path(case, tmp_path_factory):
    path = tmp_path_factory.mktemp("sides") / "switches.h5"
    simulate_to_file(case, path)
    return path


def test_sides_are_those_of_the_values_of_arguments(path):
    events = vibsim.open_result(path).events
    assert [name for name in events if "." in name] == SIDES
    t, x = np.asarray(events["t"]), np.asarray(events["x_a"])
    push, saw, damper, spring = (np.round(np.asarray(events[name])) for name in SIDES)
    places = np.array([-200, -30, -4, 0, 20, 300]) * 1e-3
    clear = np.abs(x[:, None] - places).min(axis=1) > 1e-9  # where rounding leaves nothing open
    assert 0 < clear.sum() < len(x) and {*push} == {*damper} == {-1, 1}
    assert np.array_equal(push[clear], np.sign(x[clear] + 0.004))
    assert np.array_equal(damper[clear], np.sign(x[clear]))
    assert np.array_equal(spring[clear], np.searchsorted(np.delete(places, 2), x[clear]) - 1)
    assert np.array_equal(saw, np.floor(t / 0.37 + 1e-12))


def test_rows_of_a_switch_tell_the_zero_that_it_has_come_through(path):
    events = vibsim.open_result(path).events
    switch = np.flatnonzero(events["kind"] == EVENT_KINDS["switch"])
    sides = np.array([np.asarray(events[name])[switch] for name in SIDES])
    zeros = (sides - np.round(sides)) * 2**20
    assert len(switch) > 20 and np.abs(zeros).sum(axis=0).tolist() == [1.0] * len(switch)
    of_push, of_saw = zeros[0] != 0, zeros[1] != 0
    assert np.array_equal(zeros[0, of_push], np.round(sides[0, of_push]))  # where it came in
    assert np.all(zeros[1, of_saw] == 1) and np.all(of_push ^ of_saw)


@pytest.fixture
def restarts(monkeypatch):
    """Times [s] of the events from which states between samples are asked for; None of the start."""
    asked = []

    def opened(scene, resume):
        asked.append(resume and resume[-1]["t"])
        return open_trajectory(scene, resume=resume)

    monkeypatch.setattr(columns, "open_trajectory", opened)
    return asked


def test_states_are_those_of_the_run_from_the_event_before_each(path, restarts):
    result = vibsim.open_result(path)
    states = result.at(result.time)
    assert all(same_bits(states[name], result[name]) for name in states)
    before = result.events["t"][np.searchsorted(result.events["t"][:-1], result.time, side="right") - 1]
    assert restarts == [t or None for t in np.unique(before).tolist()]


def test_a_file_without_sides_is_read_and_its_states_are_the_same(path, restarts, tmp_path):
    old = tmp_path / "old.h5"
    old.write_bytes(path.read_bytes())
    with h5py.File(old, "r+") as file:
        for name in SIDES:
            del file["events"][name]
    result = vibsim.open_result(old)
    assert not {*SIDES} & {*result.events}
    assert len(result.events.to_dataframe()) == len(result.events["t"])
    states = result.at(result.time)
    assert all(same_bits(states[name], result[name]) for name in states)
    assert restarts == [None]


def test_runs_of_many_digits_tell_the_same_sides(case):
    events = run(case.scene()).events
    digits = [block.events for block in open_truth(case.exact_scene, 40).blocks()]
    for name in ("kind", *SIDES):
        assert np.array_equal(np.concatenate([each[name] for each in digits]), events[name]), name


@pytest.mark.parametrize(("name", "side"), [("push", 0), ("push", 2), ("spring", 5), ("spring", -2)])
def test_no_run_goes_on_from_a_side_that_there_is_not(case, name, side):
    scene = case.scene()
    row = {column: values[3] for column, values in run(scene).events.items()}
    resume_point(scene, row | {"side.saw.1": 10**12})  # of mod there is every one
    with pytest.raises(ValueError, match=f"side.{name}.1 must be a side of that switch, got {side}"):
        resume_point(scene, row | {f"side.{name}.1": side})


@pytest.mark.parametrize("value", [np.nan, np.inf, 1.3])
def test_no_run_goes_on_from_what_is_no_side(case, value):
    scene = case.scene()
    row = {column: values[3] for column, values in run(scene).events.items()}
    with pytest.raises(ValueError, match=r"event row: side.push.1 must be"):
        resume_point(scene, row | {"side.push.1": value})
    del row["side.push.1"]
    with pytest.raises(ValueError, match=r"event row: side.push.1 is missing"):
        resume_point(scene, row)


BELT = """
bodies: {a: 1 kg, b: 0.5 kg}
links:
  spring: {between: [a, ground], k: 39.47841760435743 N/m, c: 1 N s/m}
  other: {between: [a, b], k: 80 N/m}
stops: {wall: {between: [a, ground], gap: 3 mm, acts: compression, law: rigid, e: 0}}
friction: {f: {between: [a, ground], N: 1 N, mu: 0.5, belt: "0.02 m/s*sign(sin(6 1/s*t))"}}
forces: {saw: {on: a, force: "1 N*mod(t/(1 s) + 4*step(t - 1 s), 1)"}}
initial: {a: {x: 1 mm}}
run: {t_end: 3 s, every: 50 ms}
"""


def test_a_run_goes_on_behind_a_jump_of_a_belt():
    """The velocity of the belt there is that behind the jump, though the time is rounded to before it."""
    scene = scene_of(BELT)
    whole = run(scene)
    times = np.unique(whole.events["t"])[1:-1]
    assert len(times) > 15
    for t in times:
        rows = rows_to_resume(scene, whole.events, int(np.flatnonzero(whole.events["t"] == t)[-1]))
        rest = run(scene, resume=rows)
        later = whole.events["t"] > t
        assert all(
            same_bits(column[1:], whole.events[name][later]) for name, column in rest.events.items()
        ), t
