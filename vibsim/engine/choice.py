"""By which flow a scene is run."""

from vibsim.physics.parts import Scene

METHODS = ("auto", "closed_form", "taylor")


def check_method(scene: Scene) -> None:
    """Raises ValueError for a method that there is not, and for closed_form with a motor, which has none."""
    if scene.method not in METHODS:
        raise ValueError(f"method must be one of {', '.join(METHODS)}, got {scene.method!r}")
    if scene.method == "closed_form" and scene.has_motor:
        raise ValueError("method closed_form needs an ideal source; with a motor use taylor or auto")


def flow_of(scene: Scene) -> str:
    """The flow of a run: "closed_form" or "taylor" where all modes take it, "auto" where each is asked.

    Raises ValueError as `check_method` does.
    """
    check_method(scene)
    if scene.has_motor or scene.rotors or scene.base_formula is not None or scene.method == "taylor":
        return "taylor"
    if scene.has_formulas:  # closed in the modes that read none, such as a flight between stops
        acts = any(force.formula is not None for force in scene.forces) or any(
            link.force is not None for link in scene.links
        )
        return "taylor" if acts else "auto"
    return "closed_form" if _always_closed(scene) else "auto"


def _always_closed(scene: Scene) -> bool:
    """Whether every mode has a closed form: one body, or two that links and stops join to each other only,
    without belts, which may stretch springs for ever, and without rigid stops, on which they hop.
    """
    if any(friction.belt for friction in scene.frictions) or scene.rigid_stops:
        return False
    joined = [{part.P, part.Q} for part in scene.links] + [{part.P, part.Q} for part in scene.stops]
    return len(scene.bodies) == 1 or (len(scene.bodies) == 2 and all(ends == {0, 1} for ends in joined))
