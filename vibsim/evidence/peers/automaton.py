"""The modes of a scene around a solver that finds events: which follows, and what an impact does."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations, product
from math import inf, prod, sin
from typing import Any

import numpy as np

from vibsim.evidence.peers.equations import Compiled, first_sides, has_power, shafts_of
from vibsim.evidence.peers.straight_line import (
    BACKWARD,
    CONTACT,
    FORWARD,
    FREE,
    LIFTED,
    OPEN,
    REST,
    STICK,
    TIES,
    masses,
    rows_of,
)
from vibsim.physics.parts import AT_FORCE, Friction, RigidStop, Scene

# A scene at one instant: depths and rates of its parts, forces of ties and accelerations in any mode.


AHEAD = (1e-11, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6)  # s: steps behind an instant at which guards are looked at
CLEAR = 100.0  # times what a guard is from 0: a change that is no rounding
QUIET = 1e-16  # nearer to 0, and over the longest step to what it is, a guard may be rounding alone


def rk4_step(
    motion: Callable[..., Sequence[float]], t: float, state: list[float], h: float, *more: Any
) -> list[float]:
    """The state a step h [s] after `state`: Kutta (1901). motion : d state/dt at (t, state, *more)"""
    a = motion(t, state, *more)
    b = motion(t + h / 2, [x + h / 2 * rate for x, rate in zip(state, a, strict=True)], *more)
    c = motion(t + h / 2, [x + h / 2 * rate for x, rate in zip(state, b, strict=True)], *more)
    d = motion(t + h, [x + h * rate for x, rate in zip(state, c, strict=True)], *more)
    stages = zip(state, a, b, c, d, strict=True)
    return [x + h / 6 * (p + 2 * (q + r) + s) for x, p, q, r, s in stages]


class Instant:
    """The parts of a scene at the time t [s] and in `state`, whose velocities may be changed.

    sides : of the switches of formulas
    """

    def __init__(self, compiled: Compiled, t: float, state: list[float], sides: Sequence[int] | None = None):
        self.compiled, self.t, self.state = compiled, t, state
        self.switches = compiled.switches
        self.sides = first_sides(compiled.scene) if sides is None else list(sides)
        self.look_again()

    def look_again(self) -> None:
        """Take note of changed velocities, or sides."""
        states = [switch.states[0] for switch in self.switches]
        self._loose = self.compiled.parameters(states, self.sides)
        self._parts = self.compiled.parts(self.t, self.state, self._loose)

    def depth(self, i: int) -> float:
        """Depth of stop i [m]."""
        return float(self._parts[2 * i])

    def rate(self, i: int) -> float:
        """Its rate [m/s]; of a friction the velocity of slip."""
        return float(self._parts[2 * i + 1])

    def contact_force(self, i: int) -> float:
        """Force of elastic stop i in contact [N]."""
        return float(self.compiled.law(i)(self.t, self.state, self._loose)[0])

    def limits(self, i: int) -> tuple[float, float]:
        """The most that friction i holds against slip forwards and backwards [N]."""
        part = self.switches[i].part
        if part.holds is None:
            forwards, backwards = part.limits
        else:
            forwards, backwards = self.compiled.law(i)(self.t, self.state, self._loose)
        return float(forwards), float(backwards)

    def turn(self, states: Sequence[str]) -> bool:
        """Bring the sides of the switches of formulas up to what they are just behind here, with the parts in
        `states`; whether any has changed.
        """
        before = list(self.sides)
        for _ in self.compiled.turning:  # a guard may read another switch
            sides = self._sides_behind(self.compiled.parameters(states, self.sides))
            if sides == self.sides:
                break
            self.sides = sides
        if self.sides == before:
            return False
        self.look_again()
        return True

    def _sides_behind(self, parameters: Sequence[float]) -> list[int]:
        """The sides of the guards a little later: of one that keeps more than half of what it is from 0 here
        over the longest step, that it has; of any other, that when it has first changed by far more.

        The first look is along the rates, which is enough where neither they nor the guard are rounding.
        """
        turning, sides, step = self.compiled.turning, list(self.sides), AHEAD[-1]
        here = self.compiled.guards(self.t, self.state, parameters)
        rest = [abs(switch.from_zero(guard)) for switch, guard in zip(turning, here, strict=True)]
        rates = self.compiled.motion(self.t, self.state, parameters)
        later = [value + step * rate for value, rate in zip(self.state, rates, strict=True)]
        left = []
        for i, guard in enumerate(self.compiled.guards(self.t + step, later, parameters)):
            sides[i], change = turning[i].side(guard, self.sides[i]), abs(guard - here[i])
            if (rest[i] < QUIET or change > rest[i] / 2) and change < CLEAR * max(rest[i], QUIET):
                left.append(i)
        for step in AHEAD if left else ():
            later = rk4_step(self.compiled.motion, self.t, self.state, step, parameters)
            guards = self.compiled.guards(self.t + step, later, parameters)
            for i in tuple(left):
                sides[i] = turning[i].side(guards[i], self.sides[i])
                if abs(guards[i] - here[i]) >= CLEAR * rest[i]:
                    left.remove(i)
            if not left:
                break
        return sides

    def balance(self, states: Sequence[str]) -> tuple[float, ...]:
        """d state/dt, and behind it the force in each part that can tie [N], were the parts in `states`."""
        parameters = self.compiled.parameters(states, self.sides)
        rates: tuple[float, ...] = self.compiled.balance(self.t, self.state, parameters)
        return rates

    def tie_force(self, i: int, values: Sequence[float]) -> float:
        """The force in part i [N], from a `balance`."""
        return values[self.compiled.ties.index(i) - len(self.compiled.ties)]

    def second_rate(self, i: int, values: Sequence[float]) -> float:
        """Second rate of the depth of a rigid stop, of x_P - x_Q of a friction, from a `balance` [m/s^2]."""
        driven = self.compiled.driven(self.t, self.state, self._loose)
        total = sum(share * a for share, a in zip(self.compiled.of_driven[i], driven, strict=True))
        for body, sign in self.compiled.rows[i]:
            total += sign * values[2 * body + 1]
        return float(-total if isinstance(self.switches[i].part, RigidStop) else total)

    def halt(self, parts: Sequence[int]) -> None:
        """Take the rates of these parts to zero, or what rounding left of them."""
        rigid = (isinstance(self.switches[i].part, RigidStop) for i in parts)
        rates = [-self.rate(i) if stop else self.rate(i) for i, stop in zip(parts, rigid, strict=True)]
        if any(rates):
            for body, row in enumerate(self.compiled.halts(parts)):
                self.state[2 * body + 1] += sum(a * rate for a, rate in zip(row, rates, strict=True))
            self.look_again()


# The states of the parts behind an event, found by trying.
#
# Of all combinations of states of the parts that are undecided at an instant, the first whose accelerations
# and forces are consistent; those with most ties are tried first, so friction sticks whenever it can.


HELD = 1.0 - 1e-10  # of the limit friction, below which ends stick: at a release the force equals it
SLACK = 1e-9  # of the largest force: beside a release that of slip is zero to HELD
MOST = 3**9  # combinations that are tried: those of nine frictions
ZERO = 1e-13  # of the largest force: zero but for rounding

States = list[str]


def consistent_states(at: Instant, states: States, undecided: Sequence[int]) -> States | None:
    """`states` with those of the parts `undecided` chosen; None where no combination is consistent.

    Raises ArithmeticError where one may be whose forces are not unique: its consistency cannot be told; and
    for more combinations than MOST.
    """
    if not undecided:
        return states
    if len(undecided) == 1 and isinstance(at.switches[undecided[0]].part, Friction):
        return _of_one_friction(at, states, undecided[0])
    trials = _combinations(at, states, undecided)
    return next((trial for trial in trials if _is_consistent(at, trial, undecided)), None)


def _of_one_friction(at: Instant, states: States, i: int) -> States:
    """It sticks if it holds, else it slips the way it is pulled."""
    chosen = list(states)
    chosen[i] = STICK
    force, (forwards, backwards) = at.tie_force(i, at.balance(chosen)), at.limits(i)
    if force < -HELD * forwards:
        chosen[i] = FORWARD
    elif force > HELD * backwards:
        chosen[i] = BACKWARD
    return chosen


def _combinations(at: Instant, states: States, undecided: Sequence[int]) -> Iterator[States]:
    count = prod(len(at.switches[i].states) for i in undecided)
    if count > MOST:
        raise ArithmeticError(f"{count} combinations of the parts at rest, of which {MOST} can be tried")
    choices = product(*(at.switches[i].states for i in undecided))
    for choice in sorted(choices, key=lambda choice: -sum(state in TIES for state in choice)):
        trial = list(states)
        for i, state in zip(undecided, choice, strict=True):
            trial[i] = state
        yield trial


def _is_consistent(at: Instant, states: States, undecided: Sequence[int]) -> bool:
    values = at.balance(states)
    scale = max((abs(at.tie_force(i, values)) for i in at.compiled.ties), default=0.0)
    for body, mass in enumerate(at.compiled.masses):
        scale = max(scale, abs(mass * values[2 * body + 1]))
    return all(_agrees(at, i, states[i], values, scale) for i in undecided)


def _agrees(at: Instant, i: int, state: str, values: Sequence[float], scale: float) -> bool:
    """Whether the state of part i agrees with its force, or with its acceleration. scale : forces [N]"""
    if state == REST:
        return at.tie_force(i, values) >= -ZERO * scale
    if state == STICK:
        forwards, backwards = at.limits(i)
        return bool(-HELD * forwards <= at.tie_force(i, values) <= HELD * backwards)
    force = min(at.compiled.masses) * at.second_rate(i, values)
    if state == OPEN:
        return bool(force <= ZERO * scale)
    return bool((force if state == FORWARD else -force) >= -SLACK * scale)


# What happens at a rigid stop that is struck: impacts until none closes, then rest or a hop.


MOST_IMPACTS = 100  # at one instant
LATER, NEVER = 1e300, inf  # s, until a hop ends


@dataclass(frozen=True)
class Shortest:
    """Hops of no more than `height` [m], or `time` [s], are none."""

    height: float
    time: float = 0.0

    def holds(self, speed: float, press: float) -> bool:
        """Whether a hop that begins with `speed` [m/s] against `press` [m/s^2] is none."""
        return press > 0 and (speed**2 <= 2 * press * self.height or 2 * speed <= press * self.time)


@dataclass
class Struck:
    """impacts : stops that were struck while they closed; undecided : parts at rest behind the impacts;
    hop_ends : until the shortest hop ends [s], LATER where that is not in sight
    """

    impacts: int
    undecided: list[int]
    hop_ends: float


def strike(
    at: Instant, states: States, striking: Sequence[int], undecided: Sequence[int], shortest: Shortest
) -> Struck:
    """Impacts of the stops `striking` and of those that touch; changes velocities of `at`, and `states` of
    the parts that they set in motion. undecided : other parts at rest. Raises ArithmeticError as `impact`.
    """
    touching = [i for i in _rigid(at) if _touches(at, i, states, {*striking, *undecided}, shortest)]
    frictions = [i for i, switch in enumerate(at.switches) if isinstance(switch.part, Friction)]
    slips = {i: at.rate(i) for i in frictions}
    first, struck = max(at.rate(i) for i in touching), set()
    for _ in range(MOST_IMPACTS):
        rates = [at.rate(i) for i in touching]
        if not max(rates) > ZERO * first >= 0:
            break
        impulses = impact(at, touching, rates)
        struck |= {i for i, L, rate in zip(touching, impulses, rates, strict=True) if L > 0 and rate > 0}
    else:
        raise ArithmeticError(f"impacts without end at {at.t:g} s")
    torn = [i for i in frictions if at.rate(i) != slips[i]]
    for i in torn:
        states[i] = FORWARD if at.rate(i) > 0 else BACKWARD
    short, hop_ends = _let_go(at, states, touching, first, shortest)
    still = [i for i in frictions if i not in torn and (i in undecided or states[i] == STICK)]
    return Struck(len(struck), [*short, *still], hop_ends)


def _rigid(at: Instant) -> list[int]:
    return [i for i, switch in enumerate(at.switches) if isinstance(switch.part, RigidStop)]


def _touches(at: Instant, i: int, states: States, there: set[int], shortest: Shortest) -> bool:
    return i in there or states[i] == REST or abs(at.depth(i)) <= shortest.height


def _let_go(
    at: Instant, states: States, touching: Sequence[int], first: float, shortest: Shortest
) -> tuple[list[int], float]:
    """Open the stops that separate behind an impact; those at rest, or with a hop that is none, and until the
    shortest of the other hops ends.
    """
    for i in touching:
        states[i] = OPEN
    values = at.balance(states)
    short, hop_ends = [], LATER
    for i in touching:
        speed, press = max(-at.rate(i), 0.0), at.second_rate(i, values)
        if speed <= ZERO * first or shortest.holds(speed, press):
            short.append(i)
        elif press > 0:
            hop_ends = min(hop_ends, 2 * speed / press)
    if short:
        at.halt(short)
    return short, hop_ends


# The mode automaton around a solver that finds events: which state each stop and friction is in.


KINDS = {
    (FREE, CONTACT): "contact_begin",
    (CONTACT, FREE): "contact_end",
    (CONTACT, LIFTED): "contact_end",
    (LIFTED, CONTACT): "contact_begin",
    (FORWARD, BACKWARD): "reversal",
    (BACKWARD, FORWARD): "reversal",
    (FORWARD, STICK): "stick_begin",
    (BACKWARD, STICK): "stick_begin",
    (STICK, FORWARD): "stick_end",
    (STICK, BACKWARD): "stick_end",
    (OPEN, REST): "rest_begin",
    (REST, OPEN): "rest_end",
}

STILL = 1e-12  # of the fastest velocity: at rest but for rounding

Events = list[str]  # kinds


class Mode:
    """The mode of the motion: `begin` with the state at t = 0, then `switch` at every event.

    states : of the parts; parameters : what the equations take; hop_ends : until the shortest hop ends that
    has just begun [s], LATER where that is not in sight, NEVER where none began
    """

    def __init__(self, compiled: Compiled, shortest: Shortest):
        self.compiled, self.switches, self.shortest = compiled, compiled.switches, shortest
        self.states = [switch.states[0] for switch in self.switches]
        self.sides = first_sides(compiled.scene)
        self.parameters: list[float] = []
        self.hop_ends = NEVER
        self._damped = [i for i, switch in enumerate(self.switches) if LIFTED in switch.states]
        self._without_jump = {
            i
            for i, switch in enumerate(self.switches)
            if switch.states == (FREE, CONTACT) and not switch.part.jumps
        }

    def begin(self, state: list[float]) -> Events:
        """Take the mode of the state at t = 0, in which an impact may fall; kinds of the events."""
        at = Instant(self.compiled, 0.0, state)
        at.turn(self.states)
        undecided, striking = [], []
        for i, switch in enumerate(self.switches):
            if isinstance(switch.part, Friction):
                self.states[i] = FORWARD if at.rate(i) > 0 else BACKWARD
                undecided += [i] * (at.rate(i) == 0)
            elif isinstance(switch.part, RigidStop):
                touches = switch.part.at_start or at.depth(i) == 0
                self.states[i] = OPEN
                undecided += [i] * (touches and at.rate(i) == 0)
                striking += [i] * (touches and at.rate(i) > 0)
            else:
                self.states[i] = _elastic_at_start(at, i)
        events: Events = []
        if striking:
            events, undecided = self._strike(at, striking, undecided)
        self._settle(at, undecided)
        return events

    def switch(self, i: int, place: int, t: float, state: list[float]) -> Events:
        """Enter the mode behind the zero of an event function of part i, at its `place` in `ends`; kinds of
        the events.

        Sets the velocities in `state` to those behind it. No kind where nothing changes, as rounding makes
        zeros beside a release. Raises ArithmeticError where no mode is consistent.
        """
        before = list(self.states)
        impacts: Events = []
        self.hop_ends = NEVER
        if i in self._without_jump:  # of any force: nothing else changes
            self.states[i] = CONTACT if before[i] == FREE else FREE
            self.parameters = self.compiled.parameters(self.states, self.sides)
            return [KINDS[before[i], self.states[i]]]
        at = Instant(self.compiled, t, state, self.sides)
        undecided = [j for j, each in enumerate(before) if each in TIES and j != i]
        match before[i] if i < len(before) else None:
            case None:
                impacts, undecided = self._turn(at, i - len(before), place, undecided)
            case "open":
                impacts, undecided = self._strike(at, [i], undecided)
            case "rest":
                self.states[i] = OPEN
            case "stick":
                self.states[i] = self._torn(at, i)
            case "forward" | "backward":
                undecided += [i, *self._still(at, i)]
            case _:
                self.states[i] = _elastic_behind(at, i, before[i], place)
        self._settle(at, undecided, i)
        steps = zip(before, self.states, strict=True)
        return impacts + [KINDS[step] for step in steps if step in KINDS]

    def _strike(self, at: Instant, striking: list[int], undecided: list[int]) -> tuple[Events, list[int]]:
        struck = strike(at, self.states, striking, undecided, self.shortest)
        self.hop_ends = struck.hop_ends
        return ["impact"] * struck.impacts, struck.undecided

    def _still(self, at: Instant, i: int) -> list[int]:
        """Frictions that slide, and come to rest at the same instant as friction i."""
        fastest = max(map(abs, at.state[1 : 2 * len(self.compiled.masses) : 2]))
        slides = (j for j, each in enumerate(self.states) if each in (FORWARD, BACKWARD) and j != i)
        return [j for j in slides if abs(at.rate(j)) <= STILL * fastest]

    def _torn(self, at: Instant, i: int) -> str:
        """The way a stick that ends begins to slip."""
        forwards, backwards = at.limits(i)
        force = at.tie_force(i, at.balance(self.states))
        return FORWARD if forwards + force < backwards - force else BACKWARD

    def _turn(self, at: Instant, i: int, place: int, undecided: list[int]) -> tuple[Events, list[int]]:
        """Take switch i of the formulas to its other side. Where that makes the velocity of base or belts
        jump, frictions slip, which give no impulse, and rigid stops are struck or left behind.
        """
        before = [at.rate(j) for j in range(len(self.switches))]
        at.sides[i] = self.compiled.turning[i].behind(at.sides[i], place)
        at.look_again()
        fastest = max(map(abs, at.state[1 : 2 * len(self.compiled.masses) : 2]))
        after = [at.rate(j) for j in range(len(self.switches))]
        jumped = [
            j
            for j, (old, new) in enumerate(zip(before, after, strict=True))
            if abs(new - old) > STILL * max(fastest, abs(old), abs(new))
        ]
        for j in jumped:
            if isinstance(self.switches[j].part, Friction) and at.rate(j):
                self.states[j] = FORWARD if at.rate(j) > 0 else BACKWARD
        rested = [j for j in jumped if self.states[j] == REST and at.rate(j)]
        for j in rested:
            self.states[j] = OPEN
        striking = [j for j in rested if at.rate(j) > 0]
        undecided = [j for j in undecided if self.states[j] in TIES]
        return self._strike(at, striking, undecided) if striking else ([], undecided)

    def _settle(self, at: Instant, undecided: list[int], last: int | None = None) -> None:
        """Choose the states of the parts `undecided`; where that cannot be done, of part `last` too. Sides of
        formulas follow from what the guards are behind here.
        """
        at.turn(self.states)
        before = list(self.states), list(at.state)
        self._choose(at, undecided, last)
        if before != (self.states, at.state) and at.turn(self.states):
            self._choose(at, [i for i, state in enumerate(self.states) if state in TIES], last)
        self.sides = at.sides
        self.parameters = self.compiled.parameters(self.states, self.sides)

    def _choose(self, at: Instant, undecided: list[int], last: int | None) -> None:
        self._mend_lifts(at)
        states = consistent_states(at, self.states, undecided)
        if states is None and last is not None and last < len(self.switches) and self.switches[last].tie:
            undecided = [*undecided, last]
            states = consistent_states(at, self.states, undecided)
        if states is None:
            raise ArithmeticError(f"no mode is consistent at {at.t:.9g} s")
        self.states = states
        tied = [i for i in dict.fromkeys(undecided) if states[i] in TIES]
        if tied:
            at.halt(tied)

    def _mend_lifts(self, at: Instant) -> None:
        """Where an impact has turned the force of a damped stop round, it lets go, or takes hold again."""
        for i in self._damped:
            if self.states[i] != FREE and at.depth(i) > self.shortest.height:
                force, part = at.contact_force(i), self.switches[i].part
                if abs(force) > SLACK * part.k * at.depth(i):
                    self.states[i] = CONTACT if force > 0 else LIFTED


def _elastic_at_start(at: Instant, i: int) -> str:
    """The state of an elastic stop at t = 0: deep, or touching on its way in."""
    part = at.switches[i].part
    depth = at.depth(i)
    if part.at_start:
        depth = -at.compiled.skin if has_power(part) else 0.0
    resting = at.rate(i) == 0 and has_power(part)  # a power of the depth does not press yet
    if depth < 0 or (depth == 0 and (at.rate(i) < 0 or resting)):
        return FREE
    return LIFTED if part.release == AT_FORCE and at.contact_force(i) < 0 else CONTACT


def _elastic_behind(at: Instant, i: int, state: str, place: int) -> str:
    """The state of an elastic stop behind the end of one: of several ends, that at `place`."""
    part, depth = at.switches[i].part, at.depth(i)
    if state == FREE:
        return CONTACT
    if state == CONTACT:
        by_depth = part.force is not None and place == 0
        return LIFTED if part.lets_go and depth > 0 and not by_depth else FREE
    return FREE if place == 0 else CONTACT


# Impacts of rigid stops by the Newton-Moreau law, by trying which of them pass on an impulse.
#
# With g' the rates of depth of the stops that touch, L their impulses and A = D G^-1 D' (D the rows of g', G
# the masses, the rotor among them):  g'(after) = g' - A L,  L >= 0,  w = g'(after) + e g' <= 0,  L w = 0.


ROUNDING = 1e-12  # of the largest rate: what counts as zero
MOST_STOPS = 12  # that touch at once, of which all sets are tried


def impact(at: Instant, touching: Sequence[int], rates: Sequence[float]) -> list[float]:
    """Change the velocities of `at` by an impact of the rigid stops `touching`, whose depths change by
    `rates` [m/s]; the impulse of each [N s]. Raises ArithmeticError where no impulses obey the law.
    """
    if len(touching) == 1 and at.compiled.scene.motor is None and not at.compiled.scene.rotors:
        impulses = _of_one_stop(at, touching[0], rates[0])
    else:
        impulses = _of_several(at, touching, rates)
    at.look_again()
    return impulses


def _of_one_stop(at: Instant, i: int, rate: float) -> list[float]:
    """Newton's law: the ends part with e times the speed at which they met."""
    row, own = at.compiled.rows[i], at.compiled.masses
    impulse = (1 + at.switches[i].part.e) * rate / sum(1 / own[body] for body, _ in row)
    for body, sign in row:
        at.state[2 * body + 1] += sign * impulse / own[body]
    return [impulse]


