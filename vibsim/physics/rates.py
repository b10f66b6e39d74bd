"""Angular rates at which a scene made of parts vibrates or is driven.

The natural ones are those of M x'' + K x = 0, friction and damping left out; a motor's unbalanced mass moves
with its body. Where one pair of ends has all the springs of a set of bodies, the rate is sqrt(k/m), m the
reduced mass. What sets cadences and time scales of results is rounded to three digits. A formula counts as
the spring that it is for small motions about the start.
"""

import threading
from collections.abc import Callable, Iterable, Sequence
from fractions import Fraction
from functools import wraps
from math import inf, lcm, pi, sqrt
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar, Union, overload

import numpy as np

from vibsim.physics.connections import body_sets, paces_of, reads_time
from vibsim.physics.linear_algebra import symmetric_eigenvalues
from vibsim.physics.numbers import N
from vibsim.physics.parts import ANGLE, BODY, MOTOR, ROTOR, SPEED, Link, RigidStop, Scene, Stop

RIGID = 1e-12  # of the largest squared rate, below which one is that of a rigid motion, 0 but for rounding

if TYPE_CHECKING:
    from vibsim.physics.formula_values import LinearPart

Spring = Union[Link, Stop, "LinearPart"]
T = TypeVar("T")


def of_parts_alone(function: Callable[[Scene], T]) -> Callable[[Scene], T]:
    """A function of a scene in which its start has no say: each thread keeps the value for its last scene."""
    kept = threading.local()

    @wraps(function)
    def known(scene: Scene) -> T:
        if not (vars(kept) and (kept.scene is scene or kept.scene.same_but_for_start(scene))):
            kept.value = function(scene)
        kept.scene = scene
        value: T = kept.value
        return value

    return known


def frequency(stiffness: float, mass: float) -> float:
    """Natural frequency [Hz] of a mass [kg] on a spring [N/m]."""
    return sqrt(stiffness / mass) / (2 * pi)


def masses(scene: Scene) -> np.ndarray:
    """Masses of the bodies [kg], the motor's unbalanced mass with its body, and inertias of rotors [kg m^2];
    shape (bodies,).
    """
    values = np.array([body.m for body in scene.bodies])
    if scene.motor is not None:
        values[scene.motor.on] += scene.motor.m3
    return values


def reduced_mass(scene: Scene, P: int, Q: int) -> float:
    """Mass of the motion of two ends against each other [kg]: 1/(1/m_P + 1/m_Q), or that of the one body
    where the other end is the ground or the base.
    """
    own = masses(scene).tolist()
    moving = [own[end] for end in (P, Q) if end >= 0]
    return float(1 / (1 / moving[0] + 1 / moving[1]) if len(moving) == 2 else moving[0])


def mobility(scene: Scene[N], ends: Iterable[int]) -> N | int:
    """Sum of 1 / mass over the bodies among `ends` [1/kg], in the number type of the scene."""
    total: N | int = 0
    for end in sorted(ends):
        if end >= 0:
            total = total + 1 / scene.bodies[end].m
    return total


def _linear_parts(scene: Scene[Any]) -> list[Spring]:
    """Springs that formulas are for small motions about the start."""
    if not scene.has_formulas:
        return []
    from vibsim.physics.formula_values import linear_parts

    return list(linear_parts(scene))


def fastest_of_formulas(scene: Scene[Any]) -> float:
    """The fastest rate [rad/s] at which bodies vibrate by formulas near the start; 0 without any."""
    rates = [
        sqrt(part.k * float(mobility(scene, (part.P, part.Q))))
        for part in _linear_parts(scene)
        if part.k > 0 and part.P >= 0 and scene.bodies[part.P].kind == BODY
    ]
    return max(rates, default=0.0)


def fastest_damping(scene: Scene) -> tuple[str, float]:
    """Name of the damper that brings its ends to one velocity fastest, and its rate c / m [1/s]; ("", 0.0)
    without dampers. Taylor series make steps of some 9 / rate, so a run takes longer in proportion to it.
    """
    dampers: list[Spring] = [*scene.links, *(stop for _, stop in scene.elastic_stops), *_linear_parts(scene)]
    rates = [(part.c / reduced_mass(scene, part.P, part.Q), part.name) for part in dampers if part.c > 0]
    rate, name = max(rates, default=(0.0, ""))
    return name, rate


def springs_of(scene: Scene) -> list[Spring]:
    """Links and elastic stops with stiffness, stops with a formula, and what of other formulas pushes
    back.
    """
    springs: list[Spring] = [link for link in scene.links if link.k]
    springs += [stop for _, stop in scene.elastic_stops if stop.k or stop.force is not None]
    return springs + [part for part in _linear_parts(scene) if part.k > 0]


def natural_rates(scene: Scene, closed: Iterable[Stop | RigidStop] = ()) -> list[float]:
    """Natural angular rates [rad/s], ascending, those of rigid motions left out.

    closed : the stops that are in contact; rigid ones are left out
    """
    return [rate for rate in all_rates(scene, closed) if rate]


