"""The schema of the long form: named parts with their keys, units, ranges and defaults.

What concerns several keys at once stands in the modules of rules beside this one.
"""

import types
from functools import cache
from typing import Annotated, Any, Literal, get_args, get_origin

from vibsim.cases.quantities import Quantity
from vibsim.cases.schema import (
    Amplitude,
    Angle,
    AnyQuantity,
    CaseHead,
    Eccentricity,
    Force,
    Key,
    Length,
    Mass,
    PositiveRate,
    Rate,
    RunKeys,
    Section,
    Velocity,
    WithFormulas,
    key,
    left_out,
    optional,
)
from vibsim.cases.schema_kinds import FORMULA_KEYS, Formula, Json, Measured, WholeNumber, kind_of_value
from vibsim.cases.short_form import Ends


class FormulaText:
    """A key that always holds a formula."""

    def read(self, value: object) -> Formula:
        if isinstance(value, Formula):
            return value
        if isinstance(value, bool) or not isinstance(value, str | int | float):
            raise ValueError(f"must be a formula, got {kind_of_value(value)}")
        return Formula(str(value))

    def json_schema(self) -> Json:
        return {"type": ["string", "number"], "description": "a formula"}


Stiffness = Annotated[Quantity, Measured("stiffness", least="0")]
Damping = Annotated[Quantity, Measured("damping", least="0")]
FrictionCoefficient = Annotated[Quantity, Measured("number", least="0")]
MuOrFormula = Annotated[Quantity | Formula, Measured("number", least="0", formula=True)]
AnyFormula = Annotated[Formula, FormulaText()]
StaticRatio = Annotated[Quantity, Measured("number", least="1")]

MU = left_out("law coulomb: friction coefficient while slipping; or a formula in the slip speed s", "0.2")
MU_S = left_out("laws stribeck: friction coefficient at speed 0, and of the limit while sticking", "0.37")
MU_D = left_out("laws stribeck: friction coefficient at high speed, at most mu_s", "0.19")
D = left_out("law stribeck hyperbolic: mu = mu_d + (mu_s - mu_d) / (1 + d |v_rel|)", "18 s/m")
V0 = left_out("law stribeck exponential: mu = mu_d + (mu_s - mu_d) exp(-|v_rel| / v0)", "0.26 m/s")
STATIC = left_out(
    "law coulomb: limit while sticking over the force while slipping, at least 1; left out: 1", "1.3"
)
BETWEEN = key("the two ends: bodies, ground or base", "[ram, ground]")
ON = key("the body that it acts on", "ram")


class LinkKeys(WithFormulas):
    """Spring and damper between two ends: force -k (x_P - x_Q) - c (v_P - v_Q) on P; or minus a formula."""

    formulas = FORMULA_KEYS["links"]
    between: Ends = BETWEEN
    force: AnyFormula | None = left_out(
        "formula of the force that drives the ends together, in d = x_P - x_Q and v = v_P - v_Q; "
        "beside it k, c and others are numbers of the formula",
        '"k*d + k3*d**3"',
    )
    k: Stiffness = optional("0 N/m", "stiffness", "4 kN/m")
    c: Damping = optional("0 N s/m", "damping", "2 N s/m")


class AnyStop(WithFormulas):
    """A stop: an elastic one pushes its ends back with k g + c g' in contact, g the depth, or with a formula;
    a rigid one turns the rate of g round in an impact.
    """

    formulas = FORMULA_KEYS["stops"]
    between: Ends = BETWEEN
    gap: Length = key("free distance, 0 or negative too; measured from all displacements 0", "1 mm")
    acts: Literal["extension", "compression"] = key(
        "extension: contact while x_Q - x_P >= gap; compression: while x_P - x_Q >= gap", "compression"
    )
    law: Literal["elastic", "rigid"] = key("law of contact", default="elastic")
    k: Annotated[Quantity, Measured("stiffness", above="0")] | None = left_out(
        "stiffness in contact (elastic only)", "1 MN/m"
    )
    c: Damping = optional("0 N s/m", "damping in contact (elastic only)", "20 N s/m")
    release: Literal["gap", "force"] = key(
        "gap: in contact while the depth g >= 0; force: pushes max(0, k g + c g') while g > 0 (elastic only)",
        default="gap",
    )
    e: Annotated[Quantity, Measured("number", least="0", most="1")] | None = left_out(
        "coefficient of restitution (rigid only)", "0.8"
    )
    force: AnyFormula | None = left_out(
        "formula of the force in contact, in the depth p and its rate pv, in place of k and c", '"K*p**1.5"'
    )


