"""The equations of motion of a scene, for the peers: one force after the other as its law is printed.

A readable twin of the engine, with which it shares the numbers of the scene and no line: no rows, no groups,
no modal coordinates. The numbers may be floats, those of heyoka, or those of a `Tape`; `kit` has sin, cos and
exp of them.
"""

from collections.abc import Sequence
from typing import Any

from vibsim.physics.friction_laws import EXPONENTIAL
from vibsim.physics.parts import BASE, Fall, Friction, Harmonic, RigidStop, Scene, Stop

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
