"""Loads of modal coordinates: forces, offsets of couplings, the base, places of bodies within groups."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Generic

from vibsim.engine.flows.closed.matrices import Matrix
from vibsim.engine.flows.closed.modal import (
    ModalPlace,
    Pitch,
    Positions,
    Shift,
    harmonic_key,
    nonzero_harmonics,
)
from vibsim.engine.modes.ties import Edge
from vibsim.physics.numbers import N
from vibsim.physics.parts import Scene

if TYPE_CHECKING:
    from vibsim.engine.modes.rows import Coupling, ModeRows


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
        zero: N,
    ) -> None:
        self.scene, self.rows, self.harmonics, self.places, self.zero = scene, rows, harmonics, places, zero
        self.leader, self.moves = rows.leader, rows.groups.moves

    def of(self, weights: list[N], component: Component[N]) -> tuple[N, list[N], list[N]]:
        """load, sines, cosines of a coordinate, from the offsets of couplings, forces and the base."""
        load = self.zero
        for q, stretch in zip(component.couplings, component.stretches, strict=True):
            if q.offset != 0:
                load = load - _weight(weights, component.B, stretch, self.zero) * q.offset
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
                    share = sway * _weight(weights, component.B, stretch, self.zero)
                    sines[h] = sines[h] - share * (q.k * X)
                    cosines[h] = cosines[h] - share * (q.c * V)

    def _force_weight(self, weights: list[N], edges: list[Edge], column: int) -> tuple[N, N] | None:
        """[(factor, mass)] by which a force on a column accelerates the coordinate; None where it does
        not.
        """
        total = None
        if not self.moves(column):
            return None
        for weight, (P, Q) in zip(weights, edges, strict=True):
            if column in (P, Q) and weight != 0:
                part = weight if column == P else -weight
                total = part if total is None else total + part
        return None if total is None else (total, self.rows.own_mass(column))

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
                factor = -(sign * _weight(weights, component.B, stretch, self.zero) * q.k)
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


def _weight(weights: list[N], B: Matrix[N], stretch: list[int], zero: N) -> N:
    """Acceleration of the coordinate by a unit force in a coupling, with its sign turned: (weights B
    stretch).
    """
    total = None
    for m, weight in enumerate(weights):
        for e, stretched in enumerate(stretch):
            if stretched != 0 and weight != 0:
                part = weight * (B[m][e] * stretched)
                total = part if total is None else total + part
    return zero if total is None else total


def _per_mass(value: N, share: tuple[N, N]) -> N:
    factor, mass = share
    return factor * (value / mass)
