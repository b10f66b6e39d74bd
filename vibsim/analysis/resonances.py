"""Frequencies at which a motor of limited power may be captured."""

from dataclasses import dataclass
from math import pi

from vibsim.physics.parts import Scene
from vibsim.physics.rates import bilinear_frequencies, natural_rates


@dataclass(frozen=True)
class Resonance:
    """A frequency [Hz] of the vibration, friction and damping left out."""

    name: str
    hz: float


def resonances(scene: Scene, impacting: bool) -> tuple[Resonance, ...]:
    """Where the vibration answers most, ascending; numbered where there are several of a kind.

    Without impacts, and with those on rigid stops alone, its natural frequencies f1, all stops open. With
    impacts on elastic stops, in the limit of large amplitudes, the bilinear frequencies 2 f1 f2/(f1 + f2), f2
    with all stops closed, and half of them: superharmonic resonances, in which the bodies vibrate and strike
    twice in a turn of the rotor.
    """
    if not (impacting and scene.elastic_stops):
        return _named("free", [rate / (2 * pi) for rate in natural_rates(scene)])
    bilinear = bilinear_frequencies(scene)
    frequencies = _named("half bilinear", [hz / 2 for hz in bilinear]) + _named("bilinear", bilinear)
    return tuple(sorted(frequencies, key=lambda one: one.hz))


def _named(kind: str, frequencies: list[float]) -> tuple[Resonance, ...]:
    if len(frequencies) == 1:
        return (Resonance(kind, frequencies[0]),)
    return tuple(Resonance(f"{kind} {i}", hz) for i, hz in enumerate(frequencies, 1))
