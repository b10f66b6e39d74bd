"""Scenes whose numbers are exactly their doubles, and their runs in many digits."""

from collections import defaultdict
from dataclasses import fields, is_dataclass, replace
from fractions import Fraction

import numpy as np

from tests.engine.random_parts import LENGTH
from tests.engine.runs import whole
from vibsim.engine.errors import EngineError
from vibsim.engine.truth import open_truth
from vibsim.physics.parts import EVENT_KINDS, EVENT_NAMES, Harmonic, RigidStop

KEPT = ("order", "tol", "every_num", "every_den")  # what is no physical number


def exact_parts(scene):
    """Makes the scene whose numbers are exactly those doubles, but for what follows from others: an omega is
    2 pi times its cycles, and the gap of a rigid stop that touches at the start is where its ends are.
    """

    def convert(part, number, pi):
        if isinstance(part, Harmonic):
            amplitude, phase = (number(Fraction(getattr(part, name))) for name in ("amplitude", "phase"))
            cycles = Fraction(part.cycles) + Fraction(part.cycles_lo)
            return Harmonic(amplitude, 2 * pi * number(cycles), cycles, 0, phase)
        if is_dataclass(part):
            names = [field.name for field in fields(part) if field.name not in KEPT]
            return replace(part, **{name: convert(getattr(part, name), number, pi) for name in names})
        if isinstance(part, tuple):
            return tuple(convert(one, number, pi) for one in part)
        return number(Fraction(part)) if isinstance(part, float) else part

    def make(number, pi):
        parts = convert(scene, number, pi)
        sine = number.__self__.sin  # of the kit
        base = sum((term.amplitude * sine(term.phase) for term in parts.base), number(0))
        places = [*(body.x for body in parts.bodies), base, number(0)]  # BASE is -2, GROUND -1
        stops = (touching(stop, places) if touches(stop) else stop for stop in parts.stops)
        return replace(parts, stops=tuple(stops))

    return make


def touches(stop):
    """Whether a stop is a rigid one whose ends meet at the start."""
    return isinstance(stop, RigidStop) and stop.at_start


def touching(stop, places):
    """The stop with the gap that its ends leave."""
    return replace(stop, gap=-(stop.sense * (places[stop.P] - places[stop.Q])))


def truth(make, digits, **options):
    """(samples as doubles, events, digits of the events, totals) of a run of many digits."""
    trajectory = open_truth(make, digits, **options)
    blocks = list(trajectory.blocks())
    tables = [whole([getattr(b, name) for b in blocks]) for name in ("samples", "events", "event_digits")]
    return (*tables, trajectory.totals)


# Whole runs in doubles against the exact flow in 40 digits: events, ends of chatter, states, motions.


CLOSE = 1e-12 * LENGTH  # as for scenes without rigid stops
LACKING = 4  # times `chatter_speed`, by which velocities may be wrong behind the hops that are left out
INSTANT = 1e-12  # s, far more than a time of an event is wrong by where it does not graze
NEAR = 1e-6  # of the run: far more than the square root of rounding, by which a near-grazing event may shift
HOPS = 1e-5  # s beside the end of a chatter, whose infinite sequence of hops doubles end sooner
LATE = 1e-6  # s, far more than the end of a chatter is wrong by besides what is left out of it
LONGER = 3  # times `chatter_time`, which several frictions in one hop make too short
CHATTER, REST, STICK = (EVENT_KINDS[name] for name in ("chatter", "rest_begin", "stick_begin"))


def faults(scene, run, close=CLOSE):
    """What a run has that 40 digits have not, or the other way round: events (kind, part), ends of chatter,
    columns; [] where rounding decides in 40 digits, too, or ends these.

    close : of displacements [m]
    """
    try:
        samples, events, _, totals = truth(exact_parts(scene), 40)
    except EngineError:
        return []  # no truth
    if totals["uncertified"]:
        return []  # nor this
    near, ends = NEAR * scene.t_end, ends_of(events, CHATTER, REST)
    found = [*unmatched(run.events, events, ends, near), *unmatched(events, run.events, ends, near)]
    found += other_ends(run, events)
    return found + disagreements(scene, run, samples, events["t"], ends, close)


def beside(times, instants, room):
    """Which of the times [s] lie within `room` of one of the instants."""
    return (np.abs(np.subtract.outer(times, instants)) < room).any(axis=1)


def unmatched(events, others, ends, near):
    """(kind, part, time [s]) of the events away from rests, before which doubles tell fewer hops, that have
    no partner of their own within `near` [s] among the others: two stops may act at one place or at one
    instant, whichever is told first.
    """
    apart = ~beside(events["t"], ends, HOPS)
    partners = times(others, ~beside(others["t"], ends, HOPS - near))
    lonely = []
    for (kind, part), instants in times(events, apart).items():
        left = iter(partners[kind, part])
        for t in instants:
            partner = next((other for other in left if other >= t - near), np.inf)
            if partner > t + near:
                lonely.append((EVENT_NAMES[kind], part, t))
                left = iter([other for other in partners[kind, part] if other >= min(partner, t)])
    return lonely


def times(events, chosen):
    """{(kind, part): times [s]} of the chosen events."""
    found = defaultdict(list)
    for t, kind, part in zip(*(events[name][chosen].tolist() for name in ("t", "kind", "part")), strict=True):
        found[kind, part].append(t)
    return found


def other_ends(run, events):
    """The ends of chatter [s] that a run has not where they are, or has besides. A sequence that ends where a
    friction holds may be told as that alone.
    """
    close = LONGER * run.totals.get("chatter_time", 0.0) + LATE
    ours, true = (ends_of(table, CHATTER) for table in (run.events, events))
    near_ours, near_true = (ends_of(table, CHATTER, REST, STICK) for table in (run.events, events))
    return [*true[~beside(true, near_ours, close)].tolist(), *ours[~beside(ours, near_true, HOPS)].tolist()]


def ends_of(events, *kinds):
    """Times of events of some kinds [s]."""
    return events["t"][np.isin(events["kind"], kinds)]


def disagreements(scene, run, samples, instants, ends, close):
    """Columns whose displacements are apart, or states of parts: away from events and ends of chatters, and
    of rigid stops that are open by more than what a body that sticks in its last hop may be.
    """
    times, doubles = samples["time"], run.samples
    close += LACKING * run.totals.get("chatter_speed", 0.0) * scene.t_end
    between = ~beside(times, ends, HOPS) & ~beside(times, instants, INSTANT)
    places = {n: column for n, column in samples.items() if n.startswith("x_")}
    far = {n: max(1.0, np.abs(column).max()) for n, column in places.items()}
    apart = [n for n in places if np.abs(doubles[n] - samples[n]).max() >= close * far[n]]
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
