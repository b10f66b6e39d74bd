"""A scene made of parts: bodies on one line, what ties, stops, rubs and drives them.

All numbers are SI and rad/s. Bodies are numbered 0, 1, ... in the order of the scene; an end of a part is
the number of a body, GROUND (at rest at 0) or BASE (moves as `Scene.base` says). For a part between P and Q
the relative displacement is x_P - x_Q and the relative velocity v_P - v_Q. Numbers are floats for runs in
doubles; runs of many digits put other number types in.
"""

from dataclasses import dataclass
from functools import lru_cache
from math import ceil
from typing import Any, Generic

from vibsim.physics.formulas import Node
from vibsim.physics.numbers import N

# The instants at which a run is sampled.


class Sampled(Generic[N]):
    """Of a scene that ends at `t_end` [s] and has samples at i * every_num / every_den [s], i = 0, 1, ..."""

    t_end: N
    every_num: int
    every_den: int

    @property
    def sample_count(self) -> int:
        """Number of samples from t = 0 up to and including t_end."""
        count = int(float(self.t_end) * self.every_den / self.every_num)
        while self.sample_time(count) <= self.t_end:
            count += 1
        while count > 0 and self.sample_time(count - 1) > self.t_end:
            count -= 1
        return count

    def sample_index(self, t: N | float) -> int:
        """Index of the first sample at or after t [s]."""
        i = int(float(t) * self.every_den / self.every_num)
        while i > 0 and self.sample_time(i - 1) >= t:
            i -= 1
        while self.sample_time(i) < t:
            i += 1
        return i

    def sample_time(self, i: int) -> float:
        """Time of sample i [s]: one correctly rounded division, so 3 x 5 ms is 0.015 and nothing else.

        In doubles, as C has it; the product is exact up to 2^53.
        """
        return (float(i) * self.every_num) / self.every_den


GROUND, BASE = -1, -2
EXTENSION, COMPRESSION = 1, -1  # sense of a stop: it acts where x_Q - x_P, or x_P - x_Q, exceeds its gap
AT_GAP, AT_FORCE = "gap", "force"  # where an elastic stop lets go: at zero depth, or at zero force


@lru_cache(maxsize=1024)
def columns_of(body: str) -> tuple[str, str]:
    """Names of the columns of a body on the line: x_ram and v_ram; x1 and v1 of one called by the number
    1.
    """
    separator = "" if body.isdigit() else "_"
    return f"x{separator}{body}", f"v{separator}{body}"


BODY, ROTOR, STATE = "body", "rotor", "state"  # kinds of what moves
MOTOR = "motor"  # name of the rotor that a motor with formulas becomes
ANGLE, SPEED = "phi", "phidot"  # columns of a motor


@dataclass(frozen=True)
class Body(Generic[N]):
    """A rigid body: mass m > 0 [kg], displacement x [m] and velocity v [m/s] at t = 0.

    kind : BODY, whose mass is that of the rotors on it as well; ROTOR: x is its angle [rad], v its speed
    [rad/s],
        m its inertia about its shaft, that of its unbalanced mass included [kg m^2]; STATE: v is a further
        state of a scene, the force on it its rate, m is 1, and x says nothing
    turns : whether x of a BODY is an angle [rad], m its inertia [kg m^2], where others move along a line
    """

    name: str
    m: N
    x: N
    v: N
    kind: str = BODY
    turns: bool = False

    @property
    def columns(self) -> tuple[str | None, str]:
        """Names of the columns of its x and v: x_ram and v_ram of a body on the line, phi_left and w_left of
        a rotor (phi and phidot of a motor); a state has one, called as it is, and what is None is never
        shown.
        """
        if self.kind == BODY:
            return columns_of(self.name)
        if self.kind == STATE:
            return None, self.name
        return (ANGLE, SPEED) if self.name == MOTOR else (f"phi_{self.name}", f"w_{self.name}")


@dataclass(frozen=True)
class Rotor:
    """An unbalanced rotor on a body: numbers of the two in the scene, and unbalance m e [kg m].

    M x'' = F + m e (w^2 cos phi + w' sin phi),  (J + m e^2) w' = T + m e x'' sin phi
    """

    column: int
    on: int
    unbalance: Any


@dataclass(frozen=True)
class Link(Generic[N]):
    """Spring k [N/m] and damper c [N s/m] between P and Q: force -k (x_P - x_Q) - c (v_P - v_Q) on P.

    force : formula of the force that drives the ends together [N], -force on P, +force on Q; k and c are 0
    then
    """

    name: str
    P: int
    Q: int
    k: N
    c: N
    force: Node | None = None


