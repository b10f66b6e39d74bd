"""Names of what a run of a scene made of parts gives: states of bodies and rotors, states of parts.

What the engine stores is a row of x and v of every body, rotors and states among them, then angle and speed
of a motor. Rows whose name is None are shown nowhere: the x of a state says nothing.
"""

from collections.abc import Collection

import numpy as np

from vibsim.physics.numbers import N
from vibsim.physics.parts import (
    ANGLE,
    EVENT_KINDS,
    IMPACTS,
    SPEED,
    STATE,
    Clearance,
    Friction,
    RigidStop,
    Scene,
    Stop,
)

RIGID_FLAGS = {"free": 0, "resting": 3}
FLAGS = {
    "stops": {"free": 0, "contact": 1, "lifted": 2},
    "frictions": {"slip_minus": -1, "stick": 0, "slip_plus": 1},
    "clearances": {"kept": 0, "violated": 1},
}


def part_flags(kind: str, part: Stop[N] | RigidStop[N] | Friction[N] | Clearance[N]) -> dict[str, int]:
    """States of a part by name; only a stop that lets go at zero force can be lifted."""
    if isinstance(part, RigidStop):
        return dict(RIGID_FLAGS)
    flags = dict(FLAGS[kind])
    if isinstance(part, Stop) and not part.lets_go:
        del flags["lifted"]
    return flags


def state_columns(scene: Scene[N]) -> tuple[str, ...]:
    """The columns of each body, in the order of bodies, then angle and speed of a motor."""
    names = tuple(name for body in scene.bodies for name in body.columns if name is not None)
    return (*names, ANGLE, SPEED) if scene.motor is not None else names


def stored_columns(scene: Scene[N]) -> tuple[str | None, ...]:
    """Names of the rows of states that the engine stores, but for the last two where there is no motor."""
    names = tuple(name for body in scene.bodies for name in body.columns)
    return (*names, ANGLE, SPEED) if scene.motor is not None else names


def stored_at_events(scene: Scene[N]) -> tuple[str | None, ...]:
    """Names of the rows of an event: its time, states, the angle of a motor in its turn, velocities before
    it. Those of switches follow.
    """
    moving = stored_columns(scene) if scene.motor is not None else (*stored_columns(scene), None, None)
    return ("t", *moving, "phase", *stored_before(scene))


def of_kinds(kinds: Collection[str]) -> np.ndarray:
    """Whether the code of an event, as an index, is that of one of these kinds."""
    return np.array([kind in kinds for kind in EVENT_KINDS])


OF_IMPACTS = of_kinds(IMPACTS)


def stop_column(name: str) -> str:
    """The column of a stop: its name; `contact` for the paper's, which is called stop."""
    return "contact" if name == "stop" else name


def flags_of_parts(scene: Scene[N]) -> list[dict[str, int]]:
    """The states that each part can be in, by name, in the order of `Status.codes`."""
    return [
        *(part_flags("stops", stop) for stop in scene.stops),
        *(part_flags("frictions", friction) for friction in scene.frictions),
        *(part_flags("clearances", clearance) for clearance in scene.clearances),
    ]


def before_columns(scene: Scene[N]) -> tuple[str, ...]:
    """Velocities in front of an event, of scenes with rigid stops: those jump, states do not."""
    return tuple(name for name in stored_before(scene) if name is not None)


def stored_before(scene: Scene[N]) -> tuple[str | None, ...]:
    """Names of the rows of velocities in front of an event that the engine stores, of bodies and a motor."""
    velocities = [None if body.kind == STATE else body.columns[1] for body in scene.bodies]
    speeds = (*velocities, SPEED if scene.has_motor else None)
    return tuple(f"before_{name}" if name and scene.rigid_stops else None for name in speeds)


def part_columns(scene: Scene[N]) -> tuple[str, ...]:
    """Names of the parts that have states, in the order of `Status.codes`."""
    stops = tuple(stop_column(stop.name) for stop in scene.stops)
    frictions = (friction.name for friction in scene.frictions)
    return (*stops, *frictions, *(clearance.name for clearance in scene.clearances))


def sample_columns(scene: Scene[N]) -> tuple[str, ...]:
    """Names of the sampled columns, in file order."""
    return ("time", *state_columns(scene), *part_columns(scene))


def event_columns(scene: Scene[N]) -> tuple[str, ...]:
    """Names of the event columns, in file order, but for those of switches, which follow (`FormulaRows`);
    `part` is the index of the part among those of `vibsim.physics.connections.event_parts`, or -1.
    """
    phase = ("phase",) if scene.motor is not None else ()
    states = (*state_columns(scene), *phase, *before_columns(scene))
    return ("t", "kind", "part", *states, *part_columns(scene))


def section_columns(scene: Scene[N]) -> tuple[str, ...]:
    """Names of the columns of the stroboscopic section, in file order."""
    return ("time", *state_columns(scene))
