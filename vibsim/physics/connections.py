"""Bodies that parts join to sets, the pairs of ends whose motion against each other matters, and the places,
angles and times that the formulas of parts read.

Parts join their ends to sets of bodies. A set that springs hold at the ground or the base vibrates about a
place; any other may drift. Coordinates of a motion without its drift are those of the pairs. A formula joins
the bodies whose difference it reads, and holds those whose place it reads by itself. Rotors and states are in
no set and no pair.
"""

from collections.abc import Iterable, Iterator
from fractions import Fraction
from functools import lru_cache
from typing import Any, NamedTuple

from vibsim.physics.formulas import (
    SWITCHES,
    TIME,
    ZERO,
    Node,
    children,
    derivative,
    is_periodic,
    reads,
    value_of,
    walk,
)
from vibsim.physics.parts import GROUND, ROTOR, STATE, Scene, Stop


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

    return tuple(Pair(*pair) for pair in pairs_read(scene))


def felt_angles(scene: Scene[Any]) -> list[int]:
    """Numbers of the rotors whose angle a force feels: those with an unbalance, and those whose angle a
    formula reads.
    """
    rotors = [i for i, body in enumerate(scene.bodies) if body.kind == ROTOR]
    if not rotors:
        return []

    felt = {rotor.column for rotor in scene.rotors if rotor.unbalance} | angles_read(scene)
    return [i for i in rotors if i in felt]


def whole_turn_angles(scene: Scene[Any]) -> list[int]:
    """Numbers of the turning bodies whose forces a whole turn leaves as they are: formulas read their angle
    in sines and cosines of whole multiples alone, and no spring or stop holds them.
    """
    turning = [i for i, body in enumerate(scene.line) if scene.unit_of(body) == "rad"]
    if not turning or not scene.has_formulas:
        return []
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
        names += [name for name in switching_parts(scene) if name not in names]
    return tuple(names)


# The formulas of a scene by their parts: where they jump, which places they read, how time drives them.


# The formulas, each with the part that it is a law of.


class PartFormula(NamedTuple):
    """A formula of a part: the section of the scene, the number of the part in it, its name, the formula."""

    section: str
    number: int
    name: str
    formula: Node


def formulas_of(scene: Scene[Any]) -> Iterator[PartFormula]:
    """All formulas of a scene, section by section."""
    for i, stop in enumerate(scene.stops):
        if isinstance(stop, Stop) and stop.force is not None:
            yield PartFormula("stops", i, stop.name, stop.force)
    for i, friction in enumerate(scene.frictions):
        course = () if friction.course is None else (friction.course,)
        for formula in (*(friction.slips or ()), *(friction.holds or ()), *course):
            yield PartFormula("frictions", i, friction.name, formula)
    for i, link in enumerate(scene.links):
        if link.force is not None:
            yield PartFormula("links", i, link.name, link.force)
    for i, force in enumerate(scene.forces):
        if force.formula is not None:
            yield PartFormula("forces", i, force.name, force.formula)
    if scene.base_formula is not None:
        yield PartFormula("base", 0, "base", scene.base_formula)


def base_formulas(scene: Scene) -> tuple[Node, ...]:
    """Displacement, velocity and acceleration of a base that moves by a formula; none of any other. Where the
    formula is that of the velocity the displacement is 0.
    """
    if scene.base_formula is None:
        return ()
    first = scene.base_formula
    rate = first if scene.base_is_rate else derivative(first, TIME)
    return (ZERO if scene.base_is_rate else first, rate, derivative(rate, TIME))


# Where formulas have several sides.


def switching_parts(scene: Scene[Any]) -> tuple[str, ...]:
    """Names of the parts whose formulas have switches, each once."""
    names = [one.name for one in formulas_of(scene) if has_switches(one.formula)]
    return tuple(dict.fromkeys(names))


def has_switches(formula: Node) -> bool:
    """Whether a formula has several sides: abs, sign, min, max, step, where, mod, tables."""
    return formula[0] in SWITCHES or any(map(has_switches, children(formula)))


# Which places of bodies formulas read.


def pairs_read(scene: Scene[Any]) -> Iterator[tuple[str, int, int]]:
    """Name of the part and ends P, Q of each difference x_P - x_Q that its formula reads; Q is GROUND where
    it reads x_P by itself. What a stop reads of its own ends is left out.
    """
    for one in formulas_of(scene):
        own = None
        if one.section == "stops":
            own = {scene.stops[one.number].P, scene.stops[one.number].Q}
        for P, Q in _places_read(one.formula):
            if {P, Q} != own and _on_line(scene, P) and _on_line(scene, Q):
                yield (one.name, P, Q) if P >= 0 else (one.name, Q, P)


def _on_line(scene: Scene, end: int) -> bool:
    return end < 0 or scene.bodies[end].kind not in (ROTOR, STATE)


