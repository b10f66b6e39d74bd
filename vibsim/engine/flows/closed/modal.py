"""The closed form of a mode: modal coordinates in which every group moves by itself.

Bodies that are coupled form components. A component that is not coupled to anything at rest has a centre of
mass that only forces move. What is left are differences between neighbours, split off exactly: with B = D
M^-1 D' and the stiffness K of the differences y = D u, they obey
    y'' = -B (C y' + K y) + D M^-1 F.
Where C and K commute, M^-1 C M^-1 K = M^-1 K M^-1 C, one rotation makes both diagonal and each coordinate an
oscillator q'' + 2 a q' + b q = load + sum of harmonics (Caughey & O'Kelly 1965). Without that, with a motor,
or where belts make a load that grows with time, the mode has no closed form here and is left to Taylor
series.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Generic

from vibsim.engine.flows.closed.magnitudes import magnitudes, size_of
from vibsim.engine.flows.closed.matrices import (
    Matrix,
    cholesky,
    inverse_triangular,
    jacobi,
    product,
    transposed,
)
from vibsim.engine.modes.ties import Edge
from vibsim.physics.arithmetic.numbers import Kit, N
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
class Place(Generic[N]):
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
    places: list[Place[N]]
    pairs: dict[Edge, Difference[N]]


def pitch(term: Harmonic[N]) -> Pitch[N]:
    """What tells one harmonic function of time from another: frequency and phase."""
    return term.omega, term.cycles, term.cycles_lo, term.phase


def sounding(terms: Iterable[Harmonic[N]]) -> list[Harmonic[N]]:
    """The terms with an amplitude."""
    return [term for term in terms if term.amplitude != 0]


def pitches(scene: Scene[N]) -> list[Pitch[N]]:
    """The distinct frequencies and phases of forces and base, in the order in which they are numbered."""
    return list(dict.fromkeys(pitch(term) for term in sounding(scene.harmonics)))


def modal_of(
    scene: Scene[N], kit: Kit[N], rows: ModeRows[N], harmonics: Sequence[Pitch[N]]
) -> Modal[N] | None:
    """The closed form of the mode `rows`, or None.

    harmonics: the distinct (omega, cycles, cycles_lo, phase) of forces and base.
    """
    if scene.motor is not None or rows.falls:
        return None
    return _Builder(scene, kit, rows, harmonics).build()


class _Builder(Generic[N]):
    def __init__(
        self, scene: Scene[N], kit: Kit[N], rows: ModeRows[N], harmonics: Sequence[Pitch[N]]
    ) -> None:
        self.scene, self.kit, self.rows, self.harmonics = scene, kit, rows, harmonics
        self.n, self.zero = len(scene.bodies), kit.number(0)
        self.leader, self.moves = rows.leader, rows.groups.moves
        self.coordinates: list[Coordinate[N]] = []
        self.places: dict[int, Place[N]] = {}

    def build(self) -> Modal[N] | None:
        if self._belts_load():
            return None
        for leader in sorted({c for c in self.leader if not self.moves(c)}, reverse=True):
            self._place_fixed(leader)
        for component in self._components():
            if not self._component(component):
                return None
        places = [self.places[c] if c in self.places else self._follower(c) for c in range(self.n + 2)]
        return Modal(self.coordinates, places, self._pairs(places))

    def _belts_load(self) -> bool:
        """Whether a belt moves one end of a spring or damper against its group: a load that grows with
        time.
        """
        for coupling in self.rows.couplings:
            P, Q = coupling.P, coupling.Q
            drifts = self.rows.drift[P] != 0 or self.rows.drift[Q] != 0
            if drifts and (self.moves(P) or self.moves(Q)):
                return True
        return any(self.rows.drift[c] != 0 and self.moves(c) for c in range(self.n))

    def _place_fixed(self, leader: int) -> None:
        """Columns of the group of the ground or the base."""
        base = 1 if leader == self.n + 1 else 0
        for c in self.rows.groups.members[leader]:
            if c == leader:
                self.places[c] = Place({}, (), base)
            elif self.rows.drift[c] != 0:
                self.coordinates.append(self._coasting(c, leader if base else None))
                self.places[c] = Place({len(self.coordinates) - 1: 1}, (), base)
            else:
                self.places[c] = Place({}, ((1, c),) + (((-1, leader),) if base else ()), base)

    def _coasting(self, c: int, base: int | None) -> Coordinate[N]:
        """A column that moves with a belt at constant speed, measured from the base where that carries it."""
        none = [self.zero] * len(self.harmonics)
        zero = self.zero
        return Coordinate(zero, zero, zero, zero, none, none, none, [((c, base), 1)], free=True)

    def _follower(self, c: int) -> Place[N]:
        """A body within a group that moves: where its leader is, and the distance at the start."""
        place = self.places[self.leader[c]]
        fixed = (*place.fixed, (1, c), (-1, self.leader[c]))
        return Place(place.shape, fixed, place.base, place.sides, place.vectors)

    def _components(self) -> list[list[int]]:
        """Leading columns that move, by what couplings join them: [(leaders, couplings)]."""
        left = [c for c in range(self.n) if self.leader[c] == c and self.moves(c)]
        components: list[list[int]] = []
        while left:
            reached, ahead = [left[0]], [left[0]]
            while ahead:
                c = ahead.pop(0)
                for coupling in self.rows.couplings:
                    P, Q = self.leader[coupling.P], self.leader[coupling.Q]
                    for one, other in ((P, Q), (Q, P)):
                        if one == c and self.moves(other) and other not in reached:
                            reached.append(other)
                            ahead.append(other)
            components.append(sorted(reached))
            left = [c for c in left if c not in reached]
        return components

    def _component(self, leaders: list[int]) -> bool:
        """Coordinates of one component; whether it has a closed form."""
        couplings = [q for q in self.rows.couplings if {self.leader[q.P], self.leader[q.Q]} & set(leaders)]
        couplings = [q for q in couplings if self.leader[q.P] != self.leader[q.Q]]
        anchors = [end for q in couplings for end in (q.P, q.Q) if not self.moves(end)]
        reference = anchors[0] if anchors else None
        edges = self._tree(leaders, couplings, reference)
        sides = [self._side(P, edges, e) for e, (P, _) in enumerate(edges)]
        differences = self._shares(leaders, sides, reference)
        stands: Stands = {c: [1 if c in side else 0 for side in sides] for c in {*leaders, reference}}
        shapes = self._oscillators(couplings, edges, stands, reference)
        if shapes is None:
            return False
        vectors = tuple(shapes)
        centre = None
        if reference is None:
            centre = self._centre(leaders)
        for c in leaders:
            shape: dict[int, N | int] = {} if centre is None else {centre: 1}
            for m, vector in shapes:
                total: N | None = None
                for e in range(len(edges)):
                    part = differences[c][e] * vector[e]
                    total = part if total is None else total + part
                if total is not None and total != 0:
                    shape[m] = total
            at: Place[N] = Place({}, ()) if reference is None else self.places[reference]
            self.places[c] = Place({**at.shape, **shape}, at.fixed, at.base)
            if reference is None:
                self.places[c].sides, self.places[c].vectors = tuple(stands[c]), vectors
        return True

    def _tree(self, leaders: list[int], couplings: list[Coupling[N]], reference: int | None) -> list[Edge]:
        """Couplings, as (P, Q) of leading columns, that join all `leaders`, and the reference where there
        is one.
        """
        reached = {leaders[0] if reference is None else reference}
        edges: list[Edge] = []
        while True:
            for q in couplings:
                P, Q = (self.leader[c] if self.moves(c) else c for c in (q.P, q.Q))
                if (P in reached) != (Q in reached) and {P, Q} <= {*leaders, reference}:
                    edges.append((P, Q))
                    reached |= {P, Q}
                    break
            else:
                return edges

    def _shares(self, leaders: list[int], sides: list[set[int]], reference: int | None) -> dict[int, list[N]]:
        """How far each leading column goes with each difference y_e = x_P - x_Q: {column: [share]}."""
        shares: dict[int, list[N]] = {c: [] for c in leaders}
        for side in sides:
            if reference is not None:
                away = reference not in side
                for c in leaders:
                    inside = c in side
                    value = (1 if inside else 0) if away else (0 if inside else -1)
                    shares[c].append(self.kit.number(value))
                continue
            near = self._total([c for c in leaders if c in side])
            far = self._total([c for c in leaders if c not in side])
            for c in leaders:
                shares[c].append(far / (near + far) if c in side else -(near / (near + far)))
        return shares

    def _side(self, start: int, edges: list[Edge], cut: int) -> set[int]:
        reached, ahead = {start}, [start]
        while ahead:
            c = ahead.pop()
            for e, (P, Q) in enumerate(edges):
                for one, other in ((P, Q), (Q, P)):
                    if e != cut and one == c and other not in reached:
                        reached.add(other)
                        ahead.append(other)
        return reached

    def _total(self, leaders: Iterable[int]) -> N:
        first, *others = leaders
        total = self.rows.own_mass(first)
        for c in others:
            total = total + self.rows.own_mass(c)
        return total

    def _stretch(self, coupling: Coupling[N], stands: Stands, reference: int | None) -> list[int]:
        """How far a coupling stretches with each difference: 0, 1 or -1."""
        P, Q = (stands[self.leader[c] if self.moves(c) else reference] for c in (coupling.P, coupling.Q))
        return [a - b for a, b in zip(P, Q, strict=True)]

    def _oscillators(
        self, couplings: list[Coupling[N]], edges: list[Edge], stands: Stands, reference: int | None
    ) -> list[Vector[N]] | None:
        """Coordinates of the differences: [(number, y = sum vector q)], or None."""
        size = len(edges)
        if size == 0:
            return []
        B = [[self._mobility(edges[i], edges[j]) for j in range(size)] for i in range(size)]
        stretches = [self._stretch(q, stands, reference) for q in couplings]
        if size == 1:
            k, c = couplings[0].k, couplings[0].c
            for q in couplings[1:]:
                k, c = k + q.k, c + q.c
            forward, backward = [[self.kit.number(1)]], [[self.kit.number(1)]]
            rates, damping = [k * B[0][0]], [c * B[0][0] / 2]
        else:
            diagonal = self._diagonal(B, couplings, stretches)
            if diagonal is None:
                return None
            forward, backward, rates, damping = diagonal
        shapes: list[Vector[N]] = []
        for m in range(size):
            sources: list[Source[N]] = [
                (edges[e], backward[m][e]) for e in range(size) if backward[m][e] != 0
            ]
            parts = edges, B, couplings, stretches, reference
            load, sines, cosines = self._loads(backward[m], *parts)
            load_size, *sizes = _sizes(*self._loads(magnitudes(backward[m]), *parts))
            coordinate = Coordinate(damping[m], rates[m], load, load_size, sines, cosines, sizes, sources)
            coordinate.shifts = self._shifts(backward[m], B, couplings, stretches, reference)
            coordinate.free = coordinate.a == 0 and coordinate.b == 0
            self.coordinates.append(coordinate)
            shapes.append((len(self.coordinates) - 1, [forward[e][m] for e in range(size)]))
        return shapes

    def _mobility(self, one: Edge, other: Edge) -> N:
        """Entry of B = D M^-1 D' for two differences."""
        total = None
        for c, sign in ((one[0], 1), (one[1], -1)):
            if self.moves(c) and c in other:
                part = (sign if c == other[0] else -sign) * self.rows.mobility[c]
                total = part if total is None else total + part
        return self.zero if total is None else total

    def _loads(
        self,
        weights: list[N],
        edges: list[Edge],
        B: Matrix[N],
        couplings: list[Coupling[N]],
        stretches: list[list[int]],
        reference: int | None,
    ) -> tuple[N, list[N], list[N]]:
        """load, sines, cosines of a coordinate, from the offsets of couplings, forces and the base."""
        load = self.zero
        for q, stretch in zip(couplings, stretches, strict=True):
            if q.offset != 0:
                load = load - self._weight(weights, B, stretch) * q.offset
        sines, cosines = [self.zero] * len(self.harmonics), [self.zero] * len(self.harmonics)
        for force in self.scene.forces:
            share = self._force_weight(weights, edges, self.leader[force.on])
            if share is not None:
                load = load + self._per_mass(force.constant, share)
                for term in sounding(force.terms):
                    h = self.harmonics.index(pitch(term))
                    sines[h] = sines[h] + self._per_mass(term.amplitude, share)
        for column, value in self.rows.constants:
            share = self._force_weight(weights, edges, self.leader[column])
            if share is not None:
                load = load + self._per_mass(value, share)
        self._base_loads(weights, edges, B, couplings, stretches, reference, sines, cosines)
        return load, sines, cosines

    def _base_loads(
        self,
        weights: list[N],
        edges: list[Edge],
        B: Matrix[N],
        couplings: list[Coupling[N]],
        stretches: list[list[int]],
        reference: int | None,
        sines: list[N],
        cosines: list[N],
    ) -> None:
        """Loads from the base: inertia where the component is measured from it, else through links to it."""
        rides = reference is not None and self.places[reference].base == 1
        for term in sounding(self.scene.base):
            h = self.harmonics.index(pitch(term))
            X, V = term.amplitude, term.amplitude * term.omega
            if rides:
                for weight, (P, Q) in zip(weights, edges, strict=True):
                    at_P, at_Q = (self.places[c].base if not self.moves(c) else None for c in (P, Q))
                    if at_P == 1 or at_Q == 1:  # y = u - X: y'' = u'' - X''
                        sign = 1 if at_Q == 1 else -1
                        sines[h] = sines[h] + sign * weight * (X * term.omega * term.omega)
            for q, stretch in zip(couplings, stretches, strict=True):
                ends = [self.places[c].base if not self.moves(c) else (1 if rides else 0) for c in (q.P, q.Q)]
                sway = ends[0] - ends[1]
                if sway != 0:
                    share = sway * self._weight(weights, B, stretch)
                    sines[h] = sines[h] - share * (q.k * X)
                    cosines[h] = cosines[h] - share * (q.c * V)

    def _weight(self, weights: list[N], B: Matrix[N], stretch: list[int]) -> N:
        """Acceleration of the coordinate by a unit force in a coupling, with its sign turned: (weights B
        stretch).
        """
        total = None
        for m, weight in enumerate(weights):
            for e, stretched in enumerate(stretch):
                if stretched != 0 and weight != 0:
                    part = weight * (B[m][e] * stretched)
                    total = part if total is None else total + part
        return self.zero if total is None else total

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

    @staticmethod
    def _per_mass(value: N, share: tuple[N, N]) -> N:
        factor, mass = share
        return factor * (value / mass)

    def _shifts(
        self,
        weights: list[N],
        B: Matrix[N],
        couplings: list[Coupling[N]],
        stretches: list[list[int]],
        reference: int | None,
    ) -> list[Shift[N]]:
        """Loads -k (distance of an end from the column that stands for it), by coupling: [(factor, plus,
        minus)].
        """
        shifts: list[Shift[N]] = []
        for q, stretch in zip(couplings, stretches, strict=True):
            if q.k == 0:
                continue
            for end, sign in ((q.P, 1), (q.Q, -1)):
                stands = self.leader[end] if self.moves(end) else reference
                if stands is None or end == stands:
                    continue
                moved = self.places[end] if not self.moves(end) else None
                if (
                    moved is not None
                    and not moved.fixed
                    and reference is not None
                    and not self.places[reference].fixed
                    and moved.base == self.places[reference].base
                ):
                    continue
                shifts.append(
                    (-(sign * self._weight(weights, B, stretch) * q.k), self._fixed(end), self._fixed(stands))
                )
        return [s for s in shifts if s[1] != s[2]]

    def _fixed(self, c: int) -> Positions:
        """Positions at the start that a column's place is made of."""
        return self.places[c].fixed if not self.moves(c) else ((1, c),)

    def _centre(self, leaders: list[int]) -> int:
        """The coordinate of a centre of mass; its number."""
        total, none = self._total(leaders), [self.zero] * len(self.harmonics)
        load, sines = self._central_loads(leaders, total, self.zero)
        load_size, *sizes = _sizes(*self._central_loads(leaders, total, *magnitudes([self.zero])), none)
        sources: list[Source[N]] = [((c, None), self.rows.own_mass(c) / total) for c in leaders]
        self.coordinates.append(
            Coordinate(self.zero, self.zero, load, load_size, sines, none, sizes, sources, free=True)
        )
        return len(self.coordinates) - 1

    def _central_loads(self, leaders: list[int], total: N, zero: N) -> tuple[N, list[N]]:
        """load and sines of a centre of mass, sums that begin at `zero`."""
        load, sines = zero, [zero] * len(self.harmonics)
        for force in self.scene.forces:
            if self.leader[force.on] in leaders:
                load = load + force.constant
                for term in sounding(force.terms):
                    h = self.harmonics.index(pitch(term))
                    sines[h] = sines[h] + term.amplitude / total
        for column, value in self.rows.constants:
            if self.leader[column] in leaders:
                load = load + value
        return load / total, sines

    def _diagonal(
        self, B: Matrix[N], couplings: list[Coupling[N]], stretches: list[list[int]]
    ) -> tuple[Matrix[N], Matrix[N], list[N], list[N]] | None:
        """Rotation to normal coordinates: (y by q, q by y, b, a), or None where damping and stiffness do
        not commute.
        """
        kit, size = self.kit, len(B)
        L = cholesky(kit, B)
        K, C = ([[self.zero] * size for _ in range(size)] for _ in range(2))
        for q, s in zip(couplings, stretches, strict=True):
            for i in range(size):
                for j in range(size):
                    K[i][j] = K[i][j] + q.k * (s[i] * s[j])
                    C[i][j] = C[i][j] + q.c * (s[i] * s[j])
        K, C = (product(product(transposed(L), A), L) for A in (K, C))
        V = jacobi(kit, K, C)
        if V is None:
            return None
        k, c = (product(product(transposed(V), A), V) for A in (K, C))
        forward = product(L, V)
        backward = product(transposed(V), inverse_triangular(kit, L))
        rates = [k[m][m] if k[m][m] > 0 else self.zero for m in range(size)]
        return forward, backward, rates, [c[m][m] / 2 for m in range(size)]

    def _pairs(self, places: list[Place[N]]) -> dict[Edge, Difference[N]]:
        """Differences of columns that events, couplings and frictions read."""
        pairs = {(t.P, t.Q) for event in self.rows.events for t in event.terms if t.kind in (0, 1)}
        pairs |= {(q.P, q.Q) for q in self.rows.couplings}
        return {pair: difference(places[pair[0]], places[pair[1]]) for pair in pairs}


