"""Impacts and rests of rigid stops that touch at one instant, as saltation and the ledgers read them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Generic

from vibsim.engine.errors import State
from vibsim.engine.events.impacts.newton_moreau import Contact, Impulse, effective_masses, motor_body
from vibsim.engine.events.relative_motion import RelativeMotion
from vibsim.engine.modes.row_maker import RowMaker
from vibsim.engine.modes.ties import Edge, Groups, Tie
from vibsim.physics.numbers import N, total_of
from vibsim.physics.parts import RigidStop, Scene


@dataclass(frozen=True)
class PlasticCapture(Generic[N]):
    """Velocities that ends give away as they come to rest on each other behind the hops that are left out.

    stop : where; loss : of energy [J]; impulse : of ground or base on the bodies [N s], zero where these move
    freely; column : of what catches them
    """

    stop: int
    loss: N
    impulse: N
    column: int


@dataclass
class SimultaneousImpacts(Generic[N]):
    """The rigid stops that touch at an instant, and what impacts did there.

    before : rates of their depths before the first impact; v, w : velocities of all columns and of the rotor
    there
    rates : behind the last one, exactly 0 where the law or rounding says so; impacts : by impact, the stops
    that passed an impulse, and these; moved : columns whose velocities they changed
    catches : by group of ends that come to rest on each other
    ended : by stop where an infinite sequence of impacts ended, the speed that rounding of the time hides;
    faded : stops at which one ended without an impact; hop : the stop whose last impact was where the stretch
    began that ends here
    together : whether rounding might decide if another stop, of one of its bodies, is struck before this one
    collapses : whether impacts in turn, between which rounding hides the way, would take all speed
    """

    contacts: list[Contact[N]]
    before: dict[int, N]
    rates: dict[int, N]
    v: list[N]
    w: N
    together: bool
    impacts: list[list[tuple[Contact[N], Impulse[N]]]] = field(default_factory=list)
    moved: set[int] = field(default_factory=set)
    catches: list[PlasticCapture[N]] = field(default_factory=list)
    ended: dict[int, N] = field(default_factory=dict)
    faded: list[int] = field(default_factory=list)
    hop: int | None = None
    collapses: bool = False

    @property
    def passed(self) -> list[Impulse[N]]:
        """The impulses, one impact after the other."""
        return [impulse for one in self.impacts for _, impulse in one]


# Rigid stops at one place: between the same ends, in either order, on one side and with one gap.


def coincident_stops_of(scene: Scene[N], i: int) -> list[int]:
    """Numbers of the rigid stops whose depth is that of rigid stop `i` at all times, `i` among them: a base
    that does not move is the ground.
    """
    ends = {j: (scene.column(one.P), scene.column(one.Q)) for j, one in scene.rigid_stops}
    (P, Q), one = ends[i], dict(scene.rigid_stops)[i]
    ways = (P, Q, one.sense, one.gap), (Q, P, -one.sense, one.gap)
    return [j for j, other in scene.rigid_stops if (*ends[j], other.sense, other.gap) in ways]


def hardest(stops: Mapping[int, RigidStop[N]], coincident_stops: Iterable[int]) -> int:
    """Of stops at one place the one that the law of impacts obeys: of the greatest e, the first of several.
    It fulfils g'(after) + e g'(before) <= 0 of all of them, so the others pass nothing.
    """
    return min(coincident_stops, key=lambda j: (-stops[j].e, j))


# How ends come to lie on each other at rigid stops: one velocity, one place.


class RestProjection(Generic[N]):
    """Moves bodies that rest on each other, or were struck, onto each other."""

    def __init__(self, scene: Scene[N], maker: RowMaker[N], relative: RelativeMotion[N]) -> None:
        self.scene, self.maker, self.relative, self.kit = scene, maker, relative, relative.kit
        self.stops = dict(scene.rigid_stops)

    def join(self, state: State[N], stops: Sequence[int]) -> list[PlasticCapture[N]]:
        """Give bodies that touch without closing at some stops one velocity; momentum is kept where they move
        freely, and that of the rotor everywhere. Tells what they gave away.
        """
        if not stops:
            return []
        n, zero, motor = self.maker.n, self.kit.number(0), self.scene.motor
        edges = {j: self.maker.ends(self.stops[j]) for j in stops}
        groups = Groups(n, [(0, *edge) for edge in edges.values()])
        inertias, turned = effective_masses(self.scene, self.kit, state.x)
        old = list(state.v)
        if motor is not None:
            inertias[motor.on], turning = motor_body(motor, inertias[motor.on], self.kit, state.phase)
            before = state.v[motor.on]
        catches: list[PlasticCapture[N]] = []
        for leader, members in groups.members.items():
            bodies = [c for c in members if c < n]
            if len(members) > 1 and bodies:
                still = zero if leader <= n else self.relative.base(state, "v")
                common = still
                if leader < n:
                    common = self._mean([inertias[c] for c in bodies], [state.v[c] for c in bodies])
                loss = impulse = zero
                for c in bodies:
                    gained = inertias[c] * (common - state.v[c])
                    loss = loss - gained * ((state.v[c] + common) / 2 - still)
                    impulse = impulse + gained
                    state.v[c] = common
                if loss != 0 or impulse != 0:
                    first = next(j for j, edge in edges.items() if groups.leader[edge[0]] == leader)
                    stop = hardest(self.stops, edges.keys() & coincident_stops_of(self.scene, first))
                    catches.append(PlasticCapture(stop, loss, impulse if leader >= n else zero, leader))
        for column, on, gain in turned:
            state.v[column] = state.v[column] + gain * (state.v[on] - old[on])
        if motor is not None:
            state.w = state.w + turning * (state.v[motor.on] - before)
        return catches

    def _mean(self, inertias: Sequence[N], values: Sequence[N]) -> N:
        """Mean of the velocities of bodies, weighted by what impulses meet; equal ones are their mean."""
        if all(value == values[0] for value in values):
            return values[0]
        total = weight = self.kit.number(0)
        for m, value in zip(inertias, values, strict=True):
            total, weight = total + m * value, weight + m
        return total / weight

    def project(self, state: State[N], stops: Iterable[int]) -> None:
        """Take what rounding left of the depths of stops that were struck or come to rest: the ends move
        onto each other, their centre of mass stays where they move freely.
        """
        n = self.maker.n
        edges: list[Tie] = []
        for j in stops:
            stop = self.stops[j]
            depth = self.relative.depth(stop, state)
            ends = self.maker.ends(stop)
            edges.append((0, *ends))
            if depth != 0:
                self._shift(state, Groups(n, edges[:-1]), ends, stop.sense * depth)

    def _shift(self, state: State[N], groups: Groups, ends: Edge, distance: N) -> None:
        """Move the group of P by `distance` against that of Q, shared as their masses say."""
        sides = [groups.members[groups.leader[end]] for end in ends]
        if set(sides[0]) & set(sides[1]):
            return
        zero = self.kit.number(0)
        held = [any(c >= self.maker.n for c in side) for side in sides]
        if any(held):
            shares = [zero if one else zero + 1 for one in held]
        else:
            own, other = (total_of(self.kit, (self.scene.bodies[c].m for c in side)) for side in sides)
            shares = [other / (own + other), own / (own + other)]
        for side, share, sign in zip(sides, shares, (1, -1), strict=True):
            for c in side:
                if c < self.maker.n:
                    state.x[c] = state.x[c] + sign * (share * distance)
