"""Names of what a run of a scene made of parts gives: states of bodies and rotor, states of parts."""

from vibsim.physics.numbers import N
from vibsim.physics.parts import Clearance, Friction, RigidStop, Scene, Stop, columns_of

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
    """Displacement and velocity of each body, then angle and speed of the rotor."""
    names = moving_columns(scene)
    return names if scene.motor is not None else names[:-2]


def moving_columns(scene: Scene[N]) -> tuple[str, ...]:
    """Displacement and velocity of each body, then angle and speed of a rotor, whether there is one or not:
    what the engines store.
    """
    return (*(name for body in scene.bodies for name in columns_of(body.name)), "phi", "phidot")


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
    """Velocities in front of an event, of scenes with rigid stops: those jump."""
    if not scene.rigid_stops:
        return ()
    velocities = [columns_of(body.name)[1] for body in scene.bodies]
    return tuple(f"before_{name}" for name in velocities + ["phidot"] * scene.has_motor)


def part_columns(scene: Scene[N]) -> tuple[str, ...]:
    """Names of the parts that have states, in the order of `Status.codes`."""
    stops = tuple(stop_column(stop.name) for stop in scene.stops)
    frictions = (friction.name for friction in scene.frictions)
    return (*stops, *frictions, *(clearance.name for clearance in scene.clearances))


def sample_columns(scene: Scene[N]) -> tuple[str, ...]:
    """Names of the sampled columns, in file order."""
    return ("time", *state_columns(scene), *part_columns(scene))


def event_columns(scene: Scene[N]) -> tuple[str, ...]:
    """Names of the event columns, in file order; `part` is the index of the part among `part_columns`, or
    -1.
    """
    phase = ("phase",) if scene.motor is not None else ()
    states = (*state_columns(scene), *phase, *before_columns(scene))
    return ("t", "kind", "part", *states, *part_columns(scene))


def section_columns(scene: Scene[N]) -> tuple[str, ...]:
    """Names of the columns of the stroboscopic section, in file order."""
    return ("time", *state_columns(scene))
