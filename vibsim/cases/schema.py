"""Keys of the short form of a case and their values, and the sections that both forms share."""

from functools import cached_property
from inspect import cleandoc
from typing import Annotated, Any, ClassVar, Literal, NoReturn, TypeVar

from vibsim.cases.quantities import NUMBER, Quantity, QuantityError
from vibsim.cases.schema_kinds import (
    ALWAYS,
    FORMULA_KEYS,
    ChosenBy,
    Fault,
    Formula,
    FormulaKey,
    Json,
    KeyKind,
    Location,
    Measured,
    Single,
    Tag,
    TextKind,
    WholeNumber,
    active_keys,
    excludes,
    kind_of,
    kind_of_value,
)


class AnyNumber:
    """A number beside a formula, or a parameter: of any unit; without a unit a pure number."""

    def read(self, value: object) -> Quantity:
        from vibsim.cases.any_unit import any_quantity

        if isinstance(value, Quantity):
            return value
        if isinstance(value, bool) or not isinstance(value, str | int | float):
            raise QuantityError(f"must be a single value, got {kind_of_value(value)}")
        return any_quantity(str(value))[0]

    def json_schema(self) -> Json:
        text = {"type": "string", "pattern": rf"^\s*{NUMBER}.*$", "description": "number and any unit"}
        return {"anyOf": [{"type": "number"}, text]}


ANY_NUMBER = Single(AnyNumber())


# Sections of a case: classes whose annotations say what stands at their keys.


REFERENCE = "#/$defs/"  # where JSON Schema keeps sections
REQUIRED = object()

S = TypeVar("S", bound="Section")
W = TypeVar("W", bound="WithFormulas")


class Key:
    """A key of a section.

    Attributes
    ----------
    annotation : what stands there
    default : as a file would say it; REQUIRED where the key must be given
    description, examples : for people
    """

    def __init__(self, annotation: Any, default: Any, description: str, examples: list[str]):
        self.annotation, self.default = annotation, default
        self.description, self.examples = description, examples

    def is_required(self) -> bool:
        return self.default is REQUIRED

    @cached_property
    def kind(self) -> KeyKind:
        return kind_of(self.annotation)

    @cached_property
    def _default(self) -> Any:
        """The default, read as if a file gave it."""
        faults: list[Fault] = []
        value = None if self.default is None else self.kind.read(self.default, (), faults)
        if faults:
            raise TypeError(f"a default that is none: {faults[0].message}")
        return value

    def default_value(self) -> Any:
        """The value of the key where it is left out; never the same mapping twice."""
        return dict(self._default) if isinstance(self._default, dict) else self._default

    def json(self, sections: dict[str, Json]) -> Json:
        """JSON Schema of the value; of the sections in it the schema is put into `sections`."""
        about: Json = {"description": self.description, "examples": self.examples}
        schema = {**self.kind.json(sections), **{name: note for name, note in about.items() if note}}
        if isinstance(self.default, str | int):
            schema["default"] = self.default
        return dict(sorted(schema.items()))


def key(description: str = "", *examples: str, default: Any = REQUIRED) -> Any:
    """Description of a key beside its annotation in a class, and examples of values as in a file."""
    return Key(None, default, description, [*examples])


def left_out(description: str, *examples: str) -> Any:
    """A key that may be left out, without a default."""
    return key(description, *examples, default=None)


