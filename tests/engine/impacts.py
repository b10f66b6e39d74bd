"""Scenes with rigid stops, and what their runs tell of impacts."""

from math import pi

from vibsim.physics.parts import COMPRESSION, EVENT_KINDS, GROUND, Body, Force, Harmonic, RigidStop, Scene

METHODS = ("auto", "taylor")
GRAVITY = 9.81  # m/s^2


def scene(bodies, method="auto", **parts):
    """A scene of the bodies and other parts, over 10 s."""
    return Scene(tuple(bodies), method=method, **{"t_end": 10.0, "every_den": 4, **parts})


def weights(bodies):
    """The weight of each body: it falls towards negative x."""
    return tuple(Force(f"w_{b.name}", i, -b.m * GRAVITY, ()) for i, b in enumerate(bodies))


def floor(i, e, name="floor", radius=0.0):
    """A stop on the ground that body i meets at x = radius [m]."""
    return RigidStop(name, GROUND, i, -radius, COMPRESSION, e)


def cosine(amplitude, omega):
    """amplitude cos(omega t)."""
    return Harmonic(amplitude, omega, omega / (2 * pi), 0.0, pi / 2)


def times(result, kind, part=None):
    """Times [s] of the events of a kind, or of those at one part."""
    rows = result.events["kind"] == EVENT_KINDS[kind]
    return result.events["t"][rows if part is None else rows & (result.events["part"] == part)]


def column(result, kind, name):
    """A column of the events of a kind."""
    return result.events[name][result.events["kind"] == EVENT_KINDS[kind]]


def ball(e, h=1.0, method="auto", **parts):
    """A ball that is let go at the height h [m] above a floor."""
    bodies = [Body("ball", 2.0, h, 0.0)]
    return scene(bodies, method, stops=(floor(0, e),), forces=weights(bodies), **parts)
