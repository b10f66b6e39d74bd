"""Where ends of parts are against each other, how fast, and what rounding leaves open of that."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Generic

from vibsim.engine.errors import State
from vibsim.engine.flows.base_motion import (
    NO_SIDES,
    base_motion,
    base_rounding,
    belt_velocity,
    fastest_base,
)
from vibsim.engine.modes.rows import Joined
from vibsim.engine.modes.ties import Edge
from vibsim.physics.formulas import Node
from vibsim.physics.numbers import Kit, N, abs
from vibsim.physics.parts import BASE, GROUND, Clearance, Friction, RigidStop, Scene, Stop

START_ROUNDING = 16  # at least: each of three numbers and of two differences is rounded once


class RelativeMotion(Generic[N]):
    """Displacements and velocities of the ends of parts against each other, from the state alone."""

    def __init__(self, scene: Scene[N], kit: Kit[N]) -> None:
        self.scene, self.kit, self.n = scene, kit, len(scene.bodies)
        self._fixed = {end: scene.column(end) for end in (GROUND, BASE)}
        self._base: tuple[N, tuple[N, N]] | None = None  # time that the base was asked for last, its motion

    def columns(self, part: Joined) -> Edge:
        """Columns of the ends of a part."""
        P, Q = part.P, part.Q
        return P if P >= 0 else self._fixed[P], Q if Q >= 0 else self._fixed[Q]

    def ends(self, part: Joined, state: State[N], of: str) -> tuple[N, N]:
        """Displacements [m] of the ends of a part, or velocities [m/s], of "x" or "v"."""
        P, Q = self.columns(part)
        return self._at(P, state, of), self._at(Q, state, of)

    def _at(self, column: int, state: State[N], of: str) -> N:
        if column < self.n:
            return (state.x if of == "x" else state.v)[column]
        return self.kit.number(0) if column == self.n else self.base(state, of)

    def columns_of(self, state: State[N], of: str) -> tuple[N, ...]:
        """Displacements or velocities of all columns."""
        return *(state.x if of == "x" else state.v), self.kit.number(0), self.base(state, of)

    def base(self, state: State[N], of: str) -> N:
        """Displacement or velocity of the base."""
        if self._base is None or self._base[0] is not state.t:
            self._base = state.t, base_motion(self.scene, self.kit, state.t)
        return self._base[1][of != "x"]

    def base_rounding(self, columns: tuple[int, int], state: State[N]) -> tuple[N, N]:
        """Uncertainty by rounding of the base of a difference of two columns and of its rate: none of
        that where the base turns round at the start, as at 90 deg.
        """
        zero = self.kit.number(0)
        if not self.scene.has_base or self.n + 1 not in columns:
            return zero, zero
        place, rate = base_rounding(self.scene, self.kit, state.t)
        return place, zero if state.t == 0 and self.base(state, "v") == 0 else rate

    def turned_by_base(self, part: Joined, rate: N, t: N) -> bool:
        """Whether a relative velocity may be all rounding of the base's, here or a period before. What is
        zero in doubles moves with the base.
        """
        return 0 < abs(rate) <= START_ROUNDING * self.kit.eps * self._fastest(part, t)

    def _fastest(self, part: Joined, t: N) -> N:
        """The sum of the velocities of the base, where a part has an end there; else 0."""
        on_base = self.n + 1 in self.columns(part)
        return fastest_base(self.scene, self.kit, t) if on_base else self.kit.number(0)

    def rests(self, stop: Stop[N] | RigidStop[N], g: N, state: State[N]) -> bool:
        """Whether rounding may be all of the gap of a rigid stop and of its rate, as of bodies a period after
        a start at rest on each other or on a base that moves.
        """
        if not isinstance(stop, RigidStop):
            return False
        (vP, vQ), (xP, xQ) = self.ends(stop, state, "v"), self.ends(stop, state, "x")
        base = self.scene.base if self.n + 1 in self.columns(stop) else ()
        travel = sum((abs(one.amplitude) for one in base), abs(xP) + abs(xQ) + abs(stop.gap))
        near, still = START_ROUNDING * self.kit.eps * travel, START_ROUNDING * self.kit.eps
        return abs(g) <= near and abs(vP - vQ) <= still * (abs(vP) + abs(vQ) + self._fastest(stop, state.t))

    def depth(self, stop: Stop[N] | RigidStop[N], state: State[N]) -> N:
        xP, xQ = self.ends(stop, state, "x")
        return -(stop.sense * (xP - xQ)) - stop.gap

    def excess(self, clearance: Clearance[N], state: State[N]) -> N:
        xP, xQ = self.ends(clearance, state, "x")
        return (xP - xQ) - clearance.distance

    def closing(self, stop: Stop[N] | RigidStop[N], state: State[N]) -> N:
        """Rate of the depth of a stop [m/s]."""
        vP, vQ = self.ends(stop, state, "v")
        return -(stop.sense * (vP - vQ))

    def slip(self, friction: Friction[N], state: State[N], sides: Mapping[Node, int] = NO_SIDES) -> N:
        """Velocity of slip [m/s]; sides: of switches in the mode that the state is in."""
        vP, vQ = self.ends(friction, state, "v")
        return (vP - vQ) - belt_velocity(friction, self.kit, state.t, sides)

    def met(self, part: Stop[N] | RigidStop[N] | Clearance[N], state: State[N]) -> bool:
        """Whether the ends of a part are exactly where its depth or excess is zero: as computed, or as told
        of the start from exact numbers, whose rounding it may be then.
        """
        if isinstance(part, Clearance):
            value, distance = self.excess(part, state), part.distance
        else:
            value, distance = self.depth(part, state), part.gap
        xP, xQ = self.ends(part, state, "x")
        size = abs(xP) + abs(xQ) + abs(distance)
        return value == 0 or (part.at_start and abs(value) <= START_ROUNDING * self.kit.eps * size)

    def touched(
        self, state: State[N], stops: Iterable[int], clearances: Iterable[int]
    ) -> tuple[list[int], list[int]]:
        """Those of some stops and clearances whose ends just touch."""
        scene = self.scene
        return (
            [i for i in stops if self.met(scene.stops[i], state)],
            [i for i in clearances if self.met(scene.clearances[i], state)],
        )

    def blurred(
        self, value: N, part: Stop[N] | RigidStop[N] | Clearance[N], state: State[N], distance: N, met: bool
    ) -> bool:
        """Whether the rounding of the base, of x_P - x_Q and of its sum with `distance` could turn the sign
        of `value`, or be what makes it zero; no rounding can where exact numbers say that the ends are met.
        """
        if met and part.at_start:
            return False
        xP, xQ = self.ends(part, state, "x")
        y = xP - xQ
        lost = self.base_rounding(self.columns(part), state)[0]
        lost += abs(_difference_error(xP, xQ, y)) + abs(_difference_error(y, -distance, y + distance))
        return 0 < lost >= abs(value)


def _difference_error(a: N, b: N, difference: N) -> N:
    """Rounding error of a - b (Knuth's two-sum)."""
    back = a - difference
    return (a - (difference + back)) + (back - b)