@lru_cache(maxsize=1024)
def _places_read(formula: Node) -> tuple[tuple[int, int], ...]:
    """The ends of the differences that a formula reads, those of single places with GROUND; not both
    fixed.
    """
    found: dict[tuple[int, int], None] = {}
    seen: set[Node] = set()
    below = [formula]
    while below:
        node = below.pop()
        if node in seen:
            continue
        seen.add(node)
        if node[0] == "sub" and node[1][0] == node[2][0] == "x":
            found.setdefault((node[1][1], node[2][1]))
        elif node[0] == "x":
            found.setdefault((node[1], GROUND))
        else:
            below += children(node)
    return tuple((P, Q) for P, Q in found if P >= 0 or Q >= 0)


def reads_own_distance(link: Any) -> bool:
    """Whether the formula of a link reads the distance of its ends, and nothing else."""
    ends = {link.P, link.Q}
    return not reads([link.force], ("t", "v", "phi", "w")) and all(
        {P, Q} == ends or (Q == GROUND and {P} == {end for end in ends if end >= 0})
        for P, Q in _places_read(link.force)
    )


def angles_read(scene: Scene[Any]) -> set[int]:
    """Numbers of the rotors whose angle any formula reads."""
    ends = {end for one in formulas_of(scene) for pair in _places_read(one.formula) for end in pair}
    return {i for i, body in enumerate(scene.bodies) if body.kind == ROTOR and i in ends}


# How time drives a scene by its formulas.


PI_TO_80_DIGITS = Fraction(
    "3.14159265358979323846264338327950288419716939937510582097494459230781640628620899"
)


class TimeRate(NamedTuple):
    """Angular rate factor pi^power [rad/s] of a sine or cosine of time."""

    factor: Fraction
    power: int

    @property
    def cycles(self) -> tuple[float, float]:
        """The frequency [Hz] as a double-double."""
        exact = self.factor / 2 * PI_TO_80_DIGITS ** (self.power - 1)
        high = float(exact)
        return high, float(exact - Fraction(high))


def reads_time(scene: Scene[Any]) -> bool:
    """Whether any formula reads the time."""
    return scene.has_formulas and any(_paces(one.formula) != () for one in formulas_of(scene))


def paces_of(scene: Scene[Any]) -> list[TimeRate] | None:
    """The rates at which time drives a scene by its formulas, each once; None where one of them has no period
    in time, as of a ramp, a growing frequency or a table.
    """
    paces: dict[TimeRate, None] = {}
    for one in formulas_of(scene):
        own = _paces(one.formula)
        if own is None:
            return None
        paces |= dict.fromkeys(own)
    return list(paces)


@lru_cache(maxsize=1024)
def _paces(formula: Node) -> tuple[TimeRate, ...] | None:
    """The rates of a formula: time may stand only in sines and cosines of rate t + what reads no time, and in
    mod(rate t + ..., number).
    """
    timed: set[Node] = set()
    for node in walk([formula]):
        if node == TIME or any(child in timed for child in children(node)):
            timed.add(node)
    if formula not in timed:
        return ()
    paces: dict[TimeRate, None] = {}
    below, seen = [formula], set[Node]()
    while below:
        node = below.pop()
        if node in seen or node not in timed:
            continue
        seen.add(node)
        if node == TIME:
            return None
        pace = _pace_of(node)
        if pace is not None:
            paces.setdefault(pace)
        else:
            below += children(node)
    return tuple(paces)


def _pace_of(node: Node) -> TimeRate | None:
    """The rate of a sine, a cosine or a remainder whose argument grows evenly with time; None of any
    other.
    """
    if node[0] not in ("sin", "cos", "mod"):
        return None
    rate = _number(derivative(node[1], TIME))
    if rate is None or not rate.factor:
        return None
    if node[0] != "mod":
        return TimeRate(abs(rate.factor), rate.power)
    modulus = _number(node[2])
    if modulus is None or not modulus.factor:
        return None
    # a whole modulus in 2 pi / (the rate of the sine that has the same period)
    return TimeRate(abs(2 * rate.factor / modulus.factor), rate.power - modulus.power + 1)


def _number(node: Node) -> TimeRate | None:
    """A formula of numbers and pi alone, as factor pi^power; None of any other."""
    value = value_of(node)
    if value is not None:
        return TimeRate(value, 0)
    if node[0] == "pi":
        return TimeRate(Fraction(1), 1)
    if node[0] in ("mul", "div"):
        one, other = (_number(child) for child in node[1:])
        if one is None or other is None or (node[0] == "div" and not other.factor):
            return None
        if node[0] == "mul":
            return TimeRate(one.factor * other.factor, one.power + other.power)
        return TimeRate(one.factor / other.factor, one.power - other.power)
    if node[0] in ("add", "sub"):
        one, other = (_number(child) for child in node[1:])
        if one is None or other is None or (one.factor and other.factor and one.power != other.power):
            return None
        sign = 1 if node[0] == "add" else -1
        return TimeRate(one.factor + sign * other.factor, one.power if one.factor else other.power)
    return None
