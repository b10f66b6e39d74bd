"""The equations of a scene, one force after the other as its law is printed, and compiled to Python."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from vibsim.evidence.peers.straight_line import (
    BACKWARD,
    CONTACT,
    FORWARD,
    FREE,
    LIFTED,
    OPEN,
    REST,
    STICK,
    FormulaReader,
    Label,
    OperationLog,
    course_rates,
    driven_count,
    formula_switches,
    masses,
    rows_of,
    switches_of,
    tied_bodies,
)
from vibsim.physics.connections import base_formulas
from vibsim.physics.formulas import Node, reads
from vibsim.physics.parts import (
    AT_FORCE,
    BASE,
    GROUND,
    ROTOR,
    STATE,
    Friction,
    Harmonic,
    RigidStop,
    Scene,
    Stop,
)

# The equations of motion of a scene, for the peers: one force after the other as its law is printed.
#
# A readable twin of the engine, with which it shares the numbers of the scene and no line: no rows, no
# groups, no modal coordinates. The numbers may be floats, those of heyoka, or those of a `OperationLog`;
# `kit` has sin, cos and exp of them, and what `FormulaReader` needs where a scene has formulas.


Number = Any
Part = Any  # with ends P and Q
Sides = Mapping[Node, Sequence[Number]]  # of the switches of formulas, see `FormulaReader`


@dataclass(frozen=True)
class Shaft:
    """A rotor: angle [rad], speed [rad/s], its body (GROUND without an unbalance), unbalance [kg m], inertia
    [kg m^2]; column : number among the bodies, None of a motor
    """

    angle: Number
    speed: Number
    on: int
    unbalance: float
    inertia: float
    column: int | None


def laid_out(scene: Scene, state: Sequence[Number]) -> tuple[list[Number], list[Number], list[Number]]:
    """x and v of each body of a scene (x of a further state 0, v the state), and phi, phidot of a motor."""
    left = iter(state)
    pairs = [(0.0 if body.kind == STATE else next(left), next(left)) for body in scene.bodies]
    return [x for x, _ in pairs], [v for _, v in pairs], list(left)


def shafts_of(scene: Scene, state: Sequence[Number]) -> list[Shaft]:
    """The rotors, a motor last."""
    x, v, motor = laid_out(scene, state)
    unbalanced = {rotor.column: rotor for rotor in scene.rotors if rotor.unbalance}
    shafts = []
    for i, body in enumerate(scene.bodies):
        if body.kind == ROTOR:
            rotor = unbalanced.get(i)
            on, unbalance = (GROUND, 0.0) if rotor is None else (rotor.on, float(rotor.unbalance))
            shafts.append(Shaft(x[i], v[i], on, unbalance, float(body.m), i))
    if scene.motor is not None:
        p, (phi, w) = scene.motor, motor
        shafts.append(Shaft(phi, w, p.on, p.m3 * p.e, p.J + p.m3 * p.e**2, None))
    return shafts


class Equations:
    """Forces of `scene` at the time t and in the state, laid out as `start_of` says.

    sides : of the switches of formulas; None to find them wherever they are read
    base : displacement, velocity and acceleration of the base [m, m/s, m/s^2]; 0 where there is none
    driven : accelerations of base and belts that time alone gives [m/s^2]
    """

    def __init__(
        self, scene: Scene, kit: Any, t: Number, state: Sequence[Number], sides: Sides | None = None
    ):
        self.scene, self.kit, self.t = scene, kit, t
        self.x, self.v, self.rotor = laid_out(scene, state)
        self.shafts = shafts_of(scene, state)
        self.formulas = FormulaReader(kit, self._inputs(), sides)
        self.base: tuple[Number, Number, Number] = (0.0, 0.0, 0.0)
        if scene.has_base:
            self.base = self._base()
            self.formulas.inputs |= {("x", BASE): self.base[0], ("v", BASE): self.base[1]}
        self.driven = [*[self.base[2]] * scene.has_base, *map(self.formulas.value, course_rates(scene))]

    def _inputs(self) -> dict[Node, Number]:
        """The inputs of formulas, but for the base."""
        inputs: dict[Node, Number] = {("t",): self.t, ("x", GROUND): 0.0, ("v", GROUND): 0.0}
        inputs |= {("x", i): x for i, x in enumerate(self.x)} | {("v", i): v for i, v in enumerate(self.v)}
        return inputs | dict(zip((("phi",), ("w",)), self.rotor, strict=False))

    def _base(self) -> tuple[Number, Number, Number]:
        """X = sum of a sin(omega t + phase) or a formula of time, and its derivatives."""
        if self.scene.base_formula is not None:
            x, v, a = map(self.formulas.value, base_formulas(self.scene))
            return x, v, a
        terms = [(term, term.omega * self.t + term.phase) for term in self.scene.base]
        sines = [self.kit.sin(angle) for _, angle in terms]
        return (
            sum_of(term.amplitude * s for (term, _), s in zip(terms, sines, strict=True)),
            sum_of(term.amplitude * term.omega * self.kit.cos(angle) for term, angle in terms),
            sum_of(-term.amplitude * term.omega**2 * s for (term, _), s in zip(terms, sines, strict=True)),
        )

    def apart(self, part: Part) -> Number:
        """x_P - x_Q [m]."""
        return self._difference(part, self.x, self.base[0])

    def apart_rate(self, part: Part) -> Number:
        """v_P - v_Q [m/s]."""
        return self._difference(part, self.v, self.base[1])

    @staticmethod
    def _difference(part: Part, of_bodies: Sequence[Number], of_base: Number) -> Number:
        of_P, of_Q = (
            of_bodies[end] if end >= 0 else of_base if end == BASE else None for end in (part.P, part.Q)
        )
        if of_Q is None:
            return of_P
        return -of_Q if of_P is None else of_P - of_Q

    def depth(self, stop: Stop | RigidStop) -> Number:
        """g = sense (x_Q - x_P) - gap [m]; less the skin of the kit where its law has a power of it."""
        depth = -stop.sense * self.apart(stop) - stop.gap
        skin = getattr(self.kit, "skin", 0.0) if has_power(stop) else 0.0
        return depth - skin if skin else depth

    def depth_rate(self, stop: Stop | RigidStop) -> Number:
        """dg/dt [m/s]."""
        return -stop.sense * self.apart_rate(stop)

    def contact_force(self, stop: Stop, *acting: Label) -> Number:
        """k g + c g', or its formula [N], of a stop in contact."""
        if stop.force is not None:
            return self.formulas.value(stop.force, *acting)
        force = stop.k * self.depth(stop)
        return force + stop.c * self.depth_rate(stop) if stop.c else force

    def slip_velocity(self, friction: Friction) -> Number:
        """v_rel = v_P - v_Q - belt [m/s]."""
        rate = self.apart_rate(friction)
        rate = rate - friction.belt if friction.belt else rate
        return rate if friction.course is None else rate - self.formulas.value(friction.course)

    def limits(self, friction: Friction, *acting: Label) -> tuple[Number, Number]:
        """The most that it holds against slip forwards and backwards [N]."""
        if friction.holds is None:
            return friction.limits
        forwards, backwards = (self.formulas.value(hold, *acting) for hold in friction.holds)
        return forwards, backwards

    def harmonic(self, term: Harmonic) -> Number:
        """amplitude sin(omega t + phase)."""
        angle = term.omega * self.t
        return term.amplitude * self.kit.sin(angle + term.phase if term.phase else angle)

    def links_and_loads(self) -> list[Number]:
        """On each body the forces of links and of the outside [N]; the torque on each rotor of the scene
        [N m], and the rate of each state.
        """
        totals: list[Number] = [0.0] * len(self.x)
        for link in self.scene.links:
            terms = [k * d for k, d in ((link.k, self.apart(link)), (link.c, self.apart_rate(link))) if k]
            if link.force is not None:
                terms = [self.formulas.value(link.force)]
            if terms:
                self.exert(totals, link, -sum_of(terms))
        for force in self.scene.forces:
            terms = [self.harmonic(term) for term in force.terms if term.amplitude]
            terms += [self.formulas.value(force.formula)] if force.formula is not None else []
            totals[force.on] = sum_of([totals[force.on], *terms, force.constant])
        return totals

    @staticmethod
    def exert(totals: list[Number], part: Part, force: Number) -> None:
        """Add a force on P, and its opposite on Q [N]."""
        if part.P >= 0:
            totals[part.P] = sum_of([totals[part.P], force])
        if part.Q >= 0:
            totals[part.Q] = totals[part.Q] - force


