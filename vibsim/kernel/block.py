"""A block of results: arrays by name, only what the scene has."""

from dataclasses import dataclass

import numpy as np

EVENT_STATE = ("x1", "v1", "x2", "v2", "phi", "phidot")


@dataclass(frozen=True)
class Block:
    """samples: columns as in `Scene.columns()`; events: t [s], kind, state after the event, phase [rad,
    motor only] and modes.

    section: time [s] and states at the ends of the excitation periods, empty unless asked for.
    t_reached: time up to which the motion is known [s]; worked_to: time up to which all that goes with it is
    worked out, the energy ledger say [s]. Within a long stretch without events that is further.
    """

    samples: dict[str, np.ndarray]
    events: dict[str, np.ndarray]
    section: dict[str, np.ndarray]
    t_reached: float
    worked_to: float


def event_columns(scene):
    """Names of the event columns that this scene has, in file order."""
    states = [name for name in scene.columns()[1:] if name not in ("contact", "friction")]
    phase = ["phase"] if scene.has_motor else []
    modes = [name for name in ("contact", "friction") if name in scene.columns()]
    return ("t", "kind", *states, *phase, *modes)


def section_columns(scene):
    """Names of the section columns that this scene has, in file order."""
    return tuple(name for name in scene.columns() if name not in ("contact", "friction"))


def select(scene, samples, events, section, t_reached, worked_to):
    """The block of those columns that the scene has."""
    return Block(
        {name: samples[name] for name in scene.columns()},
        {name: events[name] for name in event_columns(scene)},
        {name: section[name] for name in section_columns(scene)},
        float(t_reached),
        float(worked_to),
    )
