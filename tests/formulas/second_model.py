"""What the second solver solves: bodies, links, stops, frictions, forces, rotors and states with their laws.

Numbers are floats in SI units, laws are those of `second_expressions`. An end of a part is the name of
a body, GROUND or BASE. A positive force of a link drives its ends together, as on the page on scenes.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from tests.formulas.second_expressions import Law

GROUND, BASE = "ground", "base"


@dataclass
class Link:
    """P, Q and the force in d and v."""

    name: str
    P: str
    Q: str
    force: Law


@dataclass
class Stop:
    """sense (x_P - x_Q) - gap is the depth p; `force` in p and pv, or the restitution e of a rigid one."""

    name: str
    P: str
    Q: str
    gap: float
    sense: int
    force: Law | None = None
    release: str = "gap"
    e: float | None = None


@dataclass
class Friction:
    """Load N, coefficient mu in s; `static` times mu at s = 0 while sticking."""

    name: str
    P: str
    Q: str
    load: Law
    mu: Law
    static: float = 1.0
    belt: float = 0.0


@dataclass
class Force:
    name: str
    on: str
    force: Law


@dataclass
class Rotor:
    name: str
    on: str
    m: float
    e: float
    J: float
    torque: Law | None
    phi: float
    w: float


@dataclass
class Base:
    """X(t) and its two derivatives."""

    x: Law
    v: Law
    a: Law


@dataclass
class Model:
    """A scene: bodies as {name: (m, x, v)}, states as {name: (rate, start)}."""

    bodies: dict[str, tuple[float, float, float]]
    links: list[Link] = field(default_factory=list)
    stops: list[Stop] = field(default_factory=list)
    frictions: list[Friction] = field(default_factory=list)
    forces: list[Force] = field(default_factory=list)
    rotors: list[Rotor] = field(default_factory=list)
    states: dict[str, tuple[Law, float]] = field(default_factory=dict)
    base: Base | None = None
    t_end: float = 1.0
