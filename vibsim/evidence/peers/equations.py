"""The equations of a scene, one force after the other as its law is printed, and compiled to Python."""

from collections.abc import Callable, Sequence
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
    OperationLog,
    masses,
    rows_of,
    switches_of,
    tied_bodies,
)
from vibsim.physics.parts import AT_FORCE, BASE, EXPONENTIAL, Fall, Friction, Harmonic, RigidStop, Scene, Stop

# The equations of motion of a scene, for the peers: one force after the other as its law is printed.
#
# A readable twin of the engine, with which it shares the numbers of the scene and no line: no rows, no
# groups, no modal coordinates. The numbers may be floats, those of heyoka, or those of a `OperationLog`;
# `kit` has sin, cos and exp of them.


Number = Any
Part = Any  # with ends P and Q


class Equations:
    """Forces of `scene` at the time t and in the state x, v of each body in turn (, phi, phidot).

    base : displacement, velocity and acceleration of the base [m, m/s, m/s^2]; 0 where there is none
    """

    def __init__(self, scene: Scene, kit: Any, t: Number, state: Sequence[Number]):
        self.scene, self.kit, self.t = scene, kit, t
        bodies = len(scene.bodies)
        self.x, self.v = list(state[0 : 2 * bodies : 2]), list(state[1 : 2 * bodies : 2])
        self.rotor = list(state[2 * bodies :])
        self.base: tuple[Number, Number, Number] = (0.0, 0.0, 0.0)
        if scene.base:
            self.base = self._base()

    def _base(self) -> tuple[Number, Number, Number]:
        """X = sum of a sin(omega t + phase), and its derivatives."""
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
        """g = sense (x_Q - x_P) - gap [m]."""
        return -stop.sense * self.apart(stop) - stop.gap

    def depth_rate(self, stop: Stop | RigidStop) -> Number:
        """dg/dt [m/s]."""
        return -stop.sense * self.apart_rate(stop)

    def contact_force(self, stop: Stop) -> Number:
        """k g + c g' [N], of a stop in contact."""
        force = stop.k * self.depth(stop)
        return force + stop.c * self.depth_rate(stop) if stop.c else force

    def slip_velocity(self, friction: Friction) -> Number:
        """v_rel = v_P - v_Q - belt [m/s]."""
        rate = self.apart_rate(friction)
        return rate - friction.belt if friction.belt else rate

    def slip_force(self, constant: Number, fall: Fall | None, speed: Number) -> Number:
        """Friction force at the speed of slip |v_rel| [N]."""
        if fall is None:
            return constant
        s = fall.rate * speed
        return constant + fall.drop * (self.kit.exp(-s) if fall.law == EXPONENTIAL else 1.0 / (1.0 + s))

    def harmonic(self, term: Harmonic) -> Number:
        """amplitude sin(omega t + phase)."""
        angle = term.omega * self.t
        return term.amplitude * self.kit.sin(angle + term.phase if term.phase else angle)

    def links_and_loads(self) -> list[Number]:
        """On each body, the forces of links and of the outside [N]."""
        totals: list[Number] = [0.0] * len(self.x)
        for link in self.scene.links:
            terms = [k * d for k, d in ((link.k, self.apart(link)), (link.c, self.apart_rate(link))) if k]
            if terms:
                self.exert(totals, link, -sum_of(terms))
        for force in self.scene.forces:
            terms = [self.harmonic(term) for term in force.terms if term.amplitude]
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
# Parameters are, in this order: for each state of each part 1 or 0, whether the part is in it; what a mode
# can change in the matrices of `tied_bodies`, those of the ties by part, 0 where a part ties nothing. So a
# compiled integrator is compiled once for all modes.