class Section:
    """Base of all sections: unknown keys are faults, and a section does not change once it is read."""

    keys: ClassVar[dict[str, Key]] = {}  # of the sections that inherit it too

    def __init_subclass__(cls) -> None:
        cls.keys = dict(cls.keys)
        for name, annotation in cls.__annotations__.items():
            if not str(annotation).startswith("typing.ClassVar"):
                cls.keys[name] = _key(annotation, cls.__dict__.get(name, REQUIRED))

    @classmethod
    def read(cls: type[S], values: Any, at: Location, faults: list[Fault]) -> S | None:
        """The section of nested texts; what is wrong is added to `faults`, and then it is of no use."""
        if isinstance(values, cls):
            return values
        if not isinstance(values, dict):
            faults.append(Fault("no mapping", at, values))
            return None
        section = cls.__new__(cls)
        content = section.__dict__
        for name, key in cls.keys.items():
            if name in values:
                content[name] = key.kind.read(values[name], (*at, name), faults)
            elif key.is_required():
                faults.append(Fault("missing", (*at, name), values))
            else:
                content[name] = key.default_value()
        faults += [Fault("unknown", (*at, name), values[name]) for name in values if name not in cls.keys]
        return section

    @classmethod
    def as_kind(cls) -> KeyKind:
        return cls

    @classmethod
    def json(cls, sections: dict[str, Json]) -> Json:
        """A reference; the JSON Schema of the section itself is put into `sections`."""
        name = cls.__name__.removesuffix("Keys")
        if name not in sections:
            sections[name] = {}
            sections[name] = cls.json_schema(sections)
        return {"$ref": REFERENCE + name}

    @classmethod
    def json_schema(cls, sections: dict[str, Json]) -> Json:
        """JSON Schema of the section, those of the sections in it beside it."""
        required = [name for name, key in cls.keys.items() if key.is_required()]
        schema: Json = {
            "additionalProperties": False,
            "description": cleandoc(cls.__doc__ or ""),
            "properties": {name: key.json(sections) for name, key in cls.keys.items()},
        }
        return schema | ({"required": required} if required else {}) | {"type": "object"}

    def __setattr__(self, name: str, value: object) -> NoReturn:
        raise AttributeError(f"a section does not change: {name}")

    def __delattr__(self, name: str) -> NoReturn:
        raise AttributeError(f"a section does not change: {name}")

    def __eq__(self, other: object) -> bool:
        return type(self) is type(other) and self.__dict__ == other.__dict__

    def __hash__(self) -> int:
        return hash((type(self), *self.__dict__.values()))

    def __repr__(self) -> str:
        content = ", ".join(f"{name}={value!r}" for name, value in self.__dict__.items())
        return f"{type(self).__name__.removesuffix('Keys')}({content})"


class WithFormulas(Section):
    """A section in which formulas may stand, and beside them the numbers that they name."""

    formulas: ClassVar[tuple[FormulaKey, ...]] = ()

    @classmethod
    def read(cls: type[W], values: Any, at: Location, faults: list[Fault]) -> W | None:
        active = active_keys(cls.formulas, values) if isinstance(values, dict) else []
        if not active:
            return super().read(values, at, faults)
        numbers = {name for one in active for name in one.numbers if name not in {a.key for a in active}}
        excluded = {name: one for one in active for name in one.excluded}
        section = cls.__new__(cls)
        content = section.__dict__
        for name, key in cls.keys.items():
            kind = ANY_NUMBER if name in numbers else key.kind
            if name in excluded and name in values:
                faults.append(Fault("value", (*at, name), values[name], excludes(name, excluded[name])))
            elif name in values:
                content[name] = kind.read(values[name], (*at, name), faults)
            elif name in numbers or name in excluded:
                content[name] = None
            elif key.is_required():
                faults.append(Fault("missing", (*at, name), values))
            else:
                content[name] = key.default_value()
        for name, value in values.items():
            if name not in cls.keys:
                content[name] = ANY_NUMBER.read(value, (*at, name), faults)
        return section

    @classmethod
    def json_schema(cls, sections: dict[str, Json]) -> Json:
        """Beside a formula there may be numbers of any unit; without one the keys are the section's own."""
        schema = super().json_schema(sections)
        if not cls.formulas:
            return schema
        number = AnyNumber().json_schema()
        loose = {name for one in cls.formulas for name in one.numbers}
        strict = {name: schema["properties"][name] for name in schema["properties"] if name in loose}
        for name in strict:
            schema["properties"][name] = _either(strict[name], number)
        schema["additionalProperties"] = number
        schema["if"] = {"anyOf": [cls._json_condition(one.key) for one in cls.formulas]}
        schema["else"] = {"propertyNames": {"enum": [*cls.keys]}, "properties": strict}
        needed = [name for name in schema.get("required", []) if name in loose]
        if needed:
            schema["required"] = [name for name in schema["required"] if name not in needed]
            schema["else"]["required"] = needed
        return schema

    @classmethod
    def _json_condition(cls, key: str) -> Json:
        """JSON Schema of a section with a formula at a key."""
        if key in ALWAYS:
            return {"required": [key]}
        return {"required": [key], "properties": {key: {"type": "string", "pattern": "[A-Za-z_(]"}}}


def _either(strict: Json, loose: Json) -> Json:
    """The JSON Schema of what may be one thing or the other."""
    about = {name: strict[name] for name in ("description", "examples", "default") if name in strict}
    inner = {name: value for name, value in strict.items() if name not in about}
    choices = inner.get("anyOf") or inner.get("oneOf") or [inner]
    return {"anyOf": [*choices, *loose["anyOf"]]} | about


