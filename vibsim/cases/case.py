"""A case: one system and one run of it, validated and exact."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property
from operator import index
from os import PathLike, fspath
from pathlib import Path
from typing import Any, TypeGuard, Union

from vibsim.cases.problems import CaseError, Problem, counted
from vibsim.cases.quantities import Quantity, number
from vibsim.cases.scene_building import (
    DOUBLES,
    SceneBuilder,
    amplitude_value,
    build_parts,
    build_two_blocks,
    exact_numbers,
)
from vibsim.cases.schema import CaseFile, CaseHead, HarmonicKeys, Section
from vibsim.cases.schema_keys import (
    UnknownKeyError,
    form_of,
    full_key,
    keys_of,
    measured_in_case,
)
from vibsim.cases.schema_kinds import Fault, KeyKind, Measured, has_formulas
from vibsim.cases.short_form import long_start, long_text, long_values, sections_text
from vibsim.cases.sources import (
    PathText,
    SourceText,
    apply_overrides,
    case_name_from,
    find_source,
    read_tree,
    value_text,
)
from vibsim.cases.validation import (
    derived_facts,
    exact_pairs,
    fingerprint_of,
    flat_values,
    has_contradictions,
    has_rigid_stops,
    nested_values,
    resolved_text,
    resolved_values,
    starts_inside,
    validated,
)
from vibsim.cases.yaml_nodes import Place, Tree, decoded
from vibsim.physics.parts import BODY, Scene
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
    _origin: "Case | None" = field(default=None, repr=False, compare=False)  # whose numbers it has,
    _numbers: Mapping[str, Quantity] = field(default_factory=dict, repr=False, compare=False)  # but for these

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
        return self._scene

    @cached_property
    def _scene(self) -> Scene:
        if self._origin is None:
            return self._builder.scene()
        builder, scene = self._origin._builder, self._origin._scene
        if self._is_start:
            model = self.model
            start = long_start(model) if isinstance(model, CaseFile) else self._nested["initial"]
            return builder.from_start(scene, start)
        before, values = builder.values, self.long_values()
        sections = [name for name in {**before, **values} if values.get(name) != before.get(name)]
        others = SceneBuilder(values, DOUBLES) if builder.formulas else builder.of_numbers(values)
        return others.rebuilt(scene, sections)

    @cached_property
    def _builder(self) -> SceneBuilder:
        return SceneBuilder(self.long_values(), DOUBLES)

    @property
    def _is_start(self) -> bool:
        """Whether it differs from its origin in initial values alone."""
        return all(map(_is_initial, self._numbers))

    def exact_scene(self, number: Callable[[Fraction], Any], pi: Any = None) -> Scene[Any]:
        """The scene in another number type, such as those of words (`vibsim.physics.precision`).

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
        if isinstance(self.model, CaseFile) and not has_formulas(self._nested):
            return self.model
        if isinstance(self.model, CaseFile):
            what = "a formula has no symbol of the paper (Omega0, M0), which this asks for"
            raise CaseError([Problem(self.source, None, None, "excitation", what)])
        what = (
            "named parts have no symbols of the paper (m1, k2, G, ...), which this asks for; "
            "it needs a case with blocks and coupling"
        )
        raise CaseError([Problem(self.source, None, None, "bodies", what)])

    @cached_property
    def values(self) -> dict[str, Any]:
        """Every value under its dotted key, defaults filled in: Quantity, word or whole number."""
        if self._origin is not None:
            return {**self._origin.values, **self._numbers}
        return flat_values(self.model)

    @cached_property
    def _nested(self) -> dict[str, Any]:
        if self._origin is not None:
            nested: dict[str, Any] = _with_parts(self._origin._nested, _nested_from(self._numbers))
            return nested
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

    def measured(self, key: str) -> Measured | None:
        """Quantity and range of the number at a dotted or short key; beside a formula its dimension."""
        full = self.full_key(key)
        return measured_in_case(self._nested, full, self.quantity(full))

    def number(self, key: str) -> float:
        """A number of the case in SI units and rad/s; excitation.A is computed where a rule gives it.

        Raises UnknownKeyError (a KeyError) for keys that are no number of this case.
        """
        if key in ("A", "excitation.A") and isinstance(self.model, CaseFile):
            source = self.model.excitation
            if isinstance(source, HarmonicKeys):
                return float(DOUBLES.convert(*amplitude_value(source)))
        return self.quantity(key).number()

    @property
    def source_kind(self) -> str:
        """Kind of source that drives the bodies: motor, base, rotors, formula, harmonic or constant (forces),
        or none.
        """
        values = self.long_values()
        if "motor" in values or "base" in values:
            return "motor" if "motor" in values else "base"
        forces = values.get("forces", {}).values()
        if "rotors" in values or any("force" in force for force in forces):
            return "rotors" if "rotors" in values else "formula"
        if any("A" in force or "terms" in force for force in forces):
            return "harmonic"
        return "constant" if forces else "none"

    def frequency(self) -> Quantity | None:
        """Omega0 of the motor, or omega of all forces and the base where they share one; else None."""
        values = self.long_values()
        if "motor" in values:
            no_load = values["motor"].get("Omega0")
            return no_load if isinstance(no_load, Quantity) and "torque" not in values["motor"] else None
        sources = [*values.get("forces", {}).values(), *([values["base"]] if "base" in values else [])]
        sources = [source for source in sources if not {"force", "x"} & set(source)]
        terms = [term for source in sources for term in [source, *source.get("terms", {}).values()]]
        rates = {term["omega"].value: term["omega"] for term in terms if "omega" in term}
        return next(iter(rates.values())) if len(rates) == 1 else None

    def with_values(self, changes: Mapping[str, object]) -> "Case":
        """This case with some values replaced, e.g. {"excitation.Omega0": "6.5 Hz"}.

        Raises CaseError (file "overrides") for unknown keys and for values that are not allowed.
        """
        case = self._with_numbers(changes)
        if case is not None:
            return case
        tree = Tree(dict(self._nested), Place(self.source))
        apply_overrides(tree, changes, self.values.keys())
        return Case(validated(tree), self.text, self.source)

    def _with_numbers(self, changes: Mapping[str, object]) -> "Case | None":
        """The same, in a fraction of the time, where numbers alone are replaced; None where a value is none
        of these or not plainly allowed.
        """
        kinds = self._number_kinds
        if not (isinstance(changes, Mapping) and changes and kinds.keys() >= changes.keys()):
            return None
        faults: list[Fault] = []
        read = {key: kinds[key].read(value_text(value), (), faults) for key, value in changes.items()}
        if faults or not all(isinstance(number, Quantity) for number in read.values()):
            return None
        origin = self._origin if self._origin and self._is_start else self
        numbers = read if origin is self else {**self._numbers, **read}
        model = _with_parts(origin._resolved, _nested_from(numbers))
        case = Case(model, self.text, self.source, origin, numbers)
        if not case._is_start:
            return None if origin._origin or has_contradictions(case._nested, case.values) else case
        if self.is_long and has_rigid_stops(origin._nested) and starts_inside(case._nested, case.values):
            return None
        return case

    @cached_property
    def _number_kinds(self) -> dict[str, KeyKind]:
        """Kinds of the numbers that can be replaced alone, by dotted key; beside formulas initial ones."""
        if self._origin is not None:
            return self._origin._number_kinds
        if form_of(self._nested).mixed:
            return {}
        keys = self.numeric_keys()
        return _kinds_at(self._resolved, filter(_is_initial, keys) if has_formulas(self._nested) else keys)

    @cached_property
    def _resolved(self) -> CaseHead:
        """The model with defaults filled in."""
        if self._origin is not None:
            return self.model
        model = form_of(self._nested).model.read(self._nested, (), [])
        assert model is not None  # its values were read once
        return model

    def __repr__(self) -> str:
        scene = self.scene()
        count = sum(body.kind == BODY for body in scene.bodies)
        bodies = counted(count, "body")
        stops = f", {counted(len(scene.stops), 'stop')}" if scene.stops else ""
        frequency = f" at {self.frequency()}" if self.frequency() else ""
        source = f"source {self.source_kind}{frequency}"
        return f"<Case {self.name}: {bodies}{stops}, {source}, {self.quantity('run.t_end')}>"

    def _repr_html_(self) -> str:

        return html_of_case(self)

    def resolved_json(self) -> str:
        """The case as canonical JSON text: defaults filled in; from_resolved_json() reads it back exactly."""
        return resolved_text(self.model)

    @cached_property
    def sha256(self) -> str:
        """Fingerprint of what is simulated: exact values in any spelling, without name and title."""
        return fingerprint_of(self._exact_pairs)

    @cached_property
    def _exact_pairs(self) -> dict[str, str]:
        if self._origin is not None:
            return {**self._origin._exact_pairs, **exact_pairs(self._numbers)}
        return exact_pairs(self.values)

    @staticmethod
    def from_resolved_json(text: str, source: str = "resolved case") -> "Case":
        """The case that resolved_json() wrote down. Raises CaseError where the text is something else."""
        values = resolved_values(text, source)
        return Case(validated(Tree(values, Place(source))), text, source)

    def __reduce__(self) -> tuple[Any, ...]:
        return Case, (self.model, self.text, self.source)