class ModeEquations:
    """`rates`, `ties` (force in each part that can tie [N]) and `ends` (event functions) at one point.

    kit, t, state, parameters : numbers of one kind
    """

    def __init__(
        self, scene: Scene, kit: Any, t: Number, state: Sequence[Number], parameters: Sequence[Number]
    ):
        self.scene, self.switches = scene, switches_of(scene)
        self.equations = Equations(scene, kit, t, state)
        self.kit, self.bodies = kit, len(scene.bodies)
        left = iter(parameters)
        self.on = [{name: next(left) for name in switch.states} for switch in self.switches]
        together, free = bodies_tied(scene), tied_bodies(scene, ())
        self._mobility = [
            [next(left) if bodies in together else float(free.mobility[bodies]) for bodies in row]
            for row in _pairs(scene)
        ]
        self._base = [next(left) if scene.base and (i, i) in together else 0.0 for i in range(self.bodies)]
        ties = [switch for switch in self.switches if switch.tie]
        self._tie = [
            [next(left) if i in carried else 0.0 for i in range(self.bodies)] for carried in _reach(scene)
        ]
        self._base_tie = [next(left) if scene.base else 0.0 for _ in ties]
        self.rates, self.ties = self._solve()

    def _solve(self) -> tuple[list[Number], list[Number]]:
        forces, spin = self._forces(), []
        if self.scene.motor is not None:
            spin = [self.equations.rotor[1], self._turn_rotor(forces)]
        a = self._linear(self._mobility, self._base, forces)
        rates = [rate for pair in zip(self.equations.v, a, strict=True) for rate in pair]
        return rates + spin, self._linear(self._tie, self._base_tie, forces)

    def _linear(
        self, matrix: Sequence[Sequence[Number]], of_base: Sequence[Number], forces: Sequence[Number]
    ) -> list[Number]:
        sums = []
        for row, share in zip(matrix, of_base, strict=True):
            terms = [*zip(row, forces, strict=True), (share, self.equations.base[2])]
            sums.append(sum_of(factor * other for factor, other in terms if not _is_zero(factor)))
        return sums

    def _forces(self) -> list[Number]:
        """On each body, all forces but those of ties and of the rotor [N]."""
        equations = self.equations
        totals = equations.links_and_loads()
        for switch, on in zip(self.switches, self.on, strict=True):
            part = switch.part
            if isinstance(part, Friction):
                equations.exert(totals, part, self._friction(part, on[FORWARD], on[BACKWARD]))
            elif not isinstance(part, RigidStop):
                equations.exert(totals, part, part.sense * on[CONTACT] * equations.contact_force(part))
        return totals

    def _friction(self, part: Friction, forward: Number, backward: Number) -> Number:
        """Force on P while slipping [N]: against v_rel."""
        slip_force, sign = self.equations.slip_force, forward - backward
        falls = part.fall_forward is not None or part.fall_backward is not None
        speed = sign * self.equations.slip_velocity(part) if falls else 0.0
        if (part.forward, part.fall_forward) == (part.backward, part.fall_backward):
            return -sign * slip_force(part.forward, part.fall_forward, speed)
        return backward * slip_force(part.backward, part.fall_backward, speed) - forward * slip_force(
            part.forward, part.fall_forward, speed
        )

    def _turn_rotor(self, forces: list[Number]) -> Number:
        """The acceleration of the rotor, Eqs. (2.9), (2.10), whose reaction on its body enters `forces`:

        a = a0 + B m3 e sin(phi) w',  (J + m3 e^2) w' - m3 e sin(phi) a = M0 (1 - w / Omega0)

        with a0 the acceleration of the body for w' = 0, and B its mobility.
        """
        p, (phi, w) = self.scene.motor, self.equations.rotor
        assert p is not None
        unbalance = p.m3 * p.e
        coupling = unbalance * self.kit.sin(phi)
        forces[p.on] = forces[p.on] + unbalance * self.kit.cos(phi) * (w * w)
        a0 = self._linear([self._mobility[p.on]], [self._base[p.on]], forces)[0]
        torque = p.M0 - p.M0 / p.Omega0 * w
        inertia = p.J + p.m3 * p.e**2 - self._mobility[p.on][p.on] * (coupling * coupling)
        rate = (torque + coupling * a0) / inertia
        forces[p.on] = forces[p.on] + coupling * rate
        return rate

    def ends(self, i: int, state: str) -> list[Number]:
        """The event functions of part i in a state: positive inside, zero where the state ends."""
        part, equations = self.switches[i].part, self.equations
        if state in (REST, STICK):
            force = self.ties[[each for each in self.switches if each.tie].index(self.switches[i])]
            forwards, backwards = part.limits if state == STICK else (0.0, 0.0)
            return [force] if state == REST else [(forwards + force) * (backwards - force)]
        if isinstance(part, Friction):
            slip = equations.slip_velocity(part)
            return [slip if state == FORWARD else -slip]
        depth = equations.depth(part)
        if state in (FREE, OPEN):
            return [-depth]
        if part.release != AT_FORCE:
            return [depth]
        force = equations.contact_force(part)
        return [force] if state == CONTACT else [depth, -force]

    def ends_in_any_state(self, i: int) -> list[Number]:
        """The event functions of part i, in the state that the parameters say."""
        on, switch = self.on[i], self.switches[i]
        if isinstance(switch.part, Friction):
            [slip], [stick] = self.ends(i, FORWARD), self.ends(i, STICK)
            return [(on[FORWARD] - on[BACKWARD]) * slip + on[STICK] * stick]
        if switch.states == (FREE, CONTACT):
            return [(on[CONTACT] - on[FREE]) * self.equations.depth(switch.part)]
        if isinstance(switch.part, RigidStop):
            [free], [push] = self.ends(i, OPEN), self.ends(i, REST)
            return [on[OPEN] * free + on[REST] * push]
        [free], [force], [depth, _] = (self.ends(i, state) for state in (FREE, CONTACT, LIFTED))
        return [
            on[FREE] * free + on[CONTACT] * force + on[LIFTED] * depth,
            on[FREE] + on[CONTACT] - on[LIFTED] * force,
        ]


def _is_zero(value: Number) -> bool:
    return isinstance(value, float) and value == 0.0


def _pairs(scene: Scene) -> list[list[tuple[int, int]]]:
    bodies = range(len(scene.bodies))
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


