"""On which side the switches of formulas are: at the start, behind each event, and where one of them is the
event.
"""

from __future__ import annotations

from collections.abc import Container, Mapping, Sequence
from math import inf
from typing import TYPE_CHECKING, Any, Generic, cast

from vibsim.engine.doubts import START, name_of_switch
from vibsim.engine.errors import EngineError, State
from vibsim.engine.events.relative_motion import RelativeMotion
from vibsim.engine.flows.accelerations import accelerations, left_open
from vibsim.engine.flows.tape import Inputs, TapeValues
from vibsim.engine.modes.formula_rows import FormulaRows
from vibsim.engine.modes.row_maker import RowMaker
from vibsim.engine.modes.rows import SWITCH, Event, Known
from vibsim.engine.modes.status import BACKWARD, FORWARD, STICK, Kept, Status
from vibsim.physics.formulas import TIME, ZERO, Node, derivative, resolved, sub
from vibsim.physics.numbers import Kit, N, abs
from vibsim.physics.parts import Scene

if TYPE_CHECKING:
    from vibsim.engine.events.departures import DerivativeSigns

NO_JUMP = 2.0**-30  # of its size, below which two sides of a switch give one force
LATE = 64  # units of the time, within which a kink of the base is where it was found to be
MOST_STATUSES = 1000  # whose sides are kept
MOST_TURNS = 64  # of switches that turn at one instant


