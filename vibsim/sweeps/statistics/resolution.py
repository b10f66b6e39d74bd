"""The output interval from which the statistics of a point are taken."""

import math
from dataclasses import replace
from fractions import Fraction

from vibsim.cases.contradictions import MOST_SAMPLES
from vibsim.physics.two_blocks import TwoBlocks

# Between rows a displacement is a quintic, off by (w h)^6/46080 of a vibration at w rad/s:
LARGEST_ANGLE_IN_CONTACT = 1.1  # 4e-5 of the depth of penetration
LARGEST_ANGLE = 0.4  # 9e-8 of the amplitude


class TooFineError(ValueError):
    """A motion so fast, or an output interval so short, that a run has more samples than it may."""


def sampled_for_statistics(scene: TwoBlocks, every: Fraction | None = None) -> TwoBlocks:
    """The scene with the output interval `every` [s], or with the longest that its motion allows.

    Raises TooFineError where that makes more samples than a run may have.
    """
    if every is None:
        every = Fraction(1, math.ceil(samples_per_second(scene)))
    if Fraction(float(scene.t_end)) / every > MOST_SAMPLES:
        raise TooFineError("the run takes more than 1e10 samples to tell its statistics from, and may not")
    return replace(scene, every_num=every.numerator, every_den=every.denominator)


def samples_per_second(scene: TwoBlocks) -> float:
    """Samples [1/s] that resolve the free vibration, the vibration in contact and the source."""
    mass = scene.m1  # without m3: where the rotor cannot follow, m1 vibrates alone
    mobility = 1 / mass + (1 / scene.m2 if scene.has_block2 else 0.0)
    source = {"none": 0.0, "harmonic": scene.omega, "motor": scene.Omega0}[scene.source]
    spin = abs(scene.phidot) if scene.has_motor else 0.0
    rate = max(math.sqrt(scene.k1 * mobility), abs(source), spin) / LARGEST_ANGLE
    if scene.has_stop:
        rate = max(rate, math.sqrt((scene.k1 + scene.k2) * mobility) / LARGEST_ANGLE_IN_CONTACT)
    return max(rate, 1 / scene.t_end)
