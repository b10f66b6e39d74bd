"""Values of formulas at given places, velocities and times: for pictures, scales of time, the motion of a
base.

The engines have interpreters of their own; here a formula is taken as it stands, for many instants at once.
Sums and products are rounded as everywhere, functions are those of `vibsim.physics.elementary`: no value
differs from one machine to the next.
"""

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from math import pi
from typing import Any, NamedTuple

import numpy as np

from vibsim.physics import elementary
from vibsim.physics.elementary import mean
from vibsim.physics.formulas import TIME, ZERO, Node, children, derivative, walk
from vibsim.physics.parts import BASE, GROUND, ROTOR, STATE, Link, Scene

Inputs = Mapping[Node, np.ndarray | float]  # what formulas read: node -> values [SI]


def values_of(formula: Node, inputs: Inputs) -> np.ndarray:
    """Values of a formula, of the shape of its inputs; those that are not given count as 0."""
    known: dict[Node, np.ndarray] = {}
    for node in walk([formula]):
        known[node] = _value(node, [known[child] for child in children(node)], inputs)
    return known[formula]


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
            return _of_table(below[0], node[2], node[3])
        return _by_elements(getattr(elementary, kind), below[0])


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


def _of_table(u: np.ndarray, knots: tuple[Fraction, ...], pieces: tuple[Any, ...]) -> np.ndarray:
    """The polynomial of the piece that u lies in; the end values outside."""
    edges = np.array([float(knot) for knot in knots])
    inside = np.clip(u, edges[0], edges[-1])
    piece = np.clip(np.searchsorted(edges, inside, side="right") - 1, 0, len(pieces) - 1)
    longest = max(len(one) for one in pieces)
    powers = np.array([[float(c) for c in one] + [0.0] * (longest - len(one)) for one in pieces])
    value, s = np.zeros_like(inside), inside - edges[piece]
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
    X, V = _base_at(scene, t)
    return inputs | {("x", BASE): X, ("v", BASE): V}


def _base_at(scene: Scene[Any], t: float) -> tuple[float, float]:
    if scene.base_formula is not None:
        X, V = base_motion_of(scene, np.array([t]))
        return float(X[0]), float(V[0])
    place = rate = 0.0
    for term in scene.base:
        sine, cosine = elementary.sine_cosine(float(term.omega) * t + float(term.phase))
        place = place + float(term.amplitude) * sine
        rate = rate + float(term.amplitude) * float(term.omega) * cosine
    return place, rate


def start_inputs(scene: Scene[Any]) -> dict[Node, float]:
    """Values that formulas read at the start of a scene."""
    motor = scene.motor
    rotor = (0.0, 0.0) if motor is None else (float(motor.phi), float(motor.phidot))
    bodies = scene.bodies
    return inputs_at(
        scene, 0.0, [float(body.x) for body in bodies], [float(body.v) for body in bodies], rotor
    )


def base_motion_of(scene: Scene[Any], times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Displacement [m] and velocity [m/s] of a base that moves by a formula of time, at times [s]; of a belt
    the displacement is told as 0.
    """
    assert scene.base_formula is not None
    both = (scene.base_formula, derivative(scene.base_formula, TIME))
    x, v = (values_of(node, {TIME: times}) for node in ((ZERO, both[0]) if scene.base_is_rate else both))
    return np.broadcast_to(x, np.shape(times)).copy(), np.broadcast_to(v, np.shape(times)).copy()


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
    at = start_inputs(scene)
    parts = []
    for link in scene.links:
        if link.force is not None:
            parts.append(_of_link(link, at))
    for force in scene.forces:
        if force.formula is not None:
            k, c = (-_slope(force.formula, (kind, force.on), at) for kind in "xv")
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
    with a current does.
    """
    states = {i for i, body in enumerate(scene.bodies) if body.kind == STATE}
    return [
        force.on
        for force in scene.forces
        if scene.bodies[force.on].kind == ROTOR
        and (_reads_any(force.formula, states) or _works(scene, force))
    ]


def _reads_any(formula: Node | None, states: set[int]) -> bool:
    return formula is not None and any(node[0] == "v" and node[1] in states for node in walk([formula]))


def _works(scene: Scene[Any], force: Any) -> bool:
    angles = 2 * pi * np.arange(PLACES) / PLACES
    torque = np.full(PLACES, float(force.constant))
    if force.formula is not None:
        inputs: dict[Node, Any] = {**start_inputs(scene), ("x", force.on): angles, ("v", force.on): 0.0}
        torque = torque + values_of(force.formula, inputs)
    return bool(abs(mean(torque)) > NOTHING * np.abs(torque).max(initial=0.0))
