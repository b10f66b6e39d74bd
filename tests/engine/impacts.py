"""Scenes with rigid stops, and what their runs tell of impacts."""

from tests.engine.runs import scene_of
from vibsim.physics.parts import EVENT_KINDS

METHODS = ("auto", "taylor")
GRAVITY = 9.81  # m/s^2
BALL = """
bodies: {ball: 2 kg}
stops: {floor: {between: [ground, ball], gap: 0 m, acts: compression, law: rigid, e: 0}}
forces: {weight: {on: ball, F0: -19.62 N}}
initial: {ball: {x: 1 m}}
run: {t_end: 10 s, every: 250 ms}
"""
# A ball on a table that moves with it at the start.
SHAKEN = """
bodies: {ball: 1.5 kg}
stops: {table: {between: [base, ball], gap: 0 m, acts: compression, law: rigid, e: 0}}
forces: {weight: {on: ball, F0: -14.715 N}}
base: {a: 20 mm, omega: 30 rad/s}
initial: {ball: {v: 0.6 m/s}}
run: {t_end: 1 s, every: 250 ms}
"""


def times(result, kind, part=None):
    """Times [s] of the events of a kind, or of those at one part."""
    rows = result.events["kind"] == EVENT_KINDS[kind]
    return result.events["t"][rows if part is None else rows & (result.events["part"] == part)]


def column(result, kind, name):
    """A column of the events of a kind."""
    return result.events[name][result.events["kind"] == EVENT_KINDS[kind]]


def ball(e, h=1.0, **run):
    """A ball that is let go at the height h [m] above a floor."""
    return scene_of(BALL, {"floor.e": e, "ball.x": h}, **run)