def parameter_count(scene: Scene) -> int:
    """How many parameters a mode of `scene` has."""
    return len(parameters_of(scene, [switch.states[0] for switch in switches_of(scene)]))


def parameters_of(scene: Scene, states: Sequence[str]) -> list[float]:
    """The parameters of the mode in which the parts are in `states`. Raises as `tied_bodies`."""
    switches, together, bodies = switches_of(scene), bodies_tied(scene), range(len(scene.bodies))
    flags = [
        float(name == state) for switch, state in zip(switches, states, strict=True) for name in switch.states
    ]
    tied = [switch for switch, state in zip(switches, states, strict=True) if state == switch.tie]
    motion = tied_bodies(scene, tied)
    mobility = [motion.mobility[pair] for row in _pairs(scene) for pair in row if pair in together]
    base = [motion.base[i] for i in bodies if scene.base and (i, i) in together]
    ties = [switch for switch in switches if switch.tie]
    place = [tied.index(switch) if switch in tied else None for switch in ties]
    reach = zip(place, _reach(scene), strict=True)
    force = [0.0 if i is None else motion.force[i, body] for i, carried in reach for body in carried]
    of_base = [0.0 if i is None else motion.base_force[i] for i in place if scene.base]
    return [*flags, *map(float, (*mobility, *base, *force, *of_base))]


# The equations of a scene as Python functions of time, state and parameters.


class Compiled:
    """`motion`: d state/dt; `balance`: the same and, behind it, the force in each part that can tie [N];
    `parts`: depth and rate of each stop, 0 and the velocity of slip of each friction.

    ties : which parts can tie; masses [kg]; rows, of_base : the bodies, and the share of the base, in the
    displacement of each part's ends
    """

    def __init__(self, scene: Scene):
        self.scene, self.switches = scene, switches_of(scene)
        self._sizes = state_count(scene), parameter_count(scene)
        self.ties = [i for i, switch in enumerate(self.switches) if switch.tie]
        self.masses = masses(scene).tolist()
        rows, of_base = rows_of(scene, self.switches)
        self.of_base = of_base.tolist()
        self.rows = [[(body, sign) for body, sign in enumerate(row) if sign] for row in rows.tolist()]
        self.parts = self._displacements()
        self._base = self._base_motion()
        tape, equations = self._equations()
        self.motion = tape.function(equations.rates)
        self.balance = tape.function([*equations.rates, *equations.ties])
        self._ends: dict[tuple[int, str], list[Callable[..., Any]]] = {}
        self._parameters: dict[tuple[str, ...], list[float]] = {}
        self._halts: dict[tuple[int, ...], list[list[float]]] = {}

    def _equations(self) -> tuple[OperationLog, ModeEquations]:
        tape = OperationLog(*self._sizes)
        return tape, ModeEquations(self.scene, tape, tape.t, tape.states, tape.parameters)

    def _displacements(self) -> Callable[..., tuple[float, ...]]:
        """Depth and rate of each stop; 0 and the velocity of slip of each friction."""
        tape = OperationLog(self._sizes[0])
        at, values = Equations(self.scene, tape, tape.t, tape.states), []
        for part in (switch.part for switch in self.switches):
            slides = isinstance(part, Friction)
            values += [0.0, at.slip_velocity(part)] if slides else [at.depth(part), at.depth_rate(part)]
        return tape.function(values)

    def _base_motion(self) -> Callable[..., tuple[float, ...]]:
        tape = OperationLog(self._sizes[0])
        return tape.function(Equations(self.scene, tape, tape.t, tape.states).base)

    def base_acceleration(self, t: float) -> float:
        """X'' [m/s^2]."""
        return self._base(t, [0.0] * self._sizes[0])[2] if self.scene.base else 0.0

    def ends(self, i: int, state: str) -> list[Callable[..., Any]]:
        """The event functions of part i in a state, each as a tuple of one."""
        if (i, state) not in self._ends:
            count = len(self._equations()[1].ends(i, state))
            self._ends[i, state] = [self._end(i, state, place) for place in range(count)]
        return self._ends[i, state]

    def _end(self, i: int, state: str, place: int) -> Callable[..., Any]:
        tape, equations = self._equations()
        return tape.function([equations.ends(i, state)[place]])

    def parameters(self, states: Sequence[str]) -> list[float]:
        """Those of the mode of these states. Raises ArithmeticError where its ties are not unique."""
        key = tuple(states)
        if key not in self._parameters:
            self._parameters[key] = parameters_of(self.scene, states)
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
    """How many states a scene has: displacement and velocity of each body, angle and speed of a rotor."""
    return 2 * len(scene.bodies) + 2 * scene.has_motor


def start_of(scene: Scene) -> list[float]:
    """The state at t = 0: x, v of each body in turn (, phi, phidot) [m, m/s, rad, rad/s]."""
    state = [float(value) for body in scene.bodies for value in (body.x, body.v)]
    motor = scene.motor
    return state if motor is None else [*state, float(motor.phi), float(motor.phidot)]