class OneWay(WithFormulas):
    """Friction in one direction of slip: the coefficients of the law, or a formula of mu."""

    formulas = FORMULA_KEYS["friction"][:1]
    mu: MuOrFormula | None = MU
    static: StaticRatio | None = STATIC
    mu_s: FrictionCoefficient | None = MU_S
    mu_d: FrictionCoefficient | None = MU_D
    d: Annotated[Quantity, Measured("inverse velocity", least="0")] | None = D
    v0: Annotated[Quantity, Measured("velocity", above="0")] | None = V0


class DryFriction(WithFormulas):
    """Dry friction of P on Q; v_rel = v_P - v_Q - belt."""

    formulas = FORMULA_KEYS["friction"]
    between: Ends = BETWEEN
    law: Literal["coulomb", "stribeck hyperbolic", "stribeck exponential"] = key(
        "law of friction", default="coulomb"
    )
    mu: MuOrFormula | None = MU
    static: StaticRatio | None = STATIC
    mu_s: FrictionCoefficient | None = MU_S
    mu_d: FrictionCoefficient | None = MU_D
    d: Annotated[Quantity, Measured("inverse velocity", least="0")] | None = D
    v0: Annotated[Quantity, Measured("velocity", above="0")] | None = V0
    plus: OneWay | None = left_out(
        "where v_rel > 0; with minus, in place of coefficients for both directions"
    )
    minus: OneWay | None = left_out(
        "where v_rel < 0; with plus, in place of coefficients for both directions"
    )
    N: Annotated[Quantity | Formula, Measured("force", least="0", formula=True)] | None = left_out(
        "normal load, or a formula of it; left out: m g of the first end", "3 N"
    )
    g: Annotated[Quantity, Measured("acceleration", above="0")] | None = left_out(
        "gravity, where N is left out; 9.81 m/s^2 by default", "9.81 m/s^2"
    )
    belt: Annotated[Quantity | Formula, Measured("velocity", formula=True)] = optional(
        "0 m/s", "velocity of the surface of Q against Q", "0.2 m/s"
    )


class ForceTerm(Section):
    """A sin(omega t + phase)."""

    A: Amplitude = key("amplitude", "10 N")
    omega: PositiveRate = key("frequency", "25 Hz")
    phase: Angle = optional("0 rad", "phase at t = 0; 90 deg: a cosine", "90 deg")


class BodyForce(WithFormulas):
    """Force F0 + sum of A sin(omega t + phase) on a body, or a formula."""

    formulas = FORMULA_KEYS["forces"]
    on: str = ON
    force: AnyFormula | None = left_out(
        "formula of the force, in place of A, omega, phase, terms and F0", '"A*sin(w*t + r*t**2/2)"'
    )
    A: Amplitude | None = left_out("amplitude", "10 N")
    omega: PositiveRate | None = left_out("frequency", "25 Hz")
    phase: Angle | None = left_out("phase at t = 0, 0 by default; 90 deg: a cosine", "90 deg")
    terms: dict[str, ForceTerm] | None = left_out("several harmonics, in place of A, omega and phase")
    F0: Force = optional("0 N", "constant part", "-2 N")


class BaseTerm(Section):
    """a sin(omega t + phase)."""

    a: Length = key("amplitude", "0.1 mm")
    omega: PositiveRate = key("frequency", "50 Hz")
    phase: Angle = optional("0 rad", "phase at t = 0", "90 deg")


class BaseMotion(WithFormulas):
    """Displacement of base: sum of a sin(omega t + phase), or a formula."""

    formulas = FORMULA_KEYS["base"]
    x: AnyFormula | None = left_out(
        "formula of the displacement in t alone, in place of a, omega, phase and terms",
        '"a*sin(w*t)*min(t/rise, 1)"',
    )
    a: Length | None = left_out("amplitude", "0.1 mm")
    omega: PositiveRate | None = left_out("frequency", "50 Hz")
    phase: Angle | None = left_out("phase at t = 0, 0 by default", "90 deg")
    terms: dict[str, BaseTerm] | None = left_out("several harmonics, in place of a, omega and phase")


