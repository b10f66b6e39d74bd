"""Problems of the keys and values of a case, in words and at their place in the file."""

import json
from collections.abc import Callable, Iterator, Mapping
from fractions import Fraction
from json.encoder import encode_basestring_ascii as quoted
from math import inf, isfinite, pi, sqrt
from typing import Any, NamedTuple

from vibsim.cases.problems import CaseError, Problem, did_you_mean, shown, unsupported
from vibsim.cases.quantities import Quantity, QuantityError, product_fits
from vibsim.cases.schema import USUAL_ORDER, CaseFile, CaseHead, MotorKeys, Section
from vibsim.cases.schema_keys import (
    SHORT,
    Form,
    all_keys,
    form_of,
    is_tag,
    mixed_problems,
    of_one_form,
    section_at,
    sections_with,
)
from vibsim.cases.schema_kinds import Fault, Location, has_formulas
from vibsim.cases.short_form import Draft, FoundDefault, with_defaults
from vibsim.cases.sources import BROKEN, put_tables_in
from vibsim.cases.yaml_nodes import Place, Tree
from vibsim.physics.formulas import reads
from vibsim.physics.parts import GROUND, Friction, Link, Motor, Scene
from vibsim.physics.rates import bilinear_frequencies, frequency, masses, natural_rates, reduced_mass
from vibsim.physics.two_blocks import is_papers


def model_problems(faults: list[Fault], tree: Tree, form: Form) -> list[Problem]:
    """The problems behind faults, each at its place in the files of the tree."""
    named_motors = any(map(_is_named_motor, faults))
    problems = []
    for fault in faults:
        known = fault.value is not BROKEN and (tree.complete or fault.what != "missing")
        of_motors = named_motors and fault.location[:-1] == ("motor",) and fault.what == "missing"
        if known and not of_motors:
            problems.append(_problem(fault, tree, form))
    return problems


def _problem(fault: Fault, tree: Tree, form: Form) -> Problem:
    """One fault in words."""
    location, value = fault.location, fault.value
    key = ".".join(part for part in location if not is_tag(part))
    if fault.what == "unknown":
        return tree.key_place(key).problem(key, _unknown_key(location, value, form))
    if fault.what == "no variant":
        return _wrong_kind(value, key, tree)
    message = fault.message
    if fault.what == "missing":
        message = _missing_key(location, form)
    elif fault.what == "no mapping":
        message = _no_mapping(location, value, form)
    return tree.place(key).problem(key, message)


def _is_named_motor(fault: Fault) -> bool:
    """True for a motor under a name of its own, as if there could be several."""
    return fault.what == "unknown" and fault.location[0] == "motor" and isinstance(fault.value, dict)


def _listed(names: Any) -> str:
    return ", ".join(names)


def _unknown_key(location: Location, value: object, form: Form) -> str:
    *around, name = location
    section = section_at(tuple(around), form)
    allowed = _states_of(around, form) or (list(section.keys) if section else [])
    if around == ["motor"] and isinstance(value, dict):
        return f"a scene has at most one motor, without a name; allowed: {_listed(allowed)}"
    elsewhere = sections_with(name, form)
    if not elsewhere and (limit := unsupported(name)):
        return limit
    hint = f" here; it belongs to {' or '.join(elsewhere)}" if elsewhere else did_you_mean(name, allowed)
    return f"unknown key{hint}; allowed: {_listed(allowed)}"


def _states_of(around: list[str], form: Form) -> list[str]:
    """Keys of the start of a body, or of the rotor: the schema has one section for both."""
    if "initial" not in form.named or len(around) != 2 or around[0] != "initial":
        return []
    return ["phi", "phidot"] if around[1] == "motor" else ["x", "v"]


def _missing_key(location: Location, form: Form) -> str:
    *around, name = location
    section = section_at(tuple(around), form)
    field = section.keys[name] if section else None
    inner = section_at(location, form)
    needs = [key for key, item in inner.keys.items() if item.is_required()] if inner else []
    if needs:
        return f"is missing; it needs {_listed(needs)}"
    example = f", for example {name}: {field.examples[0]}" if field and field.examples else ""
    return f"is missing{example}"


