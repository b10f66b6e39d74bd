"""Names of what a run of a scene made of parts gives: states of bodies and rotor, states of parts."""

from vibsim.physics.parts import AT_FORCE, RigidStop, columns_of

RIGID_FLAGS = {"free": 0, "resting": 3}
FLAGS = {
    "stops": {"free": 0, "contact": 1, "lifted": 2},
    "frictions": {"slip_minus": -1, "stick": 0, "slip_plus": 1},
    "clearances": {"kept": 0, "violated": 1},
}


def part_flags(kind, part):
    """States of a part by name; only a stop that lets go at zero force can be lifted."""
    if isinstance(part, RigidStop):
        return dict(RIGID_FLAGS)
    flags = dict(FLAGS[kind])
    if kind == "stops" and not (part.release == AT_FORCE and part.c != 0):
        del flags["lifted"]
    return flags


def state_columns(scene):
    """Displacement and velocity of each body, then angle and speed of the rotor."""
    names = moving_columns(scene)
    return names if scene.motor is not None else names[:-2]


def moving_columns(scene):
    """Displacement and velocity of each body, then angle and speed of a rotor, whether there is one or not:
    what the engines store.
    """
    return (*(name for body in scene.bodies for name in columns_of(body.name)), "phi", "phidot")


def stop_column(name):
    """The column of a stop: its name; `contact` for the paper's, which is called stop."""
    return "contact" if name == "stop" else name


def flags_of_parts(scene):
    """The states that each part can be in, by name, in the order of `Status.codes`."""
    parts = {"stops": scene.stops, "frictions": scene.frictions, "clearances": scene.clearances}
    return [part_flags(kind, part) for kind, of_kind in parts.items() for part in of_kind]


def before_columns(scene):
    """Velocities in front of an event, of scenes with rigid stops: those jump."""
    if not scene.rigid_stops:
        return ()
    velocities = [columns_of(body.name)[1] for body in scene.bodies]
    return tuple(f"before_{name}" for name in velocities + ["phidot"] * scene.has_motor)


def part_columns(scene):
    """Names of the parts that have states, in the order of `Status.codes`."""
    stops = tuple(stop_column(stop.name) for stop in scene.stops)
    return (*stops, *(part.name for part in (*scene.frictions, *scene.clearances)))


def sample_columns(scene):
    """Names of the sampled columns, in file order."""
    return ("time", *state_columns(scene), *part_columns(scene))


def event_columns(scene):
    """Names of the event columns, in file order; `part` is the index of the part among `part_columns`, or
    -1.
    """
    phase = ("phase",) if scene.motor is not None else ()
    states = (*state_columns(scene), *phase, *before_columns(scene))
    return ("t", "kind", "part", *states, *part_columns(scene))


def section_columns(scene):
    """Names of the columns of the stroboscopic section, in file order."""
    return ("time", *state_columns(scene))
