"""Scenes for tests: the paper's values, and any of them overridden."""

import math
from dataclasses import replace
from fractions import Fraction

from vibsim.cases.formula_places import difference
from vibsim.physics import formulas
from vibsim.physics.parts import HYPERBOLIC
from vibsim.physics.two_blocks import TwoBlocks

LIMIT_FRICTION = float(Fraction("0.001") * Fraction("2.94") * Fraction("9.81"))  # mu m2 g [N]
M3_E = 0.03 * 0.11

BLOCKS = {
    "m1": 0.297,
    "m2": 2.94,
    "k1": 200.0,
    "c": 0.001,
    "k2": 12400.0,
    "G": 0.001,
    "stop_sign": 1,
    "N": LIMIT_FRICTION,
}
START = {"x1": 0.0, "v1": 0.0, "x2": 0.0, "v2": 0.0}
RUN = {"rest_distance": None, "stop_on_violation": False, "t_end": 20.0, "every_num": 1, "every_den": 200}
NO_SOURCE = dict.fromkeys(
    ("A", "F0", "omega", "cycles", "cycles_lo", "m3", "e", "J", "M0", "Omega0", "phi", "phidot")
)

TABLE_1 = {"I-A": (3.5, 0.0725), "I-B": (5.5, 0.1140), "I-C": (6.5, 0.1350)}
MOTORS = {"II-A": 3.5, "II-B": 5.5, "II-C": 6.5}
CASE_NAMES = (*TABLE_1, *(f"{name}-eq211" for name in TABLE_1), *MOTORS)


def harmonic(frequency, amplitude, constant=0.0):
    """Fields of an ideal source of `frequency` [Hz] and `amplitude` [N]."""
    return {
        **NO_SOURCE,
        "source": "harmonic",
        "A": amplitude,
        "F0": constant,
        "omega": 2 * math.pi * frequency,
        "cycles": frequency,
        "cycles_lo": 0.0,
    }


def motor(frequency):
    """Fields of the paper's motor with the motor constant `frequency` [Hz]."""
    fields = {
        "m3": 0.03,
        "e": 0.11,
        "J": 0.001,
        "M0": 0.005,
        "Omega0": 2 * math.pi * frequency,
        "phi": 0.0,
        "phidot": 0.0,
    }
    return {**NO_SOURCE, **fields, "source": "motor"}


def scene(source=None, **changes):
    """The paper's blocks, stop and friction, at rest, under `source` (fields; none by default)."""
    source = source or {**NO_SOURCE, "source": "none"}
    return TwoBlocks(**{**BLOCKS, **START, **RUN, **source, **changes})


def paper(name, **changes):
    """A case of Table 1 by name; `-eq211` has the amplitude of Eq. (2.11)."""
    if name in MOTORS:
        return scene(motor(MOTORS[name]), **changes)
    frequency, amplitude = TABLE_1[name.removesuffix("-eq211")]
    if name.endswith("-eq211"):
        amplitude = M3_E * (2 * math.pi * frequency) ** 2
    return scene(harmonic(frequency, amplitude), **changes)


def fixed_block(source=None, **changes):
    """Block 1 alone on its spring before a wall: block 2 fixed, no friction, no stop unless given."""
    return scene(source, **{"m2": None, "N": None, "k2": None, "x2": None, "v2": None, **changes})


def falling(friction, *laws, load=1):
    """`friction` with more force that falls with the speed of slip: for both directions, or for each, a law
    with its drop [N] and its rate [s/m], or None. All forces are times `load`. Numbers are decimals, exact.
    """
    forces = [exact(friction.forward), exact(friction.backward)]
    slip = formulas.sub(difference("v", friction.P, friction.Q), formulas.num(exact(friction.belt)))
    sides = list(zip(forces, laws * 2 if len(laws) == 1 else laws, (slip, formulas.neg(slip)), strict=True))
    forward, backward = (float(load * (force + exact(law[1] if law else 0))) for force, law, _ in sides)
    slips = tuple(formulas.mul(_slip_force(*side), formulas.num(load)) for side in sides)
    return replace(friction, forward=forward, backward=backward, slips=slips)


def exact(decimal):
    """The number that a double is written as."""
    return Fraction(repr(decimal))


def _slip_force(force, law, speed):
    """Node of a force, and of what falls with speed beside it."""
    if law is None:
        return formulas.num(force)
    name, drop, rate = law
    s = formulas.mul(formulas.num(exact(rate)), speed)
    hyperbola = formulas.div(formulas.ONE, formulas.add(formulas.ONE, s))
    fall = hyperbola if name == HYPERBOLIC else formulas.call("exp", formulas.neg(s))
    return formulas.add(formulas.num(force), formulas.mul(formulas.num(exact(drop)), fall))
