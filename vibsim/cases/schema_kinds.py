"""Kinds of values at a key of a case: how each is read, its messages, its JSON Schema; keys of formulas.

A text at a key that may hold a formula is one if it is no plain quantity. Beside a formula stand the numbers
that it names, of any unit, under keys of their own; keys of a built-in law that the formula replaces are such
numbers too.
"""

import re
from collections.abc import Callable, Iterable, Mapping
from fractions import Fraction
from functools import lru_cache
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, NamedTuple, Protocol, Union, get_args, get_origin

from vibsim.cases.problems import did_you_mean, shown
from vibsim.cases.quantities import (
    NUMBER,
    Quantity,
    QuantityError,
    find_unit,
    parse_quantity,
    quantity_unit,
    si_unit,
    unit_names,
)


class FormulaKey(NamedTuple):
    """A key that may hold a formula.

    Attributes
    ----------
    key : its name
    numbers : keys of the section that are numbers of the formula where there is one
    excluded : keys of the section that exclude a formula
    """

    key: str
    numbers: tuple[str, ...] = ()
    excluded: tuple[str, ...] = ()


FRICTION_LAWS = ("mu_s", "mu_d", "d", "v0")
FORMULA_KEYS: dict[str, tuple[FormulaKey, ...]] = {
    "links": (FormulaKey("force", ("k", "c")),),
    "stops": (FormulaKey("force", ("k", "c", "e"), ("law",)),),
    "friction": (
        FormulaKey("mu", FRICTION_LAWS, ("law",)),
        FormulaKey("N", ("g",)),
        FormulaKey("belt"),
    ),
    "forces": (FormulaKey("force", ("A", "omega", "phase", "F0"), ("terms",)),),
    "states": (FormulaKey("rate"),),
    "rotors": (FormulaKey("torque", ("M0", "Omega0")), FormulaKey("M0"), FormulaKey("Omega0")),
    "base": (FormulaKey("x", ("a", "omega", "phase"), ("terms",)),),
    "motor": (FormulaKey("torque", ("M0", "Omega0")), FormulaKey("M0"), FormulaKey("Omega0")),
    "excitation": (FormulaKey("M0"), FormulaKey("Omega0")),
}
ONE_PART = ("base", "motor", "excitation")  # sections that are one part
ALWAYS = ("force", "torque", "rate", "x")  # keys that hold nothing but formulas
SIDES = {"friction": ("plus", "minus")}  # sections inside a part that may hold formulas: of the first key


class Formula(NamedTuple):
    """A formula as it is written, tables in files put in as lists of pairs."""

    text: str

    def __str__(self) -> str:
        return self.text


def active_keys(keys: Iterable[FormulaKey], values: Mapping[str, Any]) -> list[FormulaKey]:
    """Those keys of formulas at which the values of a part have one."""
    return [one for one in keys if one.key in values and _holds_formula(one.key, values[one.key])]


def _holds_formula(key: str, value: object) -> bool:
    if key in ALWAYS or isinstance(value, Formula):
        return True
    return isinstance(value, str) and is_formula(value)


def excludes(name: str, one: FormulaKey) -> str:
    """Message for a key that excludes a formula."""
    what = "names a built-in law" if name == "law" else "holds harmonics"
    return f"{what}, and {one.key} is a formula; leave one of them out"


def of_part(section: str, part: object) -> list[FormulaKey]:
    """The keys of a part, or of base and motor, that hold formulas; not those of plus and minus in it."""
    if section not in FORMULA_KEYS or not isinstance(part, dict):
        return []
    return active_keys(FORMULA_KEYS[section], part)


def has_formula(section: str, part: object, key: str) -> bool:
    """Whether a part has a formula at a key."""
    return any(one.key == key for one in of_part(section, part))


def has_formulas(values: Mapping[str, Any]) -> bool:
    """Whether a case has formulas, or sections that only formulas make use of."""
    if any(section in values for section in ("parameters", "states", "rotors")):
        return True
    for section in FORMULA_KEYS:
        content = values.get(section)
        if not isinstance(content, dict):
            continue
        parts = [content] if section in ONE_PART else content.values()
        if any(of_part(section, part) or sides_of(section, part) for part in parts):
            return True
    return False


def sides_of(section: str, part: object) -> dict[str, list[FormulaKey]]:
    """The sections inside a part that hold a formula: plus and minus of a friction."""
    if section not in SIDES or not isinstance(part, dict):
        return {}
    keys = FORMULA_KEYS[section][:1]
    sides = {side: part.get(side) for side in SIDES[section]}
    active = {side: active_keys(keys, inner) for side, inner in sides.items() if isinstance(inner, dict)}
    return {side: keys for side, keys in active.items() if keys}