def sum_of(terms: Any) -> Number:
    """The sum; a zero that is no number of the kit is left out."""
    total: Number = 0.0
    for term in terms:
        if isinstance(term, float) and term == 0.0:
            continue
        total = term if isinstance(total, float) and total == 0.0 else total + term
    return total


# Rates of change in a mode, and what ends it, with the mode as parameters.
#
# Parameters are, in this order: for each state of each part 1 or 0, whether the part is in it; the numbers of
# the sides of each switch of formulas; what a mode can change in the matrices of `tied_bodies`, those of the
# ties by part, 0 where a part ties nothing. So a compiled integrator is compiled once for all modes.


class ModeEquations:
    """`rates`, `ties` (force in each part that can tie [N]) and `ends` (event functions) at one point.

    kit, t, state, parameters : numbers of one kind
    acting : 1 or 0 for each state of each part in turn, where those of the parameters are weights of laws in
        between, as of friction that is smoothed; then the sides of formulas are no parameters
    """

    def __init__(
        self,
        scene: Scene,
        kit: Any,
        t: Number,
        state: Sequence[Number],
        parameters: Sequence[Number],
        acting: Sequence[Number] | None = None,
    ):
        self.scene, self.switches, self.turning = scene, switches_of(scene), formula_switches(scene)
        self.kit, self.bodies = kit, len(scene.line)
        left = iter(parameters)
        self.on = [{name: next(left) for name in switch.states} for switch in self.switches]
        sides = {each.key: each.numbers(left) for each in self.turning} if acting is None else None
        self.equations = Equations(scene, kit, t, state, sides)
        flags = iter(acting or [flag for on in self.on for flag in on.values()])
        for i, switch in enumerate(self.switches):
            self.equations.formulas.flags |= {(i, name): next(flags) for name in switch.states}
        together, free = bodies_tied(scene), tied_bodies(scene, ())
        self._mobility = [
            [next(left) if bodies in together else float(free.mobility[bodies]) for bodies in row]
            for row in _pairs(scene)
        ]
        driven = range(driven_count(scene))
        self._driven = [
            [next(left) if (i, i) in together else 0.0 for _ in driven] for i in range(self.bodies)
        ]
        ties = [switch for switch in self.switches if switch.tie]
        self._tie = [
            [next(left) if i in carried else 0.0 for i in range(self.bodies)] for carried in _reach(scene)
        ]
        self._driven_tie = [[next(left) for _ in driven] for _ in ties]
        self.rates, self.ties = self._solve()

    def _solve(self) -> tuple[list[Number], list[Number]]:
        """The equations of motion, those of motor and rotors, Eqs. (2.9), (2.10), among them."""
        forces = self._forces()
        turned = self._turn_shafts(forces)
        a = self._linear(self._mobility, self._driven, forces)
        rates: list[Number] = [rate for pair in zip(self.equations.v, a, strict=False) for rate in pair]
        for i, body in enumerate(self.scene.bodies[self.bodies :], self.bodies):
            rates += [forces[i]] if body.kind == STATE else [self.equations.v[i], turned[i]]
        if self.scene.motor is not None:
            rates += [self.equations.rotor[1], turned[None]]
        return rates, self._linear(self._tie, self._driven_tie, forces)

    def _linear(
        self, matrix: Sequence[Sequence[Number]], of_driven: Sequence[Sequence[Number]], forces: list[Number]
    ) -> list[Number]:
        sums = []
        for row, shares in zip(matrix, of_driven, strict=True):
            terms = [*zip(row, forces, strict=False), *zip(shares, self.equations.driven, strict=True)]
            sums.append(sum_of(factor * other for factor, other in terms if not _is_zero(factor)))
        return sums

    def _forces(self) -> list[Number]:
        """On each body, all forces but those of ties and of rotors [N]."""
        equations = self.equations
        totals = equations.links_and_loads()
        for i, (switch, on) in enumerate(zip(self.switches, self.on, strict=True)):
            part = switch.part
            if isinstance(part, Friction):
                equations.exert(totals, part, self._friction(i, part, on[FORWARD], on[BACKWARD]))
            elif not isinstance(part, RigidStop):
                force = equations.contact_force(part, (i, CONTACT))
                equations.exert(totals, part, part.sense * on[CONTACT] * force)
        return totals

    def _friction(self, i: int, part: Friction, forward: Number, backward: Number) -> Number:
        """Force on P while slipping [N]: against v_rel."""
        if part.slips is None and part.forward == part.backward:
            return (backward - forward) * part.forward
        forwards, backwards = part.slips or (part.forward, part.backward)
        return self._share(backward, backwards, (i, BACKWARD)) - self._share(forward, forwards, (i, FORWARD))

    def _share(self, share: Number, force: Any, acting: Label) -> Number:
        """A share of a force, a number or a formula, which need not have a value where none of it acts."""
        if not isinstance(force, tuple):
            return share * force
        return (
            0.0
            if isinstance(share, float) and share == 0
            else share * self.equations.formulas.value(force, acting)
        )

    def _turn_shafts(self, forces: list[Number]) -> dict[int | None, Number]:
        """The accelerations w' of the rotors, by column, whose reactions on their bodies enter `forces`:

        a = a0 + sum of B u sin(phi) w',  I w' - u sin(phi) a = T

        with u the unbalance, I the inertia about the shaft, T the torque, a0 the accelerations of the bodies
        for w' = 0, and B their mobilities.
        """
        shafts, turned = self.equations.shafts, dict[int | None, Number]()
        unbalanced = [shaft for shaft in shafts if shaft.unbalance]
        for shaft in shafts:
            if not shaft.unbalance:
                turned[shaft.column] = self._torque(shaft, forces) / shaft.inertia
        for shaft in unbalanced:
            push = shaft.unbalance * self.kit.cos(shaft.angle) * (shaft.speed * shaft.speed)
            forces[shaft.on] = forces[shaft.on] + push
        couplings = [(shaft.on, shaft.unbalance * self.kit.sin(shaft.angle)) for shaft in unbalanced]
        rows = []
        for shaft, (on, coupling) in zip(unbalanced, couplings, strict=True):
            a0 = self._linear([self._mobility[on]], [self._driven[on]], forces)[0]
            row: list[Number] = []
            for k, (other, factor) in enumerate(couplings):
                share = self._mobility[on][other]
                row.append(0.0 if _is_zero(share) else -share * (coupling * factor))
                if unbalanced[k] is shaft:
                    row[k] = shaft.inertia + row[k]
            rows.append([*row, self._torque(shaft, forces) + coupling * a0])
        for shaft, (on, coupling), rate in zip(unbalanced, couplings, eliminated(rows), strict=True):
            turned[shaft.column] = rate
            forces[on] = forces[on] + coupling * rate
        return turned

    def _torque(self, shaft: Shaft, forces: Sequence[Number]) -> Number:
        """Of a motor M0 (1 - w / Omega0); of a rotor the sum of what acts on it [N m]."""
        if shaft.column is not None:
            return forces[shaft.column]
        p = self.scene.motor
        assert p is not None
        return p.M0 - p.M0 / p.Omega0 * shaft.speed

    def ends(self, i: int, state: str) -> list[Number]:
        """The event functions of part i in a state: positive inside, zero where the state ends. Parts are
        counted on by the switches of formulas, which have no states by name.
        """
        equations = self.equations
        if i >= len(self.switches):
            return self.turning[i - len(self.switches)].ends(equations.formulas, self.kit.skin)
        part = self.switches[i].part
        if state in (REST, STICK):
            force = self.ties[[each for each in self.switches if each.tie].index(self.switches[i])]
            if state == REST:
                return [force]
            forwards, backwards = equations.limits(part, (i, STICK))
            if part.holds is not None:  # of a load that may become negative, whose square is none
                return [forwards + force, backwards - force]
            return [(forwards + force) * (backwards - force)]
        if isinstance(part, Friction):
            slip = equations.slip_velocity(part)
            return [slip if state == FORWARD else -slip]
        depth = equations.depth(part)
        if state in (FREE, OPEN):
            return [-depth]
        if part.release != AT_FORCE:
            return [depth]
        if part.force is not None:
            force = equations.contact_force(part, (i, state))
            return [depth, force if state == CONTACT else -force]
        force = equations.contact_force(part)
        return [force] if state == CONTACT else [depth, -force]

    def ends_in_any_state(self, i: int) -> list[Number]:
        """The event functions of part i, in the state that the parameters say."""
        if i >= len(self.switches):
            return self.ends(i, "")
        on, switch = self.on[i], self.switches[i]
        if isinstance(switch.part, Friction):
            [slip], [stick, *second] = self.ends(i, FORWARD), self.ends(i, STICK)
            first = (on[FORWARD] - on[BACKWARD]) * slip + on[STICK] * stick
            return [first, *(on[FORWARD] + on[BACKWARD] + on[STICK] * end for end in second)]
        if switch.states == (FREE, CONTACT):
            return [(on[CONTACT] - on[FREE]) * self.equations.depth(switch.part)]
        if isinstance(switch.part, RigidStop):
            [free], [push] = self.ends(i, OPEN), self.ends(i, REST)
            return [on[OPEN] * free + on[REST] * push]
        [free], held, [depth, lifted] = (self.ends(i, state) for state in (FREE, CONTACT, LIFTED))
        if switch.part.force is not None:
            held_depth, held_force = held
            return [
                on[FREE] * free + on[CONTACT] * held_depth + on[LIFTED] * depth,
                on[FREE] + on[CONTACT] * held_force + on[LIFTED] * lifted,
            ]
        [force] = held
        return [
            on[FREE] * free + on[CONTACT] * force + on[LIFTED] * depth,
            on[FREE] + on[CONTACT] - on[LIFTED] * force,
        ]