def _wrong_kind(value: object, key: str, tree: Tree) -> Problem:
    """An excitation of no known kind, of no kind at all, or that is no mapping."""
    allowed = ["motor", "harmonic", "none"]
    if not isinstance(value, dict):
        message = f"must be a mapping such as {{kind: motor, ...}}, or none; got {shown(value)}"
        return tree.place(key).problem(key, message)
    key = f"{key}.kind"
    if "kind" not in value:
        return tree.place(key).problem(key, f"is missing; allowed: {_listed(allowed)}")
    if value["kind"] is BROKEN:
        return tree.place(key).problem(key, "cannot be read")
    if isinstance(value["kind"], dict):
        return tree.place(key).problem(key, f"must be one of {_listed(allowed)}, got a mapping")
    kind = str(value["kind"])
    choice = f"must be one of {_listed(allowed)}, got {shown(kind)}{did_you_mean(kind, allowed)}"
    return tree.place(key).problem(key, unsupported(kind) or choice)


def _no_mapping(location: Location, value: object, form: Form) -> str:
    section = section_at(location, form)
    named = form.named if len(location) == 1 else ()
    keys = _listed(section.keys) if section else "names"
    if location[-1] == "terms":
        return f"must be a list of harmonics, such as [{{A: 10 N, omega: 25 Hz}}]; got {shown(value)}"
    if len(location) == 2 and location[0] == "initial" and "initial" in form.named:
        starts = "{x: ..., v: ...} of a body, or {phi: ..., phidot: ...} of motor"
        return f"must be the start of one part, such as initial.NAME: {starts}; got {shown(value)}"
    if location[-1] in named:
        keys = NAMED_SECTIONS.get(location[-1], "parts by name, each a mapping of its keys")
    part = len(location) == 2 and location[0] in form.named
    none = ", or none" if part or (len(location) == 1 and location[0] in form.switchable) else ""
    return f"must be a mapping of {keys}{none}; got {shown(value)}"


NAMED_SECTIONS = {
    "bodies": "names and masses, such as {ram: 2 kg}",
    "initial": "bodies and their states, such as {ram: {x: 0 m, v: 0 m/s}}",
}


# What the numbers of a case imply: natural frequencies, friction, the motor; for `vibsim check -v`.


class Fact(NamedTuple):
    """A number that follows from the case, with its unit and where it comes from."""

    name: str
    value: float
    unit: str
    meaning: str


def derived_facts(scene: Scene) -> list[Fact]:
    """Facts of a scene, of the paper's two blocks by the paper's symbols; those that need a missing part
    are left out.
    """
    if is_papers(scene):
        return [*_of_blocks(scene, scene.links[0]), *_of_motor(scene.motor)]
    plain = [friction for friction in scene.frictions if friction.holds is None]
    frictions = [fact for friction in plain for fact in _friction_forces(friction, scene)]
    return [*([] if _is_by_formulas(scene) else _frequencies(scene)), *frictions, *_of_motor(scene.motor)]


def _is_by_formulas(scene: Scene) -> bool:
    """Whether formulas have a say in how bodies vibrate freely, so that stiffnesses alone do not tell."""
    loads = [force.formula for force in scene.forces if force.formula is not None]
    return any(link.force is not None for link in scene.links) or reads(loads, ("x", "v"))


def _frequencies(scene: Scene) -> Iterator[Fact]:
    """Natural frequencies with all stops open and closed, and those of large vibrations."""
    elastic = [stop for _, stop in scene.elastic_stops if stop.force is None]
    whole = len(elastic) == len(scene.elastic_stops)
    for words, closed in (("stops open", []), ("stops closed", elastic)):
        if words == "stops closed" and not (elastic and whole):
            continue
        for i, rate in enumerate(natural_rates(scene, closed), 1):
            yield Fact(f"{words.split()[1]} {i}", rate / (2 * pi), "Hz", f"natural frequency, {words}")
    for i, hertz in enumerate(bilinear_frequencies(scene) if whole else (), 1):
        yield Fact(f"bilinear {i}", hertz, "Hz", "2 f1 f2/(f1 + f2), large vibration")