_QUANTITY = re.compile(rf"\s*{NUMBER}(\s*/\s*\d+)?\s*(?P<rest>.*)", re.ASCII | re.DOTALL)
_ALPHABET = re.compile(r"""[\sA-Za-z0-9_.+\-*/(),<>=\[\]'"^]*""", re.ASCII)
_WORD = re.compile(r"[A-Za-z_]\w*", re.ASCII)
_NO_NAMES = ("inf", "infinity", "nan", "none", "null", "true", "false", "yes", "no", "on", "off", "fixed")


def is_formula(text: str) -> bool:
    """Whether a text is meant as a formula and not as a quantity, be that misspelt or of a wrong unit.

    What begins with a number and goes on with a unit, or with what may be one, is a quantity.
    """
    text = text.strip()
    if not text or not _ALPHABET.fullmatch(text) or text.lstrip("+-").lower() in _NO_NAMES:
        return False
    match = _QUANTITY.fullmatch(text)
    if match is None:
        return bool(_WORD.search(text)) or "(" in text
    rest = match["rest"]
    if not rest or find_unit(rest) is not None:
        return False
    if "*" in rest or ("(" in rest and not re.search(r"/\s*\(\s*[A-Za-z]+\S*\s[A-Za-z^0-9 ]*\)", rest)):
        return True
    if re.search(r"[^\s*^eE(][\s]*[+-]|^[+-]", rest) or rest[:1] in "*/<":
        return not re.fullmatch(r"/\s*[A-Za-z]+\d?", rest)
    from vibsim.cases.any_unit import SPELLINGS, symbol

    behind = re.findall(r"[*/]\s*([A-Za-z_]\w*)", rest, re.ASCII)
    return any(
        symbol(SPELLINGS.get(word, word).split()[0].rstrip("0123456789") or "_") is None for word in behind
    )


# Kinds of values at a key of a case: how each is read, its messages where it is wrong, its JSON Schema.


Json = dict[str, Any]
Location = tuple[str, ...]  # keys, and variants such as "(motor)"


class Fault(NamedTuple):
    """One fault at one place of a case.

    Attributes
    ----------
    what : "missing" or "unknown" key, "no mapping", "no variant", or "value" where the message says it
    location : the place, from the outermost key on
    value : what stands there; the section around a missing key
    message : empty where the words depend on the keys of the schema
    """

    what: str
    location: Location
    value: object
    message: str = ""


class Tag(NamedTuple):
    """Names a variant of a value in locations, such as "(motor)"."""

    tag: str


class ChosenBy(NamedTuple):
    """Function that finds the tag of a variant from a value as it is written."""

    tag_of: Callable[[object], str]


class Value(Protocol):
    """Reads a single value; raises ValueError with what is wrong and what is allowed."""

    def read(self, value: object) -> Any: ...
    def json_schema(self) -> Json: ...


class KeyKind(Protocol):
    """Reads what stands at a key and adds what is wrong to `faults`."""

    def read(self, value: Any, at: Location, faults: list[Fault]) -> Any: ...
    def json(self, sections: dict[str, Json]) -> Json:
        """JSON Schema; that of the sections in it is put into `sections`."""
        ...


class Words(NamedTuple):
    """One of a few words."""

    allowed: tuple[str, ...]

    def read(self, value: object) -> str:
        if isinstance(value, str) and value in self.allowed:
            return value
        near = did_you_mean(str(value), self.allowed)
        one_of = "one of " if len(self.allowed) > 1 else ""
        raise ValueError(f"must be {one_of}{', '.join(self.allowed)}, got {kind_of_value(value)}{near}")

    def json_schema(self) -> Json:
        words = {"enum": [*self.allowed]} if len(self.allowed) > 1 else {"const": self.allowed[0]}
        return words | {"type": "string"}


class TextKind(NamedTuple):
    """A text of bounded length.

    Attributes
    ----------
    longest : the most characters that it may have; None: any number
    pattern : what it must match; None: anything
    why : what to say of a text that does not match
    """

    longest: int | None = None
    pattern: str | None = None
    why: str = ""

    def read(self, value: object) -> str:
        if not isinstance(value, str):
            raise ValueError(f"must be a text, got {kind_of_value(value)}")
        if self.longest is not None and len(value) > self.longest:
            raise ValueError(f"may have at most {self.longest} characters")
        if self.pattern is not None and not re.fullmatch(self.pattern, value):
            raise ValueError(f"{self.why}; got {shown(value)}")
        return value

    def json_schema(self) -> Json:
        pattern = None if self.pattern is None else f"^{self.pattern}$"
        bounds = {"maxLength": self.longest, "pattern": pattern}
        return {"type": "string"} | {name: bound for name, bound in bounds.items() if bound is not None}


