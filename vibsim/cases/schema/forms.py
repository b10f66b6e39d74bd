"""The two forms of a case: the short one of the paper's two blocks, and the long one of named parts."""

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from vibsim.cases.problems import Problem
from vibsim.cases.schema.schema import CaseFile, CaseHead
from vibsim.cases.spelling import did_you_mean, nearest
from vibsim.cases.yaml_nodes import Place

SWITCHED_OFF = "none"
NAME = "*"  # stands for the name of a body or part in the keys of the long form


class Form(NamedTuple):
    """One way to write a case.

    Attributes
    ----------
    called : what messages call it
    sections : its sections, in file order
    own : the sections that the other form has not
    switchable : sections that may be the word none
    named : sections that hold parts by name; `--set stops.wall=none` takes one out
    """

    called: str
    sections: tuple[str, ...]
    own: tuple[str, ...]
    switchable: tuple[str, ...]
    named: tuple[str, ...] = ()

    @property
    def model(self) -> type[CaseHead]:
        """The outermost section; that of the long form is imported when the first case of parts is read."""
        if self is SHORT:
            return CaseFile
        from vibsim.cases.parts.schema import PartsFile

        return PartsFile

    def without_switched_off(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """The values of a tree without sections, and parts, that are the word none."""
        present = {
            name: value
            for name, value in values.items()
            if not (name in self.switchable and value == SWITCHED_OFF)
        }
        for section in self.named:
            if isinstance(present.get(section), dict):
                parts = present[section].items()
                present[section] = {name: part for name, part in parts if part != SWITCHED_OFF}
        return present

    def pattern(self, key: str) -> str:
        """A dotted key with NAME in place of the names of parts and the numbers of terms."""
        parts = key.split(".")
        if parts[0] in self.named and len(parts) > 1:
            parts[1] = NAME
        for i, part in enumerate(parts[:-1]):
            if part == "terms":
                parts[i + 1] = NAME
        return ".".join(parts)


SHORT = Form(
    "short",
    ("blocks", "coupling", "stop", "friction", "excitation", "initial", "rest_distance", "run"),
    ("blocks", "coupling", "stop", "excitation", "rest_distance"),
    ("stop", "friction", "excitation", "initial", "rest_distance", "run"),
)
LONG = Form(
    "long",
    ("bodies", "links", "stops", "friction", "forces", "base", "motor", "initial", "clearances", "run"),
    ("bodies", "links", "stops", "forces", "base", "motor", "clearances"),
    ("links", "stops", "friction", "forces", "base", "motor", "initial", "clearances", "run"),
    ("bodies", "links", "stops", "friction", "forces", "initial", "clearances"),
)


_OWN = (*SHORT.own, *LONG.own)
_COMMON = {"extends", "name", "title", *(name for name in SHORT.sections if name in LONG.sections)}


def form_of(values: Mapping[str, Any]) -> Form:
    """The form of a case's sections: long with bodies, or where only the long form has what is there.

    Of sections that neither has, misspelt ones, the form is that of the nearest name.
    """
    if "bodies" in values:
        return LONG
    names = {name if name in _OWN else nearest(name, _OWN) for name in values if name not in _COMMON}
    is_long = any(name in LONG.own for name in names) and not any(name in SHORT.own for name in names)
    return LONG if is_long else SHORT


def mixed_keys(values: Mapping[str, Any]) -> tuple[str, ...]:
    """Sections that the other form has and that of the case has not."""
    other = SHORT if form_of(values) is LONG else LONG
    return tuple(name for name in values if name in other.own)


def of_one_form(values: Mapping[str, Any]) -> dict[str, Any]:
    """The values that can be judged: in a mixed case neither those of the other form nor those of both."""
    foreign = mixed_keys(values)
    ambiguous = (*foreign, "friction", "initial") if foreign else ()
    return {name: value for name, value in values.items() if name not in ambiguous}


def mixed_problems(values: Mapping[str, Any], place: Any) -> Iterator[Problem]:
    """What is wrong with a case that mixes the forms; place : key -> Place of the key."""
    form = form_of(values)
    for name in mixed_keys(values):
        at: Place = place(name)
        message = (
            f"belongs to the {(SHORT if form is LONG else LONG).called} form of a case, and this one has the "
            f"{form.called} form{did_you_mean(name, form.sections)}; allowed: {', '.join(form.model.keys)}"
        )
        yield at.problem(name, message)