# From a path, a shipped name, standard input or what a file would say to a case.

CaseLike = Union[Case, str, "PathLike[str]", Mapping[str, object]]  # what `load_case` reads


def load_case(source: CaseLike, overrides: Mapping[str, object] | None = None) -> Case:
    """Read and check a case.

    Parameters
    ----------
    source : path of a YAML file, name of a shipped case, "-" for standard input, a Case; or the content of a
        file: a dict of what it would say, or its text, which has more than one line or begins with a brace
    overrides : dotted (or unambiguous short) key -> text or number, e.g. {"excitation.Omega0": "6.5 Hz"};
        checked as if the file said so, with "overrides" as the file

    Raises CaseError with every problem found, TypeError for what is neither.

    >>> import vibsim
    >>> vibsim.load_case("II-B", {"Omega0": "6.5 Hz", "run.t_end": "20 s"})
    <Case II-B: 2 bodies, 1 stop, source motor at 6.5 Hz, 20 s>
    >>> links = {"spring": {"between": ["m", "ground"], "k": "8 kN/m"}}
    >>> start, run = {"m": {"x": "1 mm"}}, {"t_end": "1 s", "every": "1 ms"}
    >>> vibsim.load_case({"bodies": {"m": 2.0}, "links": links, "initial": start, "run": run})
    <Case case: 1 body, source none, 1 s>
    """
    if isinstance(source, Case):
        return source.with_values(overrides) if overrides else source
    if isinstance(source, Mapping):
        return _case_of_dict(source, overrides)
    if _is_text(source):
        return load_case_text(source, overrides)
    if not isinstance(source, str | PathLike) or not isinstance(path := fspath(source), str):
        allowed = "a Case, the path of a case file, the name of a shipped case, a dict or YAML text"
        raise TypeError(f"a case must be {allowed}, got {source!r:.60}")
    return _case(find_source(path), overrides or {})