@dataclass(frozen=True)
class Stop(Generic[N]):
    """Elastic stop between P and Q: depth g = sense (x_Q - x_P) - gap [m], force k g + c g' in contact [N].

    `release` AT_GAP: contact while g >= 0; AT_FORCE: the force is max(0, k g + c g') while g > 0. `at_start`:
    whether g is exactly 0 at t = 0 by the numbers that these are rounded from. `force`: formula of the force
    in contact [N] in place of k g + c g', sense times it on P; k and c are 0 then.
    """

    name: str
    P: int
    Q: int
    gap: N
    sense: int
    k: N
    c: N
    release: str = AT_GAP
    at_start: bool = False
    force: Node | None = None

    @property
    def jumps(self) -> bool:
        """Whether its force may jump where the depth passes zero."""
        return self.force is not None or self.c != 0

    @property
    def lets_go(self) -> bool:
        """Whether it can let go, at zero force, while it is deep."""
        return self.release == AT_FORCE and self.jumps


@dataclass(frozen=True)
class RigidStop(Generic[N]):
    """Rigid stop between P and Q: depth g = sense (x_Q - x_P) - gap <= 0 always [m]; restitution e, 0 to 1.

    An impact turns the rate of g round and multiplies it by e; at rest, g = g' = 0, the stop pushes as hard
    as it must. `at_start` as of an elastic stop.
    """

    name: str
    P: int
    Q: int
    gap: N
    sense: int
    e: N
    at_start: bool = False


@dataclass(frozen=True)
class Friction(Generic[N]):
    """Dry friction of P on Q, v_rel = v_P - v_Q - belt - course(t).

    forward, backward : force with which slip begins and ends [N], -forward on P where v_rel > 0, +backward
        where v_rel < 0; at all speeds, where there are no `slips`
    belt : velocity of the surface of Q against Q [m/s]
    hold_forward, hold_backward : the most that it can hold against the start of slip in either direction [N],
        not below the force with which slip begins; None: as much as that
    slips : formulas of the forces while slipping forwards and backwards [N], not below 0, as of a friction
        that falls with speed
    holds : formulas of the most that it can hold against the start of slip in either direction [N], where
        that or the force with which slip begins is no number; forward and backward are 0 then
    rises : of `holds`, whether these are above the forces with which slip begins, forwards and backwards
    course : formula of the time alone of what the belt has in velocity beside `belt` [m/s], or None; slips
        and holds are formulas then
    """

    name: str
    P: int
    Q: int
    forward: N
    backward: N
    belt: N
    hold_forward: N | None = None
    hold_backward: N | None = None
    slips: tuple[Node, Node] | None = None
    holds: tuple[Node, Node] | None = None
    rises: tuple[bool, bool] = (False, False)
    course: Node | None = None

    @property
    def runs(self) -> bool:
        """Whether it has a belt of its own that moves."""
        return bool(self.belt != 0) or self.course is not None

    @property
    def limits(self) -> tuple[N, N]:
        """The most that it holds against slip forwards and backwards [N]."""
        return (
            self.forward if self.hold_forward is None else self.hold_forward,
            self.backward if self.hold_backward is None else self.hold_backward,
        )

    def drops(self, sense: int) -> bool:
        """Whether its force jumps where it begins to slip."""
        if self.holds is not None:
            return self.rises[0 if sense > 0 else 1]
        limits = self.limits
        return bool(limits[0] > self.forward if sense > 0 else limits[1] > self.backward)


@dataclass(frozen=True)
class Harmonic(Generic[N]):
    """amplitude sin(omega t + phase); omega / (2 pi) = cycles + cycles_lo [Hz], a double-double."""

    amplitude: N
    omega: N
    cycles: N
    cycles_lo: N
    phase: N


@dataclass(frozen=True)
class Force(Generic[N]):
    """Force on a body: constant + sum of harmonics [N], and a formula [N]; the torque on a rotor [N m], and
    the rate of a state.
    """

    name: str
    on: int
    constant: N
    terms: tuple[Harmonic[N], ...]
    formula: Node | None = None

    @property
    def acts(self) -> bool:
        """Whether it is more than its formula."""
        return self.formula is None or bool(self.terms) or self.constant != 0


