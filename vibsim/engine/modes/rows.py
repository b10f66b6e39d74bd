"""Mode rows: what a mode is to the engine, made once when it is met.

    couplings    links, and stops in contact, merged per pair of columns: S = k d + c d' + offset of
                 d = x_P - x_Q; -S on P, +S on Q
    constants    forces of slipping frictions
    formulas     forces that are outputs of the tape, those of frictions that fall with speed among them
    ties         frictions that stick and rigid stops at rest, numbered in this order: frictions, stops
    events       functions that are positive inside the mode and end it at zero: sums of differences, their
                 rates, couplings, loads, accelerations and formulas

Columns are the bodies in order, then ground and base. A base that rests is one with the ground, so that what
bodies hold on both is decided at once.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Generic, NamedTuple, Protocol

from vibsim.engine.modes.status import Status
from vibsim.engine.modes.ties import Cut, Groups
from vibsim.physics.formulas import Node
from vibsim.physics.numbers import N

if TYPE_CHECKING:
    from vibsim.engine.flows.tape import Tape


# Kinds of event functions; STRIKE: of a rigid stop; SWITCH: of a switch of a formula; DOMAIN: of what stands
# under a root in one.
GAP, PUSH, SLIDE, HOLD, CLEARANCE, STRIKE, SWITCH, DOMAIN = range(8)
DIFFERENCE, RATE, COUPLING, LOAD, ACCELERATION, FORMULA = range(6)  # kinds of terms
NO_ZERO = -1  # in place of an output: what is left of a force without powers of the depth is never 0

EventKey = tuple[int | tuple[int, ...], ...]  # kind of an event function and what it watches
Known = dict[EventKey, int]  # event functions that are zero at an instant, and to which order


class Joined(Protocol):
    """A part between two ends."""

    @property
    def P(self) -> int: ...
    @property
    def Q(self) -> int: ...


@dataclass
class Coupling(Generic[N]):
    """S = k d + c d' + offset of the difference d = x_P - x_Q [N]."""

    P: int
    Q: int
    k: N
    c: N
    offset: N


class FormulaForce(NamedTuple):
    """A force by a formula: sign times output number `output` of the tape on column P [N], the opposite on
    Q, which is -1 for none.
    """

    output: int
    P: int
    Q: int
    sign: int


@dataclass(slots=True)
class RotorOn(Generic[N]):
    """A rotor with its unbalance [kg m] and its inertia [kg m^2]: columns of it and of the body that it is
    on.
    """

    column: int
    on: int
    unbalance: N
    inertia: N


@dataclass(slots=True)
class Term(Generic[N]):
    """coefficient times what `kind` names: the difference of columns (P, Q), its rate, coupling number P, the
    load on column P, its acceleration, or output number P of the tape.
    """

    kind: int
    coefficient: N | int
    P: int
    Q: int = -1


Terms = tuple[Term[N], ...]
ForceTerms = tuple[Terms[N], tuple[N, ...]]  # terms and constants of the force on a set of columns


@dataclass(slots=True)
class Acceleration(Generic[N]):
    """factor times the acceleration of a group: the force of its terms and constants, over its mass."""

    mass: N
    factor: int
    terms: Terms[N]
    constants: tuple[N, ...]


@dataclass(slots=True)
class Event(Generic[N]):
    """An event function: the sum of its terms and a constant.

    key : (kind, what it watches), the same in every mode
    part : index of the stop, friction or clearance; of the cut in `ModeRows.cuts` for HOLD
    slope : its first derivative by the balance of forces, where that is better than differentiating (SLIDE);
        empty elsewhere
    turns : whether its minima count for the grazing margin
    """

    kind: int
    part: int
    direction: int
    key: EventKey
    terms: Terms[N]
    constant: N
    size: N
    slope: tuple[Acceleration[N], ...] = ()
    turns: bool = False

    def is_made_of(self, kind: int) -> bool:
        """Whether all terms, and there are some, are of one kind."""
        return bool(self.terms) and all(term.kind == kind for term in self.terms)


@dataclass
class ModeRows(Generic[N]):
    """All that the flows read of one mode."""

    status: Status
    groups: Groups
    leader: list[int]
    mass: list[N | None]  # of the group, by leading column; None where it does not move on its own
    mobility: list[N]  # 1 / mass, 0 where it does not move on its own; by column
    couplings: list[Coupling[N]]
    constants: list[tuple[int, N]]
    events: list[Event[N]] = field(default_factory=list)
    cuts: list[Cut[N]] = field(default_factory=list)
    drift: list[N] = field(default_factory=list)  # velocity of a column against its leader [m/s]
    tied: list[int] = field(default_factory=list)  # bodies that are tied to another column
    forces: dict[int, ForceTerms[N]] = field(default_factory=dict)  # on groups by leader, once asked for
    tape: Tape | None = None  # formulas of the mode, where it has some
    nodes: dict[int, Node] = field(default_factory=dict)  # the formulas of the outputs
    factors: dict[int, N] = field(default_factory=dict)  # of outputs that are a factor times their formula
    sides: dict[Node, int] = field(default_factory=dict)  # of their switches
    awake: set[int] = field(default_factory=set)  # numbers of the switches that they read
    columns: dict[int, int] = field(default_factory=dict)  # of ground and base, by their ends
    slopes: Any = None  # their partial derivatives, `tangent.formula_tangent.Slopes`, once they are asked for
    base_tape: Tape | None = None  # of the motion of the base by a formula
    base_values: Tape | None = None  # of that motion with its first two derivatives
    outputs: dict[tuple[Any, ...], int] = field(default_factory=dict)  # of the tape, by what they are for
    formulas: list[FormulaForce] = field(default_factory=list)
    follow: dict[int, int] = field(default_factory=dict)  # by column that a belt by a formula carries along
    # with its group: output of the acceleration that it has more than that [m/s^2]
    rotors: list[RotorOn[N]] = field(default_factory=list)

    @property
    def by_formulas(self) -> bool:
        """Whether formulas move it, or the base under it."""
        return bool(self.tape and self.tape.ops) or self.base_tape is not None

    def lets_go_with_depth(self, i: int) -> bool:
        """Whether the force of elastic stop number i, by a formula, is zero with the depth alone."""
        return self.outputs.get(("push", i)) == NO_ZERO

    def own_mass(self, leader: int) -> N:
        """Mass of a group that moves on its own [kg]."""
        mass = self.mass[leader]
        assert mass is not None
        return mass


# What C is told of an event beforehand: the mode behind it, where that is simple.


# kinds of rules, as in rules.c
DECIDE_IN_PYTHON, CROSS, STICK_OR_REVERSE, RIGID_IMPACT, CROSS_IF_TIES_HOLD = range(5)


class Rule(NamedTuple):
    """A rule of one event of a mode.

    target : the mode behind it; other : of STICK_OR_REVERSE, the mode where HOLD event number `hold` of the
        target is overloaded; None and -1 where there is none
    happened, part : kind of the event by name, and its part; "" and -1 where nothing is told
    key, order : of the event function that is zero behind it
    """

    kind: int
    target: Status
    other: Status | None
    hold: int
    happened: str
    part: int
    key: EventKey
    order: int
