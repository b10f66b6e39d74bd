"""Values of formulas at given places, velocities and times: for pictures, scales of time, the motion of a
base.

The engine has an interpreter of its own; here a formula is taken as it stands, for many instants at once.
Sums and products are rounded as everywhere, functions are those of `vibsim.physics.elementary`: no value
differs from one machine to the next.
"""

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from itertools import pairwise
from math import isfinite, pi
from typing import Any, NamedTuple

import numpy as np

from vibsim.physics import elementary
from vibsim.physics.connections import base_formulas
from vibsim.physics.elementary import mean, sine_cosine_of_arrays
from vibsim.physics.formulas import TIME, Node, children, derivative, piece_of_table, reads, walk
from vibsim.physics.parts import BASE, GROUND, ROTOR, STATE, Link, Scene

Inputs = Mapping[Node, np.ndarray | float]  # what formulas read: node -> values [SI]


def values_of(formula: Node, inputs: Inputs) -> np.ndarray:
    """Values of a formula, of the shape of its inputs; those that are not given count as 0."""
    known: dict[Node, np.ndarray] = {}
    for node in walk([formula]):
        known[node] = _value(node, [known[child] for child in children(node)], inputs)
    return known[formula]


def size_of(node: Node, t: float = 0.0) -> float | None:
    """The value of a formula that reads nothing but the time t [s]; None where it has none, or reads more."""
    if reads([node], ("x", "v", "phi", "w")):
        return None
    try:
        value = float(values_of(node, {TIME: t}))
    except OverflowError:  # of a number beyond all doubles
        return None
    return value if isfinite(value) else None


def _value(node: Node, below: list[np.ndarray], inputs: Inputs) -> np.ndarray:
    kind = node[0]
    if kind == "num":
        return np.asarray(float(node[1]))
    if kind == "pi":
        return np.asarray(pi)
    if kind in ("t", "x", "v", "phi", "w"):
        return np.asarray(inputs.get(node, 0.0), dtype="f8")
    with np.errstate(all="ignore"):  # where a law has no value, as a root of what is below 0, it is nan
        if kind == "pow":
            return _by_elements(lambda a: elementary.power(a, float(node[2])), below[0])
        if kind in ARITHMETIC:
            return np.asarray(ARITHMETIC[kind](*below))
        if kind in ("sin", "cos"):
            return _turned(below[0])[kind == "cos"]
        if kind == "table":
            return _of_table(node, below[0])
        return _by_elements(elementary.function(kind), below[0])


ARITHMETIC: dict[str, Callable[..., Any]] = {
    "add": lambda a, b: a + b,
    "sub": lambda a, b: a - b,
    "mul": lambda a, b: a * b,
    "div": lambda a, b: a / b,
    "choose": lambda g, a, b: np.where(g >= 0, a, b),
    "mod": lambda a, b: a - b * np.floor(a / b),
}