def _is_text(source: object) -> TypeGuard[str]:
    """Whether what stands for a case is the content of a file."""
    if not isinstance(source, str) or isinstance(source, PathText):
        return False
    return "\n" in source or source.lstrip().startswith("{")


def load_case_text(text: str, overrides: Mapping[str, object] | None = None, name: str = "case") -> Case:
    """The same from YAML text; `name` stands for the file in messages, and is the case's name by default."""
    return _case(
        SourceText(name, name, decoded(text.encode("utf-8", "replace"), name), Path(), name), overrides or {}
    )


def _case_of_dict(content: Mapping[str, object], overrides: Mapping[str, object] | None) -> Case:
    """The case that a dict describes as a file would; its problems have keys and no lines."""
    import yaml

    text = yaml.safe_dump(_plain(content), sort_keys=False, allow_unicode=True, width=100)
    try:
        return load_case_text(text, overrides)
    except CaseError as error:
        raise CaseError(
            replace(each, line=None, column=None) if each.file == "case" else each for each in error.problems
        ) from None


def _plain(value: Any) -> Any:
    """A value of a dict as YAML writes it; numbers in the digits of their repr."""
    if isinstance(value, Mapping):
        return {key if isinstance(key, int) else str(key): _plain(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(each) for each in value]
    if value is None or isinstance(value, bool | int | str):
        return value
    return repr(float(value)) if isinstance(value, float) else str(value)


def _case(source: SourceText, overrides: Mapping[str, object]) -> Case:
    tree = read_tree(source)
    tree.values.setdefault("name", case_name_from(source.stem))
    apply_overrides(tree, overrides)
    return Case(validated(tree), source.text, source.shown)


# Arguments of Python calls, checked at the edge: an error names the argument and what it may be.


def whole_number(name: str, value: Any, least: int) -> int:
    """A whole number, at least `least`. Raises TypeError for what is none, ValueError for a lesser one."""
    try:
        number = index(value)
    except TypeError:
        number = None
    if number is None or isinstance(value, bool):
        raise TypeError(f"{name} must be a whole number, got {value!r:.60}")
    if number < least:
        raise ValueError(f"{name} must be at least {least}, got {number}")
    return number


def by_key(name: str, values: Any, example: str) -> Mapping[str, Any]:
    """Values by keys of a case; None: none. Raises TypeError for what is no dict."""
    if values is None:
        return {}
    if not isinstance(values, Mapping) or not all(isinstance(key, str) for key in values):
        raise TypeError(f"{name} must be a dict such as {example}, got {values!r:.60}")
    return values


def texts(name: str, values: Any) -> list[str]:
    """Texts, or one of them. Raises TypeError for anything else."""
    listed = (
        [values] if isinstance(values, str) else list(values) if isinstance(values, Iterable) else [values]
    )
    for value in listed:
        if not isinstance(value, str):
            raise TypeError(f"{name} must be a text or a list of texts, got {value!r:.60}")
    return listed


# Cases that differ in numbers alone, as the points of a sweep: what they share is kept.


def _is_initial(key: str) -> bool:
    """Whether a dotted key is one of an initial value."""
    return key.startswith("initial.")


def _kinds_at(model: CaseHead, keys: Iterable[str]) -> dict[str, KeyKind]:
    """Kinds of the numbers at dotted keys of sections that the model has, by key."""
    kinds = {}
    for key in keys:
        *around, name = key.split(".")
        section: Any = model
        for part in around:
            section = (section if isinstance(section, dict) else vars(section))[part]
        if isinstance(section, Section):
            kinds[key] = section.keys[name].kind
    return kinds


def _nested_from(flat: Mapping[str, Any]) -> dict[str, Any]:
    """Values by dotted keys as dicts within dicts."""
    nested: dict[str, Any] = {}
    for key, value in flat.items():
        *around, name = key.split(".")
        inner = nested
        for part in around:
            inner = inner.setdefault(part, {})
        inner[name] = value
    return nested


def _with_parts(section: Any, changes: Mapping[str, Any]) -> Any:
    """A section, or a dict of parts by name, with other values at keys that it has; a dict among them is of
    the section there.
    """
    content = section if isinstance(section, dict) else vars(section)
    content = content | {
        name: _with_parts(content[name], value) if isinstance(value, dict) else value
        for name, value in changes.items()
    }
    if isinstance(section, dict):
        return content
    other = object.__new__(type(section))
    vars(other).update(content)
    return other


# What a notebook shows of a case: what it is, what follows from its numbers, and its text when opened.


CELL = 'style="text-align:left;padding:0 1em 0 0;vertical-align:top"'


def html_of_case(case: "Case") -> str:
    """The short text of the case, its title, a table of derived numbers and the folded case file; colours are
    the page's own.
    """
    from html import escape

    rows = "".join(
        _row(fact.name, f"{number(fact.value, 6)} {fact.unit}".strip(), fact.meaning)
        for fact in derived_facts(case.scene())
    )
    return (
        f"<div><b>{escape(repr(case)[1:-1])}</b><br>{escape(case.title)}<table>{rows}</table>"
        f"<details><summary>case file</summary><pre>{escape(case.to_yaml())}</pre></details></div>"
    )


def _row(*cells: str) -> str:
    from html import escape

    return "<tr>" + "".join(f"<td {CELL}>{escape(cell)}</td>" for cell in cells) + "</tr>"
