"""The motion of the base and of belts in time: sums of harmonics, or formulas."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Any, cast

from vibsim.engine.flows.tape import Inputs, Tape, TapeMaker, TapeValues, motion_tape
from vibsim.physics.formulas import SWITCHES, TIME, Node, derivative, resolved, walk
from vibsim.physics.numbers import Kit, N, abs
from vibsim.physics.parts import Friction, Harmonic, Scene

if TYPE_CHECKING:
    from collections.abc import Hashable, Iterable, Mapping

    from vibsim.engine.modes.rows import ModeRows

NO_SIDES: Mapping[Node, int] = {}  # of switches: none is known
KEPT = 16  # formulas of bases that are kept
DERIVATIVES = 4  # of the argument of a switch, that tell the piece that begins at its zero
ROUNDING = 16  # of a product of an amplitude, powers of a rate and a sine, in units of eps


def sine_and_cosine(kit: Kit[N], term: Harmonic[N], t: N) -> tuple[N, N]:
    """sin and cos of omega t + phase, without forming a large product."""
    angle = kit.turn_angle(term.cycles, term.cycles_lo, t) + term.phase
    return kit.rounded_sine_cosine(angle)


def value_and_rate(kit: Kit[N], terms: Iterable[Harmonic[N]], t: N) -> tuple[N, N]:
    """Sum of harmonics at t and its rate of change."""
    value = rate = kit.number(0)
    for term in terms:
        sine, cosine = sine_and_cosine(kit, term, t)
        value = value + term.amplitude * sine
        rate = rate + term.amplitude * term.omega * cosine
    return value, rate


class BaseFormula:
    """X(t) by a formula [m], or X'(t) where `is_rate`, with its first two derivatives; X is 0 then."""

    def __init__(self, formula: Node, kit: Kit[Any], is_rate: bool = False) -> None:
        self.kit, self.is_rate = kit, is_rate
        self.formula = formula
        self.switches = [node for node in walk([formula]) if node[0] in SWITCHES]
        self.tapes: dict[tuple[int, ...], Tape] = {}

    def tape(self, t: Any, known: Mapping[Node, int] = NO_SIDES) -> Tape:
        """X, X' and X'' in the piece that the time t [s] is in, or begins. known: sides of switches in the
        mode that is meant, where t may belong to two pieces
        """
        sides: dict[Node, int] = {}
        for node in self.switches:
            sides[node] = known[node] if node in known else self._side(node, t, sides)
        key = tuple(sides.values())
        if key not in self.tapes:
            self.tapes[key] = motion_tape(self.kit, self.formula, sides, "base")
        return self.tapes[key]

    def _side(self, node: Node, t: Any, sides: dict[Node, int]) -> int:
        at = self._value(node[1], t, sides)
        if node[0] == "choose":
            return 1 if (at or self._departure(node[1], t, sides)) >= 0 else -1
        if node[0] == "mod":
            turns = float(at / self._value(node[2], t, sides))
            whole = int(turns // 1)
            return whole - (turns == whole and self._departure(node[1], t, sides) < 0)
        knots = [self.kit.number(knot) for knot in node[2]]
        falls = at in knots and self._departure(node[1], t, sides) < 0
        return sum(1 for knot in knots if at >= knot) - 1 - falls

    def _value(self, node: Node, t: Any, sides: dict[Node, int]) -> Any:
        maker = TapeMaker(self.kit, {})
        return _values(self.kit, maker.tape([maker.place(node, sides)]), t).output(0)[0]

    def _departure(self, node: Node, t: Any, sides: dict[Node, int]) -> Any:
        """The first derivative by the time that is not zero, of a formula that begins at t [s] at a switch; 0
        where those up to the order DERIVATIVES are.
        """
        formula, value = resolved(node, sides), self.kit.number(0)
        for _ in range(DERIVATIVES):
            formula = derivative(formula, TIME)
            value = self._value(formula, t, sides)
            if value != 0:
                break
        return value

    def values(self, t: Any, tape: Tape | None = None) -> list[tuple[Any, Any]]:
        """X, X' and X'' at t [s], each with a bound of its rounding; tape: of the piece that is meant."""
        values = _values(self.kit, tape or self.tape(t), t)
        if self.is_rate:
            return [(self.kit.number(0), self.kit.number(0)), values.output(0), values.output(1)]
        return [values.output(k) for k in range(3)]


def _values(kit: Kit[N], tape: Tape, t: N) -> TapeValues[N]:
    """Values along a tape that reads nothing but the time t [s]."""
    zero = kit.number(0)
    return TapeValues(kit, tape, Inputs(t, (), (), zero, zero), Inputs(kit.eps * abs(t), (), (), zero, zero))


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


def base_rounding(scene: Scene[N], kit: Kit[N], t: N) -> tuple[N, N]:
    """Bounds of the rounding of displacement [m] and velocity [m/s] of the base at t [s].

    A sine is as wrong as its angle times its cosine; at a quarter turn, where motions start, it is 0 or 1. A
    formula is as wrong as its values, and as t is.
    """
    place = rate = kit.number(0)
    if scene.base_formula is not None:
        (X, lost), (V, lost_rate), (A, _) = base_formula(scene, kit).values(t)
        unit, late = ROUNDING * kit.eps, kit.eps * abs(t)
        return unit * abs(X) + late * abs(V) + lost, unit * abs(V) + late * abs(A) + lost_rate
    for term in scene.base:
        sine, cosine = (abs(value) for value in sine_and_cosine(kit, term, t))
        angle = abs(kit.turn_angle(term.cycles, term.cycles_lo, t)) + abs(term.phase)
        size = ROUNDING * kit.eps * abs(term.amplitude)
        if sine != 1 or cosine != 0:
            place = place + size * (sine + angle * cosine)
        rate = rate + size * term.omega * (cosine + angle * sine)
    return place, rate


def belt_velocity(friction: Friction[N], kit: Kit[N], t: N, sides: Mapping[Node, int] = NO_SIDES) -> N:
    """Velocity at t [s] of the belt of a friction, be it a number, a formula or both [m/s]; sides: as of
    `course_velocity`.
    """
    if friction.course is None:
        return friction.belt
    return friction.belt + course_velocity(friction.course, kit, t, sides)


def course_velocity(course: Node, kit: Kit[N], t: N, sides: Mapping[Node, int] = NO_SIDES) -> N:
    """Velocity at t [s] of a belt that moves by a formula [m/s]; sides: of the switches in the mode that t is
    in, whose own may turn at that instant as well.
    """
    motion = _kept(course, cast("Hashable", kit), True)
    velocity: N = motion.values(t, motion.tape(t, sides))[1][0]
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
