"""Frequencies at which a motor of limited power may be captured."""

from dataclasses import dataclass

from vibsim.cases.derived_facts import frequency, reduced_mass
from vibsim.physics.two_blocks import TwoBlocks


@dataclass(frozen=True)
class Resonance:
    """A frequency [Hz] of the relative motion, friction and damping left out."""

    name: str
    hz: float


def resonances(scene: TwoBlocks, impacting: bool) -> tuple[Resonance, ...]:
    """Where the relative vibration answers most, ascending.

    Without impacts its natural frequency f1 = sqrt(k1/m)/2 pi, m the reduced mass. With impacts, in the limit
    of large amplitudes, the bilinear frequency 2 f1 f2/(f1 + f2), f2 = sqrt((k1 + k2)/m)/2 pi, and half of
    it: a superharmonic resonance, in which the blocks vibrate and strike twice in a turn of the rotor.
    """
    if not scene.k1:
        return ()
    free = frequency(scene.k1, reduced_mass(scene))
    if not (impacting and scene.has_stop):
        return (Resonance("free", free),)
    contact = frequency(scene.k1 + scene.k2, reduced_mass(scene))
    bilinear = 2 * free * contact / (free + contact)
    return Resonance("half bilinear", bilinear / 2), Resonance("bilinear", bilinear)
