"""Whole runs in doubles against the exact flow in 40 digits: events, ends of chatter, states, motions."""

from collections import defaultdict

import numpy as np

from tests.engine.random_parts import LENGTH
from tests.engine.test_truth import exact_parts, truth
from vibsim.physics.modes import EVENT_KINDS, EVENT_NAMES

CLOSE = 1e-12 * LENGTH  # as for scenes without rigid stops
LACKING = 4  # times `chatter_speed`, by which velocities may be wrong behind the hops that are left out
INSTANT = 1e-12  # s, far more than a time of an event is wrong by where it does not graze
NEAR = 1e-6  # of the run: far more than the square root of rounding, by which a near-grazing event may shift
HOPS = 1e-5  # s beside the end of a chatter, whose infinite sequence of hops doubles end sooner
CHATTER = EVENT_KINDS["chatter"]


def faults(scene, run):
    """What a run has that 40 digits have not, or the other way round: events (kind, part), ends of chatter,
    columns; [] where rounding decides in 40 digits, too.
    """
    samples, events, _, totals = truth(exact_parts(scene), 40)
    if totals["uncertified"]:
        return []  # no truth
    ends = events["t"][events["kind"] == CHATTER]
    found = other_events(run.events, events, ends, NEAR * scene.t_end)
    found += other_ends(run, ends)
    return found + disagreements(scene, run, samples, events["t"], ends)


def beside(times, instants, room):
    """Which of the times [s] lie within `room` of one of the instants."""
    return (np.abs(np.subtract.outer(times, instants)) < room).any(axis=1)


def plain_times(events, ends):
    """{(kind, part): times [s]} of the events away from ends of chatter, where doubles tell fewer hops; two
    stops may act at one place or at one instant, whichever is told first.
    """
    times = defaultdict(list)
    apart = ~beside(events["t"], ends, HOPS)
    for t, kind, part in zip(*(events[name][apart].tolist() for name in ("t", "kind", "part")), strict=True):
        times[EVENT_NAMES[kind], part].append(t)
    return times


def other_events(events, exact, ends, near):
    """The (kind, part) of which there are more or fewer, or not within `near` [s] of where they are."""
    found, true = plain_times(events, ends), plain_times(exact, ends)
    return [
        key
        for key in {*found, *true}
        if len(found[key]) != len(true[key]) or np.abs(np.subtract(found[key], true[key])).max() > near
    ]


def other_ends(run, ends):
    """The ends of chatter [s] that a run has not within `chatter_time`, or has besides."""
    found = run.events["t"][run.events["kind"] == CHATTER]
    close = run.totals.get("chatter_time", 0.0) + INSTANT
    return [*ends[~beside(ends, found, close)].tolist(), *found[~beside(found, ends, HOPS)].tolist()]


def disagreements(scene, run, samples, instants, ends):
    """Columns whose displacements are apart, or states of parts: away from events and ends of chatters, and
    of rigid stops that are open by more than what a body that sticks in its last hop may be.
    """
    times, doubles = samples["time"], run.samples
    close = CLOSE + LACKING * run.totals.get("chatter_speed", 0.0) * scene.t_end
    between = ~beside(times, ends, HOPS) & ~beside(times, instants, INSTANT)
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