class SwitchSides(Generic[N]):
    """Decides the sides of the switches of a scene."""

    def __init__(self, scene: Scene[N], maker: RowMaker[N], relative: RelativeMotion[N], kit: Kit[N]) -> None:
        self.scene, self.maker, self.relative, self.kit = scene, maker, relative, kit
        assert maker.formulas is not None
        self.rows: FormulaRows[N] = maker.formulas
        self.none = (None,) * len(self.rows.switches)
        self._with_sides = Kept[Status, Status](MOST_STATUSES)
        self._place: tuple[Any, ...] | None = None  # state, and mode before, whose inputs were asked for last
        self._inputs: tuple[Inputs[N], Inputs[N]]
        self._guards: dict[Any, list[N]] = {}  # values of arguments of switches there
        self._here: dict[Status, Status] = {}  # statuses there with all their sides

    def inputs(
        self, state: State[N], before: Status | None = None, came: State[N] | None = None
    ) -> tuple[Inputs[N], Inputs[N]]:
        """Values that formulas read at a state, and their uncertainty by rounding: that of the state, and of
        the time at which it is taken. Kept for one state, of which several modes are tried.

        before : the mode that led there; came : the state that it led to, where an impact has changed that
        """
        place = (state.t, *state.x, *state.v, state.phase, state.turns, state.w, before)
        if place != self._place:
            self._inputs = self._made_inputs(state, before, came or state)
            self._place = place
            self._guards, self._here = {}, {}
        return self._inputs

    def _made_inputs(
        self, state: State[N], before: Status | None, came: State[N]
    ) -> tuple[Inputs[N], Inputs[N]]:
        zero = self.kit.number(0)
        x = [*state.x, zero, self.relative.base(state, "x")]
        v = [*state.v, zero, self.relative.base(state, "v")]
        a = [zero] * len(v)
        if before is not None:
            a, _ = accelerations(self.scene, self.kit, self.maker.rows(before), came)
        at = Inputs(state.t, x, v, self.kit.unwind(state.phase, state.turns), state.w)
        return at, left_open(self.kit, state, x, v, a, zero, zero)

    def completed(
        self,
        state: State[N],
        status: Status,
        fixed: Container[int] = (),
        open_ones: dict[int, bool] | None = None,
        before: Status | None = None,
        came: State[N] | None = None,
    ) -> Status:
        """The status with the sides of its switches by the values of their arguments. `fixed` ones stay as
        they were. So do those within rounding of zero whose argument is the same formula; else, or where the
        value is zero exactly, the upper side holds.

        open_ones : is given the numbers of those within rounding, and whether they are zero exactly
        before : the mode that led there; came : the state that it led to, where velocities, also that of the
            base, have jumped since then. Where they go on from there as they came, no argument jumps, but for
            those that a switch within them has turned: a side that was known stays until its own zero is an
            event. The value may tell another one, as of a state that rests at a zero and is there to the time
            between two doubles
        """
        rows, old = self.rows, status.switches or self.none
        if not rows.switches:
            return status._replace(switches=())
        led = rows.sides(before) if before is not None else None
        decided: dict[int, int] = {}
        sides: dict[Node, int] = {}
        for node, i, sign in rows.awake(status, sides):
            was = old[i]
            if i not in decided and was is not None and i in fixed:
                decided[i] = was
            if i not in decided and (by_stops := rows.side_by_stops(node, status)):
                decided[i] = sign * by_stops
            if i not in decided:
                if led is not None and not self._goes_on(node, sides, led):
                    was = None  # the side of another formula
                if was is not None and led is not None and came is None:
                    decided[i] = was
                else:
                    values = self._guard_values(node, sides, state, before, came)
                    side, unsure = self._side(node, values, None if was is None else sign * was)
                    decided[i] = sign * side
                    if unsure and open_ones is not None:
                        open_ones[i] = values[0] == values[1] == 0
            sides[node] = sign * decided[i]
        completed = Status(*status[:3], tuple(map(decided.get, range(len(rows.switches)))))
        rows.awake_in.keep(completed, set(decided))
        return completed

    def _goes_on(self, node: Node, sides: Mapping[Node, int], led: Mapping[Node, int]) -> bool:
        """Whether the argument of a switch reads the same formula as before; led: sides then."""
        return node in led and all(sides.get(one) == led.get(one) for one in self.rows.behind[node])

    def doubt(
        self, state: State[N], departures: DerivativeSigns[N], open_ones: Mapping[int, bool], reason: str
    ) -> None:
        """Count a doubt for each switch whose side rounding leaves open and at which a formula jumps.

        open_ones : as `completed` gives them
        """
        for i, exact in open_ones.items():
            if not exact and not self.rows.only_bends(i):
                departures.doubt(state, reason, [name_of_switch(self.maker, i)])

    def _guard_values(
        self,
        node: Node,
        sides: Mapping[Node, int],
        state: State[N],
        before: Status | None,
        came: State[N] | None = None,
    ) -> list[N]:
        """Values of the argument of a switch at a state, with the bounds of their rounding."""
        at, blur = self.inputs(state, before, came)
        key = node, *map(sides.get, self.rows.behind[node])
        values = self._guards.get(key)
        if values is None:
            values = self._guards[key] = self.rows.guard_values(node, sides, at, blur)
        return values

    def with_sides(self, state: State[N], status: Status) -> Status:
        """The status with a side of each switch that its formulas read, where it has none yet."""
        known = self._with_sides.get(status)
        if known is not None:
            return known
        there = {i for i, side in enumerate(status.switches) if side is not None}
        if there == self.rows.awake_in.get(status):
            return self._with_sides.keep(status, status)
        self.inputs(state)  # which forgets what other states have
        known = self._here.get(status)
        if known is None:
            known = self._here[status] = self.completed(state, status, there)
            if all(side is None or i in there for i, side in enumerate(known.switches)):
                self._with_sides.keep(status, known)  # whatever the state
        return known

    def _side(self, node: Node, values: list[N], before: int | None) -> tuple[int, bool]:
        """The side of a switch by the value of its argument, and whether rounding leaves it open."""
        value, bound = values[:2]
        if node[0] == "choose":
            if abs(value) <= bound:  # of what is zero exactly the upper side holds, whatever it was before
                return (before or 1) if bound > 0 else 1, True
            return (1 if value > 0 else -1), False
        if node[0] == "mod":
            turns = value / values[2]
            side = _floor(self.kit, turns)
            near = _near(self.kit, turns, bound / values[2])
        else:
            knots = [self.kit.number(knot) for knot in node[2]]
            side = sum(1 for knot in knots if value >= knot) - 1
            near = next((k for k, knot in enumerate(knots) if abs(value - knot) <= bound), None)
        if near is None:
            return side, False
        return (before if before in (near - 1, near) and before is not None else near), True

    def kinks(self, event: Event[N]) -> bool:
        """Whether an event is the turn of a switch in the motion of the base or a belt."""
        return event.kind == SWITCH and event.part in self.rows.of_courses

    def turned(self, status: Status, event: Event[N]) -> Status:
        """The status behind the zero of the event function of a switch."""
        i, node = event.part, self.rows.switches[event.part]
        side = status.switches[i]
        assert side is not None
        step = -1 if event.key[2] == side else 1
        after = -side if node[0] == "choose" else side + step
        sides = list(status.switches)
        sides[i] = after
        return status._replace(switches=tuple(sides))

    def jumps(self, state: State[N], before: Status, after: Status, i: int) -> bool:
        """Whether any formula has another value behind the turn of switch `i`. Raises EngineError of a
        displacement of the base that jumps.
        """
        if self.rows.only_bends(i):
            return False
        sides = [self.rows.sides(one) for one in (before, after)]
        turned = {node for node in self.rows.same if sides[0].get(node) != sides[1].get(node)}
        inputs = self.inputs(state, before)
        for root in self.rows.roots(before):
            if turned.isdisjoint(self.rows.within(root.node)):
                continue
            if self._jumps([root.node] * 2, sides, inputs):
                if root.role == ("base",) and not self.scene.base_is_rate:
                    raise EngineError("torn", state)
                return True
            if root.role[0] == "course":
                rates = [derivative(resolved(root.node, each), TIME) for each in sides]
                if self._jumps(rates, sides, inputs):
                    return True
        return False

    def _jumps(
        self, nodes: Sequence[Node], sides: Sequence[Mapping[Node, int]], inputs: tuple[Inputs[N], Inputs[N]]
    ) -> bool:
        """Whether two formulas, each on its sides of the switches, differ by more than rounding."""
        pair = zip(nodes, sides, strict=True)
        tapes = [TapeValues(self.kit, self.rows.tape([node], each), *inputs) for node, each in pair]
        (one, lost), (other, blurred) = (values.output(0) for values in tapes)
        return bool(abs(one - other) > lost + blurred + NO_JUMP * (abs(one) + abs(other)))

    def base_jumps(self, state: State[N], before: Status, after: Status, i: int) -> bool:
        """Whether the velocity of the base jumps at the turn of switch `i`, and something sticks to it, may
        rest on it, or is damped by it.
        """
        if self.scene.base_formula is None or i not in self.rows.of_courses:
            return False
        sides = [self.rows.sides(one) for one in (before, after)]
        velocities = [self._base_velocity(each) for each in sides]
        return self._jumps(velocities, sides, self.inputs(state, before))

    def step_behind_kink(self, state: State[N], after: Status) -> None:
        """Move the time on by its rounding, to where the base has the velocity that it has behind a kink; not
        where another switch turns at the same instant, which it still has to, nor beyond the end of the run.
        """
        start = state.t
        sides = self.rows.sides(after)
        tape = self.rows.tape([self._base_velocity(sides)], sides)
        for _ in range(LATE):
            behind = TapeValues(self.kit, tape, *self.inputs(state)).output(0)[0]
            if abs(self.relative.base(state, "v") - behind) <= NO_JUMP * abs(behind):
                return
            if state.t >= self.scene.t_end:
                break
            state.t = self.kit.next_after(state.t, inf)
        state.t = start

    def _base_velocity(self, sides: Mapping[Node, int]) -> Node:
        """Formula of the velocity of the base on these sides of its switches."""
        formula = resolved(cast("Node", self.scene.base_formula), sides)
        return formula if self.scene.base_is_rate else derivative(formula, TIME)

    def jumping_belts(
        self, state: State[N], before: Status, after: Status, base: bool = False
    ) -> dict[int, int]:
        """The frictions whose belts jump between two modes, with the senses in which their ends slip then;
        STICK where they are at rest on it by chance. base : whether the base does
        """
        inputs, sides = self.inputs(state, before), [self.rows.sides(one) for one in (before, after)]
        found: dict[int, int] = {}
        for k, friction in enumerate(self.scene.frictions):
            course = friction.course
            P, Q = self.maker.ends(friction)
            on_base = base and self.maker.n + 1 in (P, Q)
            if on_base or (course is not None and self._jumps([course] * 2, sides, inputs)):
                slip = sub(sub(("v", P), ("v", Q)), course or ZERO)
                value, bound = TapeValues(self.kit, self.rows.tape([slip], sides[1]), *inputs).output(0)
                value, bound = value - friction.belt, bound + self.kit.eps * abs(friction.belt)
                found[k] = STICK if abs(value) <= bound else FORWARD if value > 0 else BACKWARD
        return found

    def initial(
        self, state: State[N], departures: DerivativeSigns[N], status: Status
    ) -> tuple[Status, Known]:
        """The sides at a start in the mode `status`, and the known zeros: those that are zero go where their
        first derivative leads.
        """
        unsure: dict[int, bool] = {}
        status = self.completed(state, status, (), unsure)
        known: Known = {}
        if not unsure:
            return status, known
        for _ in range(MOST_TURNS):
            known.clear()
            for event in departures.enter(state, status).events:
                if (
                    event.kind != SWITCH
                    or event.part not in unsure
                    or not self._is_zero(event, state, status)
                ):
                    continue
                sense, order = departures.departure(state, status, event.key)
                if sense < 0:
                    for i in self._reading(event.part):  # whose arguments are others now
                        unsure.pop(i, None)
                    fixed = {event.part, *unsure}
                    status = self.completed(state, self.turned(status, event), fixed, unsure)
                    break
                if sense > 0:
                    known[event.key] = order
            else:
                going = {key[1] for key in known}
                resting = {i: exact for i, exact in unsure.items() if i not in going}
                self.doubt(state, departures, resting, START)
                return status, known
        held = dict.fromkeys(self.rows.owners[i] for i in sorted(unsure))
        raise EngineError("held", state, ", ".join(held))

    def _reading(self, turned: int) -> set[int]:
        """The switches whose arguments read switch number `turned`."""
        numbers = {node: i for node, (i, _) in self.rows.same.items()}
        return {i for node, i in numbers.items() if turned in map(numbers.get, self.rows.behind[node])}

    def _is_zero(self, event: Event[N], state: State[N], status: Status) -> bool:
        """Whether the zero of an event function is the one that a switch is at: tables and mod have two."""
        node = self.rows.switches[event.part]
        if node[0] == "choose":
            return True
        values = self.rows.guard_values(node, self.rows.sides(status), *self.inputs(state))
        key = event.key[2]
        assert isinstance(key, int)
        if node[0] == "mod":
            return bool(abs(values[0] - key * values[2]) <= values[1])
        return bool(abs(values[0] - self.kit.number(node[2][key])) <= values[1])


def _floor(kit: Kit[N], value: N) -> int:
    """The whole number not above a value."""
    whole = int(float(value) // 1)
    while kit.number(whole + 1) <= value:
        whole += 1
    while kit.number(whole) > value:
        whole -= 1
    return whole


def _near(kit: Kit[N], value: N, bound: N) -> int | None:
    """The whole number within `bound` of a value."""
    whole = round(float(value))
    return whole if abs(value - kit.number(whole)) <= bound else None
