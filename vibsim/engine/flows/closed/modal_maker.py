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
from operator import mul
from typing import TYPE_CHECKING, Generic

from vibsim.engine.flows.closed.matrices import (
    Matrix,
    cholesky,
    inverse_triangular,
    jacobi,
    magnitudes,
    product,
    size_of,
    transposed,
)
from vibsim.engine.flows.closed.modal import (
    Component,
    Coordinate,
    Difference,
    Loads,
    Modal,
    ModalPlace,
    Pitch,
    Source,
    Stands,
    Vector,
)
from vibsim.engine.modes.ties import Edge, Groups, beyond
from vibsim.physics.numbers import Kit, N, total_of
from vibsim.physics.parts import Scene

if TYPE_CHECKING:
    from vibsim.engine.modes.rows import Coupling, ModeRows


def modal_of(
    scene: Scene[N], kit: Kit[N], rows: ModeRows[N], harmonics: Sequence[Pitch[N]]
) -> Modal[N] | None:
    """The closed form that the mode `rows` moves by, or None.

    harmonics: the distinct (omega, cycles, cycles_lo, phase) of forces and base.
    """
    if not may_have_closed_form(scene, rows):
        return None
    return _Builder(scene, kit, rows, harmonics).build()


def may_have_closed_form(scene: Scene[N], rows: ModeRows[N]) -> bool:
    """Whether nothing that a mode is made of leaves it to Taylor series in any case."""
    return scene.method != "taylor" and scene.motor is None and not rows.by_formulas and not rows.rotors


class _Builder(Generic[N]):
    def __init__(
        self, scene: Scene[N], kit: Kit[N], rows: ModeRows[N], harmonics: Sequence[Pitch[N]]
    ) -> None:
        self.scene, self.kit, self.rows, self.harmonics = scene, kit, rows, harmonics
        self.n, self.zero = len(scene.bodies), kit.number(0)
        self.leader, self.moves = rows.leader, rows.groups.moves
        self.coordinates: list[Coordinate[N]] = []
        self.places: dict[int, ModalPlace[N]] = {}
        self.loads = Loads(scene, rows, harmonics, self.places, kit)

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
                self.places[c] = ModalPlace({}, (), base)
            elif self.rows.drift[c] != 0:
                self.coordinates.append(self._coasting(c, leader if base else None))
                self.places[c] = ModalPlace({len(self.coordinates) - 1: 1}, (), base)
            else:
                self.places[c] = ModalPlace({}, ((1, c),) + (((-1, leader),) if base else ()), base)

    def _coasting(self, c: int, base: int | None) -> Coordinate[N]:
        """A column that moves with a belt at constant speed, measured from the base where that carries it."""
        none = [self.zero] * len(self.harmonics)
        zero = self.zero
        return Coordinate(zero, zero, zero, zero, none, none, none, [((c, base), 1)], free=True)

    def _follower(self, c: int) -> ModalPlace[N]:
        """A body within a group that moves: where its leader is, and the distance at the start."""
        place = self.places[self.leader[c]]
        fixed = (*place.fixed, (1, c), (-1, self.leader[c]))
        return ModalPlace(place.shape, fixed, place.base, place.sides, place.vectors)

    def _components(self) -> list[list[int]]:
        """Leading columns that move, by what couplings join them."""
        ends = ((self.leader[coupling.P], self.leader[coupling.Q]) for coupling in self.rows.couplings)
        joined = Groups(self.n, [(0, P, Q) for P, Q in ends if self.moves(P) and self.moves(Q)])
        leading = (c for c in sorted(joined.members) if self.leader[c] == c and self.moves(c))
        return [joined.members[c] for c in leading]

    def _component(self, leaders: list[int]) -> bool:
        """Coordinates of one component; whether it has a closed form."""
        couplings = [q for q in self.rows.couplings if {self.leader[q.P], self.leader[q.Q]} & set(leaders)]
        couplings = [q for q in couplings if self.leader[q.P] != self.leader[q.Q]]
        anchors = [end for q in couplings for end in (q.P, q.Q) if not self.moves(end)]
        reference = anchors[0] if anchors else None
        edges = self._tree(leaders, couplings, reference)
        sides = [{*beyond(edges, e, Q)} for e, (_, Q) in enumerate(edges)]
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
                share = total_of(self.kit, map(mul, differences[c], vector))
                if share != 0:
                    shape[m] = share
            at: ModalPlace[N] = ModalPlace({}, ()) if reference is None else self.places[reference]
            self.places[c] = ModalPlace({**at.shape, **shape}, at.fixed, at.base)
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

    def _total(self, leaders: Iterable[int]) -> N:
        return total_of(self.kit, map(self.rows.own_mass, leaders))

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
        component = Component(edges, B, couplings, stretches, reference)
        if size == 1:
            k, c = total_of(self.kit, (q.k for q in couplings)), total_of(self.kit, (q.c for q in couplings))
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
            load, sines, cosines = self.loads.of(backward[m], component)
            load_size, *sizes = _sizes(*self.loads.of(magnitudes(backward[m]), component))
            coordinate = Coordinate(damping[m], rates[m], load, load_size, sines, cosines, sizes, sources)
            coordinate.shifts = self.loads.shifts(backward[m], component)
            coordinate.free = coordinate.a == 0 and coordinate.b == 0
            self.coordinates.append(coordinate)
            shapes.append((len(self.coordinates) - 1, [forward[e][m] for e in range(size)]))
        return shapes

    def _mobility(self, one: Edge, other: Edge) -> N:
        """Entry of B = D M^-1 D' for two differences."""
        ends = [(c, sign) for c, sign in ((one[0], 1), (one[1], -1)) if self.moves(c) and c in other]
        parts = ((sign if c == other[0] else -sign) * self.rows.mobility[c] for c, sign in ends)
        return total_of(self.kit, parts)

    def _centre(self, leaders: list[int]) -> int:
        """The coordinate of a centre of mass; its number."""
        total, none = self._total(leaders), [self.zero] * len(self.harmonics)
        load, sines = self.loads.central(leaders, total, self.zero)
        load_size, *sizes = _sizes(*self.loads.central(leaders, total, *magnitudes([self.zero])), none)
        sources: list[Source[N]] = [((c, None), self.rows.own_mass(c) / total) for c in leaders]
        self.coordinates.append(
            Coordinate(self.zero, self.zero, load, load_size, sines, none, sizes, sources, free=True)
        )
        return len(self.coordinates) - 1

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

    def _pairs(self, places: list[ModalPlace[N]]) -> dict[Edge, Difference[N]]:
        """Differences of columns that events, couplings and frictions read."""
        pairs = {(t.P, t.Q) for event in self.rows.events for t in event.terms if t.kind in (0, 1)}
        pairs |= {(q.P, q.Q) for q in self.rows.couplings}
        return {pair: difference(places[pair[0]], places[pair[1]]) for pair in pairs}


def _sizes(load: N, sines: list[N], cosines: list[N]) -> list[N]:
    """Of loads taken on magnitudes: those of the load and of each harmonic."""
    return [size_of(load), *(size_of(s) + size_of(c) for s, c in zip(sines, cosines, strict=True))]


def difference(one: ModalPlace[N], other: ModalPlace[N]) -> Difference[N]:
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