def _friction_forces(friction: Friction, scene: Scene) -> list[Fact]:
    """Limits while sticking, and the forces while slipping where these are lower."""
    turns = scene.unit_of(scene.bodies[max(friction.P, friction.Q)]) == "rad"
    unit, word = ("N m", "torque") if turns else ("N", "force")
    limits, forces = friction.limits, _at_high_speed(friction)
    alike = limits[0] == limits[1] and forces[0] == forces[1]
    words = "at high speed" if friction.slips else "while slipping"
    facts = []
    for i, side in enumerate(("",) if alike else (" plus", " minus")):
        facts.append(Fact(friction.name + side, limits[i], unit, f"limit friction {word}"))
        if isfinite(forces[i]) and forces[i] != limits[i]:
            facts.append(Fact(f"{friction.name}{side}", forces[i], unit, f"friction {word} {words}"))
    return facts


def _at_high_speed(friction: Friction) -> tuple[float, float]:
    """Forces while slipping forwards and backwards beyond all speeds [N]; infinite or NaN where there are
    none.
    """
    if friction.slips is None:
        return friction.forward, friction.backward
    import numpy as np

    from vibsim.physics.formula_values import values_of

    end, sense = (friction.P, 1) if friction.P >= 0 else (friction.Q, -1)
    with np.errstate(all="ignore"):
        forward, backward = (
            float(values_of(slip, {("v", end): side * sense * inf}))
            for slip, side in zip(friction.slips, (1, -1), strict=True)
        )
    return forward, backward


def _of_blocks(scene: Scene, coupling: Link) -> Iterator[Fact]:
    """Frequencies, damping and friction of two blocks, or of block 1 before a wall."""
    k1, mass = coupling.k, reduced_mass(scene, coupling.P, coupling.Q)
    own = "(m1 + m3)" if scene.has_motor else "m1"
    held = frequency(k1, float(masses(scene)[coupling.P]))
    yield Fact("block 1 on its spring", held, "Hz", f"sqrt(k1/{own})/(2 pi)")
    free = frequency(k1, mass)
    if coupling.Q != GROUND:
        yield Fact("free", free, "Hz", "blocks against each other, no friction, stop open")
    for _, stop in scene.elastic_stops:
        contact = frequency(k1 + stop.k, mass)
        yield Fact("in contact", contact, "Hz", "the same with k1 + k2")
        bilinear = 2 * free * contact / (free + contact)
        yield Fact("bilinear", bilinear, "Hz", "2 f1 f2/(f1 + f2), large vibration")
    if k1:
        ratio = coupling.c / (2 * sqrt(k1 * mass))
        yield Fact("damping ratio", ratio, "", "c/(2 sqrt(k1 m)), stop open")
    for friction in scene.frictions:
        yield Fact("limit friction force", friction.forward, "N", "mu m2 g")
        if k1:
            yield Fact(
                "friction band", friction.forward / k1, "m", "N/k1; inside it block 2 can stay at rest"
            )


def _of_motor(motor: Motor | None) -> Iterator[Fact]:
    if motor is None:
        return
    if motor.M0:
        run_up = motor.Omega0 * (motor.J + motor.m3 * motor.e**2) / motor.M0
        yield Fact("run-up time constant", run_up, "s", "Omega0 (J + m3 e^2)/M0")
    yield Fact("full force", motor.m3 * abs(motor.e) * motor.Omega0**2, "N", "m3 e Omega0^2, Eq. (2.11)")


# The resolved form of a case: its values with the defaults filled in, and their canonical JSON text.


RESOLVED_FORMAT = 1  # of the JSON text
NOT_PHYSICS = ("name", "title", "run.trust_tolerance")


def nested_values(case: CaseHead) -> dict[str, Any]:
    """Sections as dicts of quantities, words and whole numbers; missing sections are left out."""
    values = _section_values(case)
    if not isinstance(case, CaseFile):
        values = with_defaults(values, form_of(values).torsional)
        return values if "order" in values["run"] else values | {"run": _with_order(values)}
    for name in _absent_states(case):
        del values["initial"][name]
    return values


def _with_order(values: dict[str, Any]) -> dict[str, Any]:
    """The section run of a case that does not say the order of its series, with that order."""
    order = USUAL_ORDER
    if has_formulas(values):
        from vibsim.cases.plain_laws import default_order

        order = default_order(values)
    items = list(values["run"].items())
    place = list(values["run"]).index("method") + 1
    return dict([*items[:place], ("order", order), *items[place:]])


