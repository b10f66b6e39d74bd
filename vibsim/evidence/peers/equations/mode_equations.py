"""Rates of change in a mode, and what ends it, with the mode as parameters.

Parameters are, in this order: for each state of each part 1 or 0, whether the part is in it; what a mode can
change in the matrices of `tied_bodies`, those of the ties by part, 0 where a part ties nothing. So a compiled
integrator is compiled once for all modes.
"""

from collections.abc import Sequence
from typing import Any

from vibsim.evidence.peers.equations.of_motion import Equations, Number, sum_of
from vibsim.evidence.peers.equations.switches import (
    BACKWARD,
    CONTACT,
    FORWARD,
    FREE,
    LIFTED,
    OPEN,
    REST,
    STICK,
    switches_of,
)
from vibsim.evidence.peers.equations.tied_bodies import tied_bodies
from vibsim.physics.parts import AT_FORCE, Friction, RigidStop, Scene


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