def all_rates(scene: Scene, closed: Iterable[Stop | RigidStop] = ()) -> list[float]:
    """The same with a 0 for each rigid motion: one for each body."""
    every: list[Spring] = [*scene.links, *(stop for stop in closed if isinstance(stop, Stop))]
    springs = [spring for spring in every if spring.k] + [part for part in _linear_parts(scene) if part.k > 0]
    turning = [i for i, body in enumerate(scene.bodies) if body.kind == ROTOR]
    rates = [_of_pair(scene, [spring])[0] for spring in springs if spring.P in turning]
    springs = [spring for spring in springs if spring.P not in turning]
    for one in body_sets(scene, springs):
        own = [spring for spring in springs if {spring.P, spring.Q} & set(one.bodies)]
        pairs = {frozenset((spring.P, spring.Q)) for spring in own}
        if not own:
            rates += [0.0] * len(one.bodies)  # a body alone, or several that formulas join
        elif len(pairs) == 1 and len([end for end in next(iter(pairs)) if end >= 0]) == len(one.bodies):
            rates += _of_pair(scene, own)
        else:
            rates += _eigenvalues(scene, own, one.bodies)
    return sorted(rates)


def _of_pair(scene: Scene, springs: Sequence[Spring]) -> list[float]:
    """Rates of the one or two bodies between which all the springs are."""
    P, Q = springs[0].P, springs[0].Q
    stiffness = 0.0
    for spring in springs:  # one by one: sum() of floats compensates from Python 3.12 on
        stiffness += spring.k
    rate = sqrt(stiffness / reduced_mass(scene, P, Q))
    return [0.0, rate] if P >= 0 and Q >= 0 else [rate]


def _eigenvalues(scene: Scene, springs: Sequence[Spring], bodies: Sequence[int]) -> list[float]:
    """Rates of a set of bodies, those of rigid motions 0."""
    share = 1 / np.sqrt(masses(scene)[list(bodies)])  # of each body in coordinates in which all masses are 1
    place = {body: i for i, body in enumerate(bodies)}
    stiffness = np.zeros((len(share), len(share)))
    for spring in springs:
        row = np.zeros(len(share))
        for end, sign in ((spring.P, 1.0), (spring.Q, -1.0)):
            if end >= 0:
                row[place[end]] = sign * share[place[end]]
        stiffness += spring.k * (row[:, None] * row)
    squares = symmetric_eigenvalues(stiffness)
    return [sqrt(square) if square > RIGID * max(squares) else 0.0 for square in squares]


def bilinear_frequencies(scene: Scene) -> list[float]:
    """Frequencies of vibrations that are large against all gaps [Hz], ascending: 2 f1 f2/(f1 + f2) for each
    natural frequency f1 with all stops open, f2 that of its place in the order with all stops closed.

    Exact for one relative motion with one stop, an estimate else. Empty without elastic stops.
    """
    if not scene.elastic_stops:
        return []
    open_hz, closed_hz = (
        [rate / (2 * pi) for rate in all_rates(scene, closed)] for closed in ((), scene.stops)
    )
    pairs = zip(open_hz, closed_hz, strict=True)
    return [2 * free * contact / (free + contact) for free, contact in pairs if free]


@of_parts_alone
def is_driven(scene: Scene) -> bool:
    """Whether there is a motor, a force that changes with time, a base that moves or a rotor that is
    driven.
    """
    if scene.motor is not None or bool(scene.harmonics):
        return True
    return reads_time(scene) or turning_rotor(scene) is not None


def turning_rotor(scene: Scene[Any]) -> int | None:
    """Number of the rotor whose turns are the cycles of a scene without a motor that nothing drives in time:
    the first one that its torque drives forwards, or any that torques drive; None of any other scene.
    """
    if not scene.has_formulas or scene.motor is not None or reads_time(scene):
        return None
    if not any(body.kind == ROTOR for body in scene.bodies):
        return None
    if any(term.amplitude != 0 and term.cycles != 0 for term in scene.harmonics):
        return None
    from vibsim.physics.formula_values import driven_rotors

    return next(iter(driven_rotors(scene)), None)


def turning_columns(scene: Scene[Any]) -> tuple[str, str] | None:
    """Columns of angle and speed whose turns are the cycles of a scene: of the motor, or of its rotor."""
    if scene.motor is not None:
        return ANGLE, SPEED
    rotor = turning_rotor(scene)
    if rotor is None:
        return None
    phi, w = scene.bodies[rotor].columns
    return (phi, w) if phi is not None else None


def motor_columns(scene: Scene[Any]) -> tuple[str, str] | None:
    """Columns of angle and speed of the motor, be its torque a formula; None without a motor."""
    by_formula = any(body.kind == ROTOR and body.name == MOTOR for body in scene.bodies)
    return (ANGLE, SPEED) if scene.motor is not None or by_formula else None


