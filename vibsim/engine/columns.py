"""Names of what a run of a scene made of parts gives: states of bodies and rotor, states of parts."""

from vibsim.physics.parts import AT_FORCE, columns_of

FLAGS = {
    "stops": {"free": 0, "contact": 1, "lifted": 2},
    "frictions": {"slip_minus": -1, "stick": 0, "slip_plus": 1},
    "clearances": {"kept": 0, "violated": 1},
}


def part_flags(kind, part):
    """States of a part by name; only a stop that lets go at zero force can be lifted."""
    flags = dict(FLAGS[kind])
    if kind == "stops" and not (part.release == AT_FORCE and part.c != 0):
        del flags["lifted"]
    return flags


def state_columns(scene):
    """Displacement and velocity of each body, then angle and speed of the rotor."""
    names = [name for body in scene.bodies for name in columns_of(body.name)]
    return (*names, "phi", "phidot") if scene.motor is not None else tuple(names)


def stop_column(name):
    """The column of a stop: its name; `contact` for the paper's, which is called stop."""
    return "contact" if name == "stop" else name


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
    return ("t", "kind", "part", *state_columns(scene), *phase, *part_columns(scene))


def section_columns(scene):
    """Names of the columns of the stroboscopic section, in file order."""
    return ("time", *state_columns(scene))