def _sizes(load: N, sines: list[N], cosines: list[N]) -> list[N]:
    """Of loads taken on magnitudes: those of the load and of each harmonic."""
    return [size_of(load), *(size_of(s) + size_of(c) for s, c in zip(sines, cosines, strict=True))]


def difference(one: Place[N], other: Place[N]) -> Difference[N]:
    """x_P - x_Q of two places."""
    if one.vectors and one.vectors is other.vectors:  # of one component: its centre drops out exactly
        turns = [a - b for a, b in zip(one.sides, other.sides, strict=True)]
        shape: dict[int, N | int] = {m: weighted(turns, vector) for m, vector in one.vectors}
    else:
        shape = dict(one.shape)
        for m, value in other.shape.items():
            shape[m] = shape[m] - value if m in shape else -value
    fixed: dict[int, int] = {}
    for sign, place in ((1, one), (-1, other)):
        for s, c in place.fixed:
            fixed[c] = fixed.get(c, 0) + sign * s
    terms = [(m, value) for m, value in sorted(shape.items()) if value != 0]
    return Difference(terms, [(s, c) for c, s in sorted(fixed.items()) if s], one.base - other.base)


def weighted(turns: Iterable[int], vector: Iterable[N]) -> N | int:
    """Sum of the entries of `vector` with the signs `turns` (-1, 0, 1)."""
    total: N | int = 0
    for sign, value in zip(turns, vector, strict=True):
        if sign:
            total = sign * value if total == 0 else total + sign * value
    return total
