"""The motion of the base: sums of harmonics, or a formula in the time."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Any, cast

from vibsim.engine.flows.motion import ROUNDING, series_rounding, sine_and_cosine, value_and_rate
from vibsim.engine.flows.tape import Inputs, Tape, TapeMaker, TapeSeries, TapeValues, motion_tape
from vibsim.physics.formulas import SWITCHES, Node, walk
from vibsim.physics.numbers import Kit, N, abs
from vibsim.physics.parts import Friction, Scene

if TYPE_CHECKING:
    from collections.abc import Hashable, Sequence

    from vibsim.engine.modes.rows import ModeRows

KEPT = 16  # formulas of bases that are kept


class BaseFormula:
    """X(t) by a formula [m], or X'(t) where `is_rate`, with its first two derivatives; X is 0 then."""

    def __init__(self, formula: Node, kit: Kit[Any], is_rate: bool = False) -> None:
        self.kit, self.is_rate = kit, is_rate
        self.formula = formula
        self.switches = [node for node in walk([formula]) if node[0] in SWITCHES]
        self.tapes: dict[tuple[int, ...], Tape] = {}

    def tape(self, t: Any) -> Tape:
        """X, X' and X'' in the piece that the time t [s] is in, or begins."""
        sides: dict[Node, int] = {}
        for node in self.switches:
            sides[node] = self._side(node, t, sides)
        key = tuple(sides.values())
        if key not in self.tapes:
            self.tapes[key] = motion_tape(self.kit, self.formula, sides, "base")
        return self.tapes[key]

    def _side(self, node: Node, t: Any, sides: dict[Node, int]) -> int:
        maker = TapeMaker(self.kit, sides, {})
        places = [maker.output(one) for one in node[1 : 3 if node[0] == "mod" else 2]]
        values = [_values(self.kit, maker.tape, t).output(k)[0] for k in places]
        if node[0] == "choose":
            return 1 if values[0] >= 0 else -1
        if node[0] == "mod":
            return int(float(values[0] / values[1]) // 1)
        return sum(1 for knot in node[2] if values[0] >= self.kit.number(knot)) - 1

    def values(self, t: Any, tape: Tape | None = None) -> list[tuple[Any, Any]]:
        """X, X' and X'' at t [s], each with a bound of its rounding; tape: of the piece that is meant."""
        values = _values(self.kit, tape or self.tape(t), t)
        if self.is_rate:
            return [(self.kit.number(0), self.kit.number(0)), values.output(0), values.output(1)]
        return [values.output(k) for k in range(3)]

    def series(self, t: Any, count: int, inverse: Sequence[Any]) -> list[Any]:
        """The first `count` Taylor coefficients of X at t [s]."""
        series = series_in_time(self.kit, self.tape(t), t, count, inverse)
        if self.is_rate:
            return [self.kit.number(0), *(value * inverse[n + 1] for n, value in enumerate(series[:-1]))]
        return series


def _values(kit: Kit[N], tape: Tape, t: N) -> TapeValues[N]:
    """Values along a tape that reads nothing but the time t [s]."""
    zero = kit.number(0)
    return TapeValues(kit, tape, Inputs(t, (), (), zero, zero), Inputs(kit.eps * abs(t), (), (), zero, zero))


def series_in_time(kit: Kit[N], tape: Tape, t: N, count: int, inverse: Sequence[N]) -> list[N]:
    """The first `count` Taylor coefficients at t [s] of output 0 of a tape that reads nothing but the
    time.
    """
    series = TapeSeries(kit, tape, inverse)
    series.start(t, count, (), ())
    for n in range(count):
        series.advance(n)
    return list(series.output(0)[:count])


@lru_cache(maxsize=KEPT)  # kits are compared by being the same
def _kept(formula: Node, kit: Hashable, is_rate: bool) -> BaseFormula:
    return BaseFormula(formula, cast("Kit[Any]", kit), is_rate)


def base_formula(scene: Scene[Any], kit: Kit[Any]) -> BaseFormula:
    """The motion of the base of a scene by a formula."""
    assert scene.base_formula is not None
    return _kept(scene.base_formula, cast("Hashable", kit), scene.base_is_rate)


def base_motion(scene: Scene[N], kit: Kit[N], t: N, rows: ModeRows[N] | None = None) -> tuple[N, N]:
    """Displacement [m] and velocity [m/s] of the base at t [s].

    rows : of the mode that t is in, or ends; without them a formula is in the piece that begins where two
    meet
    """
    if scene.base_formula is None:
        return value_and_rate(kit, scene.base, t)
    (X, _), (V, _), _ = base_formula(scene, kit).values(t, rows.base_values if rows else None)
    return X, V


def base_acceleration(scene: Scene[N], kit: Kit[N], t: N, rows: ModeRows[N] | None = None) -> N:
    """Second derivative of the motion of the base [m/s^2]; rows: as of `base_motion`."""
    if scene.base_formula is not None:
        A: N = base_formula(scene, kit).values(t, rows.base_values if rows else None)[2][0]
        return A
    total = kit.number(0)
    for term in scene.base:
        sine, _ = sine_and_cosine(kit, term, t)
        total = total - term.amplitude * term.omega * term.omega * sine
    return total


def base_rounding(scene: Scene[N], kit: Kit[N], t: N, count: int) -> list[N]:
    """Rounding bounds of the first coefficients of X at t [s]; those of a formula from the sizes of its
    derivatives of order 0 to 2.
    """
    if scene.base_formula is None:
        return series_rounding(kit, scene.base, t, count)
    formula = base_formula(scene, kit)
    inverse = [kit.number(0)] + [1 / kit.number(n) for n in range(1, count + 2)]
    series = formula.series(t, count + 1, inverse)
    late = kit.eps * abs(t)
    bounds = [ROUNDING * kit.eps * abs(series[n]) + late * (n + 1) * abs(series[n + 1]) for n in range(count)]
    for n, (_, bound) in enumerate(formula.values(t)[:count]):
        bounds[n] = bounds[n] + (bound if n < 2 else bound / 2)
    return bounds


def belt_velocity(friction: Friction[N], kit: Kit[N], t: N) -> N:
    """Velocity at t [s] of the belt of a friction, be it a number, a formula or both [m/s]."""
    if friction.course is None:
        return friction.belt
    return friction.belt + course_velocity(friction.course, kit, t)


def course_velocity(course: Node, kit: Kit[N], t: N) -> N:
    """Velocity at t [s] of a belt that moves by a formula [m/s]."""
    velocity: N = _kept(course, cast("Hashable", kit), True).values(t)[1][0]
    return velocity


def course_acceleration(course: Node, kit: Kit[N], t: N) -> N:
    """Acceleration of such a belt at t [s] [m/s^2]."""
    acceleration: N = _kept(course, cast("Hashable", kit), True).values(t)[2][0]
    return acceleration


def fastest_base(scene: Scene[N], kit: Kit[N], t: N) -> N:
    """A bound of the velocity of the base, of a formula that at t [m/s]."""
    if scene.base_formula is not None:
        return abs(base_motion(scene, kit, t)[1])
    return sum((abs(one.amplitude * one.omega) for one in scene.base), kit.number(0))
