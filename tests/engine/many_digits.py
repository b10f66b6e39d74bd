"""Scenes whose numbers are exactly their doubles, and their runs in many digits."""

from dataclasses import fields, is_dataclass, replace
from fractions import Fraction

from tests.engine.runs import whole
from vibsim.engine.truth import open_truth
from vibsim.physics.parts import Harmonic, RigidStop

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