def _is_zero(value: Number) -> bool:
    return isinstance(value, float) and value == 0.0


def eliminated(rows: Sequence[Sequence[Number]]) -> list[Number]:
    """The solution of linear equations, each row with its right-hand side behind it, by elimination without
    exchange of rows: their matrix is symmetric and positive definite.
    """
    left, done = [list(row) for row in rows], []
    while left:
        first, *rest = left
        done.append(first)
        left = []
        for row in rest:
            factor = row[0] / first[0]
            left.append([a - factor * b for a, b in zip(row[1:], first[1:], strict=True)])
    solution: list[Number] = []
    for first in reversed(done):
        known = sum_of(-a * value for a, value in zip(first[1:-1], solution, strict=True))
        solution.insert(0, sum_of([first[-1], known]) / first[0])
    return solution


def has_power(stop: Stop | RigidStop) -> bool:
    """Whether the law of a stop has a root, or a power that is no whole number."""
    return isinstance(stop, Stop) and stop.force is not None and reads([stop.force], ("pow",))


def _pairs(scene: Scene) -> list[list[tuple[int, int]]]:
    bodies = range(len(scene.line))
    return [[(i, j) for j in bodies] for i in bodies]


def bodies_tied(scene: Scene) -> set[tuple[int, int]]:
    """Pairs of bodies (i, j), i = j among them, that some mode of the scene can tie: elsewhere the mobilities
    of a mode are those of the bodies alone.
    """
    return {(i, j) for group in _groups(scene) for i in group for j in group}


