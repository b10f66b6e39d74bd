"""A case: one system and one run of it, validated, exact, and able to say itself in one canonical text."""

import hashlib
import json
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any

from vibsim.cases.file_tree import Tree, read_tree
from vibsim.cases.keys import UnknownKeyError, full_key
from vibsim.cases.overrides import apply_overrides
from vibsim.cases.problems import CaseError, Problem
from vibsim.cases.quantities import Quantity
from vibsim.cases.scene_building import DOUBLES, amplitude_value, build_scene, exact_numbers
from vibsim.cases.schema import CaseFile, Harmonic, Motor, Section
from vibsim.cases.sources import case_name_from, find_source
from vibsim.cases.validation import validated
from vibsim.cases.yaml_nodes import Place
from vibsim.physics.scene import Scene

RESOLVED_FORMAT = 1  # of resolved_json


@dataclass(frozen=True)
class Case:
    """A validated case.

    Attributes
    ----------
    model : the validated sections; every number an exact Quantity
    text : the YAML text as given (without overrides)
    source : the file or shipped name that it came from, for messages
    """

    model: CaseFile
    text: str
    source: str

    @property
    def name(self) -> str:
        return self.model.name

    @property
    def title(self) -> str:
        return self.model.title

    def scene(self) -> Scene:
        """The numbers of the case in SI and rad/s, each the double nearest to the exact value."""
        return build_scene(self.model, DOUBLES)

    def exact_scene(self, number: Callable[[Fraction], Any], pi: Any = None) -> Scene:
        """The scene in another number type: number(Fraction) of each exact value, e.g. for flint.arb or mpmath.mpf.

        `pi` is pi in that type (without it, pi to 1100 digits is converted). A frequency given per turn stays an exact
        Fraction in `cycles`; one given in rad/s is divided by 2 pi in the number type. `cycles_lo` is 0.
        """
        return build_scene(self.model, exact_numbers(number, pi))

    @cached_property
    def values(self) -> dict[str, Any]:
        """Every value under its dotted key, defaults filled in: Quantity, word or whole number."""
        return dict(_leaves(_as_tree(self.model), ""))

    def numeric_keys(self) -> list[str]:
        """Dotted keys of the numbers that this case has, in file order: what can be swept."""
        return [key for key, value in self.values.items() if isinstance(value, Quantity)]

    def quantity(self, key: str) -> Quantity:
        """The exact quantity behind a key ("excitation.Omega0" or "Omega0"). Raises UnknownKeyError (a KeyError)."""
        name = full_key(key, tuple(self.values))
        found = self.values.get(name)
        if not isinstance(found, Quantity):
            raise UnknownKeyError(f"{key} is no number of case {self.name}; numbers: {', '.join(self.numeric_keys())}")
        return found

    def number(self, key: str) -> float:
        """A number of the case in SI units and rad/s; excitation.A is computed where a rule gives it.

        Raises UnknownKeyError (a KeyError) for keys that are no number of this case.
        """
        source = self.model.excitation
        if key in ("A", "excitation.A") and isinstance(source, Harmonic):
            return DOUBLES.convert(*amplitude_value(source))
        return self.quantity(key).number()

    def frequency(self) -> Quantity | None:
        """Frequency of the source: omega (harmonic) or Omega0 (motor); None without excitation."""
        source = self.model.excitation
        if isinstance(source, Harmonic):
            return source.omega
        return source.Omega0 if isinstance(source, Motor) else None

    def with_values(self, changes: Mapping[str, object]) -> "Case":
        """This case with some values replaced, e.g. {"excitation.Omega0": "6.5 Hz"}; what depends on them follows.

        Raises CaseError (file "--set") for unknown keys and values that are not allowed.
        """
        tree = Tree(_as_tree(self.model), Place(self.source))
        apply_overrides(tree, changes)
        return Case(validated(tree), self.text, self.source)

    def resolved_json(self) -> str:
        """The case in one canonical JSON text: defaults filled in, numbers as text, read back to the same exact case."""
        return json.dumps({"vibsim_case": RESOLVED_FORMAT} | _texts(_as_tree(self.model)), ensure_ascii=False)

    @cached_property
    def sha256(self) -> str:
        """Fingerprint of what is simulated: the exact values, whatever their spelling, without name and title."""
        exact = {key: _exact_text(value) for key, value in self.values.items() if key not in ("name", "title")}
        return hashlib.sha256(json.dumps(exact, sort_keys=True).encode()).hexdigest()

    @staticmethod
    def from_resolved_json(text: str, source: str = "resolved case") -> "Case":
        """The case that resolved_json() wrote down. Raises CaseError where the text is something else."""
        values = _resolved_values(text, source)
        return Case(validated(Tree(values, Place(source))), text, source)


def load_case(source: object, overrides: Mapping[str, object] | None = None) -> Case:
    """Read a case: a YAML file's path, a shipped case's name, or "-" for standard input.

    Parameters
    ----------
    source : str or path
    overrides : dotted (or unambiguous short) key -> value, e.g. {"excitation.Omega0": "6.5 Hz", "run.t_end": "20 s"};
        validated as if the file said so

    Raises CaseError with every problem found.
    """
    found = find_source(str(source))
    tree = read_tree(found)
    tree.values.pop("extends", None)
    tree.values.setdefault("name", case_name_from(found.stem))
    apply_overrides(tree, overrides or {})
    return Case(validated(tree), found.text, found.shown)


def _resolved_values(text: str, source: str) -> dict[str, Any]:
    try:
        values = json.loads(text)
    except (ValueError, RecursionError):
        values = None
    if not isinstance(values, dict) or "vibsim_case" not in values:
        raise CaseError([Problem(source, None, None, "", "is not the resolved JSON text of a vibsim case")])
    version = values.pop("vibsim_case")
    if version != RESOLVED_FORMAT:
        what = f"is a resolved case of format {version}; this version of vibsim reads {RESOLVED_FORMAT}"
        raise CaseError([Problem(source, None, None, "", what)])
    return values


def _as_tree(section: Section) -> dict[str, Any]:
    """A section as nested dict with quantities as leaves; what does not apply to the case is left out."""
    tree: dict[str, Any] = {}
    for name, value in section:
        if isinstance(value, Section):
            tree[name] = _as_tree(value)
        elif value is not None:
            tree[name] = value
    if isinstance(section, CaseFile):
        for name in _absent_states(section):
            del tree["initial"][name]
    return tree


def _absent_states(case: CaseFile) -> list[str]:
    absent = [] if isinstance(case.blocks.m2, Quantity) else ["x2", "v2"]
    return absent if isinstance(case.excitation, Motor) else [*absent, "phi", "phidot"]


def _leaves(tree: dict[str, Any], prefix: str) -> Iterator[tuple[str, Any]]:
    for name, value in tree.items():
        if isinstance(value, dict):
            yield from _leaves(value, f"{prefix}{name}.")
        else:
            yield f"{prefix}{name}", value


def _texts(tree: dict[str, Any]) -> dict[str, Any]:
    return {
        name: _texts(value) if isinstance(value, dict) else value.text if isinstance(value, Quantity) else value
        for name, value in tree.items()
    }


def _exact_text(value: Any) -> str:
    if not isinstance(value, Quantity):
        return str(value)
    return f"{value.value} turns" if value.per_turn else str(value.value)
