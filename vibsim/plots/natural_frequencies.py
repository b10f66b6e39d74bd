"""Frequencies at which the scene itself likes to vibrate, and the rhythm of its source."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from vibsim.physics.parts import Scene as PartsScene
from vibsim.physics.rates import fastest_rate, natural_rates, source_rates

MOST = 6  # natural frequencies of a scene of named parts


@dataclass(frozen=True)
class Frequency:
    """A frequency [Hz] and its name, plain and as a mathtext label."""

    name: str
    label: str
    hz: float


def natural_frequencies(scene: Any) -> list[Frequency]:
    """Linear and bilinear frequencies of the relative motion (without friction and damping).

    sqrt(k1 / m1) is the paper's natural frequency (block 2 held). Free-free: sqrt(k1 / m), with m the reduced
    mass of both blocks, the motor's m3 counted to block 1. With a stop, f1 without and f2 with the impact
    spring give the bilinear 2 f1 f2 / (f1 + f2), the limit of large amplitudes, and half of it (a subharmonic
    of the impacting motion).
    """
    if isinstance(scene, PartsScene):
        return _of_parts(scene)
    if not scene.k1:
        return []
    found = [Frequency("held", r"$\sqrt{k_1/m_1}$", _hertz(scene.k1, scene.m1))]
    mass = reduced_mass(scene)
    free = _hertz(scene.k1, mass)
    if scene.m2 is not None:
        found.append(Frequency("free-free", "free–free", free))
    elif scene.has_motor:
        found.append(Frequency("with motor", r"$\sqrt{k_1/(m_1+m_3)}$", free))
    if scene.has_stop and scene.k2:
        stiff = _hertz(scene.k1 + scene.k2, mass)
        bilinear = 2 * free * stiff / (free + stiff)
        found += [
            Frequency("bilinear", "bilinear", bilinear),
            Frequency("half bilinear", "½ bilinear", bilinear / 2),
        ]
    return found


def _of_parts(scene: PartsScene) -> list[Frequency]:
    """Those of a scene of named parts with all stops open, ascending."""
    rates = natural_rates(scene)
    return [
        Frequency(f"f{i}", f"$f_{{{i}}}$", rate / (2 * math.pi)) for i, rate in enumerate(rates[:MOST], 1)
    ]


def fractions(scene: Any) -> list[Frequency]:
    """Fractions of the frequencies at which a motion with impacts may resonate too.

    q/p of the bilinear frequency: p impacts in q turns of the source. Half of it is in `natural_frequencies`.
    """
    found = {frequency.name: frequency for frequency in natural_frequencies(scene)}
    if "bilinear" not in found:
        return []
    own = found.get("free-free") or found.get("with motor") or found["held"]
    parts = [("⅓ ", 1 / 3, found["bilinear"]), ("⅔ ", 2 / 3, found["bilinear"])]
    parts += [("¾ ", 3 / 4, found["bilinear"]), ("½ ", 1 / 2, own), ("⅓ ", 1 / 3, own)]
    return [Frequency(sign + whole.name, sign + whole.label, part * whole.hz) for sign, part, whole in parts]


def reduced_mass(scene: Any) -> float:
    """Mass of the relative motion [kg]: m1 (with m3) against m2, or alone where block 2 is fixed."""
    mass = scene.m1 + (scene.m3 if scene.has_motor else 0.0)
    return mass if scene.m2 is None else mass * scene.m2 / (mass + scene.m2)


def source_period(scene: Any, phidot: float | None = None) -> float | None:
    """Period of the source [s]; of the free vibration without one; None where nothing has a rhythm.

    phidot : mean speed of the motor [rad/s], where known; its no-load speed otherwise
    """
    if scene.has_motor:
        speed = abs(phidot or 0.0) or abs(no_load_speed(scene))
        return 2 * math.pi / speed
    if isinstance(scene, PartsScene):
        rate = min(source_rates(scene) or natural_rates(scene), default=None)
        return 2 * math.pi / rate if rate else None
    if scene.source == "harmonic" and scene.omega:
        return 2 * math.pi / abs(scene.omega)
    return 1 / _hertz(scene.k1, reduced_mass(scene)) if scene.k1 else None


def no_load_speed(scene: Any) -> float:
    """No-load speed of the motor [rad/s]."""
    return float(getattr(scene, "motor", scene).Omega0)


def shortest_period(scene: Any) -> float | None:
    """Shortest period in the motion [s]: of the source or of the vibration in contact."""
    if isinstance(scene, PartsScene):
        return 2 * math.pi / fastest if (fastest := fastest_rate(scene)) else None
    stiffness = scene.k1 + (scene.k2 if scene.has_stop else 0.0)
    own = [1 / _hertz(stiffness, reduced_mass(scene))] if stiffness else []
    source = source_period(scene)
    return min([*own, *([source] if source else [])], default=None)


def _hertz(stiffness: float, mass: float) -> float:
    return math.sqrt(stiffness / mass) / (2 * math.pi)
