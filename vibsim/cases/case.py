"""A case: one system and one run of it, validated and exact."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any

from vibsim.cases.parts.building import build_parts
from vibsim.cases.parts.short_form import long_values
from vibsim.cases.parts.text import long_text, sections_text
from vibsim.cases.problems import CaseError, Problem
from vibsim.cases.reading.file_tree import Tree
from vibsim.cases.reading.overrides import apply_overrides
from vibsim.cases.reading.validation import validated
from vibsim.cases.resolved import fingerprint, flat_values, nested_values, resolved_text, resolved_values
from vibsim.cases.scene_building import DOUBLES, amplitude_value, build_two_blocks, exact_numbers
from vibsim.cases.schema.forms import form_of
from vibsim.cases.schema.keys import UnknownKeyError, full_key, keys_of
from vibsim.cases.schema.schema import CaseFile, CaseHead, Harmonic
from vibsim.cases.values.quantities import Quantity
from vibsim.cases.yaml_nodes import Place
from vibsim.physics.parts import Scene
from vibsim.physics.two_blocks import TwoBlocks


@dataclass(frozen=True)
class Case:
    """A validated case.

    Attributes
    ----------
    model : the validated sections, of the short form or of the long one; every number an exact Quantity
    text : the YAML text as given, without overrides
    source : the file that it came from, for messages

    >>> import vibsim
    >>> case = vibsim.load_case("II-B", overrides={"Omega0": "6.5 Hz"})
    >>> case.name, round(case.number("Omega0"), 3)  # in rad/s
    ('II-B', 40.841)
    """

    model: CaseHead
    text: str
    source: str

    @property
    def name(self) -> str:
        return self.model.name

    @property
    def title(self) -> str:
        return self.model.title

    @property
    def is_long(self) -> bool:
        """True for a case in the long form, a scene of named parts."""
        return not isinstance(self.model, CaseFile)

    def scene(self) -> Scene:
        """The scene as a list of parts, for both forms of case: SI and rad/s, each number rounded once."""
        return build_parts(self.long_values(), DOUBLES)

    def exact_scene(self, number: Callable[[Fraction], Any], pi: Any = None) -> Scene[Any]:
        """The scene in another number type, such as flint.arb or mpmath.mpf.

        Parameters
        ----------
        number : makes a number of that type from a Fraction
        pi : pi in that type; without it, a fraction right to 1100 digits is converted

        A frequency given per turn stays an exact Fraction in `cycles`; one given in rad/s is divided by 2 pi
        in the number type. `cycles_lo` is 0.
        """
        return build_parts(self.long_values(), exact_numbers(number, pi))

    def two_blocks(self) -> TwoBlocks:
        """The numbers of a case in the short form by the symbols of the paper, SI and rad/s.

        Raises CaseError for a case in the long form.
        """
        return build_two_blocks(self._short_form(), DOUBLES)

    def exact_two_blocks(self, number: Callable[[Fraction], Any], pi: Any = None) -> TwoBlocks:
        """The same in another number type; arguments as of `exact_scene`."""
        return build_two_blocks(self._short_form(), exact_numbers(number, pi))

    def long_values(self) -> dict[str, Any]:
        """Nested values of the case in the long form, defaults filled in."""
        return long_values(self.model) if isinstance(self.model, CaseFile) else self._nested

    def replace(self, changes: Mapping[str, object] | None = None, /, **more: object) -> "Case":
        """This case with some values replaced: by dotted or short keys in a mapping, or short keys by name.

        Raises CaseError for unknown keys and for values that are not allowed.

        >>> import vibsim
        >>> case = vibsim.load_case("II-B").replace({"run.t_end": "20 s"}, Omega0="6.5 Hz", c=0.01)
        >>> print(case.quantity("Omega0"), case.quantity("c"))
        6.5 Hz 0.01 N s/m
        """
        return self.with_values({**(changes or {}), **more})

    def to_yaml(self) -> str:
        """The case as YAML text, every default filled in, changed values too; reads back to the same case.

        `text` is the text as it was given.

        >>> import vibsim
        >>> print(vibsim.load_case("II-B", {"c": "0.03 N s/m"}).to_yaml()[:64])
        name: II-B
        title: "Non-ideal source, motor constant 5.5 Hz"
        <BLANKLINE>
        blo
        """
        return long_text(self._nested) if self.is_long else sections_text(self._nested)

    def long_text(self) -> str:
        """The case as YAML text in the long form, defaults filled in."""
        return long_text(self.long_values())

    def _short_form(self) -> CaseFile:
        if isinstance(self.model, CaseFile):
            return self.model
        what = (
            "named parts have no symbols of the paper (m1, k2, G, ...), which this asks for; "
            "it needs a case with blocks and coupling"
        )
        raise CaseError([Problem(self.source, None, None, "bodies", what)])

    @cached_property
    def values(self) -> dict[str, Any]:
        """Every value under its dotted key, defaults filled in: Quantity, word or whole number."""
        return flat_values(self.model)

    @cached_property
    def _nested(self) -> dict[str, Any]:
        return nested_values(self.model)

    def numeric_keys(self) -> list[str]:
        """Dotted keys of the quantities that this case has, in file order: what can be swept."""
        return [key for key, value in self.values.items() if isinstance(value, Quantity)]

    def full_key(self, key: str) -> str:
        """The dotted key that a dotted or short key stands for in this case. Raises UnknownKeyError."""
        return full_key(key, self.values, keys_of(form_of(self._nested), self._nested))

    def quantity(self, key: str) -> Quantity:
        """The exact quantity behind a dotted or short key. Raises UnknownKeyError (a KeyError)."""
        quantity = self.values.get(self.full_key(key))
        if not isinstance(quantity, Quantity):
            listed = ", ".join(self.numeric_keys())
            raise UnknownKeyError(f"{key} is no number of case {self.name}; its numbers are {listed}")
        return quantity

    def number(self, key: str) -> float:
        """A number of the case in SI units and rad/s; excitation.A is computed where a rule gives it.

        Raises UnknownKeyError (a KeyError) for keys that are no number of this case.
        """
        if key in ("A", "excitation.A") and isinstance(self.model, CaseFile):
            source = self.model.excitation
            if isinstance(source, Harmonic):
                return float(DOUBLES.convert(*amplitude_value(source)))
        return self.quantity(key).number()

    @property
    def source_kind(self) -> str:
        """What drives the bodies: motor, base, harmonic forces, constant ones alone, or none."""
        values = self.long_values()
        if "motor" in values or "base" in values:
            return "motor" if "motor" in values else "base"
        forces = values.get("forces", {}).values()
        if any("A" in force or "terms" in force for force in forces):
            return "harmonic"
        return "constant" if forces else "none"

    def frequency(self) -> Quantity | None:
        """Omega0 of the motor, or omega of all forces and the base where they share one; else None."""
        values = self.long_values()
        if "motor" in values:
            no_load: Quantity = values["motor"]["Omega0"]
            return no_load
        sources = [*values.get("forces", {}).values(), *([values["base"]] if "base" in values else [])]
        terms = [term for source in sources for term in [source, *source.get("terms", {}).values()]]
        rates = {term["omega"].value: term["omega"] for term in terms if "omega" in term}
        return next(iter(rates.values())) if len(rates) == 1 else None

    def with_values(self, changes: Mapping[str, object]) -> "Case":
        """This case with some values replaced, e.g. {"excitation.Omega0": "6.5 Hz"}.

        Raises CaseError (file "overrides") for unknown keys and for values that are not allowed.
        """
        tree = Tree(dict(self._nested), Place(self.source))
        apply_overrides(tree, changes)
        return Case(validated(tree), self.text, self.source)

    def __repr__(self) -> str:
        scene = self.scene()
        bodies = f"{len(scene.bodies)} bod{'y' if len(scene.bodies) == 1 else 'ies'}"
        stops = f", {len(scene.stops)} stop{'' if len(scene.stops) == 1 else 's'}" if scene.stops else ""
        frequency = f" at {self.frequency()}" if self.frequency() else ""
        source = f"source {self.source_kind}{frequency}"
        return f"<Case {self.name}: {bodies}{stops}, {source}, {self.quantity('run.t_end')}>"

    def _repr_html_(self) -> str:
        from vibsim.cases.notebook import html_of_case

        return html_of_case(self)

    def resolved_json(self) -> str:
        """The case as canonical JSON text: defaults filled in; from_resolved_json() reads it back exactly."""
        return resolved_text(self.model)

    @cached_property
    def sha256(self) -> str:
        """Fingerprint of what is simulated: exact values in any spelling, without name and title."""
        return fingerprint(self.values)

    @staticmethod
    def from_resolved_json(text: str, source: str = "resolved case") -> "Case":
        """The case that resolved_json() wrote down. Raises CaseError where the text is something else."""
        values = resolved_values(text, source)
        return Case(validated(Tree(values, Place(source))), text, source)

    def __reduce__(self) -> tuple[Any, ...]:
        return Case, (self.model, self.text, self.source)