class BodyMotor(WithFormulas):
    """Motor of limited power with an unbalanced rotor on a body, Eqs. (2.8) to (2.10)."""

    formulas = FORMULA_KEYS["motor"]
    on: str = ON
    m3: Mass = key("unbalanced mass", "0.03 kg")
    e: Eccentricity = key("eccentricity; negative: mirrored", "0.11 m")
    J: Annotated[Quantity, Measured("inertia", least="0")] = key(
        "moment of inertia of the rotor without m3", "0.001 kg m^2"
    )
    M0: Annotated[Quantity | Formula, Measured("torque", least="0", formula=True)] = key(
        "torque at standstill, or a formula of it", "0.005 N m"
    )
    Omega0: Annotated[Quantity | Formula, Measured("angular rate", above="0", formula=True)] = key(
        "speed at which the torque vanishes, or a formula of it", "5.5 Hz"
    )
    torque: AnyFormula | None = left_out(
        "formula of the torque on the rotor, in phi and w, in place of M0 and Omega0", '"M0*(1 - w/Omega0)"'
    )


class RotorKeys(WithFormulas):
    """An unbalanced rotor on a body: a motor, an exciter or a pendulum."""

    formulas = FORMULA_KEYS["rotors"]
    on: str = ON
    m: Annotated[Quantity, Measured("mass", least="0")] = optional("0 kg", "unbalanced mass", "0.03 kg")
    e: Length = optional("0 m", "eccentricity; negative: mirrored", "0.11 m")
    J: Annotated[Quantity, Measured("inertia", least="0")] = optional(
        "0 kg m^2", "moment of inertia of the rotor without m", "0.001 kg m^2"
    )
    torque: AnyFormula | None = left_out(
        "formula of the torque on the rotor, in phi and w; without it and M0 there is none",
        '"-m*g*e*cos(phi)"',
    )
    M0: Annotated[Quantity | Formula, Measured("torque", formula=True)] | None = left_out(
        "torque at standstill, or a formula of it", "0.005 N m"
    )
    Omega0: Annotated[Quantity | Formula, Measured("angular rate", formula=True)] | None = left_out(
        "speed at which the torque M0 (1 - w / Omega0) vanishes, or a formula of it; of a motor "
        "that turns backwards below 0, as M0",
        "5.5 Hz",
    )


class StateKeys(WithFormulas):
    """A further state of first order, such as a current: its name stands for it in formulas."""

    formulas = FORMULA_KEYS["states"]
    rate: AnyFormula = key("formula of its rate", '"(U - R*i)/L"')
    start: AnyQuantity = optional("0", "value at t = 0, with the unit of the state", "0 A")


class StartState(Section):
    """State of a body or a rotor, of that of the motor under the name motor, at t = 0; 0 unless given."""

    x: Length | None = left_out("displacement of a body", "1 mm")
    v: Velocity | None = left_out("velocity of a body", "0 m/s")
    phi: Angle | None = left_out("angle of a rotor", "90 deg")
    phidot: Rate | None = left_out("rotor speed (motor only)", "0 Hz")
    w: Rate | None = left_out("speed of a rotor (not of motor)", "0 Hz")


class ClearanceKeys(Section):
    """A limit that is watched and exerts no force: x_P - x_Q <= distance."""

    between: Ends = BETWEEN
    distance: Annotated[Quantity, Measured("length", above="0")] = key(
        "distance of the ends at rest", "80 mm"
    )


class PartsRun(RunKeys):
    """How long, how often and how."""

    order: Annotated[int, WholeNumber(4, 40)] | None = left_out(  # type: ignore[assignment]
        "order of the Taylor series, the highest where formulas are stiff; left out: 32 where formulas or"
        " rotors are smooth and nothing else ends a step (stops, friction, clearances, states), else 20"
    )
    on_violation: Literal["warn", "stop"] = key(
        "of a clearance: count and warn, or end the run", default="warn"
    )


class PartsFile(CaseHead):
    """A scene of bodies on a line, made of named parts, and one run of it."""

    parameters: dict[str, AnyQuantity] = key(
        "numbers that formulas read, by name", "{g: 9.81 m/s^2}", default={}
    )
    bodies: dict[str, Mass] = key("name and mass of each body", "{ram: 2 kg}")
    links: dict[str, LinkKeys] = key("springs and dampers, by name", default={})
    stops: dict[str, AnyStop] = key("stops, by name", default={})
    friction: dict[str, DryFriction] = key("dry frictions, by name", default={})
    forces: dict[str, BodyForce] = key("forces on bodies, by name", default={})
    states: dict[str, StateKeys] = key("further states of first order, by name", default={})
    rotors: dict[str, RotorKeys] = key("unbalanced rotors on bodies, by name", default={})
    base: BaseMotion | None = left_out("motion of base; left out: there is none")
    motor: BodyMotor | None = left_out("the motor; left out: there is none")
    initial: dict[str, StartState] = key(
        "state at t = 0 by body and rotor, of that of the motor as motor; left out: at rest", default={}
    )
    clearances: dict[str, ClearanceKeys] = key("limits that are watched, by name", default={})
    run: PartsRun = key("left out: 300 s, every 5 ms", default={})