def source_rates(scene: Scene) -> list[float]:
    """Angular rates [rad/s] of forces, base, formulas of time and motor (its no-load speed); those that are 0
    left out.
    """
    rates = [abs(term.omega) for term in scene.harmonics if term.amplitude]
    rates += [2 * pi * pitch[0] for pitch in _pitches(scene) or []]
    rates += [abs(scene.motor.Omega0)] if scene.motor is not None else []
    return [rate for rate in rates if rate]


def source_period(scene: Scene) -> float:
    """Period of the source [s]: of the motor without load, the common one of forces and base or, without
    any, that of the slowest of them; of the slowest free vibration where there is no source; inf where
    nothing vibrates.
    """
    period = None if scene.motor is not None else common_period(scene)
    if period is not None:
        for term in scene.harmonics:
            if term.cycles == period.cycles:
                return float(2 * pi / abs(term.omega) * period.turns)
        return float(period.end(1))
    rates = source_rates(scene) if scene.motor is None else [abs(scene.motor.Omega0)]
    rates = [rate for rate in rates if rate] or natural_rates(scene)
    return 2 * pi / min(rates) if rates else inf


def longest_period(scene: Scene) -> float:
    """The longest of the periods of sources and free vibration [s]; infinite without any."""
    rates = [*source_rates(scene), *natural_rates(scene)]
    return _rounded(max((2 * pi / rate for rate in rates), default=inf))


def fastest_rate(scene: Scene, closed: Iterable[Stop | RigidStop] | None = None) -> float:
    """The fastest of sources, rotor at the start and vibration with stops closed, all unless told [rad/s];
    0 without any.
    """
    closed = scene.stops if closed is None else closed
    spin = spins(scene)
    return _rounded(max([*source_rates(scene), *spin, *natural_rates(scene, closed)], default=0.0))


def spins(scene: Scene) -> list[float]:
    """Speeds of motor and rotors at the start [rad/s], without signs."""
    own = [abs(scene.motor.phidot)] if scene.motor is not None else []
    return own + [abs(body.v) for body in scene.bodies if body.kind == ROTOR]


def _rounded(value: float) -> float:
    return float(f"{value:.3g}")


# The period of what drives a scene from outside: of all its harmonics together, where there is one.


MOST = 1000  # largest denominator of a ratio of frequencies that counts as exact
EXACT = Fraction(1, 2**100)  # relative: a frequency is a double-double of 107 bits


class Period(NamedTuple):
    """`turns` turns of a harmonic of cycles + cycles_lo [Hz], a double-double."""

    cycles: float
    cycles_lo: float
    turns: int

    @overload
    def end(self, k: float) -> float: ...
    @overload
    def end(self, k: np.ndarray) -> np.ndarray: ...
    def end(self, k: Any) -> Any:
        """End of period k [s], or of several."""
        t = k * self.turns / self.cycles
        return t - t * (self.cycles_lo / self.cycles)


def common_period(scene: Scene[Any]) -> Period | None:
    """The shortest period of all forces and the base, or None where nothing moves them or their frequencies
    have no common one: ratios count as exact within the rounding of double-doubles; None too where a formula
    reads the time otherwise than in sines and remainders. Amplitudes of 0 count
    where there are no others: what a sweep begins with at 0 N has a clock already.
    Frequencies are doubles or fractions.
    """
    terms = [term for term in scene.harmonics if term.cycles != 0]
    further = _pitches(scene)
    if further is None:
        return None
    if len(terms) == 1 and not further:
        return Period(terms[0].cycles, terms[0].cycles_lo, 1)
    strong = [term for term in terms if term.amplitude != 0]
    own = [(term.cycles, term.cycles_lo) for term in strong or ([] if further else terms)]
    pitches = list(dict.fromkeys([*own, *further]))
    if not pitches:
        return None
    if len(pitches) == 1:
        return Period(*pitches[0], 1)
    exact = [Fraction(cycles) + Fraction(cycles_lo) for cycles, cycles_lo in pitches]
    turns = 1
    for frequency in exact[1:]:
        ratio = frequency / exact[0]
        near = ratio.limit_denominator(MOST)
        if abs(near - ratio) > EXACT * ratio:
            return None
        turns = lcm(turns, near.denominator)
    return Period(*pitches[0], turns)


def _pitches(scene: Scene[Any]) -> list[tuple[float, float]] | None:
    """Frequencies [Hz] at which formulas of time repeat themselves, as double-doubles; None where one never
    does.
    """
    if not scene.has_formulas:
        return []
    paces = paces_of(scene)
    if paces is None:
        return None
    return [pace.cycles for pace in paces]


def has_section(scene: Scene[N]) -> bool:
    """Whether the scene has a motor, sources with a common period, or a rotor that its torque drives: what
    ends the periods at which a run is looked at stroboscopically.
    """
    return scene.motor is not None or common_period(scene) is not None or turning_rotor(scene) is not None