def flat_values(case: CaseHead) -> dict[str, Any]:
    """The same under dotted keys, e.g. "excitation.Omega0"."""
    return dict(_leaves(nested_values(case), ""))


def every_value(case: CaseHead) -> dict[str, Any]:
    """Flat values, with the initial states that the case has no use for."""
    return dict(_leaves(_section_values(case), ""))


def resolved_text(case: CaseHead) -> str:
    """Canonical JSON: every value, numbers as the texts that read back to the same exact quantity."""
    return json.dumps({"vibsim_case": RESOLVED_FORMAT} | _texts(nested_values(case)), ensure_ascii=False)


def resolved_values(text: str, source: str) -> dict[str, Any]:
    """Nested texts of what resolved_text() wrote. Raises CaseError where the text is something else."""
    try:
        values = json.loads(text)
    except (ValueError, RecursionError):
        values = None
    if not isinstance(values, dict) or "vibsim_case" not in values:
        raise CaseError([Problem(source, None, None, "", "is not the resolved JSON text of a vibsim case")])
    version = values.pop("vibsim_case")
    if version != RESOLVED_FORMAT:
        what = f"is a resolved case of format {version}; this vibsim reads format {RESOLVED_FORMAT}"
        raise CaseError([Problem(source, None, None, "", what)])
    return values


def exact_texts(flat: Mapping[str, Any]) -> dict[str, str]:
    """The exact values that tell what is simulated, in one spelling for each (330 rpm is 5.5 Hz).

    Name, title and trust tolerance do not count: they leave the motion as it is.
    """
    return {key: _exact_text(value) for key, value in flat.items() if key not in NOT_PHYSICS}


def exact_pairs(flat: Mapping[str, Any]) -> dict[str, str]:
    """The same texts with their keys as JSON has them, `"key": "text"`, in the order of the keys."""
    return {key: f"{quoted(key)}: {quoted(text)}" for key, text in sorted(exact_texts(flat).items())}


def fingerprint_of(pairs: Mapping[str, str]) -> str:
    """SHA-256 of exact texts with their keys."""
    import hashlib  # loads OpenSSL, 2 ms, which a run does while the engine runs already

    return hashlib.sha256(f"{{{', '.join(pairs.values())}}}".encode()).hexdigest()


def _section_values(section: Section | dict[str, Any]) -> dict[str, Any]:
    """The keys of a section, or its parts by name; empty sections of parts are left out."""
    inner = section if isinstance(section, dict) else section.__dict__
    return {
        name: _section_values(value) if isinstance(value, Section | dict) else value
        for name, value in inner.items()
        if value is not None and value != {}
    }


def _absent_states(case: CaseFile) -> list[str]:
    absent = [] if isinstance(case.blocks.m2, Quantity) else ["x2", "v2"]
    return absent if isinstance(case.excitation, MotorKeys) else [*absent, "phi", "phidot"]


def _leaves(values: dict[str, Any], prefix: str) -> Iterator[tuple[str, Any]]:
    for name, value in values.items():
        if isinstance(value, dict):
            yield from _leaves(value, f"{prefix}{name}.")
        else:
            yield f"{prefix}{name}", value


def _texts(value: Any) -> Any:
    if isinstance(value, dict):
        return {name: _texts(inner) for name, inner in value.items()}
    return value if isinstance(value, str | int) else str(value)


def _exact_text(value: Any) -> str:
    if not isinstance(value, Quantity):
        return str(value)
    return f"{value.value} turns" if value.per_turn else str(value.value)


# A tree of texts to a validated case file, or all that is wrong with it, each at its place.


def validated(tree: Tree) -> CaseHead:
    """The case file of a tree. Raises CaseError with all problems found, in file order."""
    put_tables_in(tree)
    form = form_of(tree.values)
    problems = [*tree.problems, *mixed_problems(tree.values, tree.key_place)]
    values = form.without_switched_off(of_one_form(tree.values))
    if tree.values or not problems:
        model, further = _checked(values, tree, form)
        if model is not None and not (further or problems):
            return model
        reported = {problem.key for problem in problems if problem.key}
        problems += [problem for problem in further if not _around(problem.key) & reported]
    raise CaseError(sorted(dict.fromkeys(problems), key=_file_order(tree)))


