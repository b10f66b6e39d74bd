"""The closed form of a mode as data: modal coordinates, where each column is in them, their loads.

`vibsim.engine.flows.closed.modal_maker` makes it.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Generic

from vibsim.engine.flows.closed.matrices import Matrix
from vibsim.engine.modes.ties import Edge
from vibsim.physics.numbers import Kit, N, total_of
from vibsim.physics.parts import Harmonic, Scene

if TYPE_CHECKING:
    from vibsim.engine.modes.rows import Coupling, ModeRows


Pitch = tuple[N, N, N, N]  # omega, cycles, cycles_lo, phase
Positions = tuple[tuple[int, int], ...]  # sum of sign times the position of a column at the start
Source = tuple[tuple[int, int | None], N | int]  # column of differences or None, weight
Shift = tuple[N, Positions, Positions]  # factor, positions plus and minus
Vector = tuple[int, list[N]]  # number of a coordinate, differences by it
Stands = dict[int | None, list[int]]  # by leading column: 1 on the side of P of a difference


@dataclass
class Coordinate(Generic[N]):
    """One modal coordinate.

    a, b : of q'' + 2 a q' + b q = load + sum_h (sine_h sin + cosine_h cos)(omega_h t + phase_h)
    load_size, sizes : magnitudes of the terms that `load`, and by h sine and cosine, are sums of
    sources : [(column of differences or None, weight)]: q at the start is the weighted sum of these
    shifts : [(weight, coupling)]: loads that the place of bodies within their groups adds
    """

    a: N
    b: N
    load: N
    load_size: N
    sines: list[N]
    cosines: list[N]
    sizes: list[N]
    sources: list[Source[N]]
    shifts: list[Shift[N]] = field(default_factory=list)
    free: bool = False  # neither spring nor damper


@dataclass
class ModalPlace(Generic[N]):
    """A column as sum of shape[m] q_m, of positions at the start of the segment (sign, column), and of the
    base's displacement times `base`.
    """

    shape: dict[int, N | int]
    fixed: Positions
    base: int = 0
    sides: tuple[int, ...] = ()  # of each difference of its component without reference, 1 on the side of P
    vectors: tuple[
        Vector[N], ...
    ] = ()  # (m, difference by q_m) of that component; the same object for all of its columns


@dataclass
class Difference(Generic[N]):
    """x_P - x_Q as sum of coefficient q_m over the `terms` (m, coefficient), of positions at the start of the
    segment (sign, column), and of the base's displacement times `base`.
    """

    terms: list[tuple[int, N | int]]
    fixed: list[tuple[int, int]]
    base: int


@dataclass
class Modal(Generic[N]):
    """Closed form of a mode: coordinates, and where each column, and pair of columns, is in terms of them."""

    coordinates: list[Coordinate[N]]
    places: list[ModalPlace[N]]
    pairs: dict[Edge, Difference[N]]


def harmonic_key(term: Harmonic[N]) -> Pitch[N]:
    """Key of one harmonic function of time: frequency and phase."""
    return term.omega, term.cycles, term.cycles_lo, term.phase


def nonzero_harmonics(terms: Iterable[Harmonic[N]]) -> list[Harmonic[N]]:
    """The terms with an amplitude."""
    return [term for term in terms if term.amplitude != 0]


def pitches(scene: Scene[N]) -> list[Pitch[N]]:
    """The distinct frequencies and phases of forces and base, in the order in which they are numbered."""
    return list(dict.fromkeys(harmonic_key(term) for term in nonzero_harmonics(scene.harmonics)))


# Loads of modal coordinates: forces, offsets of couplings, the base, places of bodies within groups.


@dataclass
class Component(Generic[N]):
    """Groups that are coupled to one another.

    edges : (P, Q) of the differences y = x_P - x_Q that tell their places
    B : D M^-1 D' of the differences
    couplings, stretches : each coupling, and how far it stretches with each difference: 0, 1 or -1
    reference : a column at rest, or of the base, that they are coupled to; None where there is none
    """

    edges: list[Edge]
    B: Matrix[N]
    couplings: list[Coupling[N]]
    stretches: list[list[int]]
    reference: int | None


class Loads(Generic[N]):
    """Loads of the coordinates of a mode.

    places : of columns that are held
    """

    def __init__(
        self,
        scene: Scene[N],
        rows: ModeRows[N],
        harmonics: Sequence[Pitch[N]],
        places: dict[int, ModalPlace[N]],
        kit: Kit[N],
    ) -> None:
        self.scene, self.rows, self.harmonics, self.places, self.kit = scene, rows, harmonics, places, kit
        self.zero = kit.number(0)
        self.leader, self.moves = rows.leader, rows.groups.moves

    def of(self, weights: list[N], component: Component[N]) -> tuple[N, list[N], list[N]]:
        """load, sines, cosines of a coordinate, from the offsets of couplings, forces and the base."""
        load = self.zero
        for q, stretch in zip(component.couplings, component.stretches, strict=True):
            if q.offset != 0:
                load = load - self._weight(weights, component.B, stretch) * q.offset
        sines, cosines = [self.zero] * len(self.harmonics), [self.zero] * len(self.harmonics)
        for force in self.scene.forces:
            share = self._force_weight(weights, component.edges, self.leader[force.on])
            if share is not None:
                load = load + _per_mass(force.constant, share)
                for term in nonzero_harmonics(force.terms):
                    h = self.harmonics.index(harmonic_key(term))
                    sines[h] = sines[h] + _per_mass(term.amplitude, share)
        for column, value in self.rows.constants:
            share = self._force_weight(weights, component.edges, self.leader[column])
            if share is not None:
                load = load + _per_mass(value, share)
        self._base_loads(weights, component, sines, cosines)
        return load, sines, cosines

    def _base_loads(
        self, weights: list[N], component: Component[N], sines: list[N], cosines: list[N]
    ) -> None:
        """Loads from the base: inertia where the component is measured from it, else through links to it."""
        rides = component.reference is not None and self.places[component.reference].base == 1
        for term in nonzero_harmonics(self.scene.base):
            h = self.harmonics.index(harmonic_key(term))
            X, V = term.amplitude, term.amplitude * term.omega
            if rides:
                for weight, (P, Q) in zip(weights, component.edges, strict=True):
                    at_P, at_Q = (self.places[c].base if not self.moves(c) else None for c in (P, Q))
                    if at_P == 1 or at_Q == 1:  # y = u - X: y'' = u'' - X''
                        sign = 1 if at_Q == 1 else -1
                        sines[h] = sines[h] + sign * weight * (X * term.omega * term.omega)
            for q, stretch in zip(component.couplings, component.stretches, strict=True):
                ends = [self.places[c].base if not self.moves(c) else (1 if rides else 0) for c in (q.P, q.Q)]
                sway = ends[0] - ends[1]
                if sway != 0:
                    share = sway * self._weight(weights, component.B, stretch)
                    sines[h] = sines[h] - share * (q.k * X)
                    cosines[h] = cosines[h] - share * (q.c * V)

    def _force_weight(self, weights: list[N], edges: list[Edge], column: int) -> tuple[N, N] | None:
        """[(factor, mass)] by which a force on a column accelerates the coordinate; None where it does
        not.
        """
        acting = [
            weight if column == P else -weight
            for weight, (P, Q) in zip(weights, edges, strict=True)
            if column in (P, Q) and weight != 0
        ]
        if not self.moves(column) or not acting:
            return None
        return total_of(self.kit, acting), self.rows.own_mass(column)

    def _weight(self, weights: list[N], B: Matrix[N], stretch: list[int]) -> N:
        """Acceleration of the coordinate by a unit force in a coupling, with its sign turned: (weights B
        stretch).
        """
        return total_of(
            self.kit,
            (
                weight * (row[e] * stretched)
                for weight, row in zip(weights, B, strict=True)
                for e, stretched in enumerate(stretch)
                if stretched != 0 and weight != 0
            ),
        )

    def shifts(self, weights: list[N], component: Component[N]) -> list[Shift[N]]:
        """Loads -k (distance of an end from the column that stands for it), by coupling: [(factor, plus,
        minus)].
        """
        shifts: list[Shift[N]] = []
        for q, stretch in zip(component.couplings, component.stretches, strict=True):
            if q.k == 0:
                continue
            for end, sign in ((q.P, 1), (q.Q, -1)):
                stands = self.leader[end] if self.moves(end) else component.reference
                if stands is None or end == stands:
                    continue
                moved = self.places[end] if not self.moves(end) else None
                if (
                    moved is not None
                    and not moved.fixed
                    and component.reference is not None
                    and not self.places[component.reference].fixed
                    and moved.base == self.places[component.reference].base
                ):
                    continue
                factor = -(sign * self._weight(weights, component.B, stretch) * q.k)
                shifts.append((factor, self._fixed(end), self._fixed(stands)))
        return [s for s in shifts if s[1] != s[2]]

    def _fixed(self, c: int) -> Positions:
        """Positions at the start that a column's place is made of."""
        return self.places[c].fixed if not self.moves(c) else ((1, c),)

    def central(self, leaders: list[int], total: N, zero: N) -> tuple[N, list[N]]:
        """load and sines of a centre of mass, sums that begin at `zero`."""
        load, sines = zero, [zero] * len(self.harmonics)
        for force in self.scene.forces:
            if self.leader[force.on] in leaders:
                load = load + force.constant
                for term in nonzero_harmonics(force.terms):
                    h = self.harmonics.index(harmonic_key(term))
                    sines[h] = sines[h] + term.amplitude / total
        for column, value in self.rows.constants:
            if self.leader[column] in leaders:
                load = load + value
        return load / total, sines


def _per_mass(value: N, share: tuple[N, N]) -> N:
    factor, mass = share
    return factor * (value / mass)
