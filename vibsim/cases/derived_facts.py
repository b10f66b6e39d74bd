"""What the numbers of a case imply: natural frequencies, friction, the motor; for `vibsim check -v`."""

from collections.abc import Iterator
from math import pi, sqrt
from typing import NamedTuple

from vibsim.physics.parts import GROUND, Friction, Link, Motor, Scene
from vibsim.physics.rates import (
    bilinear_frequencies,
    frequency,
    masses,
    natural_rates,
    reduced_mass,
)
from vibsim.physics.two_blocks import is_papers


class Fact(NamedTuple):
    """A number that follows from the case, with its unit and where it comes from."""

    name: str
    value: float
    unit: str
    meaning: str


def derived_facts(scene: Scene) -> list[Fact]:
    """Facts of a scene, of the paper's two blocks by the paper's symbols; those that need a missing part
    are left out.
    """
    if is_papers(scene):
        return [*_of_blocks(scene, scene.links[0]), *_of_motor(scene.motor)]
    frictions = [fact for friction in scene.frictions for fact in _friction_forces(friction)]
    return [*_frequencies(scene), *frictions, *_of_motor(scene.motor)]


def _frequencies(scene: Scene) -> Iterator[Fact]:
    """Natural frequencies with all stops open and closed, and those of large vibrations."""
    elastic = [stop for _, stop in scene.elastic_stops]
    for words, closed in (("stops open", []), ("stops closed", elastic)):
        if words == "stops closed" and not elastic:
            continue
        for i, rate in enumerate(natural_rates(scene, closed), 1):
            yield Fact(f"{words.split()[1]} {i}", rate / (2 * pi), "Hz", f"natural frequency, {words}")
    for i, hertz in enumerate(bilinear_frequencies(scene), 1):
        yield Fact(f"bilinear {i}", hertz, "Hz", "2 f1 f2/(f1 + f2), large vibration")


def _friction_forces(friction: Friction) -> list[Fact]:
    """Limits while sticking, and the forces while slipping where these are lower."""
    limits, forces = friction.limits, (friction.forward, friction.backward)
    falls = friction.fall_forward, friction.fall_backward
    alike = limits[0] == limits[1] and forces[0] == forces[1] and falls[0] == falls[1]
    facts = []
    for i, side in enumerate(("",) if alike else (" plus", " minus")):
        facts.append(Fact(friction.name + side, limits[i], "N", "limit friction force"))
        if forces[i] != limits[i]:
            words = "at high speed" if falls[i] else "while slipping"
            facts.append(Fact(f"{friction.name}{side}", forces[i], "N", f"friction force {words}"))
    return facts


def _of_blocks(scene: Scene, coupling: Link) -> Iterator[Fact]:
    """Frequencies, damping and friction of two blocks, or of block 1 before a wall."""
    k1, mass = coupling.k, reduced_mass(scene, coupling.P, coupling.Q)
    own = "(m1 + m3)" if scene.has_motor else "m1"
    held = frequency(k1, float(masses(scene)[coupling.P]))
    yield Fact("block 1 on its spring", held, "Hz", f"sqrt(k1/{own})/(2 pi)")
    free = frequency(k1, mass)
    if coupling.Q != GROUND:
        yield Fact("free", free, "Hz", "blocks against each other, no friction, stop open")
    for _, stop in scene.elastic_stops:
        contact = frequency(k1 + stop.k, mass)
        yield Fact("in contact", contact, "Hz", "the same with k1 + k2")
        bilinear = 2 * free * contact / (free + contact)
        yield Fact("bilinear", bilinear, "Hz", "2 f1 f2/(f1 + f2), large vibration")
    if k1:
        ratio = coupling.c / (2 * sqrt(k1 * mass))
        yield Fact("damping ratio", ratio, "", "c/(2 sqrt(k1 m)), stop open")
    for friction in scene.frictions:
        yield Fact("limit friction force", friction.forward, "N", "mu m2 g")
        if k1:
            yield Fact(
                "friction band", friction.forward / k1, "m", "N/k1; inside it block 2 can stay at rest"
            )


def _of_motor(motor: Motor | None) -> Iterator[Fact]:
    if motor is None:
        return
    if motor.M0:
        run_up = motor.Omega0 * (motor.J + motor.m3 * motor.e**2) / motor.M0
        yield Fact("run-up time constant", run_up, "s", "Omega0 (J + m3 e^2)/M0")
    yield Fact("full force", motor.m3 * abs(motor.e) * motor.Omega0**2, "N", "m3 e Omega0^2, Eq. (2.11)")
