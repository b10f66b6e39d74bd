"""The machine of the paper by the symbols of the paper: two blocks, one spring, one stop, one friction.

Parts missing from the scene are None and add no terms. The fields are floats; runs of arbitrary
precision put other number types in. The engine reads `as_parts()`.
"""

from dataclasses import dataclass
from typing import Any

from vibsim.physics.numbers import N
from vibsim.physics.parts import (
    COMPRESSION,
    EXTENSION,
    GROUND,
    Body,
    Clearance,
    Force,
    Friction,
    Harmonic,
    Link,
    Motor,
    Sampled,
    Scene,
    Stop,
)

Number = Any  # of any type that has operators


@dataclass(frozen=True)
class TwoBlocks(Sampled):
    """Parameters, initial state and run settings of one simulation (symbols as in the paper).

    Attributes
    ----------
    m1, m2 : masses of the blocks [kg]; m2 is None where block 2 is fixed (a wall)
    k1, c : coupling spring [N/m] and damper [N s/m], Eqs. (2.4), (2.6)
    k2, G : impact spring [N/m] and gap [m], Eq. (2.5); k2 is None without a stop
    stop_sign : +1, contact while x2 - x1 >= G (the paper); -1, contact while x1 - x2 >= G
    N : limit friction force mu m2 g [N], Eq. (2.7); None without friction
    source : "none", "harmonic" (Eqs. 2.1-2.3) or "motor" (Eqs. 2.8-2.10)
    A, F0 : amplitude and constant part of the force on block 1 [N], harmonic source
    omega : excitation frequency [rad/s]; omega / (2 pi) = cycles + cycles_lo [Hz], a double-double
    m3, e, J : unbalanced mass [kg], eccentricity [m], rotor inertia [kg m^2]
    M0, Omega0 : stall torque [N m] and no-load speed [rad/s] of the motor
    x1, v1, x2, v2, phi, phidot : state at t = 0 [m, m/s, rad, rad/s]
    rest_distance : distance of the blocks at rest [m] or None; stop_on_violation ends the run there
    t_end : end of the run [s]; samples at i * every_num / every_den [s], i = 0, 1, ...
    method : "auto", "closed_form" or "taylor"; order and tol of the Taylor flow
    at_stop, at_rest_distance : whether the exact numbers that these are rounded from start the blocks exactly
    at the stop, or at the rest distance, where rounded ones may lie beside it
    """

    m1: Number
    m2: Number
    k1: Number
    c: Number
    k2: Number
    G: Number
    stop_sign: int
    N: Number
    source: str
    A: Number
    F0: Number
    omega: Number
    cycles: Number
    cycles_lo: Number
    m3: Number
    e: Number
    J: Number
    M0: Number
    Omega0: Number
    x1: Number
    v1: Number
    x2: Number
    v2: Number
    phi: Number
    phidot: Number
    rest_distance: Number
    stop_on_violation: bool
    t_end: Number
    every_num: int
    every_den: int
    method: str = "auto"
    order: int = 20
    tol: Number = 2.0**-53
    at_stop: bool = False
    at_rest_distance: bool = False

    @property
    def has_block2(self) -> bool:
        return self.m2 is not None

    @property
    def has_stop(self) -> bool:
        return self.k2 is not None

    @property
    def has_friction(self) -> bool:
        return self.N is not None

    @property
    def has_motor(self) -> bool:
        return self.source == "motor"

    def as_parts(self) -> Scene:
        """The same scene as a list of parts; called as in the long form of a case in the short form."""
        zero, other = self.m1 - self.m1, 1 if self.has_block2 else GROUND
        first = Body("1", self.m1, self.x1, self.v1)
        second = (Body("2", self.m2, self.x2, self.v2),) if self.has_block2 else ()
        sense = EXTENSION if self.stop_sign == 1 else COMPRESSION
        return Scene(
            bodies=(first, *second),
            links=(Link("coupling", 0, other, self.k1, self.c),),
            stops=(Stop("stop", 0, other, self.G, sense, self.k2, zero, at_start=self.at_stop),)
            if self.has_stop
            else (),
            frictions=(Friction("friction", 1, GROUND, self.N, self.N, zero),) if self.has_friction else (),
            forces=self._forces(zero),
            motor=self._motor(),
            clearances=()
            if self.rest_distance is None
            else (Clearance("rest_distance", 0, other, self.rest_distance, self.at_rest_distance),),
            stop_on_violation=self.stop_on_violation,
            t_end=self.t_end,
            every_num=self.every_num,
            every_den=self.every_den,
            method=self.method,
            order=self.order,
            tol=self.tol,
        )

    def _forces(self, zero: Number) -> tuple[Force, ...]:
        if self.source != "harmonic":
            return ()
        term = Harmonic(self.A, self.omega, self.cycles, self.cycles_lo, zero)
        return (Force("excitation", 0, self.F0, (term,)),)

    def _motor(self) -> Motor | None:
        if not self.has_motor:
            return None
        return Motor(0, self.m3, self.e, self.J, self.M0, self.Omega0, self.phi, self.phidot)


def is_papers(scene: Scene) -> bool:
    """Whether a scene is the machine of the paper, or a part of it: its parts are called and tied as
    `TwoBlocks.as_parts` has them.
    """
    called = {
        "bodies": ("1", "2"),
        "links": ("coupling",),
        "stops": ("stop",),
        "frictions": ("friction",),
        "forces": ("excitation",),
        "clearances": ("rest_distance",),
    }
    names = {section: tuple(part.name for part in getattr(scene, section)) for section in called}
    tied = [(part.P, part.Q) for part in (*scene.links, *scene.stops, *scene.clearances)]
    other = 1 if len(scene.bodies) > 1 else GROUND
    return (
        len(scene.links) == 1
        and all(names[section] == of[: len(names[section])] for section, of in called.items())
        and all(ends == (0, other) for ends in tied)
        and all((part.P, part.Q) == (1, GROUND) for part in scene.frictions)
        and not scene.base
    )


# The force between the blocks as printed, for what the engine is judged by, which has it as rows of a mode.
# Relative displacement y = x1 - x2, its rate u = v1 - v2.


def transmitted_force(scene: TwoBlocks, y: N, u: N, contact: bool) -> N:
    """S = F_s1 + F_d (+ F_s2 in contact) [N], Eqs. (2.4)-(2.6): what block 1 passes to block 2.

    Arguments: y [m], u [m/s], contact (bool). Eq. (2.5) is k2 (y + G) with the paper's stop, k2 (y - G) with
    its mirror image.
    """
    force: N = scene.k1 * y + scene.c * u
    if contact:
        force = force + scene.k2 * (y + scene.stop_sign * scene.G)
    return force
