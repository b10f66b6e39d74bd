"""A point of a branch: an orbit, the tangent of the branch there, and its test values."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Any

import numpy as np

from vibsim.lazy import once
from vibsim.orbits.branches.correction import correct, kernel, tangent
from vibsim.orbits.branches.family import Family, FamilyPoint
from vibsim.orbits.stability import ON_CIRCLE, dot, length_of, modulus, product
from vibsim.physics.connections import body_sets, formulas_of, reads_own_distance
from vibsim.physics.formula_values import potential_of, values_of
from vibsim.physics.parts import Scene
from vibsim.physics.rates import masses

STEADY = 4.0  # times that the share of the parameter in the tangent may change where Newton holds it
CLOSE = 1e-3  # scaled distance of a node whose derivative by the parameter Newton's method may begin with
STEEP = 1e-3  # share of the parameter in the tangent, below which it is not held
STRAIGHT = 0.9  # cosine of the angle between a step and the tangent behind it
BENT = 0.7  # cosine of the angle between tangents, below which it does not tell the way
LONGEST = 2.0  # steps, as long as the last one, that the cubic through two nodes is taken ahead
TELLING = 1e-9  # of the sum in a product, over its terms: rounding is a millionth of it
LEAST_LIMIT = 1e-6  # scaled length that a Newton step may have, however near two nodes are
UNIT = 1e-6  # distance from 1 of multipliers that may be those of a family
LEVEL = 1e-9  # share of the parameter in the tangent that is rounding where orbits come in families
REAL = 1e-9  # imaginary part, over its size, below which a multiplier counts as real


class Node:
    """A point of a branch.

    point : the orbit; along : unit vector about along the branch; iterations : of Newton's method
    trend : change of `slope` per length on the way from the node before, and that length; None where none is
        told
    like : the node that tells which way the tangent goes, where it is not `along` that does
    """

    def __init__(self, point: FamilyPoint, along: np.ndarray, iterations: int):
        self.point, self.along, self.iterations = point, along, iterations
        self.trend: tuple[np.ndarray, float] | None = None
        self.like: Node | None = None

    @staticmethod
    def of(point: FamilyPoint, tangent: np.ndarray, iterations: int) -> "Node":
        """A node whose tangent is known."""
        node = Node(point, tangent, iterations)
        node.__dict__["tangent"] = tangent
        return node

    @once
    def tangent(self) -> np.ndarray:
        """Unit vector along the branch, scaled, the way that `along` points or `like` goes: beyond a corner,
        or where it is bent much since, dp/ds has changed its sign if det(P' - I) has.
        """
        like, self.like = self.like, None
        along = tangent(self.point.jacobian(), self.along if like is None else like.heading)
        if like is None or (like.word == self.word and dot(along, like.tangent) > BENT):
            return along
        sense = like.fold * self.fold  # no number where a rigid stop is grazed
        if not abs(sense) > 0 or self.point.family.conservative or self.in_family or like.in_family:
            return along
        return -along if along[-1] * like.ahead * sense < 0 else along

    def go_like(self, known: Sequence["Node"]) -> None:
        """Have the tangent go the way of others, the nearest first: of one with the same order of events, if
        there is one.
        """
        self.like = next((each for each in known if each.word == self.word), known[0])

    @once
    def kernel(self) -> np.ndarray:
        """Orthonormal vectors that the curves through the point span, one per row."""
        return kernel(self.point.jacobian())

    @once
    def slope(self) -> np.ndarray | None:
        """The derivative by the scaled parameter, as the tangent tells it; None beside a fold, where it does
        not, and of conservative orbits, of which each has its own without further ado.
        """
        linear = self.point.linear
        if self.point.family.conservative:
            return None
        pull = product(linear, self.tangent[:-1])
        return -pull / self.tangent[-1] if abs(pull).max() > TELLING * abs(linear).max() else None

    @property
    def has_tangent(self) -> bool:
        """Whether the tangent has been worked out."""
        return "tangent" in self.__dict__

    @property
    def heading(self) -> np.ndarray:
        """The tangent where it is known, else what is near it."""
        heading: np.ndarray = self.__dict__.get("tangent", self.along)
        return heading

    @property
    def z(self) -> np.ndarray:
        return self.point.z

    @property
    def parameter(self) -> float:
        return self.point.parameter

    @property
    def word(self) -> tuple[Any, ...]:
        return self.point.word

    @property
    def multipliers(self) -> np.ndarray:
        return self.point.multipliers

    @once
    def index(self) -> int:
        """Number of multipliers outside the unit circle; those of a family are on it but for rounding."""
        if self.point.family.conservative:
            return int(self.point.reciprocal.outside)
        return sum(modulus(mu) > 1 for mu in self.own_multipliers)

    @once
    def own_multipliers(self) -> list[complex]:
        """The multipliers without those that are 1 because the orbit belongs to a family."""
        every: list[complex] = self.multipliers.tolist()
        distances = [modulus(mu - 1) for mu in every]
        if not any(distance < UNIT for distance in distances):
            return every
        count = max(self.families, sum(distance < ON_CIRCLE for distance in distances))
        left_out = sorted(range(len(every)), key=distances.__getitem__)[:count]
        return [mu for i, mu in enumerate(every) if i not in left_out]

    @property
    def ahead(self) -> float:
        """dp/ds, scaled: 0 at a fold."""
        return float(self.tangent[-1])

    @property
    def fold(self) -> float:
        """det(P' - I), which is zero with a multiplier 1; without those that what is kept makes 1."""
        return self.point.fold

    @property
    def doubling(self) -> float:
        """det(P' + I), which is zero with a multiplier -1."""
        return self.point.doubling

    @once
    def pairs(self) -> list[complex]:
        """Complex multipliers with positive imaginary part, one of each pair, the largest first."""
        return [mu for mu in self.multipliers.tolist() if mu.imag > REAL * modulus(mu)]

    @once
    def pairs_outside(self) -> int:
        return sum(modulus(mu) > 1 for mu in self.pairs)

    def torus(self, near: complex) -> float:
        """|mu|^2 - 1 of the pair of multipliers near `near`: zero at a Neimark-Sacker point.

        Where the pair has become real, the product of the two instead, which goes on smoothly.
        """
        real = [mu.real for mu in self.multipliers if abs(mu.imag) <= REAL * modulus(mu)]
        products = [(modulus(mu - near), mu.real * mu.real + mu.imag * mu.imag) for mu in self.pairs]
        products += [(abs((a + b) / 2 - near.real) + abs(near.imag), a * b) for a, b in combinations(real, 2)]
        return min(products)[1] - 1.0

    @property
    def collision(self) -> float:
        """Of a conservative orbit: zero where two pairs of multipliers meet."""
        return float(self.point.reciprocal.collision)

    @property
    def level(self) -> bool:
        """Whether the branch goes on within a family of orbits at one value of the parameter."""
        return abs(self.ahead) < LEVEL and self.families > 0

    @property
    def in_family(self) -> bool:
        """Whether the orbit is one of a family at its parameter, or at neighbouring ones."""
        return len(self.own_multipliers) < len(self.multipliers)

    @once
    def families(self) -> int:
        """Dimensions of the family that the orbit belongs to at its parameter: 0 for an orbit alone."""
        return len(self.kernel) - 1


def node_at(
    family: Family,
    start: np.ndarray,
    across: np.ndarray | None,
    near: Node | None,
    limit: float,
    slope: np.ndarray | None = None,
) -> Node:
    """The node on the hyperplane through `start` across a unit vector, or at the parameter of `start` without
    one; its tangent goes on from that of `near`. slope : about its derivative by the parameter, where its own
    will be asked for. Raises ContinuationError.
    """
    families, guessed = near is not None and near.in_family, slope is not None
    if slope is None and across is not None and near is not None and limit <= CLOSE and not families:
        slope = near.point.about
    corrected = correct(family, start, across, limit, slope, families, guessed)
    if corrected.slope is not None:
        corrected.point.about = corrected.slope
    if corrected.near is not None:
        corrected.point.take_slope(corrected.near)
    heading = np.eye(len(start))[-1] if near is None else near.heading
    return Node(corrected.point, heading, corrected.iterations)


def ahead_of(family: Family, before: "Node | None", node: Node, step: float, bend: float) -> Node:
    """The node one step ahead; before: the node that came before, if any; bend: change of dp/ds with s.

    The parameter is held where no fold is near, nor a resonance so steep that it tells little of the orbit:
    then one scene serves all of Newton's steps.
    """
    steady = abs(node.ahead) >= max(STEADY * step * abs(bend), STEEP)
    start = predicted(before, node, step)
    if steady:
        return node_at(family, start, None, node, 4 * step)
    return node_at(family, start, node.tangent, node, 4 * step, slope_ahead(before, node, step))


def slope_ahead(before: Node | None, node: Node, step: float) -> np.ndarray | None:
    """About the derivative by the parameter one step ahead of a node: on the parabola through it and the two
    before, on the line through two where that is all; None where nothing is told.
    """
    if before is None or node.trend is None or node.slope is None:
        return None
    change, length = node.trend
    if step > LONGEST * length:
        return None
    slope = node.slope + step * change
    if before.trend is not None:
        earlier, last = before.trend
        slope += step * (step + length) / (length + last) * (change - earlier)
    return slope


def trend(before: Node, node: Node) -> tuple[np.ndarray, float] | None:
    """The `trend` of a node behind another; None where the branch does not go on smoothly between them."""
    if before.word != node.word or node.in_family or not goes_on(before, node):
        return None
    here, there = before.slope, node.slope
    if here is None or there is None:
        return None
    length = length_of(node.z - before.z)
    return (there - here) / length, length


def predicted(before: "Node | None", node: Node, step: float) -> np.ndarray:
    """Scaled unknowns one step ahead of a node: on the cubic through it and the one before, where both have
    the same order of events, else along its tangent; so in a family, whose every orbit near is a solution and
    holds no cubic to a course.
    """
    if before is not None and before.word == node.word and not node.in_family:
        length = length_of(node.z - before.z)
        if step <= LONGEST * length and goes_on(before, node):
            return _hermite(before, node, 1 + step / length, length)
    return np.asarray(node.z + step * node.tangent)


def goes_on(before: Node, node: Node) -> bool:
    """Whether unknowns went from one node to the next as the branch does: not so across an impact on the
    section.
    """
    chord = node.z - before.z
    return bool(dot(node.tangent, chord) > STRAIGHT * length_of(chord))


@dataclass(frozen=True)
class Chord:
    """The chord between two nodes, and on what the nodes between them are looked for.

    begin : its beginning; vector, length : scaled
    across : unit vector along it, where nodes lie on hyperplanes across it; None where the parameter changes
        steadily and is that of their share
    """

    begin: np.ndarray
    vector: np.ndarray
    length: float
    across: np.ndarray | None

    @property
    def limit(self) -> float:
        """Of a step of Newton's method."""
        return max(self.length, LEAST_LIMIT)

    def placed(self, start: np.ndarray, share: float) -> np.ndarray:
        """A start of Newton's method, moved to where the nodes of a share are looked for."""
        place = self.begin + share * self.vector
        if self.across is None:
            start[-1] = place[-1]
            return start
        return np.asarray(start + self.across * (dot(self.across, place - start)))

    def pace(self, tangent: np.ndarray) -> np.ndarray:
        """dz / d share where the branch has a tangent."""
        if self.across is None:
            return np.asarray(tangent * (self.vector[-1] / tangent[-1]))
        return np.asarray(tangent * (self.length / dot(self.across, tangent)))


def chord_of(one: Node, other: Node) -> Chord:
    """The chord from one node to another."""
    vector = other.z - one.z
    length = length_of(vector)
    paces = np.array([vector[-1] / length, one.heading[-1], other.heading[-1]])
    steady = bool((paces > 0).all() or (paces < 0).all()) and abs(paces).max() < STEADY * abs(paces).min()
    return Chord(one.z, vector, length, None if steady else vector / length)


def between(family: Family, one: Node, other: Node, share: float) -> Node:
    """The node at a share of the way from one to another: of the parameter where it changes steadily, else on
    the hyperplane across their chord.
    """
    chord = chord_of(one, other)
    start = start_between(one, other, share, chord)
    near, far = (one, other) if share < 0.5 else (other, one)
    node = node_at(family, start, chord.across, near, chord.limit)
    node.go_like((near, far))
    return node


def start_between(one: Node, other: Node, share: float, chord: Chord) -> np.ndarray:
    """About where the node at a share of a chord is: on the cubic with the tangents at both ends."""
    return chord.placed(_hermite(one, other, share, chord.length), share)


def _hermite(one: Node, other: Node, share: float, length: float) -> np.ndarray:
    """The cubic through two nodes with their tangents."""
    t, rest = share, 1 - share
    begin, end = rest * rest * t * length, t * t * rest * length
    ahead = t * t * (3 - 2 * t)
    return np.asarray(one.z + ahead * (other.z - one.z) + (begin * one.heading - end * other.heading))


# Energy and momentum of a scene that loses none: what a conservative orbit is told by.


ENERGY = "energy"  # stands for a key of the case where orbits are continued in their energy


def without_still_sources(scene: Scene) -> Scene:
    """The scene without harmonics of amplitude 0, whose clock nothing hears."""

    forces = tuple(
        replace(force, terms=tuple(term for term in force.terms if term.amplitude != 0))
        for force in scene.forces
    )
    return replace(scene, forces=forces, base=tuple(term for term in scene.base if term.amplitude != 0))


def what_is_not_conservative(scene: Scene) -> list[str]:
    """The parts that give or take energy, in words; none where energy is kept. Of formulas those of links
    that read the distance of their ends alone are known to keep it.
    """
    parts = ["the motor"] if scene.motor is not None else []
    parts += [f"the {body.kind} {body.name}" for body in scene.bodies[len(scene.line) :]]
    parts += [f"the formula of {name}" for name in _unknown_formulas(scene)]
    parts += [f"the force {one.name}" for one in scene.forces if any(t.amplitude != 0 for t in one.terms)]
    parts += ["the moving base"] * any(term.amplitude != 0 for term in scene.base)
    parts += [f"the damper of link {one.name}" for one in scene.links if one.c != 0]
    parts += [f"the damper of stop {one.name}" for _, one in scene.elastic_stops if one.c != 0]
    parts += [f"the restitution of stop {one.name}" for _, one in scene.rigid_stops if one.e != 1]
    rubbing = [one for one in scene.frictions if any(one.limits) or one.slips is not None]
    return parts + [f"the friction {one.name}" for one in rubbing]


def _unknown_formulas(scene: Scene) -> list[str]:
    """Names of the parts whose formulas may give or take energy, but for frictions."""
    if not scene.has_formulas:
        return []
    unknown = [
        one.name
        for one in formulas_of(scene)
        if one.section not in ("links", "frictions")
        or (one.section == "links" and not reads_own_distance(scene.links[one.number]))
    ]
    return list(dict.fromkeys(unknown))


class Conserved:
    """Energy [J], and momenta [N s] of the sets of bodies that nothing holds, by the unknowns of an orbit.

    Displacements count from the references, which rest at 0; constant forces have a potential.
    """

    def __init__(self, scene: Scene, at: Any):
        self.scene, self.at, self.m = scene, at, masses(scene)
        self.n = len(scene.bodies)
        sets = [one for one in body_sets(scene, [*scene.links, *scene.stops]) if not one.held]
        rows = np.zeros((len(sets), 2 * self.n))
        for row, one in zip(rows, sets, strict=True):
            row[[self.n + body for body in one.bodies]] = self.m[list(one.bodies)]
        self.rows = rows[[len(one.bodies) > 1 for one in sets]]
        self._kept = rows

    def energy(self, X: np.ndarray) -> float:
        """Kinetic energy, that of springs and of elastic stops in contact, potential of constant forces."""
        state = self.at.lifted(X)
        x, v = state[: self.n], state[self.n :]
        springs = sum(link.k * self._apart(x, link) ** 2 for link in self.scene.links)
        springs += sum(2 * self._potential(x, link) for link in self._formulas)
        stops = sum(stop.k * max(0.0, self._depth(x, stop)) ** 2 for _, stop in self.scene.elastic_stops)
        loads = sum(force.constant * x[force.on] for force in self.scene.forces)
        return float((dot(self.m, v * v) + springs + stops) / 2 - loads)

    def gradient(self, X: np.ndarray) -> np.ndarray:
        """Derivative of the energy by the unknowns."""
        state = self.at.lifted(X)
        x, slope = state[: self.n], np.concatenate([np.zeros(self.n), self.m * state[self.n :]])
        pulls: list[tuple[Any, float]] = [(link, link.k * self._apart(x, link)) for link in self.scene.links]
        pulls += [(link, self._pull(x, link)) for link in self._formulas]
        pulls += [(s, -s.sense * s.k * max(0.0, self._depth(x, s))) for _, s in self.scene.elastic_stops]
        for part, pull in pulls:
            for end, sign in ((part.P, 1), (part.Q, -1)):
                if end >= 0:
                    slope[end] += sign * pull
        for force in self.scene.forces:
            slope[force.on] -= force.constant
        return np.asarray(slope[self.at.free])

    @property
    def _formulas(self) -> list[Any]:
        """The links with a formula."""
        return [link for link in self.scene.links if link.force is not None]

    def _potential(self, x: np.ndarray, link: Any) -> float:
        """Energy of a link with a formula [J]."""
        return potential_of(link, self._apart(x, link))

    def _pull(self, x: np.ndarray, link: Any) -> float:
        """Force of a link with a formula that draws its ends together [N]."""
        return float(values_of(link.force, {("x", end): x[end] for end in (link.P, link.Q) if end >= 0}))

    def momenta(self, X: np.ndarray) -> np.ndarray:
        """Of each set that nothing holds."""
        return product(self.rows, self.at.lifted(X))

    @property
    def momentum_rows(self) -> np.ndarray:
        """Derivative of the momenta by the unknowns."""
        return np.asarray(self.rows[:, self.at.free])

    @property
    def kept_rows(self) -> np.ndarray:
        """The same with those of bodies that nothing joins to another, whose velocity is kept."""
        return np.asarray(self._kept[:, self.at.free])

    def _apart(self, x: np.ndarray, part: Any) -> float:
        return float(sum(sign * x[end] for end, sign in ((part.P, 1), (part.Q, -1)) if end >= 0))

    def _depth(self, x: np.ndarray, stop: Any) -> float:
        return float(-stop.sense * self._apart(x, stop) - stop.gap)