# The long form of a torsional scene: bodies turn, x is an angle [rad], forces are torques [N m]. Its sections
# and keys are those of bodies on a line, with other dimensions at their values.


TURNED = {
    "mass": "inertia",
    "length": "angle",
    "velocity": "angular rate",
    "inverse velocity": "inverse angular rate",
    "force": "torque",
    "stiffness": "torsional stiffness",
    "damping": "torsional damping",
}
TEXTS = {
    "0 N/m": "0 N m/rad",
    "0 N s/m": "0 N m s/rad",
    "0 m/s": "0 rad/s",
    "0 N": "0 N m",
    "1e-6 m": "1e-6 rad",
    "1 um": "1e-6 rad",
    "1 mm": "1 mrad",
    "2 kg": "0.3 kg m^2",
    "{ram: 2 kg}": "{disc: 0.3 kg m^2}",
    "4 kN/m": "4 kN m/rad",
    "1 MN/m": "1 MN m/rad",
    "2 N s/m": "2 N m s/rad",
    "10 N": "10 N m",
    "3 N": "3 N m",
}  # defaults and examples
UNCHANGED = ("rotors", "motor")  # which no torsional scene has


@cache
def turning_file(mixed: bool = False) -> type[CaseHead]:
    """The outermost section of a torsional scene, or of one in which some bodies turn and others do not."""
    turned: type[CaseHead] = _turned_section(PartsFile, mixed)
    return turned


def _turned_section(section: Any, mixed: bool) -> Any:
    """The section with the dimensions of turning bodies; mixed: with either ones."""
    turned: Any = type(section.__name__, (section,), {"__doc__": section.__doc__, "__annotations__": {}})
    kept = (*UNCHANGED, "base", "run") if mixed else UNCHANGED
    turned.keys = {
        name: key if name in kept else _turned_key(key, mixed) for name, key in section.keys.items()
    }
    return turned


def _turned_key(key: Key, mixed: bool) -> Key:
    if mixed:
        return Key(_turned(key.annotation, mixed), key.default, key.description, key.examples)
    default = TEXTS.get(key.default, key.default) if isinstance(key.default, str) else key.default
    examples = [TEXTS.get(example, example) for example in key.examples]
    return Key(_turned(key.annotation, mixed), default, key.description, examples)


def _turned(annotation: Any, mixed: bool) -> Any:
    """An annotation with other dimensions in it; the rule of an amplitude, m3 e omega^2, is left out."""
    if isinstance(annotation, type) and get_origin(annotation) is None:
        return _turned_section(annotation, mixed) if issubclass(annotation, Section) else annotation
    if get_origin(annotation) is Annotated:
        inner, *notes = get_args(annotation)
        measured = next((note for note in notes if isinstance(note, Measured)), None)
        if measured is not None:
            dimension = TURNED.get(measured.dimension, measured.dimension)
            if dimension not in TURNED.values():
                return annotation
            if mixed:
                return Annotated[inner, measured._replace(also=dimension, alternative="", any_unit=True)]
            return Annotated[inner, measured._replace(dimension=dimension, alternative="", any_unit=True)]
        variants = [one for one in get_args(inner) if _measure_in(one) is not None]
        if variants:
            return _turned(variants[-1], mixed)
        return annotation
    if get_origin(annotation) is dict:
        key, value = get_args(annotation)
        return types.GenericAlias(dict, (key, _turned(value, mixed)))
    arguments = [one for one in get_args(annotation) if one is not type(None)]
    if len(arguments) == 1 and len(get_args(annotation)) == 2:
        return _turned(arguments[0], mixed) | None
    return annotation


def _measure_in(annotation: Any) -> Measured | None:
    notes = getattr(annotation, "__metadata__", ())
    return next((note for note in notes if isinstance(note, Measured)), None)