@dataclass(frozen=True)
class Motor(Generic[N]):
    """DC motor of limited power with an unbalanced rotor on a body, Eqs. (2.8)-(2.10) of the paper.

    Unbalanced mass m3 [kg], eccentricity e [m], rotor inertia J [kg m^2], stall torque M0 [N m], no-load
    speed Omega0 [rad/s]; rotor angle phi [rad] and speed phidot [rad/s] at t = 0.
    """

    on: int
    m3: N
    e: N
    J: N
    M0: N
    Omega0: N
    phi: N
    phidot: N

    @property
    def constants(self) -> tuple[Any, ...]:
        """All but its start."""
        return self.on, self.m3, self.e, self.J, self.M0, self.Omega0

    @property
    def unbalance(self) -> N:
        """m3 e [kg m]."""
        return self.m3 * self.e

    @property
    def inertia(self) -> N:
        """Of rotor and unbalanced mass about the shaft [kg m^2]."""
        return self.J + self.unbalance * self.e

    @property
    def drag(self) -> N:
        """By how much the torque falls with the speed [N m s]."""
        return self.M0 / self.Omega0

    def torque(self, w: N) -> N:
        """Torque [N m] at the speed w [rad/s] of the rotor, Eq. (2.8): M0 (1 - w / Omega0)."""
        return self.M0 - self.drag * w


@dataclass(frozen=True)
class Clearance(Generic[N]):
    """A limit that is watched and exerts no force: x_P - x_Q <= distance [m]; `at_start` as of a stop."""

    name: str
    P: int
    Q: int
    distance: N
    at_start: bool = False


