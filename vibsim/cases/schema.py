"""The schema of a case file: sections, keys, units, ranges and defaults, as pydantic models.

`vibsim schema` prints it as JSON Schema. What concerns several keys at once stands in contradictions.py.
"""

from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Discriminator, Field, Tag
from pydantic_core import PydanticCustomError

from vibsim.cases.measured import Measured
from vibsim.cases.problems import shown
from vibsim.cases.quantities import Quantity, parse_quantity

NAME_PATTERN = r"[A-Za-z0-9][A-Za-z0-9._+ -]*"

Mass = Annotated[Quantity, Measured("mass", above="0")]
MassOrFixed = Annotated[Quantity | str, Measured("mass", above="0", word="fixed")]
Length = Annotated[Quantity, Measured("length")]
Velocity = Annotated[Quantity, Measured("velocity")]
Force = Annotated[Quantity, Measured("force")]
Duration = Annotated[Quantity, Measured("time", above="0")]
Angle = Annotated[Quantity, Measured("angle")]
Rate = Annotated[Quantity, Measured("angular rate")]
PositiveRate = Annotated[Quantity, Measured("angular rate", above="0")]
Eccentricity = Annotated[Quantity, Measured("length", nonzero=True)]


def value(text: str, dimension: str) -> Any:
    """A default value, from its text."""
    return parse_quantity(text, dimension)


def whole_number(value: object) -> int:
    """A whole number from its text; 20.0, 2e1 and 1_0 are none."""
    text = str(value).strip()
    if not (text.isascii() and text.isdigit() and len(text) < 10):
        raise PydanticCustomError("whole_number", "{what}", {"what": f"must be a whole number, got {shown(value)}"})
    return int(text)


class Section(BaseModel):
    """Base of all sections: unknown keys are errors, and a section does not change once it is read."""

    model_config = ConfigDict(extra="forbid", frozen=True, arbitrary_types_allowed=True)


class Blocks(Section):
    """The two blocks."""

    m1: Mass = Field(description="mass of block 1, the excited one", examples=["0.297 kg"])
    m2: MassOrFixed = Field(
        description="mass of block 2, which rubs on the surface; fixed: a wall", examples=["2.94 kg", "fixed"]
    )


class Coupling(Section):
    """Spring and damper between the blocks, Eqs. (2.4) and (2.6)."""

    k1: Annotated[Quantity, Measured("stiffness", least="0")] = Field(
        description="stiffness of the coupling spring", examples=["200 N/m"]
    )
    c: Annotated[Quantity, Measured("damping", least="0")] = Field(
        value("0 N s/m", "damping"), description="coefficient of the damper", examples=["0.001 N s/m"]
    )


class Stop(Section):
    """The impact spring, Eq. (2.5); it acts only while the blocks are in contact."""

    k2: Annotated[Quantity, Measured("stiffness", above="0")] = Field(
        description="stiffness of the impact spring", examples=["12400 N/m"]
    )
    G: Length = Field(description="gap; negative: the stop is preloaded", examples=["1 mm"])
    acts: Literal["extension", "compression"] = Field(
        "extension", description="extension: contact while x2 - x1 >= G (the paper); compression: while x1 - x2 >= G"
    )


class Friction(Section):
    """Coulomb friction between block 2 and the surface, Eq. (2.7)."""

    mu: Annotated[Quantity, Measured("number", least="0")] = Field(
        description="friction coefficient; 0: no friction", examples=["0.001"]
    )
    g: Annotated[Quantity, Measured("acceleration", above="0")] = Field(
        value("9.81 m/s^2", "acceleration"), description="gravity", examples=["9.81 m/s^2"]
    )


class AmplitudeRule(Section):
    """The amplitude that an unbalanced mass of the same speed would give, Eq. (2.11)."""

    rule: Literal["m3 e omega^2"] = Field(description="A = m3 e omega^2; follows omega when that is swept")
    m3: Mass = Field(description="unbalanced mass", examples=["0.03 kg"])
    e: Eccentricity = Field(description="eccentricity", examples=["0.11 m"])


def _amplitude_tag(amplitude: object) -> str:
    return "(rule)" if isinstance(amplitude, dict | AmplitudeRule) else "(value)"


Amplitude = Annotated[
    Annotated[AmplitudeRule, Tag("(rule)")] | Annotated[Force, Tag("(value)")], Discriminator(_amplitude_tag)
]


