"""How ends come to lie on each other at rigid stops: one velocity, one place."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Generic

from vibsim.engine.events.impacts.newton_moreau import motor_body
from vibsim.engine.events.impacts.touch import Catch
from vibsim.engine.events.impacts.twins import hardest, twins_of
from vibsim.engine.events.relative_motion import RelativeMotion
from vibsim.engine.modes.row_maker import RowMaker
from vibsim.engine.modes.ties import Edge, Groups, Tie
from vibsim.engine.state import State
from vibsim.physics.arithmetic.numbers import N
from vibsim.physics.parts import Scene


class Seats(Generic[N]):
    """Moves bodies that rest on each other, or were struck, onto each other."""

    def __init__(self, scene: Scene[N], maker: RowMaker[N], relative: RelativeMotion[N]) -> None:
        self.scene, self.maker, self.relative, self.kit = scene, maker, relative, relative.kit
        self.stops = dict(scene.rigid_stops)

    def join(self, state: State[N], stops: Sequence[int]) -> list[Catch[N]]:
        """Give bodies that touch without closing at some stops one velocity; momentum is kept where they move
        freely, and that of the rotor everywhere. Tells what they gave away.
        """
        n, zero, motor = self.maker.n, self.kit.number(0), self.scene.motor
        edges = {j: self.maker.ends(self.stops[j]) for j in stops}
        groups = Groups(n, [(0, *edge) for edge in edges.values()])
        inertias = [body.m for body in self.scene.bodies]
        if motor is not None:
            inertias[motor.on], turning = motor_body(motor, inertias[motor.on], self.kit, state.phase)
            before = state.v[motor.on]
        catches: list[Catch[N]] = []
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
                    stop = hardest(self.stops, edges.keys() & twins_of(self.scene, first))
                    catches.append(Catch(stop, loss, impulse if leader >= n else zero, leader))
        if motor is not None:
            state.w = self.kit.exact(state.w + turning * (state.v[motor.on] - before))
        return catches

    def _mean(self, inertias: Sequence[N], values: Sequence[N]) -> N:
        """Mean of the velocities of bodies, weighted by what impulses meet; equal ones are their mean."""
        if all(value == values[0] for value in values):
            return values[0]
        total = weight = self.kit.number(0)
        for m, value in zip(inertias, values, strict=True):
            total, weight = total + m * value, weight + m
        return self.kit.exact(total / weight)

    def seat(self, state: State[N], stops: Iterable[int]) -> None:
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
            own, other = (self._mass(side) for side in sides)
            shares = [other / (own + other), own / (own + other)]
        for side, share, sign in zip(sides, shares, (1, -1), strict=True):
            for c in side:
                if c < self.maker.n:
                    state.x[c] = self.kit.exact(state.x[c] + sign * (share * distance))

    def _mass(self, bodies: Iterable[int]) -> N:
        """Mass of bodies [kg], one by one: sum() of floats compensates from Python 3.12 on."""
        total = self.kit.number(0)
        for c in bodies:
            total = total + self.scene.bodies[c].m
        return total