def _groups(scene: Scene) -> list[set[int]]:
    """The bodies that ties join when all of them hold; those that no tie touches are in none."""
    groups: list[set[int]] = []
    for switch in (switch for switch in switches_of(scene) if switch.tie):
        group = {end for end in (switch.part.P, switch.part.Q) if end >= 0}
        joined = [each for each in groups if each & group]
        groups = [each for each in groups if each not in joined] + [group.union(*joined)]
    return groups


def _reach(scene: Scene) -> list[list[int]]:
    """For each part that can tie, the bodies whose forces it can carry."""
    groups = _groups(scene)
    ties = [switch.part for switch in switches_of(scene) if switch.tie]
    return [sorted(next(group for group in groups if {tie.P, tie.Q} & group)) for tie in ties]


def first_sides(scene: Scene) -> list[int]:
    """A side of each switch of formulas, whichever: those of the state follow from its guard."""
    return [0] * len(formula_switches(scene))


def parameter_count(scene: Scene) -> int:
    """How many parameters a mode of `scene` has."""
    return len(parameters_of(scene, [switch.states[0] for switch in switches_of(scene)], first_sides(scene)))


def parameters_of(scene: Scene, states: Sequence[str], sides: Sequence[int]) -> list[float]:
    """The parameters of the mode in which the parts are in `states`, the switches of formulas on `sides`.
    Raises as `tied_bodies`.
    """
    switches = switches_of(scene)
    flags = [
        float(name == state) for switch, state in zip(switches, states, strict=True) for name in switch.states
    ]
    for turning, side in zip(formula_switches(scene), sides, strict=True):
        flags += turning.parameters(side)
    return flags + tie_parameters(scene, states)