def _key(annotation: Any, said: Any) -> Key:
    """A key from its annotation and what the class says of it: `key(...)`, a default alone, or nothing."""
    if isinstance(said, Key):
        return Key(annotation, said.default, said.description, said.examples)
    return Key(annotation, said, "", [])


# The schema of a case file: sections, keys, units, ranges and defaults, as classes that read them.
#
# `vibsim schema` prints it as JSON Schema. What concerns several keys at once stands in contradictions.py.


NAME_PATTERN = r"[A-Za-z0-9][A-Za-z0-9._+ -]*"
NAMES = "may hold letters, digits, spaces and . _ + -, and begins with a letter or digit"

Mass = Annotated[Quantity, Measured("mass", above="0")]
MassOrFixed = Annotated[Quantity | str, Measured("mass", above="0", word="fixed")]
Length = Annotated[Quantity, Measured("length")]
Velocity = Annotated[Quantity, Measured("velocity")]
Force = Annotated[Quantity, Measured("force")]
Duration = Annotated[Quantity, Measured("time", above="0")]
Angle = Annotated[Quantity, Measured("angle")]
Rate = Annotated[Quantity, Measured("angular rate")]
AnyQuantity = Annotated[Quantity, AnyNumber()]
PositiveRate = Annotated[Quantity, Measured("angular rate", above="0")]
Eccentricity = Annotated[Quantity, Measured("length", nonzero=True)]


def optional(default: str, description: str, *examples: str) -> Any:
    """A key with a default, written and checked as in a file; the default is an example too."""
    return key(description, *(examples or [default]), default=default)


class Blocks(Section):
    """The two blocks."""

    m1: Mass = key("mass of block 1, the excited one", "0.297 kg")
    m2: MassOrFixed = key("mass of block 2, which rubs on the surface; fixed: a wall", "2.94 kg", "fixed")


class CouplingKeys(Section):
    """Spring and damper between the blocks, Eqs. (2.4) and (2.6)."""

    k1: Annotated[Quantity, Measured("stiffness", least="0")] = key(
        "stiffness of the coupling spring", "200 N/m"
    )
    c: Annotated[Quantity, Measured("damping", least="0")] = optional(
        "0 N s/m", "coefficient of the damper", "0.001 N s/m"
    )


class StopKeys(Section):
    """The impact spring, Eq. (2.5); it acts only while the blocks are in contact."""

    k2: Annotated[Quantity, Measured("stiffness", above="0")] = key(
        "stiffness of the impact spring", "12400 N/m"
    )
    G: Length = key("gap; negative: the stop is preloaded", "1 mm")
    acts: Literal["extension", "compression"] = key(
        "extension: contact while x2 - x1 >= G (the paper); compression: while x1 - x2 >= G",
        default="extension",
    )


class FrictionKeys(Section):
    """Coulomb friction between block 2 and the surface, Eq. (2.7)."""

    mu: Annotated[Quantity, Measured("number", least="0")] = key(
        "friction coefficient; 0: no friction", "0.001"
    )
    g: Annotated[Quantity, Measured("acceleration", above="0")] = optional("9.81 m/s^2", "gravity")


class AmplitudeRule(Section):
    """The amplitude that an unbalanced mass of the same speed would give, Eq. (2.11)."""

    rule: Literal["m3 e omega^2"] = key("A = m3 e omega^2; follows omega when that is swept")
    m3: Mass = key("unbalanced mass", "0.03 kg")
    e: Eccentricity = key("eccentricity", "0.11 m")


def _amplitude_tag(amplitude: object) -> str:
    return "(rule)" if isinstance(amplitude, dict | AmplitudeRule) else "(value)"


Amplitude = Annotated[
    Annotated[AmplitudeRule, Tag("(rule)")]
    | Annotated[
        Quantity, Measured("force", alternative="{rule: m3 e omega^2, m3: ..., e: ...}"), Tag("(value)")
    ],
    ChosenBy(_amplitude_tag),
]


class HarmonicKeys(Section):
    """Ideal source: the force A sin(omega t) + F0 on block 1, Eqs. (2.1) to (2.3)."""

    kind: Literal["harmonic"]
    A: Amplitude = key("amplitude of the force", "0.0725 N")
    omega: PositiveRate = key("excitation frequency", "3.5 Hz", "22 rad/s", "210 rpm")
    F0: Force = optional("0 N", "constant part of the force")


