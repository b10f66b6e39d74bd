"""Keys of a case that hold formulas, and the numbers beside them: what stands where, and how it is read.

A text at such a key that is no plain quantity is a formula. Beside a formula stand the numbers that it names,
of any unit, under keys of their own; keys of a built-in law that the formula replaces are such numbers too.
"""

import re
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

from vibsim.cases.quantities import NUMBER, find_unit


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
    if section not in FORMULA_KEYS or not isinstance(part, Mapping):
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
        if not isinstance(content, Mapping):
            continue
        parts = [content] if section in ONE_PART else content.values()
        if any(of_part(section, part) or sides_of(section, part) for part in parts):
            return True
    return False


def sides_of(section: str, part: object) -> dict[str, list[FormulaKey]]:
    """The sections inside a part that hold a formula: plus and minus of a friction."""
    if not isinstance(part, Mapping):
        return {}
    keys = FORMULA_KEYS.get(section, ())[:1]
    sides = {side: part.get(side) for side in SIDES.get(section, ())}
    active = {side: active_keys(keys, inner) for side, inner in sides.items() if isinstance(inner, Mapping)}
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
