"""Runs with rigid stops against the exact flow in 40 digits: none missed, none invented where certified."""

import numpy as np
import pytest
from hypothesis import given, settings

from tests.engine.random_parts import LENGTH, rigid_scenes
from tests.engine.runs import Run, outcome
from tests.engine.test_truth import exact_parts, truth
from vibsim.physics.modes import EVENT_KINDS, EVENT_NAMES
from vibsim.physics.parts import (
    AT_GAP,
    COMPRESSION,
    EXTENSION,
    GROUND,
    Body,
    Friction,
    Link,
    RigidStop,
    Scene,
    Stop,
)

pytest.importorskip("flint")
IMPACT = EVENT_KINDS["impact"]
CLOSE = 1e-12 * LENGTH  # as for scenes without rigid stops
LACKING = 4  # times `chatter_speed`, by which velocities may be wrong behind the hops that are left out
INSTANT = 1e-12  # s, far more than a time of an event is wrong by
HOPS = 1e-5  # s beside the end of a chatter, whose infinite sequence of hops doubles end sooner


def beside(times, instants, room=HOPS):
    """Which of the times [s] lie within `room` of one of the instants."""
    return [any(abs(t - instant) < room for instant in instants) for t in times.tolist()]


def told(events, ends):
    """(kind, part) of the events, those of one instant sorted: two stops may act at one place. Beside the
    ends of chatters [s] only that one ends: sequences may consist of sequences, of which doubles tell fewer.
    """
    rows, ended = [], False
    kinds = [EVENT_NAMES[kind] for kind in events["kind"].tolist()]
    times, parts = events["t"].tolist(), events["part"].tolist()
    for t, kind, part, hop in zip(times, kinds, parts, beside(events["t"], ends), strict=True):
        if hop:
            ended = ended or kind == "chatter"
        else:
            rows += [(t, [("chatter", -1)])] if ended else []
            ended = False
            if rows and t - rows[-1][0] < INSTANT:
                rows[-1][1].append((kind, part))
            else:
                rows.append((t, [(kind, part)]))
    return [sorted(row) for _, row in rows] + [[("chatter", -1)]] * ended


def disagreements(scene, run, samples, instants, ends):
    """Columns whose displacements are apart, or states of parts: away from events and ends of chatters, and
    of rigid stops that are open by more than what a body that sticks in its last hop may be.
    """
    times, doubles = samples["time"], run.samples
    close = CLOSE + LACKING * run.totals["chatter_speed"] * scene.t_end
    between = ~np.array(beside(times, ends)) & ~np.array(beside(times, instants, INSTANT))
    apart = [n for n in samples if n.startswith("x_") and np.abs(doubles[n] - samples[n]).max() >= close]
    for name in (n for n, column in samples.items() if column.dtype == np.int8):
        stop = next((one for _, one in scene.rigid_stops if one.name == name), None)
        plain = between if stop is None else between & (room(scene, stop, samples) > close)
        if (doubles[name] != samples[name])[plain].any():
            apart.append(name)
    return apart


def room(scene, stop, samples):
    """How far a stop is open [m]."""
    X = sum(term.amplitude * np.sin(term.omega * samples["time"] + term.phase) for term in scene.base)
    places = [*(samples[f"x_{body.name}"] for body in scene.bodies), X, 0.0]  # BASE is -2, GROUND -1
    return stop.sense * (places[stop.P] - places[stop.Q]) + stop.gap


@settings(max_examples=25)
@given(rigid_scenes(radians=4.0))
def test_doubles_follow_the_truth(scene):
    doubles = outcome(scene, "auto")
    if not isinstance(doubles, Run) or doubles.totals["uncertified"]:
        return  # rounding may decide, and the run says so
    samples, events, _, totals = truth(exact_parts(scene), 40)
    if totals["uncertified"]:
        return  # no truth
    ends = events["t"][events["kind"] == EVENT_KINDS["chatter"]].tolist()
    assert told(doubles.events, ends) == told(events, ends)
    assert disagreements(scene, doubles, samples, events["t"].tolist(), ends) == []


@pytest.mark.slow
@pytest.mark.timeout(7200)
@settings(max_examples=4000)
@given(rigid_scenes(radians=4.0))
def test_doubles_follow_the_truth_often(scene):
    test_doubles_follow_the_truth.hypothesis.inner_test(scene)


def test_bodies_at_rest_on_each_other_meet_the_wall_in_many_digits():
    """They went through it: the friction between bodies that rest on each other has no sliding velocity,
    which was zero only within the radius of a ball; no step is known to be shorter than what that allows.
    """
    a, b = Body("a", 0.75, 0.01, 0.06), Body("b", 0.95, 0.0, 0.0)
    stops = (
        RigidStop("wall", 1, GROUND, 0.001, EXTENSION, 0.5, False),
        Stop("soft", GROUND, 0, 0.0, EXTENSION, 109.0, 0.0, AT_GAP, False),
        RigidStop("between", 1, 0, -0.01, COMPRESSION, 0.5, True),
    )
    links, frictions = (Link("l", 1, 0, 56.6, 0.0),), (Friction("f", 1, 0, 0.27, 0.27, 0.0, 0.27, 0.35),)
    scene = Scene((a, b), links, stops, frictions, t_end=0.12, every_num=1, every_den=200)
    doubles, (samples, events, *_) = outcome(scene, "auto"), truth(exact_parts(scene), 40)
    walls = [
        table["t"][(table["kind"] == IMPACT) & (table["part"] == 0)] for table in (doubles.events, events)
    ]
    assert len(walls[0]) == len(walls[1]) == 1
    assert abs(walls[0] - walls[1]) < 1e-12
    assert samples["x_b"].min() >= -0.001
