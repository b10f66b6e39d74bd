"""Energy and momentum of a scene that loses none: what a conservative orbit is told by."""

from dataclasses import replace
from typing import Any

import numpy as np

from vibsim.orbits.matrices import dot, product
from vibsim.physics.body_sets import body_sets
from vibsim.physics.parts import Scene
from vibsim.physics.rates import masses

ENERGY = "energy"  # stands for a key of the case where orbits are continued in their energy


def without_still_sources(scene: Scene) -> Scene:
    """The scene without harmonics of amplitude 0, whose clock nothing hears."""

    forces = tuple(
        replace(force, terms=tuple(term for term in force.terms if term.amplitude != 0))
        for force in scene.forces
    )
    return replace(scene, forces=forces, base=tuple(term for term in scene.base if term.amplitude != 0))


def what_is_not_conservative(scene: Scene) -> list[str]:
    """The parts that give or take energy, in words; none where energy is kept."""
    parts = ["the motor"] if scene.motor is not None else []
    parts += [f"the force {one.name}" for one in scene.forces if any(t.amplitude != 0 for t in one.terms)]
    parts += ["the moving base"] * any(term.amplitude != 0 for term in scene.base)
    parts += [f"the damper of link {one.name}" for one in scene.links if one.c != 0]
    parts += [f"the damper of stop {one.name}" for _, one in scene.elastic_stops if one.c != 0]
    parts += [f"the restitution of stop {one.name}" for _, one in scene.rigid_stops if one.e != 1]
    return parts + [f"the friction {one.name}" for one in scene.frictions if any(one.limits)]


class Conserved:
    """Energy [J], and momenta [N s] of the sets of bodies that nothing holds, by the unknowns of an orbit.

    Displacements count from the references, which rest at 0; constant forces have a potential.
    """

    def __init__(self, scene: Scene, at: Any):
        self.scene, self.at, self.m = scene, at, masses(scene)
        self.n = len(scene.bodies)
        sets = [one for one in body_sets(scene, [*scene.links, *scene.stops]) if not one.held]
        rows = np.zeros((len(sets), 2 * self.n))
        for row, one in zip(rows, sets, strict=True):
            row[[self.n + body for body in one.bodies]] = self.m[list(one.bodies)]
        self.rows = rows[[len(one.bodies) > 1 for one in sets]]
        self._kept = rows

    def energy(self, X: np.ndarray) -> float:
        """Kinetic energy, that of springs and of elastic stops in contact, potential of constant forces."""
        state = self.at.lifted(X)
        x, v = state[: self.n], state[self.n :]
        springs = sum(link.k * self._apart(x, link) ** 2 for link in self.scene.links)
        stops = sum(stop.k * max(0.0, self._depth(x, stop)) ** 2 for _, stop in self.scene.elastic_stops)
        loads = sum(force.constant * x[force.on] for force in self.scene.forces)
        return float((dot(self.m, v * v) + springs + stops) / 2 - loads)

    def gradient(self, X: np.ndarray) -> np.ndarray:
        """Derivative of the energy by the unknowns."""
        state = self.at.lifted(X)
        x, slope = state[: self.n], np.concatenate([np.zeros(self.n), self.m * state[self.n :]])
        pulls: list[tuple[Any, float]] = [(link, link.k * self._apart(x, link)) for link in self.scene.links]
        pulls += [(s, -s.sense * s.k * max(0.0, self._depth(x, s))) for _, s in self.scene.elastic_stops]
        for part, pull in pulls:
            for end, sign in ((part.P, 1), (part.Q, -1)):
                if end >= 0:
                    slope[end] += sign * pull
        for force in self.scene.forces:
            slope[force.on] -= force.constant
        return np.asarray(slope[self.at.free])

    def momenta(self, X: np.ndarray) -> np.ndarray:
        """Of each set that nothing holds."""
        return product(self.rows, self.at.lifted(X))

    @property
    def momentum_rows(self) -> np.ndarray:
        """Derivative of the momenta by the unknowns."""
        return np.asarray(self.rows[:, self.at.free])

    @property
    def kept_rows(self) -> np.ndarray:
        """The same with those of bodies that nothing joins to another, whose velocity is kept."""
        return np.asarray(self._kept[:, self.at.free])

    def _apart(self, x: np.ndarray, part: Any) -> float:
        return float(sum(sign * x[end] for end, sign in ((part.P, 1), (part.Q, -1)) if end >= 0))

    def _depth(self, x: np.ndarray, stop: Any) -> float:
        return float(-stop.sense * self._apart(x, stop) - stop.gap)