class Harmonic(Section):
    """Ideal source: the force A sin(omega t) + F0 on block 1, Eqs. (2.1) to (2.3)."""

    kind: Literal["harmonic"]
    A: Amplitude = Field(description="amplitude of the force", examples=["0.0725 N"])
    omega: PositiveRate = Field(description="excitation frequency", examples=["3.5 Hz", "22 rad/s", "210 rpm"])
    F0: Force = Field(value("0 N", "force"), description="constant part of the force", examples=["0 N"])


class Motor(Section):
    """Non-ideal source: unbalanced rotor on block 1, driven by a motor of limited power, Eqs. (2.8) to (2.10)."""

    kind: Literal["motor"]
    m3: Mass = Field(description="unbalanced mass", examples=["0.03 kg"])
    e: Eccentricity = Field(description="eccentricity; negative: mirrored", examples=["0.11 m"])
    J: Annotated[Quantity, Measured("inertia", least="0")] = Field(
        description="moment of inertia of the rotor without m3", examples=["0.001 kg m^2"]
    )
    M0: Annotated[Quantity, Measured("torque", least="0")] = Field(
        description="torque of the motor at standstill", examples=["0.005 N m"]
    )
    Omega0: PositiveRate = Field(description="speed at which the torque vanishes", examples=["5.5 Hz", "330 rpm"])


class NoExcitation(Section):
    """No excitation: the blocks move from their initial state."""

    kind: Literal["none"] = "none"


def _excitation_tag(excitation: object) -> str:
    kind = excitation.get("kind") if isinstance(excitation, dict) else getattr(excitation, "kind", None)
    return f"({kind})"


Excitation = Annotated[
    Annotated[Motor, Tag("(motor)")] | Annotated[Harmonic, Tag("(harmonic)")] | Annotated[NoExcitation, Tag("(none)")],
    Discriminator(_excitation_tag),
]


class Initial(Section):
    """State at t = 0; at rest unless given."""

    x1: Length = Field(value("0 m", "length"), description="displacement of block 1", examples=["0 m"])
    v1: Velocity = Field(value("0 m/s", "velocity"), description="velocity of block 1", examples=["0 m/s"])
    x2: Length = Field(value("0 m", "length"), description="displacement of block 2", examples=["0 m"])
    v2: Velocity = Field(value("0 m/s", "velocity"), description="velocity of block 2", examples=["0 m/s"])
    phi: Angle = Field(value("0 rad", "angle"), description="rotor angle (motor only)", examples=["0 rad", "90 deg"])
    phidot: Rate = Field(value("0 rad/s", "angular rate"), description="rotor speed (motor only)", examples=["0 Hz"])


class RestDistance(Section):
    """Distance of the blocks at rest; the model stops being valid when x1 - x2 exceeds it."""

    value: Annotated[Quantity, Measured("length", above="0")] = Field(
        description="distance of the blocks at rest", examples=["80 mm"]
    )
    on_violation: Literal["warn", "stop"] = Field("warn", description="count and warn, or end the run")


class Run(Section):
    """How long, how often and how."""

    t_end: Duration = Field(value("300 s", "time"), description="end of the run", examples=["300 s"])
    every: Duration = Field(
        value("5 ms", "time"), description="output interval; never changes the trajectory", examples=["5 ms", "1/60 s"]
    )
    method: Literal["auto", "closed_form", "taylor"] = Field(
        "auto", description="auto: the closed form where it exists (no motor), else Taylor series"
    )
    order: Annotated[int, BeforeValidator(whole_number)] = Field(20, ge=4, le=40, description="order of the Taylor series")
    tol: Annotated[Quantity, Measured("number", least="1e-30", most="1e-3")] = Field(
        value("1.1102230246251565e-16", "number"),
        description="relative tolerance of the Taylor series; the default is 2^-53, and less pays only beyond doubles",
    )


class CaseFile(Section):
    """A vibro-impact system and one run of it."""

    model_config = ConfigDict(
        title="vibsim case",
        json_schema_extra={"$schema": "https://json-schema.org/draft/2020-12/schema"},
    )

    extends: str | None = Field(None, description="another case file, or a shipped case, that this one starts from")
    name: str = Field("", max_length=80, pattern=f"^({NAME_PATTERN})?$", description="default: the file's name")
    title: str = Field("", max_length=300, description="one line on what the case shows")
    blocks: Blocks
    coupling: Coupling
    stop: Stop | None = Field(None, description="left out or none: no stop")
    friction: Friction | None = Field(None, description="left out or none: no friction")
    excitation: Excitation = Field(NoExcitation(), description="left out or none: no excitation")
    initial: Initial = Field(Initial(), description="left out: at rest")
    rest_distance: RestDistance | None = Field(None, description="left out or none: not watched")
    run: Run = Field(Run(), description="left out: 300 s, every 5 ms")