def tie_parameters(scene: Scene, states: Sequence[str]) -> list[float]:
    """Those of the matrices of `tied_bodies`. Raises as `tied_bodies`."""
    switches, together, bodies = switches_of(scene), bodies_tied(scene), range(len(scene.line))
    tied = [switch for switch, state in zip(switches, states, strict=True) if state == switch.tie]
    motion = tied_bodies(scene, tied)
    mobility = [motion.mobility[pair] for row in _pairs(scene) for pair in row if pair in together]
    driven = [share for i in bodies if (i, i) in together for share in motion.driven[i]]
    ties = [switch for switch in switches if switch.tie]
    place = [tied.index(switch) if switch in tied else None for switch in ties]
    reach = zip(place, _reach(scene), strict=True)
    force = [0.0 if i is None else motion.force[i, body] for i, carried in reach for body in carried]
    nothing = [0.0] * driven_count(scene)
    of_driven = [share for i in place for share in (nothing if i is None else motion.driven_force[i])]
    return [*map(float, (*mobility, *driven, *force, *of_driven))]


# The equations of a scene as Python functions of time, state and parameters.


class Compiled:
    """`motion`: d state/dt; `balance`: the same and, behind it, the force in each part that can tie [N];
    `parts`: depth and rate of each stop, 0 and the velocity of slip of each friction; `guards`: what the
    sides of the switches of formulas follow from; `driven`: accelerations of base and belts. All are
    functions of time, state and parameters.

    ties : which parts can tie; masses [kg]; rows, of_driven : the bodies, and the shares of base and belts,
    in the displacement of each part's ends; skin : as of an `OperationLog`
    """

    def __init__(self, scene: Scene, skin: float = 0.0):
        self.scene, self.switches, self.turning = scene, switches_of(scene), formula_switches(scene)
        self._sizes, self.skin = (state_count(scene), parameter_count(scene), skin), skin
        self.ties = [i for i, switch in enumerate(self.switches) if switch.tie]
        self.masses = masses(scene).tolist()
        rows, of_driven = rows_of(scene, self.switches)
        self.of_driven = of_driven.tolist()
        self.rows = [[(body, sign) for body, sign in enumerate(row) if sign] for row in rows.tolist()]
        self.parts = self._function(self._displacements)
        self.driven = self._function(lambda at: at.equations.driven)
        self.guards = self._function(
            lambda at: [one.guard(at.equations.formulas, skin) for one in at.turning]
        )
        self.motion = self._function(lambda at: at.rates)
        self.balance = self._function(lambda at: [*at.rates, *at.ties])
        self._laws: dict[int, Callable[..., Any]] = {}
        self._ends: dict[tuple[int, str], list[Callable[..., Any]]] = {}
        self._parameters: dict[tuple[tuple[str, ...], tuple[int, ...]], list[float]] = {}
        self._halts: dict[tuple[int, ...], list[list[float]]] = {}

    def _function(self, numbers: Callable[[ModeEquations], Sequence[Number]]) -> Callable[..., Any]:
        """The function of time, state and parameters that returns these numbers."""
        tape = OperationLog(*self._sizes)
        return tape.function(numbers(ModeEquations(self.scene, tape, tape.t, tape.states, tape.parameters)))

    @staticmethod
    def _displacements(at: ModeEquations) -> list[Number]:
        equations, values = at.equations, []
        for part in (switch.part for switch in at.switches):
            slides = isinstance(part, Friction)
            values += (
                [0.0, equations.slip_velocity(part)]
                if slides
                else [equations.depth(part), equations.depth_rate(part)]
            )
        return values

    def law(self, i: int) -> Callable[..., Any]:
        """Of an elastic stop the force in contact, of a friction the most that it holds forwards and
        backwards [N], as a function that returns a tuple.
        """
        if i not in self._laws:
            part = self.switches[i].part
            self._laws[i] = self._function(
                lambda at: (
                    at.equations.limits(part)
                    if isinstance(part, Friction)
                    else [at.equations.contact_force(part)]
                )
            )
        return self._laws[i]

    def ends(self, i: int, state: str) -> list[Callable[..., Any]]:
        """The event functions of part i in a state, or of a switch of formulas, each as a tuple of one."""
        if (i, state) not in self._ends:
            self._ends[i, state] = [
                self._function(lambda at, place=place: [at.ends(i, state)[place]])  # type: ignore[misc]
                for place in range(self._count(i, state))
            ]
        return self._ends[i, state]

    def _count(self, i: int, state: str) -> int:
        """How many event functions part i has in a state."""
        tape = OperationLog(*self._sizes)
        return len(ModeEquations(self.scene, tape, tape.t, tape.states, tape.parameters).ends(i, state))

    def parameters(self, states: Sequence[str], sides: Sequence[int] | None = None) -> list[float]:
        """Those of the mode of these states, and sides of switches of formulas. Raises ArithmeticError where
        its ties are not unique.
        """
        key = tuple(states), tuple(first_sides(self.scene) if sides is None else sides)
        if key not in self._parameters:
            self._parameters[key] = parameters_of(self.scene, *key)
        return self._parameters[key]

    def halts(self, parts: Sequence[int]) -> list[list[float]]:
        """Impulsive changes that take unit rates of the displacements of these parts to zero, masses
        weighing: change of the velocity of each body (bodies, parts).
        """
        key = tuple(parts)
        if key not in self._halts:
            rows = rows_of(self.scene, [self.switches[i] for i in parts])[0]
            through = rows.T / np.array(self.masses)[:, None]
            self._halts[key] = (-through @ np.linalg.pinv(rows @ through)).tolist()
        return self._halts[key]


def state_count(scene: Scene) -> int:
    """How many states a scene has: displacement and velocity of each body and rotor, one of each further
    state.
    """
    return sum(1 if body.kind == STATE else 2 for body in scene.bodies) + 2 * scene.has_motor


def start_of(scene: Scene) -> list[float]:
    """The state at t = 0: x, v of each body in turn, angle and speed of each rotor, further states
    (, phi, phidot) [m, m/s, rad, rad/s].
    """
    state: list[float] = []
    for body in scene.bodies:
        state += [float(body.v)] if body.kind == STATE else [float(body.x), float(body.v)]
    motor = scene.motor
    return state if motor is None else [*state, float(motor.phi), float(motor.phidot)]