class WholeNumber(NamedTuple):
    """A whole number from `least` to `most`, from its text; 20.0, 2e1 and 1_0 are none."""

    least: int
    most: int

    def read(self, value: object) -> int:
        text = str(value).strip()
        if not (text.isascii() and text.isdigit() and len(text) < 10):
            raise ValueError(f"must be a whole number, got {shown(value)}")
        if int(text) < self.least:
            raise ValueError(f"must be >= {self.least}, got {text}")
        if int(text) > self.most:
            raise ValueError(f"must be <= {self.most}, got {text}")
        return int(text)

    def json_schema(self) -> Json:
        return {"type": "integer", "minimum": self.least, "maximum": self.most}


class Single(NamedTuple):
    """A single value."""

    of: Value

    def read(self, value: Any, at: Location, faults: list[Fault]) -> Any:
        try:
            return self.of.read(value)
        except ValueError as error:
            faults.append(Fault("value", at, value, str(error)))
            return None

    def json(self, sections: dict[str, Json]) -> Json:
        return self.of.json_schema()


class Optional(NamedTuple):
    """A value that may be left out; None stands for that in files that vibsim wrote, and nothing does in a
    case.
    """

    of: KeyKind

    def read(self, value: Any, at: Location, faults: list[Fault]) -> Any:
        return None if value is None else self.of.read(value, at, faults)

    def json(self, sections: dict[str, Json]) -> Json:
        return self.of.json(sections)


class NamedKind(NamedTuple):
    """Parts by name, or terms by number."""

    of: KeyKind

    def read(self, value: Any, at: Location, faults: list[Fault]) -> Any:
        if not isinstance(value, dict):
            faults.append(Fault("no mapping", at, value))
            return None
        return {name: self.of.read(part, (*at, name), faults) for name, part in value.items()}

    def json(self, sections: dict[str, Json]) -> Json:
        return {"type": "object", "additionalProperties": self.of.json(sections)}


class Variants(NamedTuple):
    """One of several kinds, by a tag."""

    tag_of: Callable[[object], str]
    by_tag: dict[str, KeyKind]

    def read(self, value: Any, at: Location, faults: list[Fault]) -> Any:
        tag = self.tag_of(value)
        if tag not in self.by_tag:
            faults.append(Fault("no variant", at, value))
            return None
        return self.by_tag[tag].read(value, (*at, tag), faults)

    def json(self, sections: dict[str, Json]) -> Json:
        return {"oneOf": [kind.json(sections) for kind in self.by_tag.values()]}


def kind_of(annotation: Any) -> KeyKind:
    """The kind that an annotation asks for. Raises TypeError for one that says nothing about a case."""
    origin, arguments = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        return _annotated(arguments[0], arguments[1:])
    if origin is Literal:
        return Single(Words(arguments))
    if origin in (Union, UnionType) and NoneType in arguments and len(arguments) == 2:
        return Optional(kind_of(next(item for item in arguments if item is not NoneType)))
    if origin is dict:
        return NamedKind(kind_of(arguments[1]))
    if annotation is str:
        return Single(TextKind())
    if hasattr(annotation, "as_kind"):
        kind: KeyKind = annotation.as_kind()
        return kind
    raise TypeError(f"no kind of value is known for {annotation}")


def _annotated(inner: Any, notes: tuple[Any, ...]) -> KeyKind:
    for note in notes:
        if isinstance(note, ChosenBy):
            return Variants(note.tag_of, {_tag(variant): kind_of(variant) for variant in get_args(inner)})
        if hasattr(note, "read"):
            return Single(note)
    return kind_of(inner)


def _tag(variant: Any) -> str:
    return next(note.tag for note in variant.__metadata__ if isinstance(note, Tag))


def kind_of_value(value: object) -> str:
    """A value as messages show it; a mapping is not written out."""
    return "a mapping" if isinstance(value, dict) else shown(value)


# What one value of a case must be: its dimension and its range, as a note in the annotation of a key.


_exact = lru_cache(maxsize=64)(Fraction)  # of the few texts that bounds are written as


