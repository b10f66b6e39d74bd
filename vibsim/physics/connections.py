"""Which bodies of a scene hang together, and the pairs of ends whose motion against each other matters.

Parts join their ends to sets of bodies. A set that springs hold at the ground or the base vibrates about a
place; any other may drift. Coordinates of a motion without its drift are those of the pairs. A formula joins
the bodies whose difference it reads, and holds those whose place it reads by itself. Rotors and states are in
no set and no pair.
"""

from collections.abc import Iterable
from typing import Any, NamedTuple

from vibsim.physics.formulas import is_periodic
from vibsim.physics.parts import GROUND, ROTOR, Scene


class Pair(NamedTuple):
    """Two ends, called after the first part between them; x = x_P - x_Q."""

    name: str
    P: int
    Q: int


class BodySet(NamedTuple):
    """Bodies, ascending, that parts join; `held` where the ground or the base is among their ends."""

    bodies: tuple[int, ...]
    held: bool

    @property
    def reference(self) -> int:
        """The body that stands for the set where it moves as a whole: the last one."""
        return self.bodies[-1]


def body_sets(scene: Scene, parts: Iterable[Any]) -> list[BodySet]:
    """The sets of bodies that `parts` and formulas join, each body in one of them, in the order of their
    first bodies.
    """
    leader = list(range(len(scene.line)))
    held = [False] * len(leader)

    def root(body: int) -> int:
        while leader[body] != body:
            body = leader[body]
        return body

    for part in (*parts, *felt_pairs(scene)):
        ends = [root(end) for end in (part.P, part.Q) if end >= 0]
        first, last = min(ends), max(ends)
        leader[last] = first
        held[first] = held[first] or held[last] or len(ends) == 1
    roots = [root(body) for body in range(len(leader))]
    return [
        BodySet(tuple(body for body, own in enumerate(roots) if own == first), held[first])
        for first in sorted(set(roots))
    ]


def pairs_of(scene: Scene) -> tuple[Pair, ...]:
    """The pairs of ends of links and stops, each once, in the order of the parts; for bodies that none of
    them touches, the pairs of their frictions; for others, the body against the ground, called after it.
    """
    joined = _distinct((*scene.links, *scene.stops))
    touched = _bodies(joined)
    rubbing = [part for part in scene.frictions if not _bodies([part]) <= touched]
    pairs = _distinct((*joined, *rubbing))
    touched = _bodies(pairs)
    alone = [Pair(body.name, i, GROUND) for i, body in enumerate(scene.line) if i not in touched]
    return (*pairs, *alone)


def joined_pairs(scene: Scene) -> tuple[Pair, ...]:
    """The pairs of ends of links and stops alone."""
    return _distinct((*scene.links, *scene.stops))


def force_pairs(scene: Scene) -> tuple[Pair, ...]:
    """The pairs of ends whose distance makes forces: of links and stops, and those that formulas read."""
    return _distinct((*scene.links, *scene.stops, *felt_pairs(scene)))


def felt_pairs(scene: Scene[Any]) -> tuple[Pair, ...]:
    """The pairs of ends whose distance formulas read, but for what a stop reads of its own ends: no other
    shift of bodies is felt by a formula.
    """
    if not scene.has_formulas:
        return ()
    from vibsim.physics.formula_parts import pairs_read

    return tuple(Pair(*pair) for pair in pairs_read(scene))


def felt_angles(scene: Scene[Any]) -> list[int]:
    """Numbers of the rotors whose angle a force feels: those with an unbalance, and those whose angle a
    formula reads.
    """
    rotors = [i for i, body in enumerate(scene.bodies) if body.kind == ROTOR]
    if not rotors:
        return []
    from vibsim.physics.formula_parts import angles_read

    felt = {rotor.column for rotor in scene.rotors if rotor.unbalance} | angles_read(scene)
    return [i for i in rotors if i in felt]


def whole_turn_angles(scene: Scene[Any]) -> list[int]:
    """Numbers of the turning bodies whose forces a whole turn leaves as they are: formulas read their angle
    in sines and cosines of whole multiples alone, and no spring or stop holds them.
    """
    turning = [i for i, body in enumerate(scene.line) if scene.unit_of(body) == "rad"]
    if not turning or not scene.has_formulas:
        return []
    from vibsim.physics.formula_parts import formulas_of

    springs = [link for link in scene.links if link.k]
    fixed = _bodies([*springs, *scene.stops, *scene.clearances])
    formulas = [one.formula for one in formulas_of(scene)]
    return [i for i in turning if i not in fixed and all(is_periodic(one, ("x", i)) for one in formulas)]


def drifting_sets(scene: Scene) -> list[BodySet]:
    """The sets of bodies that neither springs, nor stops on both sides, hold at the ground or the base; each
    is joined by springs or such stops, so that all of it drifts alike.
    """
    springs = [link for link in scene.links if link.k]
    return [one for one in body_sets(scene, [*springs, *_caged(scene)]) if not one.held]


def _caged(scene: Scene) -> list[Any]:
    """The stops of pairs of ends that are stopped both ways."""
    senses: dict[frozenset[int], set[int]] = {}
    for stop in scene.stops:
        senses.setdefault(frozenset((stop.P, stop.Q)), set()).add(_sense(stop))
    return [stop for stop in scene.stops if len(senses[frozenset((stop.P, stop.Q))]) == 2]


def _sense(stop: Any) -> int:
    """The sense of a stop, its ends taken in ascending order."""
    return int(stop.sense if stop.P < stop.Q else -stop.sense)


def _distinct(parts: Iterable[Any]) -> tuple[Pair, ...]:
    pairs: dict[frozenset[int], Pair] = {}
    for part in parts:
        pairs.setdefault(frozenset((part.P, part.Q)), Pair(part.name, part.P, part.Q))
    return tuple(pairs.values())


def _bodies(parts: Iterable[Any]) -> set[int]:
    return {end for part in parts for end in (part.P, part.Q) if end >= 0}


# Which parts events may be of.


def event_parts(scene: Scene[Any]) -> tuple[str, ...]:
    """Names of the parts that events may be of, in the order in which files number them: stops, frictions,
    clearances; behind these the links, forces (torques of rotors and rates of states among them) and the base
    whose formulas have switches.
    """
    names = [part.name for part in (*scene.stops, *scene.frictions, *scene.clearances)]
    if scene.has_formulas:
        from vibsim.physics.formula_parts import switching_parts

        names += [name for name in switching_parts(scene) if name not in names]
    return tuple(names)
