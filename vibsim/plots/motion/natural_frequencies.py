"""Frequencies at which the scene itself likes to vibrate, and the rhythm of its source."""

from __future__ import annotations

import math
from dataclasses import dataclass

from vibsim.physics import rates
from vibsim.physics.parts import GROUND, Motor, Scene
from vibsim.physics.two_blocks import is_papers

MOST = 6  # natural frequencies that are named


@dataclass(frozen=True)
class Frequency:
    """A frequency [Hz] and its name, plain and as a mathtext label."""

    name: str
    label: str
    hz: float


def natural_frequencies(scene: Scene) -> list[Frequency]:
    """Linear and bilinear frequencies of the vibration (without friction and damping).

    Of the paper's two blocks sqrt(k1 / m1), the paper's natural frequency (block 2 held), and free-free: the
    blocks against each other, the motor's m3 counted to block 1; of other scenes f1, f2, ... with all stops
    open. Where there is one vibration with a stop, f1 without and f2 with the stop give the bilinear
    2 f1 f2 / (f1 + f2), the limit of large amplitudes, and half of it (a subharmonic of the impacting
    motion).
    """
    hertz = [rate / (2 * math.pi) for rate in rates.natural_rates(scene)]
    frequencies = _papers(scene, hertz[0]) if hertz and is_papers(scene) else []
    frequencies = frequencies or [
        Frequency(f"f{i}", f"$f_{{{i}}}$", hz) for i, hz in enumerate(hertz[:MOST], 1)
    ]
    bilinear = rates.bilinear_frequencies(scene)
    if len(bilinear) == 1:
        frequencies.append(Frequency("bilinear", "bilinear", bilinear[0]))
        frequencies.append(Frequency("half bilinear", "½ bilinear", bilinear[0] / 2))
    return frequencies


def _papers(scene: Scene, free: float) -> list[Frequency]:
    """Those of the two blocks of the paper, or of block 1 before a wall."""
    coupling = scene.links[0]
    held = rates.frequency(coupling.k, scene.bodies[coupling.P].m)
    frequencies = [Frequency("held", r"$\sqrt{k_1/m_1}$", held)]
    if coupling.Q != GROUND:
        frequencies.append(Frequency("free-free", "free–free", free))
    elif scene.has_motor:
        frequencies.append(Frequency("with motor", r"$\sqrt{k_1/(m_1+m_3)}$", free))
    return frequencies


def fractions(scene: Scene) -> list[Frequency]:
    """Fractions of the frequencies at which a motion with impacts may resonate too.

    q/p of the bilinear frequency: p impacts in q turns of the source. Half of it is in `natural_frequencies`.
    """
    frequencies = {frequency.name: frequency for frequency in natural_frequencies(scene)}
    if "bilinear" not in frequencies:
        return []
    own = next(frequencies[name] for name in ("free-free", "with motor", "held", "f1") if name in frequencies)
    parts = [("⅓ ", 1 / 3, frequencies["bilinear"]), ("⅔ ", 2 / 3, frequencies["bilinear"])]
    parts += [("¾ ", 3 / 4, frequencies["bilinear"]), ("½ ", 1 / 2, own), ("⅓ ", 1 / 3, own)]
    return [Frequency(sign + whole.name, sign + whole.label, part * whole.hz) for sign, part, whole in parts]


def source_period(scene: Scene, phidot: float | None = None) -> float | None:
    """Period of the source [s]; of the free vibration without one; None where nothing has a rhythm.

    phidot : mean speed of the motor [rad/s], where known; its no-load speed otherwise
    """
    if scene.has_motor and phidot:
        return 2 * math.pi / abs(phidot)
    period = rates.source_period(scene)
    return period if math.isfinite(period) else None


def motor_of(scene: Scene) -> Motor:
    """The motor of a scene that has one."""
    assert scene.motor is not None
    return scene.motor


def shortest_period(scene: Scene) -> float | None:
    """Shortest period in the motion [s]: of a source or of the vibration with all stops in contact."""
    rates_of_scene = [*rates.source_rates(scene), *rates.natural_rates(scene, scene.stops)]
    return 2 * math.pi / max(rates_of_scene) if rates_of_scene else None