class Measured(NamedTuple):
    """A quantity of one dimension and its range, for use inside Annotated.

    Attributes
    ----------
    dimension : name in the unit table, such as "length"
    above, least, most : the value must be > above, >= least, <= most (texts in SI units; None: no bound)
    nonzero : the value must not be 0
    word : a word that may stand in place of the quantity, such as "fixed"
    alternative : what else may stand there, for messages
    formula : whether a formula may stand in place of the quantity
    any_unit : whether it may be in any unit of its dimension: of a torsional scene, or beside a formula
    also : another dimension that it may have, of turning bodies in a scene in which others do not turn
    """

    dimension: str
    above: str | None = None
    least: str | None = None
    most: str | None = None
    nonzero: bool = False
    word: str | None = None
    alternative: str = ""
    formula: bool = False
    any_unit: bool = False
    also: str = ""

    def read(self, value: object) -> Quantity | Formula | str:
        """The quantity behind a text (or the word, or the formula). Raises QuantityError."""
        if isinstance(value, Quantity | Formula):
            return value
        if isinstance(value, bool) or not isinstance(value, str | int | float):
            raise QuantityError(f"must be a single value, got {kind_of_value(value)}")
        text = str(value)
        if self.any_unit:
            return self._in_any_unit(text)
        if self.word is not None and text.strip() == self.word:
            return self.word
        alternative = f"the word {self.word}" if self.word else self.alternative
        try:
            quantity = parse_quantity(text, self.dimension, alternative)
        except QuantityError:
            if self.formula and isinstance(value, str) and is_formula(text):
                return Formula(text)
            composed = self._in_composed_unit(text)
            if composed is None:
                raise
            quantity = composed
        broken = self.broken_bound(quantity.value)
        if broken:
            raise QuantityError(f"must be {broken}, got {shown(text)}")
        return quantity

    def _in_composed_unit(self, text: str) -> Quantity | None:
        """A quantity in a unit that the table has not but that is one of its dimension, such as 2 ug or
        3 uN/um; None of any other.
        """
        unit = quantity_unit(text)
        if not unit or find_unit(unit) is not None or (self.dimension == "angular rate" and unit[0] == "1"):
            return None
        from vibsim.cases.any_unit import quantity_of

        try:
            return quantity_of(text, self.dimension)
        except QuantityError:
            return None

    def parsed(self, text: str) -> Quantity:
        """The quantity behind a text, whether its bounds hold or not. Raises QuantityError."""
        if not self.any_unit:
            return self._in_composed_unit(text) or parse_quantity(text, self.dimension)
        from vibsim.cases.any_unit import quantity_of

        if self.also:
            try:
                return quantity_of(text, self.also)
            except QuantityError:
                pass
        return quantity_of(text, self.dimension)

    def _in_any_unit(self, text: str) -> Quantity | Formula:
        if self.formula and is_formula(text):
            return Formula(text)
        quantity = self.parsed(text)
        broken = self.broken_bound(quantity.value)
        if broken:
            raise QuantityError(f"must be {broken}, got {shown(text)}")
        return quantity

    def broken_bound(self, value: Fraction) -> str | None:
        """The bound that a value breaks, in words; None inside the range."""
        if self.nonzero and value == 0:
            return "different from 0"
        if self.above is not None and value <= _exact(self.above):
            return f"> {self.above}"
        if self.least is not None and value < _exact(self.least):
            return f">= {self.least}"
        if self.most is not None and value > _exact(self.most):
            return f"<= {self.most}"
        return None

    def json_schema(self) -> dict[str, Any]:
        """A number in SI units with its bounds, a text with a unit, or the word."""
        units = [] if self.any_unit else unit_names(self.dimension)
        tail = r"\s*[^\s0-9].*" if self.dimension == "angular rate" else ".*" if units else r"\s*"
        text: dict[str, Any] = {"type": "string", "pattern": rf"^\s*{NUMBER}(\s*/\s*\d+)?{tail}$"}
        if units:
            text["description"] = f"number and unit: {', '.join(units)}"
        choices = [text]
        if self.dimension != "angular rate":
            choices.insert(
                0, {"type": "number", "description": f"in {si_unit(self.dimension).name or 'no unit'}"}
            )
            choices[0] |= self._json_bounds()
        if self.word is not None:
            choices.append({"const": self.word})
        if self.formula:
            choices.append({"type": "string", "pattern": "[A-Za-z_(]", "description": "a formula"})
        return {"anyOf": choices}

    def _json_bounds(self) -> dict[str, Any]:
        bounds = {"exclusiveMinimum": self.above, "minimum": self.least, "maximum": self.most}
        keywords: dict[str, Any] = {name: float(bound) for name, bound in bounds.items() if bound is not None}
        return keywords | ({"not": {"const": 0}} if self.nonzero else {})