@dataclass(frozen=True)
class Scene(Sampled[N], Generic[N]):
    """Parts and run settings of one simulation.

    Attributes
    ----------
    bodies, links, stops, frictions, forces, clearances : the parts, in the order of the case
    base : harmonics of the displacement X(t) [m] of BASE
    base_formula : formula of X(t) [m] in the time alone, in place of harmonics
    base_is_rate : whether that is a formula of the velocity X'(t) [m/s] of a belt on the ground, whose place
        nothing feels
    motor : the motor, or None
    rotors : the unbalanced rotors among the bodies
    torsional : whether all displacements are angles [rad]
    state_units : name of each state, and its unit as a case has it, such as ("i", "A"); "" where it has none
    stop_on_violation : whether the run ends where a clearance is violated
    t_end : end of the run [s]; samples at i * every_num / every_den [s], i = 0, 1, ...
    method : "auto", "closed_form" or "taylor"; order and tol of the Taylor flow
    """

    bodies: tuple[Body[N], ...]
    links: tuple[Link[N], ...] = ()
    stops: tuple[Stop[N] | RigidStop[N], ...] = ()
    frictions: tuple[Friction[N], ...] = ()
    forces: tuple[Force[N], ...] = ()
    base: tuple[Harmonic[N], ...] = ()
    motor: Motor[N] | None = None
    clearances: tuple[Clearance[N], ...] = ()
    stop_on_violation: bool = False
    t_end: N = 0.0  # type: ignore[assignment]  # the default is one for doubles
    every_num: int = 1
    every_den: int = 200
    method: str = "auto"
    order: int = 20
    tol: N | float = 2.0**-53
    base_formula: Node | None = None
    base_is_rate: bool = False
    rotors: tuple[Rotor, ...] = ()
    torsional: bool = False
    state_units: tuple[tuple[str, str], ...] = ()

    @property
    def has_motor(self) -> bool:
        return self.motor is not None

    @property
    def line(self) -> tuple[Body[N], ...]:
        """The bodies on the line, which come first: all but rotors and states."""
        if self.bodies[-1].kind == BODY:
            return self.bodies
        return tuple(body for body in self.bodies if body.kind == BODY)

    @property
    def length_unit(self) -> str:
        """Unit of displacements: rad of a torsional scene."""
        return "rad" if self.torsional else "m"

    def unit_of(self, body: Body[N]) -> str:
        """Unit of the displacement of a body or rotor."""
        return "rad" if body.turns or body.kind == ROTOR else self.length_unit

    def unit_between(self, *ends: int) -> str:
        """Unit of the displacement between the ends of a part: rad where one of them turns."""
        return next((self.unit_of(self.bodies[end]) for end in ends if end >= 0), self.length_unit)

    def unit_of_stops(self, name: str | None = None) -> str:
        """Unit of the gap of a stop; without a name of all stops, m where some turn and others do not."""
        units = {self.unit_between(stop.P, stop.Q) for stop in self.stops if name in (None, stop.name)}
        return units.pop() if len(units) == 1 else self.length_unit

    @property
    def force_unit(self) -> str:
        """Unit of forces: N m of a torsional scene, where they are torques."""
        return "N m" if self.torsional else "N"

    @property
    def has_formulas(self) -> bool:
        """Whether any part has a law that is a formula, or there is a rotor or a state."""
        return (
            self.base_formula is not None
            or self.bodies[-1].kind != BODY
            or any(link.force is not None for link in self.links)
            or any(isinstance(stop, Stop) and stop.force is not None for stop in self.stops)
            or any(friction.slips is not None for friction in self.frictions)
            or any(force.formula is not None for force in self.forces)
        )

    @property
    def has_courses(self) -> bool:
        """Whether a friction has a belt whose velocity is a formula of its own."""
        return any(friction.course is not None for friction in self.frictions)

    @property
    def has_stop(self) -> bool:
        return bool(self.stops)

    @property
    def elastic_stops(self) -> list[tuple[int, Stop[N]]]:
        """The elastic stops, each with its number among all stops."""
        return [(i, stop) for i, stop in enumerate(self.stops) if isinstance(stop, Stop)]

    @property
    def rigid_stops(self) -> list[tuple[int, RigidStop[N]]]:
        """The rigid stops, each with its number among all stops."""
        return [(i, stop) for i, stop in enumerate(self.stops) if isinstance(stop, RigidStop)]

    @property
    def harmonics(self) -> list[Harmonic[N]]:
        """The harmonics of all forces, then those of the base."""
        return [term for force in self.forces for term in force.terms] + list(self.base)

    @property
    def has_base(self) -> bool:
        """Whether the base has a motion, be it one of amplitudes 0."""
        return bool(self.base) or self.base_formula is not None

    @property
    def base_moves(self) -> bool:
        """Whether the base moves: where all its amplitudes are 0 it is one with the ground."""
        return self.base_formula is not None or any(term.amplitude != 0 for term in self.base)

    def column(self, end: int) -> int:
        """Column of an end of a part: bodies in their order, then ground, then the base where it moves."""
        if end >= 0:
            return end
        return len(self.bodies) + (end == BASE and self.base_moves)

    def but(self, **parts: Any) -> "Scene[N]":
        """The same with other parts or settings, as `dataclasses.replace`: in a third of its time."""
        other = object.__new__(type(self))
        vars(other).update(vars(self), **parts)
        return other

    def same_but_for_start(self, other: "Scene[N]") -> bool:
        """Whether another scene differs in displacements and velocities at t = 0 alone, as far as the same
        objects as parts tell. Not of one with rotors: there these may decide whose turns are its cycles.
        """
        theirs = vars(other)
        for name, value in vars(self).items():  # a loop: it is asked several times for each point of a sweep
            another = theirs[name]
            if another is value or name in ("bodies", "motor"):
                continue
            if not isinstance(value, int | float | str) or another != value:
                return False
        for one, two in zip(self.bodies, other.bodies, strict=True):
            if (one.name, one.m, one.turns) != (two.name, two.m, two.turns):
                return False
            if not one.kind == two.kind != ROTOR:
                return False
        return (self.motor and self.motor.constants) == (other.motor and other.motor.constants)

    def without_samples(self) -> "Scene[N]":
        """The same with no sample but that of t = 0; no motion depends on its samples."""
        return self.but(every_num=2 * ceil(float(self.t_end)) or 1, every_den=1)

    def end_name(self, end: int) -> str:
        """Name of an end of a part: a body's name, ground or base."""
        return {GROUND: "ground", BASE: "base"}.get(end) or self.bodies[end].name


# Names and codes of the events, the same in C and in every file.


EVENT_KINDS = {
    "start": 0,
    "contact_begin": 1,
    "contact_end": 2,
    "reversal": 3,
    "stick_begin": 4,
    "stick_end": 5,
    "violation_begin": 6,
    "violation_end": 7,
    "end": 8,
    "impact": 9,
    "transmitted": 10,
    "chatter": 11,
    "rest_begin": 12,
    "rest_end": 13,
    "switch": 14,
}
IMPACTS = ("contact_begin", "impact")  # of elastic stops, and of rigid ones
RIGID_KINDS = ("impact", "transmitted", "chatter", "rest_begin", "rest_end")  # of rigid stops alone
SWITCH = "switch"  # kind of the events at which a formula jumps; of formulas alone
EVENT_NAMES = {code: name for name, code in EVENT_KINDS.items()}
# laws by which a friction falls with the speed of slip, see vibsim.cases.formula_building
HYPERBOLIC, EXPONENTIAL = "stribeck hyperbolic", "stribeck exponential"
