"""The sampling of a point's run, for what is taken from samples: it resolves the motion."""

import math
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from functools import reduce
from operator import add

from vibsim.cases.reading.contradictions import MOST_SAMPLES
from vibsim.physics.parts import Link, Scene, Stop
from vibsim.physics.rates import mobility, source_rates

# Samples h apart miss an extreme of a vibration at w rad/s by up to (w h)^2 / 8 of it:
LARGEST_ANGLE_IN_CONTACT = 1.1  # 15 % of the depth of penetration
LARGEST_ANGLE = 0.4  # 2 % of the amplitude


class TooFineError(ValueError):
    """A motion so fast, or an output interval so short, that a run has more samples than it may."""


def sampled_for_statistics(scene: Scene, every: Fraction | None = None) -> Scene:
    """The scene with the output interval `every` [s], or with the longest that its motion allows.

    Raises TooFineError where that makes more samples than a run may have.
    """
    if every is None:
        every = Fraction(1, math.ceil(samples_per_second(scene)))
    if Fraction(float(scene.t_end)) / every > MOST_SAMPLES:
        raise TooFineError("the run takes more than 1e10 samples to resolve its motion, and may not")
    return replace(scene, every_num=every.numerator, every_den=every.denominator)


def samples_per_second(scene: Scene) -> float:
    """Samples [1/s] that resolve free vibration, vibration in contact and sources."""
    spin = [abs(scene.motor.phidot)] if scene.motor is not None else []
    rate = max([fastest(scene, scene.links), *source_rates(scene), *spin]) / LARGEST_ANGLE
    stops = [stop for _, stop in scene.elastic_stops]
    if stops:
        rate = max(rate, fastest(scene, (*scene.links, *stops)) / LARGEST_ANGLE_IN_CONTACT)
    return max(rate, 1 / scene.t_end)


def fastest(scene: Scene, springs: Sequence[Link | Stop]) -> float:
    """A bound of the rates [1/s] at which bodies vibrate on springs.

    y'' + B K y = 0 in the differences y of the pairs of ends that springs join: B_ij sums 1 / mass over the
    bodies that pairs i and j share. By Gershgorin's theorem no eigenvalue of B K exceeds the largest sum over
    j of B_ij k_j: exact for one pair, and for a long chain of equal bodies. Dampers make vibrations slower;
    what dies out at once need not be resolved. A motor's m3 is left out: where the rotor cannot follow, its
    body vibrates alone.
    """
    pairs: dict[frozenset[int], float] = {}
    for part in springs:
        ends = frozenset((part.P, part.Q))
        pairs[ends] = pairs.get(ends, 0.0) + part.k
    shares = [[mobility(scene, ends & others) * k for others, k in pairs.items()] for ends in pairs]
    return math.sqrt(max((reduce(add, of_pair) for of_pair in shares), default=0.0))