def _turned(angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Sine and cosine."""
    sine, cosine = elementary.sine_cosine_of_arrays(np.atleast_1d(angles))
    return sine.reshape(angles.shape), cosine.reshape(angles.shape)


def _by_elements(function: Callable[[float], float], values: np.ndarray) -> np.ndarray:
    flat = [_or_nan(function, value) for value in np.ravel(values).tolist()]
    return np.array(flat, dtype="f8").reshape(np.shape(values))


def _or_nan(function: Callable[[float], float], value: float) -> float:
    try:
        return float(function(value))
    except (ValueError, OverflowError, ZeroDivisionError):
        return float("nan")


def _of_table(table: Node, u: np.ndarray) -> np.ndarray:
    """The polynomial of the piece that u lies in, or what holds outside of the knots."""
    edges = np.array([float(knot) for knot in table[2]])
    pieces = [piece_of_table(table, side) for side in range(-1, len(edges))]
    longest = max(len(piece) for _, piece in pieces)
    powers = np.array([[float(c) for c in one] + [0.0] * (longest - len(one)) for _, one in pieces])
    piece = np.searchsorted(edges, u, side="right")
    inside = np.clip(u, edges[0], edges[-1])
    value, s = np.zeros_like(inside), inside - np.array([float(knot) for knot, _ in pieces])[piece]
    for n in reversed(range(longest)):
        value = value * s + powers[piece, n]
    return np.asarray(value)


# The state of a scene as inputs of formulas.


PANELS = 8  # of an integral, each of twelve nodes: a polynomial of degree 23 on each


def inputs_at(
    scene: Scene[Any], t: float, x: Sequence[float], v: Sequence[float], rotor: Sequence[float] = (0.0, 0.0)
) -> dict[Node, float]:
    """Values that formulas read at a time [s]: x and v of each body, angle and speed of a motor."""
    inputs: dict[Node, float] = {TIME: t, ("phi",): rotor[0], ("w",): rotor[1]}
    for i, (place, velocity) in enumerate(zip(x, v, strict=False)):
        inputs["x", i], inputs["v", i] = float(place), float(velocity)
    X, V, _ = (float(np.ravel(value)[0]) for value in motion_of_base(scene, np.array([t])))
    return inputs | {("x", BASE): X, ("v", BASE): V}


def start_inputs(scene: Scene[Any]) -> dict[Node, float]:
    """Values that formulas read at the start of a scene."""
    motor = scene.motor
    rotor = (0.0, 0.0) if motor is None else (float(motor.phi), float(motor.phidot))
    bodies = scene.bodies
    return inputs_at(
        scene, 0.0, [float(body.x) for body in bodies], [float(body.v) for body in bodies], rotor
    )


def potential_of(link: Link[Any], distance: float) -> float:
    """Energy [J] of a link whose formula reads the distance of its ends alone, at x_P - x_Q [m]: the
    integral of its force from 0, by Gauss's rule of twelve nodes on PANELS panels.
    """
    assert link.force is not None
    step, (nodes, weights) = distance / PANELS, map(np.array, elementary.TWELVE)
    places = step * (np.arange(PANELS)[:, None] + nodes)
    own = link.P if link.P >= 0 else link.Q
    at = places if own == link.P else -places
    force = np.broadcast_to(values_of(link.force, {("x", own): at}), places.shape)
    return float(elementary.total((force * weights).ravel())) * step


# Springs that formulas are near the start of a scene: what sets scales of time.


class LinearPart(NamedTuple):
    """A spring [N/m] and damper [N s/m] between P and Q that a formula is for small motions about the start;
    of a rotor [N m/rad], [N m s/rad] against the ground.
    """

    name: str
    P: int
    Q: int
    k: float
    c: float


def linear_parts(scene: Scene[Any]) -> list[LinearPart]:
    """The formulas of links and forces as springs and dampers, those that push back; rates of states are
    none.
    """
    links = [link for link in scene.links if link.force is not None]
    forces = [(force, force.formula) for force in scene.forces if force.formula is not None]
    if not links and not forces:
        return []
    at = start_inputs(scene)
    parts = [_of_link(link, at) for link in links]
    for force, formula in forces:
        k, c = (-_slope(formula, (kind, force.on), at) for kind in "xv")
        parts.append(LinearPart(force.name, force.on, GROUND, k, c))
    return [part for part in parts if part.k > 0 or part.c > 0]


def _of_link(link: Link, at: Inputs) -> LinearPart:
    assert link.force is not None
    own = link.P if link.P >= 0 else link.Q
    sign = 1 if own == link.P else -1
    k, c = (sign * _slope(link.force, (kind, own), at) for kind in "xv")
    return LinearPart(link.name, link.P, link.Q, k, c)


def _slope(formula: Node, of: Node, at: Inputs) -> float:
    """Derivative of a formula at a state; 0 where it has none."""
    value = float(values_of(derivative(formula, of), at))
    return value if np.isfinite(value) else 0.0


# The rotor by whose turns a scene without a period of time is looked at.


PLACES = 8  # of a turn, at which a torque is taken: they cancel its harmonics up to the seventh
NOTHING = 1e-12  # of the largest torque of a turn: rounding


def driven_rotors(scene: Scene[Any]) -> list[int]:
    """Numbers of the rotors whose torque does work over a turn at rest, or reads a state as that of a motor
    with a current does; those first that it drives, or that begin to turn, forwards.
    """
    states = {i for i, body in enumerate(scene.bodies) if body.kind == STATE}
    torques = [force for force in scene.forces if scene.bodies[force.on].kind == ROTOR]
    work = {force.on: _work(scene, force) for force in torques}
    driven = [force.on for force in torques if work[force.on] or _reads_any(force.formula, states)]
    return sorted(driven, key=lambda i: (work[i] or scene.bodies[i].v) < 0)


def _reads_any(formula: Node | None, states: set[int]) -> bool:
    return formula is not None and any(node[0] == "v" and node[1] in states for node in walk([formula]))


def _work(scene: Scene[Any], force: Any) -> float:
    """Mean torque over a turn at rest [N m]; 0 where it is rounding alone."""
    angles = 2 * pi * np.arange(PLACES) / PLACES
    torque = np.full(PLACES, float(force.constant))
    if force.formula is not None:
        inputs: dict[Node, Any] = {**start_inputs(scene), ("x", force.on): angles, ("v", force.on): 0.0}
        torque = torque + values_of(force.formula, inputs)
    total = float(mean(torque))
    return total if abs(total) > NOTHING * np.abs(torque).max(initial=0.0) else 0.0


# Tables: exact polynomials between the knots.


MOST_EXACT = 40  # knots of a spline that is solved in fractions; of longer ones to 1e-80
DIGITS = 80
Pieces = tuple[tuple[Fraction, ...], ...]


def pieces_of(knots: list[Fraction], values: list[Fraction], kind: str) -> Pieces:
    """The polynomials between the knots of a table. Raises ValueError for tables that are none."""
    if len(knots) < 2:
        raise ValueError("a table needs at least two pairs")
    for i, (one, next_) in enumerate(pairwise(knots), 1):
        if one >= next_:
            raise ValueError(f"the first numbers of pairs must rise; those of pairs {i} and {i + 1} do not")
    return spline_pieces(knots, values) if kind == "cubic" else line_pieces(knots, values)


def line_pieces(knots: list[Fraction], values: list[Fraction]) -> Pieces:
    """Straight lines between the knots: value, and slope."""
    return tuple(
        (values[i], (values[i + 1] - values[i]) / (knots[i + 1] - knots[i])) for i in range(len(knots) - 1)
    )


def spline_pieces(knots: list[Fraction], values: list[Fraction]) -> Pieces:
    """The not-a-knot cubic spline: two cubics meet in the third derivative too at the second and last but one
    knot. With two knots a line, with three a parabola.
    """
    if len(knots) == 2:
        return line_pieces(knots, values)
    steps = [b - a for a, b in pairwise(knots)]
    slopes = [(b - a) / h for a, b, h in zip(values, values[1:], steps, strict=False)]
    if len(knots) == 3:
        bend = (slopes[1] - slopes[0]) / (steps[0] + steps[1])
        starts = [slopes[0] - bend * steps[0], slopes[0] + bend * steps[0]]
        return tuple((values[i], starts[i], bend) for i in range(2))
    bends = _second_derivatives(steps, slopes)
    return tuple(
        (
            values[i],
            slopes[i] - steps[i] * (2 * bends[i] + bends[i + 1]) / 6,
            bends[i] / 2,
            (bends[i + 1] - bends[i]) / (6 * steps[i]),
        )
        for i in range(len(steps))
    )


def _second_derivatives(steps: list[Fraction], slopes: list[Fraction]) -> list[Fraction]:
    """Second derivatives M at the knots: h_(i-1) M_(i-1) + 2 (h_(i-1) + h_i) M_i + h_i M_(i+1) = 6 (s_i -
    s_(i-1)), with M_0 = M_1 - h_0 (M_2 - M_1)/h_1 and alike at the end, which leaves three bands.
    """
    n = len(steps)
    cut = _exact if n < MOST_EXACT else _to_digits
    first, last = steps[0] / steps[1], steps[-1] / steps[-2]
    below = [steps[i - 1] for i in range(1, n)]
    middle = [2 * (steps[i - 1] + steps[i]) for i in range(1, n)]
    above = [steps[i] for i in range(1, n)]
    right = [6 * (slopes[i] - slopes[i - 1]) for i in range(1, n)]
    middle[0] += steps[0] * (1 + first)
    above[0] -= steps[0] * first
    middle[-1] += steps[-1] * (1 + last)
    below[-1] -= steps[-1] * last
    for i in range(1, n - 1):
        share = cut(below[i] / middle[i - 1])
        middle[i] = cut(middle[i] - share * above[i - 1])
        right[i] = cut(right[i] - share * right[i - 1])
    inner = [Fraction(0)] * (n - 1)
    for i in range(n - 2, -1, -1):
        behind = above[i] * inner[i + 1] if i < n - 2 else 0
        inner[i] = cut((right[i] - behind) / middle[i])
    start = inner[0] - first * (inner[1] - inner[0]) if n > 2 else inner[0]
    end = inner[-1] + last * (inner[-1] - inner[-2]) if n > 2 else inner[-1]
    return [start, *inner, end]


def _exact(value: Fraction) -> Fraction:
    return value


def _to_digits(value: Fraction) -> Fraction:
    """The value to 80 digits."""
    if not value:
        return value
    places = DIGITS - (len(str(abs(value.numerator))) - len(str(value.denominator)))
    scale = Fraction(10) ** places
    return Fraction(round(value * scale)) / scale


# Gaps of stops and differences of ends on a motion that is known.


def gap_of(
    scene: Any, number: int, t: Any, state: np.ndarray, rates: np.ndarray | None = None
) -> tuple[Any, Any, Any]:
    """Gap of a stop [m], its rate and acceleration at states (N, ...), with their rates of change."""
    stop, n = scene.stops[number], len(scene.bodies)
    base = motion_of_base(scene, t)
    values = state, state[n:], None if rates is None else rates[n:]
    gap, rate, bend = (
        0.0 if of is None else stop.sense * apart(stop, of, base[order]) for order, of in enumerate(values)
    )
    return stop.gap + gap, rate, bend


def apart(part: Any, values: Any, of_base: Any) -> Any:
    """P - Q of the ends of a part: `values` by body, that of the base, and 0 of the ground."""
    P, Q = (values[end] if end >= 0 else of_base if end == BASE else 0.0 for end in (part.P, part.Q))
    return P - Q


def motion_of_base(scene: Any, t: Any) -> tuple[Any, Any, Any]:
    """Displacement, velocity and acceleration of the base at the times t."""
    if scene.base_formula is not None:
        values = [values_of(one, {TIME: t}) for one in base_formulas(scene)]
        return values[0], values[1], values[2]
    x = v = a = 0.0
    for term in scene.base:
        sine, cosine = sine_cosine_of_arrays(term.omega * t + term.phase)
        x = x + term.amplitude * sine
        v = v + term.amplitude * term.omega * cosine
        a = a - term.amplitude * term.omega**2 * sine
    return x, v, a


def motion_of_belt(friction: Any, t: Any) -> tuple[Any, Any]:
    """Velocity and acceleration of the belt of a friction against its Q at the times t."""
    if friction.course is None:
        return friction.belt, 0.0
    formulas = friction.course, derivative(friction.course, TIME)
    velocity, acceleration = (values_of(one, {TIME: t}) for one in formulas)
    return friction.belt + velocity, acceleration
