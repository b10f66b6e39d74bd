"""Hypothesis strategies: scenes over all features, short enough for the Python engine.

Every scale follows from a length L, a mass m and a rate w, so that each drawn feature matters in most scenes.
"""

import math
from functools import cache

from hypothesis import strategies as st

from tests.scenes import NO_SOURCE, RUN, START
from vibsim.physics.two_blocks import TwoBlocks

RADIANS = 40.0  # length of a run in radians of its fastest rate


@cache
def between(low, high):
    """A number of three digits: zeros are exact zeros, and no quantity is 1e-300 of the others."""
    return st.integers(round(low * 1000), round(high * 1000)).map(lambda n: n / 1000)


@cache
def decades(low, high):
    """10**u with u uniform."""
    return between(low, high).map(lambda u: 10.0**u)


@cache
def signed(scale):
    """Zero (often) or a number of the size of `scale`."""
    return st.one_of(st.just(0.0), between(-1.0, 1.0)).map(lambda u: u * scale)


@st.composite
def scenes(draw, sources=("none", "harmonic", "motor"), radians=RADIANS, features=True):
    """A scene: blocks, coupling, stop, friction, source, initial state, rest distance.

    sources: kinds of source to draw from; radians: length of the run; features=False: no rest distance.
    """
    source = draw(st.sampled_from(sources))
    length, m1, rate = draw(decades(-4, -1)), draw(decades(-1, 1)), 2 * math.pi * draw(decades(-0.5, 1))
    m2 = draw(st.one_of(st.none(), decades(-1, 1.5)))
    stiffness = m1 * rate**2
    k1 = draw(st.sampled_from((stiffness, stiffness, stiffness, 0.0)))
    mobility = 1 / m1 + (1 / m2 if m2 else 0.0)
    fields = {**NO_SOURCE, **RUN, **START, "m1": m1, "m2": m2, "k1": k1, "source": source}
    fields["c"] = draw(damping(k1 or stiffness, mobility))
    fields["k2"] = draw(st.one_of(st.none(), between(0.5, 100.0).map(lambda u: u * stiffness)))
    fields["stop_sign"] = draw(st.sampled_from((1, -1)))
    fields["G"] = None if fields["k2"] is None else draw(st.one_of(st.just(0.0), between(-0.3, 1.0))) * length
    force = stiffness * length
    if m2 is None:
        fields.update(x2=None, v2=None, N=None)
    else:
        fields["N"] = draw(st.one_of(st.none(), decades(-3, 0).map(lambda u: u * force)))
        fields["x2"] = draw(signed(length))
        fields["v2"] = draw(st.one_of(st.just(0.0), signed(rate * length)))
    fields["x1"] = fields["x2"] or 0.0
    fields["x1"] += draw(signed(length))
    fields["v1"] = draw(signed(rate * length))
    if source == "harmonic":
        fields.update(draw(ideal_sources(force, rate, math.sqrt(k1 * mobility))))
    if source == "motor":
        fields.update(draw(motors(m1, length, rate)))
    if features:
        fields["rest_distance"] = draw(st.one_of(st.none(), between(0.1, 1.0).map(lambda u: u * length)))
        fields["stop_on_violation"] = draw(st.booleans())
    fastest = fastest_rate(fields, mobility)
    fields["t_end"] = radians / fastest
    fields["every_num"] = 1 + int(fields["t_end"] * 1e6 / draw(st.integers(3, 60)))
    fields["every_den"] = 10**6
    return TwoBlocks(**fields)


def damping(stiffness, mobility):
    """c [N s/m]: none, about critical, or any share of it up to far above."""
    critical = 2 * math.sqrt(stiffness / mobility)
    shares = st.one_of(
        st.just(0.0), st.sampled_from((1.0, 1 - 1e-12, 1 + 1e-12)), decades(-4, -1), decades(-1, 1.5)
    )
    return shares.map(lambda share: share * critical)


@st.composite
def ideal_sources(draw, force, rate, natural):
    """Harmonic source, often at the natural frequency, sometimes with a constant part or no amplitude."""
    omega = draw(st.one_of(st.just(natural or rate), decades(-2, 1).map(lambda u: u * rate)))
    return {
        "A": draw(st.one_of(st.just(0.0), between(-2.0, 2.0), between(-2.0, 2.0))) * force,
        "F0": draw(signed(force)),
        "omega": omega,
        "cycles": omega / (2 * math.pi),
        "cycles_lo": draw(st.sampled_from((0.0, 1e-17))) * omega,
    }


@st.composite
def motors(draw, m1, length, rate):
    """A motor whose imbalance moves the blocks by about `length`."""
    m3, e = m1 * draw(decades(-2, 0)), length * draw(decades(0, 1.5))
    return {
        "m3": m3,
        "e": e,
        "J": m3 * e * e * draw(decades(-1, 1)),
        "M0": m3 * e * e * rate**2 * draw(decades(-2, 1)),
        "Omega0": rate * draw(between(0.2, 2.0)),
        "phi": draw(st.one_of(st.just(0.0), between(-100.0, 100.0))),
        "phidot": draw(st.one_of(st.just(0.0), between(-1.5, 1.5).map(lambda u: u * rate))),
    }


def fastest_rate(fields, mobility):
    """The fastest of natural, damping and source rates [1/s]."""
    stiffness = fields["k1"] + (fields["k2"] or 0.0)
    sources = [abs(fields[name] or 0.0) for name in ("omega", "Omega0", "phidot")]
    return max(math.sqrt(stiffness * mobility), fields["c"] * mobility, *sources, 0.1)