def has_contradictions(values: dict[str, Any], flat: Mapping[str, Any]) -> bool:
    """Whether numbers that are right by themselves contradict each other, in a case without formulas whose
    keys and words are right.
    """
    if contradictions(flat):
        return True
    form = form_of(values)
    if form is SHORT:
        return False
    from vibsim.cases.part_rules import findings

    return bool(findings(flat, values, form))


def has_rigid_stops(values: dict[str, Any]) -> bool:
    """Whether a case in the long form has a rigid stop."""
    return any(stop.get("law") == "rigid" for stop in values.get("stops", {}).values())


def starts_inside(values: dict[str, Any], flat: Mapping[str, Any]) -> bool:
    """Whether a body starts inside a rigid stop; values: of a valid case in the long form but for its start.
    That alone and units, where some bodies turn and others do not, decide whether a start is allowed that is
    so by itself.
    """
    from vibsim.cases.part_laws import starts_are_outside

    form = form_of(values)
    return any(True for _ in starts_are_outside(Draft(flat, values, form.torsional, form.mixed)))


def _checked(values: dict[str, Any], tree: Tree, form: Form) -> tuple[CaseHead | None, list[Problem]]:
    """The model where every value is right by itself, and all problems, also those between keys."""
    problems: list[Problem] = []
    faults: list[Fault] = []
    model = form.model.read(values, (), faults)
    if model is None or faults:
        model, problems = None, model_problems(faults, tree, form)
        flat = dict(_readable(values, "", form))
    else:
        flat = every_value(model)
    for keys, message in contradictions(flat):
        key = min(keys, key=lambda key: _layer(tree, tree.key_place(key)))
        place = tree.key_place(key) if key in form.switchable else tree.place(key)
        problems.append(place.problem(key, message))
    if form is not SHORT:
        problems += _problems_of_parts(values, tree, form)
    return model, problems + _problems_of_formulas(values, tree)


def _problems_of_parts(values: dict[str, Any], tree: Tree, form: Form) -> list[Problem]:
    """Problems found by the rules of the long form, without those of a file that could not be read."""
    from vibsim.cases.part_rules import findings

    if not tree.complete:
        return []
    return [_found(finding, tree) for finding in findings(dict(_readable(values, "", form)), values, form)]


def _problems_of_formulas(values: dict[str, Any], tree: Tree) -> list[Problem]:
    """Problems of formulas; a case without them is not looked at any further."""
    if not (tree.complete and has_formulas(values)):
        return []
    from vibsim.cases.formula_building import formula_findings

    return [_found(finding, tree) for finding in formula_findings(values)]


def _found(finding: FoundDefault, tree: Tree) -> Problem:
    """Problem that a rule found, at its place; of a formula, at the character that is to blame."""
    place = (tree.key_place if finding.of_the_name else tree.place)(finding.key)
    if finding.span is not None:
        place = tree.place_inside(finding.key, finding.span[0])
    return place.problem(finding.key, finding.message)


def _layer(tree: Tree, place: Place) -> int:
    """0 for an override, 1 for the case's own file, 2 for what that extends; the lowest is to blame."""
    if place.line is None and place != tree.root:
        return 0
    return 1 if place.file == tree.root.file else 2


def _readable(values: dict[str, Any], prefix: str, form: Form) -> Iterator[tuple[str, Any]]:
    """Those values of an invalid case that can be read by themselves."""
    for name, value in values.items():
        key = f"{prefix}{name}"
        if isinstance(value, dict):
            yield from _readable(value, f"{key}.", form)
            continue
        measured = all_keys(form).get(form.pattern(key))
        try:
            yield key, measured.read(value) if measured else value
        except QuantityError:
            continue


def _around(key: str) -> set[str]:
    """A key and the sections around it: "a.b" gives {"a.b", "a"}."""
    parts = key.split(".")
    return {".".join(parts[: count + 1]) for count in range(len(parts))}


def _file_order(tree: Tree) -> Any:
    """Sort by file (the case's own first, overrides last), then by place."""

    def order(problem: Problem) -> tuple[bool, bool, str, int, int]:
        own = problem.file == tree.root.file
        return problem.line is None, not own, problem.file, problem.line or 0, problem.column or 0

    return order


# Rules that concern several keys at once.
#
# Each yields the keys that contradict one another and what is wrong; the first key is to blame where all
# stand in one file.


