"""What the numbers of a case imply: natural frequencies and the friction band, for `vibsim check -v`."""

from math import pi, sqrt
from typing import NamedTuple

from vibsim.physics.parts import Friction
from vibsim.physics.parts import Scene as PartsScene
from vibsim.physics.rates import natural_rates
from vibsim.physics.two_blocks import TwoBlocks


class Fact(NamedTuple):
    """A number that follows from the case, with its unit and where it comes from."""

    name: str
    value: float
    unit: str
    meaning: str


def derived_facts(scene: TwoBlocks) -> list[Fact]:
    """Facts of a scene; those that need what it has not got are left out."""
    return [*_frequencies(scene), *_damping(scene), *_forces(scene)]


def facts_of_parts(scene: PartsScene) -> list[Fact]:
    """Natural frequencies with all stops open and closed, and friction limits, of named parts."""
    facts = []
    elastic = [stop for _, stop in scene.elastic_stops]
    for words, closed in (("stops open", []), ("stops closed", elastic)):
        if words == "stops closed" and not elastic:
            continue
        for i, rate in enumerate(natural_rates(scene, closed), 1):
            facts.append(
                Fact(f"{words.split()[1]} {i}", rate / (2 * pi), "Hz", f"natural frequency, {words}")
            )
    for friction in scene.frictions:
        facts += _friction_forces(friction)
    return facts


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


def excited_mass(scene: TwoBlocks) -> float:
    """Mass that moves with block 1 [kg]: m1, with a motor m1 + m3."""
    return scene.m1 + (scene.m3 if scene.has_motor else 0.0)


def reduced_mass(scene: TwoBlocks) -> float:
    """Mass of the relative motion [kg]: 1/(1/m1 + 1/m2), or m1 before a wall; with a motor m1 + m3."""
    mass = excited_mass(scene)
    return 1 / (1 / mass + 1 / scene.m2) if scene.has_block2 else mass


def frequency(stiffness: float, mass: float) -> float:
    """Natural frequency [Hz] of a mass [kg] on a spring [N/m]."""
    return sqrt(stiffness / mass) / (2 * pi)


def _frequencies(scene: TwoBlocks) -> list[Fact]:
    block, mass = excited_mass(scene), reduced_mass(scene)
    name = "(m1 + m3)" if scene.has_motor else "m1"
    facts = [Fact("block 1 on its spring", frequency(scene.k1, block), "Hz", f"sqrt(k1/{name})/(2 pi)")]
    free = frequency(scene.k1, mass)
    if scene.has_block2:
        facts.append(Fact("free", free, "Hz", "blocks against each other, no friction, stop open"))
    if scene.has_stop:
        contact = frequency(scene.k1 + scene.k2, mass)
        facts.append(Fact("in contact", contact, "Hz", "the same with k1 + k2"))
        facts.append(
            Fact(
                "bilinear", 2 * free * contact / (free + contact), "Hz", "2 f1 f2/(f1 + f2), large vibration"
            )
        )
    return facts


def _damping(scene: TwoBlocks) -> list[Fact]:
    if scene.k1 == 0:
        return []
    ratio = scene.c / (2 * sqrt(scene.k1 * reduced_mass(scene)))
    return [Fact("damping ratio", ratio, "", "c/(2 sqrt(k1 m)), stop open")]


def _forces(scene: TwoBlocks) -> list[Fact]:
    facts = []
    if scene.has_friction:
        facts.append(Fact("limit friction force", scene.N, "N", "mu m2 g"))
        if scene.k1:
            facts.append(
                Fact("friction band", scene.N / scene.k1, "m", "N/k1; inside it block 2 can stay at rest")
            )
    if scene.has_motor:
        inertia = scene.J + scene.m3 * scene.e**2
        run_up = scene.Omega0 * inertia / scene.M0 if scene.M0 else None
        facts += [Fact("run-up time constant", run_up, "s", "Omega0 (J + m3 e^2)/M0")] if run_up else []
        facts.append(
            Fact("full force", scene.m3 * abs(scene.e) * scene.Omega0**2, "N", "m3 e Omega0^2, Eq. (2.11)")
        )
    return facts
