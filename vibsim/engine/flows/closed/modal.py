"""The closed form of a mode as data: modal coordinates, and where each column is in terms of them.

`vibsim.engine.flows.closed.modal_maker` makes it.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Generic

from vibsim.engine.modes.ties import Edge
from vibsim.physics.numbers import N
from vibsim.physics.parts import Harmonic, Scene

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