MOST_SAMPLES = 10**10
LARGEST_WHOLE = 2**53  # above it a double does not hold every whole number

Flat = Mapping[str, Any]  # dotted key -> Quantity, word or whole number; what cannot be read is absent
Contradiction = tuple[tuple[str, ...], str]


def contradictions(flat: Flat) -> list[Contradiction]:
    """All (keys, message) that the rules find in a case's values."""
    return [problem for rule in RULES for problem in rule(flat)]


def _extends_is_followed(flat: Flat) -> Iterator[Contradiction]:
    if "extends" in flat:
        yield ("extends",), "works in a case file only"


def _present(flat: Flat, section: str) -> bool:
    return any(key.startswith(f"{section}.") for key in flat)


def _friction_needs_block_2(flat: Flat) -> Iterator[Contradiction]:
    if flat.get("blocks.m2") == "fixed" and _present(flat, "friction"):
        yield (
            ("friction", "blocks.m2"),
            "block 2 is fixed and cannot slide; leave friction out, or write none",
        )


def _states_that_exist(flat: Flat) -> Iterator[Contradiction]:
    if flat.get("blocks.m2") == "fixed":
        yield from _without(flat, ("x2", "v2"), "blocks.m2", "block 2 is fixed")
    if flat.get("excitation.kind", "none") != "motor":
        yield from _without(flat, ("phi", "phidot"), "excitation.kind", "there is no motor")


def _without(flat: Flat, states: tuple[str, ...], cause: str, why: str) -> Iterator[Contradiction]:
    """States that are given and do not exist; an exact 0 says nothing and is let through."""
    for name in states:
        state = flat.get(f"initial.{name}")
        if isinstance(state, Quantity) and state.value != 0:
            yield (f"initial.{name}", cause), f"{why}, so initial.{name} must be left out, got {state}"


def _closed_form_needs_linear(flat: Flat) -> Iterator[Contradiction]:
    if flat.get("run.method") == "closed_form" and flat.get("excitation.kind") == "motor":
        what = "a motor has no closed form; with one, run.method must be auto or taylor, got closed_form"
        yield ("run.method", "excitation.kind"), what


def _output_interval(flat: Flat) -> Iterator[Contradiction]:
    """Sample i is at i p/q, and both products are whole numbers that a double holds."""
    every, t_end = _exact(flat, "run.every"), _exact(flat, "run.t_end")
    if every is None:
        return
    span = every + (t_end or 0)
    samples = span / every
    if samples > MOST_SAMPLES:
        count = f"{float(samples):.3g}"
        what = (
            f"{flat['run.t_end']} every {flat['run.every']} makes {count} samples; at most 1e10 are allowed"
        )
        yield ("run.every", "run.t_end"), what
    elif every.numerator >= LARGEST_WHOLE or span * every.denominator >= LARGEST_WHOLE:
        every_text = f"as p/q seconds, {flat['run.every']} has too many digits"
        what = f"{every_text}: p, and q times run.t_end, must be below 2^53; a fraction such as 1/60 s may do"
        yield ("run.every", "run.t_end"), what


def _exact(flat: Flat, key: str) -> Fraction | None:
    value = flat.get(key)
    return value.value if isinstance(value, Quantity) else None


def _derived_numbers_fit(flat: Flat) -> Iterator[Contradiction]:
    """Values computed from several others must fit a double as they do."""
    for name, factors in PRODUCTS.items():
        values = [factor for factor in map(flat.get, factors) if isinstance(factor, Quantity)]
        if len(values) == len(factors) and not product_fits(values):
            yield factors, f"{name} does not fit double precision (2.3e-308 to 2.2e307)"


PRODUCTS = {
    "mu m2 g": ("friction.mu", "blocks.m2", "friction.g"),
    "m3 e omega^2": ("excitation.A.m3", "excitation.A.e", "excitation.omega", "excitation.omega"),
    "m3 e^2": ("excitation.m3", "excitation.e", "excitation.e"),
}
RULES: tuple[Callable[[Flat], Iterator[Contradiction]], ...] = (
    _extends_is_followed,
    _friction_needs_block_2,
    _states_that_exist,
    _closed_form_needs_linear,
    _output_interval,
    _derived_numbers_fit,
)
