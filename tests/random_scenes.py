"""Random scenes of two blocks over all features, and what random scenes are drawn by: by hypothesis, which
looks for the smallest scene that fails, or by a seed, which gives the same scene for ever.

Every scale follows from a length L, a mass m and a rate w, so that each drawn feature matters in most scenes.
"""

import math
from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.scenes import NO_SOURCE, RUN, START
from vibsim.physics.two_blocks import TwoBlocks

RADIANS = 40.0  # length of a run in radians of its fastest rate


class Draws:
    """Draws of a seed: the same with every version of everything, on every machine."""

    def __init__(self, seed):
        self.random = Random(seed)

    def integers(self, low, high):
        return self.random.randint(low, high)

    def sampled_from(self, options):
        return self.random.choice(options)

    def booleans(self):
        return self.random.random() < 0.5

    def either(self, *draws):
        """What one of some functions draws."""
        return self.sampled_from(draws)()

    def between(self, low, high):
        """A number of three digits: zeros are exact zeros, and no quantity is 1e-300 of the others."""
        return self.integers(round(low * 1000), round(high * 1000)) / 1000

    def decades(self, low, high):
        """10**u with u uniform, to nine digits: the last ones of a power are not the same on all machines."""
        return float(f"{10.0 ** self.between(low, high):.9g}")

    def signed(self, scale):
        """Zero (often) or a number of the size of `scale`."""
        return self.either(lambda: 0.0, lambda: self.between(-1.0, 1.0)) * scale


class DrawsOfHypothesis(Draws):
    """Draws that hypothesis makes, and makes smaller where a test fails."""

    def __init__(self, draw):
        self.draw = draw

    def integers(self, low, high):
        return self.draw(st.integers(low, high))

    def sampled_from(self, options):
        return self.draw(st.sampled_from(options))

    def booleans(self):
        return self.draw(st.booleans())


def strategy(drawn):
    """The strategy of hypothesis for what `drawn(draw, ...)` draws."""

    @st.composite
    def by_hypothesis(draw, *args, **options):
        return drawn(DrawsOfHypothesis(draw), *args, **options)

    return by_hypothesis


def always(check, *draws, few, many):
    """The test that `check` holds for what is drawn: `few` times, and `many` times among slow tests."""

    @pytest.mark.parametrize(
        "count", (few, pytest.param(many, marks=(pytest.mark.slow, pytest.mark.timeout(7200))))
    )
    def test(count):
        settings(max_examples=count)(given(*draws)(check))()

    return test


def two_blocks(draw, sources=("none", "harmonic", "motor"), radians=RADIANS, features=True):
    """A scene: blocks, coupling, stop, friction, source, initial state, rest distance.

    sources: kinds of source to draw from; radians: length of the run; features=False: no rest distance.
    """
    source = draw.sampled_from(sources)
    length, m1, rate = draw.decades(-4, -1), draw.decades(-1, 1), 2 * math.pi * draw.decades(-0.5, 1)
    m2 = draw.either(lambda: None, lambda: draw.decades(-1, 1.5))
    stiffness = m1 * rate**2
    k1 = draw.sampled_from((stiffness, stiffness, stiffness, 0.0))
    mobility = 1 / m1 + (1 / m2 if m2 else 0.0)
    fields = {**NO_SOURCE, **RUN, **START, "m1": m1, "m2": m2, "k1": k1, "source": source}
    fields["c"] = damping(draw, k1 or stiffness, mobility)
    fields["k2"] = draw.either(lambda: None, lambda: draw.between(0.5, 100.0) * stiffness)
    fields["stop_sign"] = draw.sampled_from((1, -1))
    if fields["k2"] is None:
        fields["G"] = None
    else:
        fields["G"] = draw.either(lambda: 0.0, lambda: draw.between(-0.3, 1.0)) * length
    force = stiffness * length
    if m2 is None:
        fields.update(x2=None, v2=None, N=None)
    else:
        fields["N"] = draw.either(lambda: None, lambda: draw.decades(-3, 0) * force)
        fields["x2"] = draw.signed(length)
        fields["v2"] = draw.either(lambda: 0.0, lambda: draw.signed(rate * length))
    fields["x1"] = (fields["x2"] or 0.0) + draw.signed(length)
    fields["v1"] = draw.signed(rate * length)
    if source == "harmonic":
        fields.update(ideal_source(draw, force, rate, math.sqrt(k1 * mobility)))
    if source == "motor":
        fields.update(motor(draw, m1, length, rate))
    if features:
        fields["rest_distance"] = draw.either(lambda: None, lambda: draw.between(0.1, 1.0) * length)
        fields["stop_on_violation"] = draw.booleans()
    fields["t_end"] = radians / fastest_rate(fields, mobility)
    fields["every_num"] = 1 + int(fields["t_end"] * 1e6 / draw.integers(3, 60))
    fields["every_den"] = 10**6
    return TwoBlocks(**fields)


scenes = strategy(two_blocks)


def damping(draw, stiffness, mobility):
    """c [N s/m]: none, about critical, or any share of it up to far above."""
    critical = 2 * math.sqrt(stiffness / mobility)
    about = (1.0, 1 - 1e-12, 1 + 1e-12)
    share = draw.either(
        lambda: 0.0,
        lambda: draw.sampled_from(about),
        lambda: draw.decades(-4, -1),
        lambda: draw.decades(-1, 1.5),
    )
    return share * critical


def ideal_source(draw, force, rate, natural):
    """Harmonic source, often at the natural frequency, sometimes with a constant part or no amplitude."""
    omega = draw.either(lambda: natural or rate, lambda: draw.decades(-2, 1) * rate)
    amplitude = draw.sampled_from((0.0, 1.0, 1.0)) and draw.between(-2.0, 2.0)
    return {
        "A": amplitude * force,
        "F0": draw.signed(force),
        "omega": omega,
        "cycles": omega / (2 * math.pi),
        "cycles_lo": draw.sampled_from((0.0, 1e-17)) * omega,
    }


def motor(draw, m1, length, rate):
    """A motor whose imbalance moves the blocks by about `length`."""
    m3, e = m1 * draw.decades(-2, 0), length * draw.decades(0, 1.5)
    return {
        "m3": m3,
        "e": e,
        "J": m3 * e * e * draw.decades(-1, 1),
        "M0": m3 * e * e * rate**2 * draw.decades(-2, 1),
        "Omega0": rate * draw.between(0.2, 2.0),
        "phi": draw.either(lambda: 0.0, lambda: draw.between(-100.0, 100.0)),
        "phidot": draw.either(lambda: 0.0, lambda: draw.between(-1.5, 1.5) * rate),
    }


def fastest_rate(fields, mobility):
    """The fastest of natural, damping and source rates [1/s]."""
    stiffness = fields["k1"] + (fields["k2"] or 0.0)
    sources = [abs(fields[name] or 0.0) for name in ("omega", "Omega0", "phidot")]
    return max(math.sqrt(stiffness * mobility), fields["c"] * mobility, *sources, 0.1)
