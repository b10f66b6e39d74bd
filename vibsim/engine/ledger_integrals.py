"""The integrals of the ledgers in a mode, made from its rows when it is met.

An integral adds factor times an integral over each stretch of the mode to one entry of a ledger:

    SQUARE    (v_P - v_Q)^2
    WORK      force number `source` times v_P
    TORQUE    torque of the motor times the speed of its rotor
    FUNCTION  a function of the mode's rows, times the velocity of column P where that is not NOTHING
    IMPULSE   force number `source`
    SLIP      v_P - v_Q - drift: from velocities, whose digits do not drown in displacements
    RUB       a function of the mode's rows, times v_P - v_Q - drift
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, Generic

from vibsim.engine.modes.packing import Packer
from vibsim.engine.modes.row_maker import RowMaker
from vibsim.engine.modes.rows import COUPLING, FORMULA, HOLD, Event, Joined, ModeRows, Term, Terms
from vibsim.engine.modes.status import CONTACT, STICK, Status
from vibsim.engine.modes.ties import Edge, Groups, Tie, beyond
from vibsim.engine.number_forms import DOUBLES, NumberForm
from vibsim.physics.numbers import Kit, N
from vibsim.physics.parts import BODY, ROTOR, Friction, Scene

SQUARE, WORK, TORQUE, FUNCTION, IMPULSE, SLIP, RUB = range(7)
NOTHING = -1

Entry = tuple[str, str, str]  # name of an entry: quantity, section of the case, part


@dataclass(frozen=True)
class LedgerIntegral(Generic[N]):
    """factor times the integral that `kind` names, for entry number `entry`."""

    kind: int
    entry: int
    factor: N
    P: int = NOTHING
    Q: int = NOTHING
    source: int = NOTHING
    drift: N | float = 0.0


@dataclass
class LedgerIntegrals(Generic[N]):
    """The integrals of a mode, and the functions of its rows that they read."""

    integrals: list[LedgerIntegral[N]] = field(default_factory=list)
    functions: list[Event[N]] = field(default_factory=list)


def entries_of(scene: Scene[N], momentum: bool = False) -> list[Entry]:
    """Names of the entries of a scene's ledger: (quantity, section, part), work and loss [J], impulse
    [N s].
    """
    belts = [f.name for f in scene.frictions if f.runs]
    sections = {BODY: "forces", ROTOR: "rotors"}  # a state has no power
    on_bodies = [force for force in scene.forces if scene.bodies[force.on].kind == BODY]
    driven = [force for force in scene.forces if scene.bodies[force.on].kind in sections]
    names = [("work", sections[scene.bodies[force.on].kind], force.name) for force in driven]
    names += [("work", "motor", "")] if scene.motor else []
    names += [("work", "base", "")] if scene.has_base else []
    names += [("work", "friction", name) for name in belts]
    names += [("loss", "links", link.name) for link in scene.links if link.c != 0 or link.force is not None]
    rigid = [i for i, _ in scene.rigid_stops]
    damped = [i for i, stop in scene.elastic_stops if stop.jumps]
    names += [("loss", "stops", stop.name) for i, stop in enumerate(scene.stops) if i in (*rigid, *damped)]
    names += [("loss", "friction", friction.name) for friction in scene.frictions]
    if momentum:
        names += [("impulse", "forces", force.name) for force in on_bodies]
        names += [("impulse", "ground", "")]
        names += [("impulse", "base", "")] if scene.base_moves else []
        names += [("impulse", "friction", name) for name in belts]
    return names


class IntegralMaker(Generic[N]):
    """Makes the integrals of the modes of a scene."""

    def __init__(self, scene: Scene[N], kit: Kit[N], maker: RowMaker[N], momentum: bool = False) -> None:
        self.scene, self.kit, self.maker, self.momentum = scene, kit, maker, momentum
        self.names = entries_of(scene, momentum)
        self.ground, self.base = maker.n, maker.n + 1

    def integrals(self, rows: ModeRows[N]) -> LedgerIntegrals[N]:
        """The integrals of the mode of `rows`."""
        self.now: LedgerIntegrals[N] = LedgerIntegrals()
        self._sources()
        self._dampers(rows.status)
        self._couplings(rows)
        for i, friction in enumerate(self.scene.frictions):
            if rows.status.frictions[i] != STICK and friction.slips is None:
                self._slipping(friction, rows.status.frictions[i])
        for role, output in rows.outputs.items():
            self._by_formula(rows, role, output)
        for k, function, orientation in self._ties(rows):
            self._holding(k, function, orientation)
        return self.now

    def _add(
        self,
        kind: int,
        name: Entry,
        factor: N,
        P: int = NOTHING,
        Q: int = NOTHING,
        source: int = NOTHING,
        drift: N | float = 0.0,
    ) -> None:
        """An integral for the entry `name`, where the ledger has it."""
        if name in self.names:
            self.now.integrals.append(
                LedgerIntegral(kind, self.names.index(name), factor, P, Q, source, drift)
            )

    def _function(self, terms: Iterable[Term[N]], constant: N) -> int:
        """Number of a function of the rows."""
        function: Event[N] = Event(HOLD, 0, 1, (), tuple(terms), constant, self.kit.number(0))
        self.now.functions.append(function)
        return len(self.now.functions) - 1

    def _sources(self) -> None:
        one = self.kit.number(1)
        for i, force in enumerate(self.scene.forces):
            if force.acts:
                self._add(WORK, ("work", "forces", force.name), one, P=force.on, source=i)
                self._add(IMPULSE, ("impulse", "forces", force.name), one, source=i)
        self._add(TORQUE, ("work", "motor", ""), one)

    def _dampers(self, status: Status) -> None:
        for link in self.scene.links:
            P, Q = self.maker.ends(link)
            self._add(SQUARE, ("loss", "links", link.name), link.c, P=P, Q=Q)
        for i, stop in self.scene.elastic_stops:
            if status.stops[i] == CONTACT:
                P, Q = self.maker.ends(stop)
                self._add(SQUARE, ("loss", "stops", stop.name), stop.c, P=P, Q=Q)

    def _couplings(self, rows: ModeRows[N]) -> None:
        """Forces of couplings that end at the base, or at the ground for the balance of momentum."""
        one, zero = self.kit.number(1), self.kit.number(0)
        for q, coupling in enumerate(rows.couplings):
            outside = [end for end in (coupling.P, coupling.Q) if end >= self.ground]
            if self.base in outside or (self.momentum and outside):
                source = self._function([Term(COUPLING, 1, q)], zero)
                self._driven((coupling.P, coupling.Q), -one, zero, "", FUNCTION, source)  # -S on P

    def _driven(
        self, ends: Edge, on_P: N, belt: N, name: str, kind: int, source: int, runs: bool = False
    ) -> None:
        """Integrals of a force between P and Q, on_P times a function (or, for SLIP, times 1) on P and the
        opposite on Q: what base and belt, which keep their courses, put in, and the impulse from outside.
        runs : whether the belt moves otherwise than evenly
        """
        for end, on_end in zip(ends, (on_P, -on_P), strict=True):
            if end == self.base:
                P, Q = (self.base, self.ground) if kind == SLIP else (self.base, NOTHING)
                self._add(kind, ("work", "base", ""), -on_end, P=P, Q=Q, source=source)
        if belt != 0:
            self._timed(kind, ("work", "friction", name), on_P * belt, source)
        outside = [end for end in ends if end >= self.ground]
        if self.momentum and len(outside) == 1:
            on_body = on_P if outside[0] == ends[1] else -on_P
            place = "base" if outside[0] == self.base else "ground"
            entry = ("impulse", "friction", name) if belt != 0 or runs else ("impulse", place, "")
            self._timed(kind, entry, on_body, source)

    def _timed(self, kind: int, name: Entry, factor: N, source: int) -> None:
        """factor times the integral of the function, or of 1."""
        if kind == SLIP:
            self._add(SLIP, name, factor, P=self.ground, Q=self.ground, drift=-self.kit.number(1))
        else:
            self._add(FUNCTION, name, factor, source=source)

    def _slipping(self, friction: Friction[N], sign: int) -> None:
        P, Q = self.maker.ends(friction)
        on_P = -friction.forward if sign > 0 else friction.backward
        self._add(SLIP, ("loss", "friction", friction.name), -on_P, P=P, Q=Q, drift=friction.belt)
        self._driven((P, Q), on_P, friction.belt, friction.name, SLIP, NOTHING)

    def _by_formula(self, rows: ModeRows[N], role: tuple[Any, ...], output: int) -> None:
        """Work of a force by a formula, and what a link, a stop or a friction by one takes up: stored in a
        spring by a formula, or lost.
        """
        scene, one, zero, runs = self.scene, self.kit.number(1), self.kit.number(0), False
        if role[0] not in ("force", "link", "stop", "slip"):
            return
        if role[0] == "stop" and rows.status.stops[role[1]] != CONTACT:
            return
        source = self._function([Term(FORMULA, 1, output)], zero)
        if role[0] == "force":
            force = scene.forces[role[1]]
            section = "rotors" if scene.bodies[force.on].kind == ROTOR else "forces"
            self._add(FUNCTION, ("work", section, force.name), one, P=force.on, source=source)
            self._add(FUNCTION, ("impulse", "forces", force.name), one, source=source)
            return
        if role[0] == "slip":
            friction = scene.frictions[role[1]]
            ends, name, sign, belt = self.maker.ends(friction), friction.name, -role[2], friction.belt
            runs = friction.course is not None
            if runs:  # force times velocity of the belt
                power = self._function([Term(FORMULA, 1, rows.outputs["power", role[1]])], zero)
                for entry, share in (("work", sign * one), ("loss", sign * one)):
                    self._add(FUNCTION, (entry, "friction", name), share, source=power)
        elif role[0] == "stop":
            stop = scene.stops[role[1]]
            ends, name, sign, belt = self.maker.ends(stop), stop.name, stop.sense, zero
        else:
            link = scene.links[role[1]]
            ends, name, sign, belt = self.maker.ends(link), link.name, -1, zero
        section = {"link": "links", "stop": "stops", "slip": "friction"}[role[0]]
        self._add(RUB, ("loss", section, name), -sign * one, P=ends[0], Q=ends[1], source=source, drift=belt)
        self._driven(ends, sign * one, belt, name, FUNCTION, source, runs)

    def _holding(self, k: int, function: tuple[Terms[N], N], orientation: int) -> None:
        part, belt = self.maker.tie(k), self.maker.belt(k)
        P, Q = self.maker.ends(part)
        runs = isinstance(part, Friction) and part.course is not None
        if belt != 0 or runs or self.base in (P, Q) or (self.momentum and max(P, Q) >= self.ground):
            on_P = self.kit.number(1) if orientation > 0 else -self.kit.number(1)
            source = self._function(*function)
            self._driven((P, Q), on_P, belt, part.name, FUNCTION, source, runs)
            if runs:  # at rest on the belt, the ends part as fast as that moves
                self._add(RUB, ("work", "friction", part.name), on_P, P=P, Q=Q, source=source, drift=belt)

    def _ties(self, rows: ModeRows[N]) -> Iterator[tuple[int, tuple[Terms[N], N], int]]:
        """(number of the tie, (terms, constant) of the force T that it passes, +1 where T acts on P and -1 on
        Q).

        Where ties are redundant the split of the force is not unique: stops carry it, then the first
        frictions that hold the group together. The sums of the ledgers do not depend on that.
        """
        frictions = len(self.scene.frictions)
        stuck = sorted(self.maker.tied(rows.status).stuck, key=lambda tie: tie[0] < frictions)
        tree: list[Tie] = []
        joined = 0
        for tie in stuck:
            members = Groups(self.maker.n, [*tree, tie]).members
            if len(members) < self.maker.n + 2 - joined:
                tree.append(tie)
                joined += 1
        for i, P, Q in tree:
            leader = rows.leader[P]
            group = [tie for tie in tree if rows.leader[tie[1]] == leader]
            edges = [(a, b) for _, a, b in group]
            reference = self.maker.reference(leader, rows.groups.members[leader])
            side = beyond(edges, group.index((i, P, Q)), reference)
            yield i, self.maker.tie_force(rows, side), 1 if P in side else -1


# Ledgers, integrals, extremes and sections as flat numbers, in the order in which ledger_integrals.c reads
# them.


def pack_ledger(
    scene: Scene, names: Sequence[Entry], ends: Callable[[Joined], Edge], form: NumberForm[Any] = DOUBLES
) -> tuple[bytes, bytes]:
    """Number of entries, and the stops that may let go while they are pressed: what the spring of one holds
    then, k g^2 / 2, is lost there, and counts against the loss where it pushes again. ends: columns of the
    ends of a part.
    """
    pack = Packer(form)
    jumping = [(i, stop) for i, stop in scene.elastic_stops if stop.lets_go]
    pack.put((len(names), len(jumping)))
    for i, stop in jumping:
        entry = names.index(("loss", "stops", stop.name))
        pack.put((i, entry, *ends(stop), stop.sense), (stop.gap, stop.k))
    return pack.packed


def pack_impacts(
    scene: Scene,
    names: Sequence[Entry],
    ends: Callable[[Joined], Edge],
    early: bool,
    form: NumberForm[Any] = DOUBLES,
) -> tuple[bytes, bytes]:
    """The rigid stops, with the entries `names` of the ledgers that an impact on them adds to, the frictions
    that it may turn, and the elastic stops and clearances that it may close or open. early: as of
    `Chatter`
    """
    pack = Packer(form)
    entry = {name: number for number, name in enumerate(names)}
    bounds = [(*ends(stop), stop.sense, stop.gap) for _, stop in scene.elastic_stops]
    bounds += [(*ends(one), -1, one.distance) for one in scene.clearances]
    pack.put((len(scene.rigid_stops), len(scene.frictions), len(bounds), int(early)))
    for j, stop in scene.rigid_stops:
        ground = len(scene.bodies)
        place = {ground: "ground", ground + 1: "base"}.get(max(ends(stop)), "")
        work = entry.get(("work", "base", ""), -1) if place == "base" else -1
        entries = entry.get(("loss", "stops", stop.name), -1), work, entry.get(("impulse", place, ""), -1)
        pack.put((j, *ends(stop), stop.sense, *entries), (stop.gap, stop.e))
    for friction in scene.frictions:
        pack.put(ends(friction), (friction.belt,))
    for P, Q, sense, gap in bounds:
        pack.put((P, Q, sense), (gap,))
    return pack.packed


def pack_extremes(scene: Scene, ends: Sequence[Edge], since: float) -> tuple[bytes, bytes]:
    """The pairs of columns of `ends`, whose extremes are kept, the stops whose gap is that of one of them,
    and the time they begin at [s].
    """
    pack = Packer()
    pairs = [(scene.column(P), scene.column(Q)) for P, Q in ends]
    gaps: list[tuple[int, int, int, float]] = []  # stop, its place among the pairs, sense, gap
    for i, stop in enumerate(scene.stops):
        P, Q = scene.column(stop.P), scene.column(stop.Q)
        if (P, Q) in pairs:
            gaps.append((i, pairs.index((P, Q)), stop.sense, stop.gap))
        elif (Q, P) in pairs:
            gaps.append((i, pairs.index((Q, P)), -stop.sense, stop.gap))
    pack.put((len(pairs), len(gaps), *(column for pair in pairs for column in pair)))
    for number, pair, sense, gap in gaps:
        pack.put((number, pair, sense), (gap,))
    pack.put((), (since,))
    return pack.packed


def pack_integrals(integrals: LedgerIntegrals, form: NumberForm[Any] = DOUBLES) -> tuple[bytes, bytes]:
    """The integrals of a mode."""
    pack, functions = Packer(form), integrals.functions
    pack.put((len(integrals.integrals), len(functions), sum(len(function.terms) for function in functions)))
    for m in integrals.integrals:
        pack.put((m.kind, m.entry, m.P, m.Q, m.source), (m.factor, m.drift))
    for function in functions:
        pack.put((len(function.terms),), (function.constant,))
        for term in function.terms:
            pack.put((term.kind, term.P), (term.coefficient,))
    return pack.packed