class MotorKeys(WithFormulas):
    """Non-ideal source: unbalanced rotor on block 1, motor of limited power, Eqs. (2.8) to (2.10)."""

    formulas = FORMULA_KEYS["excitation"]
    kind: Literal["motor"]
    m3: Mass = key("unbalanced mass", "0.03 kg")
    e: Eccentricity = key("eccentricity; negative: mirrored", "0.11 m")
    J: Annotated[Quantity, Measured("inertia", least="0")] = key(
        "moment of inertia of the rotor without m3", "0.001 kg m^2"
    )
    M0: Annotated[Quantity | Formula, Measured("torque", least="0", formula=True)] = key(
        "torque of the motor at standstill, or a formula of it", "0.005 N m"
    )
    Omega0: Annotated[Quantity | Formula, Measured("angular rate", above="0", formula=True)] = key(
        "speed at which the torque vanishes, or a formula of it", "5.5 Hz", "330 rpm"
    )


class NoExcitation(Section):
    """No excitation: the blocks move from their initial state."""

    kind: Literal["none"] = "none"


def _excitation_tag(excitation: object) -> str:
    kind = excitation.get("kind") if isinstance(excitation, dict) else getattr(excitation, "kind", None)
    return f"({kind})"


Excitation = Annotated[
    Annotated[MotorKeys, Tag("(motor)")]
    | Annotated[HarmonicKeys, Tag("(harmonic)")]
    | Annotated[NoExcitation, Tag("(none)")],
    ChosenBy(_excitation_tag),
]


class Initial(Section):
    """State at t = 0; at rest unless given."""

    x1: Length = optional("0 m", "displacement of block 1")
    v1: Velocity = optional("0 m/s", "velocity of block 1")
    x2: Length = optional("0 m", "displacement of block 2")
    v2: Velocity = optional("0 m/s", "velocity of block 2")
    phi: Angle = optional("0 rad", "rotor angle (motor only)", "0 rad", "90 deg")
    phidot: Rate = optional("0 rad/s", "rotor speed (motor only)", "0 Hz")


class RestDistance(Section):
    """Distance of the blocks at rest; the model stops being valid when x1 - x2 exceeds it."""

    value: Annotated[Quantity, Measured("length", above="0")] = key("distance of the blocks at rest", "80 mm")
    on_violation: Literal["warn", "stop"] = key("count and warn, or end the run", default="warn")


USUAL_ORDER = 20  # of Taylor series


class RunKeys(Section):
    """How long, how often and how."""

    t_end: Duration = optional("300 s", "end of the run")
    every: Duration = optional("5 ms", "output interval; never changes the trajectory", "5 ms", "1/60 s")
    method: Literal["auto", "closed_form", "taylor"] = key(
        "auto: the closed form in modes that have one (none with a motor or falling friction), "
        "else Taylor series; closed_form: the same, but refused with a motor; taylor: series in every mode",
        default="auto",
    )
    order: Annotated[int, WholeNumber(4, 40)] = key("order of the Taylor series", default=USUAL_ORDER)
    tol: Annotated[Quantity, Measured("number", least="1e-30", most="1e-3")] = optional(
        "1.1102230246251565e-16",
        "relative tolerance of the Taylor series; 2^-53 by default, and less helps only beyond doubles",
    )
    trust_tolerance: Annotated[Quantity, Measured("length", above="0")] = optional(
        "1e-6 m", "error up to which the displacements count as right: the trust horizon ends there", "1 um"
    )


class CaseHead(Section):
    """Head of every case file: the file that it extends, its name and its title."""

    extends: str | None = left_out("another case file, or a shipped case, that this one starts from")
    name: Annotated[str, TextKind(80, NAME_PATTERN, NAMES)] = key("default: the file's name", default="case")
    title: Annotated[str, TextKind(300)] = key("one line on what the case shows", default="")


class CaseFile(CaseHead):
    """A vibro-impact system of the paper's two blocks and one run of it: the short form of a case."""

    parameters: dict[str, AnyQuantity] = key(
        "numbers that formulas read, by name", "{g: 9.81 m/s^2}", default={}
    )
    blocks: Blocks
    coupling: CouplingKeys
    stop: StopKeys | None = left_out("left out or none: no stop")
    friction: FrictionKeys | None = left_out("left out or none: no friction")
    excitation: Excitation = key("left out or none: no excitation", default={"kind": "none"})
    initial: Initial = key("left out: at rest", default={})
    rest_distance: RestDistance | None = left_out("left out or none: not watched")
    run: RunKeys = key("left out: 300 s, every 5 ms", default={})
