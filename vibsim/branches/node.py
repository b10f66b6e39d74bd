"""A point of a branch: an orbit, the tangent of the branch there, and its test values."""

from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from typing import Any

import numpy as np

from vibsim.branches.arclength import Corrected, correct, kernel, tangent
from vibsim.branches.family import Family, FamilyPoint

STEEP = 0.2  # share of the parameter in a tangent from which on the parameter is held while Newton corrects
LEAST_LIMIT = 1e-6  # scaled length that a Newton step may have, however near two nodes are
REAL = 1e-9  # imaginary part, over its size, below which a multiplier counts as real


@dataclass(frozen=True)
class Node:
    """A point of a branch.

    point : the orbit; tangent : unit vector along the branch, scaled; iterations : of Newton's method
    """

    point: FamilyPoint
    tangent: np.ndarray
    iterations: int

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

    @property
    def index(self) -> int:
        """Number of multipliers outside the unit circle."""
        return int(np.sum(np.abs(self.multipliers) > 1))

    @property
    def ahead(self) -> float:
        """dp/ds, scaled: 0 at a fold."""
        return float(self.tangent[-1])

    @cached_property
    def fold(self) -> float:
        """det(P' - I), which is zero with a multiplier 1."""
        return float(np.linalg.det(self.point.matrix - np.eye(len(self.point.matrix))))

    @cached_property
    def doubling(self) -> float:
        """det(P' + I), which is zero with a multiplier -1."""
        return float(np.linalg.det(self.point.matrix + np.eye(len(self.point.matrix))))

    @cached_property
    def pairs(self) -> list[complex]:
        """Complex multipliers with positive imaginary part, one of each pair, the largest first."""
        return [mu for mu in self.multipliers if mu.imag > REAL * abs(mu)]

    @property
    def pairs_outside(self) -> int:
        return sum(abs(mu) > 1 for mu in self.pairs)

    def torus(self, near: complex) -> float:
        """|mu|^2 - 1 of the pair of multipliers near `near`: zero at a Neimark-Sacker point.

        Where the pair has become real, the product of the two instead, which goes on smoothly.
        """
        real = [mu.real for mu in self.multipliers if abs(mu.imag) <= REAL * abs(mu)]
        products = [(abs(mu - near), abs(mu) ** 2) for mu in self.pairs]
        products += [(abs((a + b) / 2 - near.real) + abs(near.imag), a * b) for a, b in combinations(real, 2)]
        return min(products)[1] - 1.0

    @cached_property
    def families(self) -> int:
        """Dimensions of the family that the orbit belongs to at its parameter: 0 for an orbit alone."""
        return len(kernel(self.point.jacobian())) - 1


def node_at(family: Family, start: np.ndarray, across: np.ndarray, near: Node | None, limit: float) -> Node:
    """The node on the hyperplane through `start` across a unit vector; its tangent goes on from that of `near`.

    Raises ContinuationError.
    """
    slope = near.point.slope if near is not None and near.families == 0 else None
    return with_tangent(correct(family, start, across, limit, slope), across if near is None else near.tangent)


def with_tangent(corrected: Corrected, along: np.ndarray) -> Node:
    """A node of a point, its tangent the one nearest to `along`."""
    point = corrected.point
    return Node(point, tangent(point.jacobian(), along), corrected.iterations)


def ahead_of(family: Family, node: Node, step: float) -> Node:
    """The node one step ahead along the tangent.

    The parameter is held where it changes fast enough: then one scene serves all of Newton's steps.
    """
    start = node.z + step * node.tangent
    across = node.tangent if abs(node.ahead) < STEEP else np.eye(len(node.z))[-1]
    return node_at(family, start, across, node, 4 * step)


def between(family: Family, one: Node, other: Node, share: float) -> Node:
    """The node at a share of the way from one to another, on the hyperplane across their chord."""
    chord = other.z - one.z
    length = float(np.linalg.norm(chord))
    across = chord / length
    near = one if share < 0.5 else other
    start = _hermite(one, other, share, length)
    start = start + across * (across @ (one.z + share * chord - start))
    return node_at(family, start, across, near, max(length, LEAST_LIMIT))


def _hermite(one: Node, other: Node, share: float, length: float) -> np.ndarray:
    """The cubic through two nodes with their tangents."""
    t = share
    value = (2 * t**3 - 3 * t**2 + 1) * one.z + (3 * t**2 - 2 * t**3) * other.z
    slopes = (t**3 - 2 * t**2 + t) * one.tangent + (t**3 - t**2) * other.tangent
    return np.asarray(value + length * slopes)