def _of_several(at: Instant, touching: Sequence[int], rates: Sequence[float]) -> list[float]:
    scene, switches = at.compiled.scene, [at.switches[i] for i in touching]
    matrix, places = _mass_matrix(scene, at.state)
    rows = np.zeros((len(touching), len(places)))
    rows[:, : len(scene.line)] = -rows_of(scene, switches)[0]
    mobility = np.linalg.inv(matrix)
    e = np.array([float(switch.part.e) for switch in switches])
    impulses = _impulses(rows @ mobility @ rows.T, np.array(rates), e)
    for place, step in zip(places, (-mobility @ rows.T @ impulses).tolist(), strict=True):
        at.state[place] += step
    passed: list[float] = impulses.tolist()
    return passed


def _mass_matrix(scene: Scene, state: Sequence[float]) -> tuple[np.ndarray, list[int]]:
    """Of the bodies, and of the rotors behind them, whose unbalance ties each to its body; places of their
    velocities in the state.
    """
    shafts = [shaft for shaft in shafts_of(scene, range(len(state))) if shaft.unbalance]
    n = len(scene.line)
    matrix = np.diag([*masses(scene), *(shaft.inertia for shaft in shafts)])
    for k, shaft in enumerate(shafts):
        coupling = -shaft.unbalance * sin(state[shaft.angle])
        matrix[shaft.on, n + k] = matrix[n + k, shaft.on] = coupling
    return matrix, [*range(1, 2 * n, 2), *(shaft.speed for shaft in shafts)]


def _impulses(A: np.ndarray, rates: np.ndarray, e: np.ndarray) -> np.ndarray:
    """L of the law, trying all sets of stops that pass on an impulse, small ones first."""
    closing, count = (1 + e) * rates, len(rates)
    slack = ROUNDING * np.abs(rates).max()
    if count > MOST_STOPS:
        raise ArithmeticError(f"{count} stops touch at once, of which {MOST_STOPS} can be tried in all sets")
    for size in range(count + 1):
        for members in map(list, combinations(range(count), size)):
            L = np.zeros(count)
            if members:
                L[members] = np.linalg.lstsq(A[np.ix_(members, members)], closing[members], rcond=None)[0]
            w = closing - A @ L
            if (np.abs(w[members]) <= slack).all() and (w <= slack).all() and (L >= 0).all():
                return L
    raise ArithmeticError("no impulses obey the law of impact: a body is held from both sides")
