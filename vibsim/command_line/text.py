"""Results and cases in words: what commands print."""

from __future__ import annotations

import json
import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from math import pi
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vibsim.cases.problems import counted, one_line
from vibsim.cases.quantities import Quantity, number
from vibsim.command_line.terminal import say, style
from vibsim.physics.connections import reads_time
from vibsim.physics.parts import ROTOR, STATE, Harmonic, Motor, Scene
from vibsim.physics.rates import turning_rotor
from vibsim.results import Result
from vibsim.results.hdf5_reading import plain
from vibsim.results.result import unknown_text

if TYPE_CHECKING:
    from vibsim.analysis.regime import Lyapunov
    from vibsim.cases import Case


# What a trajectory came to, for people (lines) and for programs (JSON).


LABEL_WIDTH = 16
METHODS = {"closed_form": "closed form", "auto": "closed form or Taylor"}  # as one reads them
NO_JSON = ("case_yaml", "lyapunov_growth")  # as long as a file of its own


def heading(name: str, title: str) -> str:
    """Name (bold) and title of a case."""
    title = one_line(title)
    return style(one_line(name), bold=True) + (f"  {title}" if title and title != name else "")


def case_lines(case: Case) -> list[tuple[str, str]]:
    """Label and text of what is run: bodies and parts of the long form, source and span."""
    scene = case.scene()
    every = seconds(scene.every_num / scene.every_den)
    return [
        *(
            scene_lines(scene, case)
            if case.is_long or scene.has_formulas
            else [("source", source_text(scene))]
        ),
        ("span", f"{seconds(scene.t_end)}, a sample every {every}: {counted(scene.sample_count, 'sample')}"),
    ]


def result_lines(result: Result) -> list[tuple[str, str]]:
    """Label and text of everything that is known of a trajectory; what is not known has no line."""
    attrs, case, scene = result.attrs, result.case, result.case.scene()
    lines = [*case_lines(case), ("engine", engine_text(attrs))]
    if not result.complete:
        lines.append(("incomplete", style(f"samples end at {last_sample(result):g} s", fg="yellow")))
    elif result.t_reached < scene.t_end:
        limit = "a clearance" if case.is_long else "the rest distance"
        lines.append(("stopped", style(f"at {result.t_reached:.6g} s, by {limit}", fg="yellow")))
    if "events" in attrs:
        lines.append(("motion", motion_text(attrs)))
    if "orbit_periods" in attrs:
        lines.append(("orbit", orbit_text(attrs, scene)))
    counts = counts_of(result)
    lines += count_lines(counts)
    if "digits" in attrs:
        lines.append(("digits", digits_text(attrs)))
    if result.trust_horizon is not None:
        lines.append(("trust horizon", trust_text(result)))
    if "certified" in attrs:
        lines.append(("certificate", certificate_text(attrs)))
        lines += [("", text) for text in doubt_texts(result)]
    if "grazing_margin" in attrs:
        lines.append(
            (
                "grazing margin",
                f"{metres(attrs['grazing_margin'], scene.unit_of_stops())} at {attrs['grazing_time']:.3f} s",
            )
        )
    if "energy_residual" in attrs:
        lines.append(("energy residual", energy_text(attrs)))
    if "lyapunov_growth" in attrs:
        lines += exponent_lines(result)
    if case.is_long:
        lines += clearance_lines(scene, attrs, counts)
    elif "rest_distance_needed" in attrs or scene.clearances:
        lines.append(("rest distance", rest_distance_text(attrs, scene)))
    return lines


def counts_of(result: Result) -> dict[str, dict[str, int]]:
    """Counts of events of each part; nothing of the short form, which has one of each."""
    if not result.case.is_long:
        return {}
    from vibsim.results.columns import part_counts

    return part_counts(result, result.case.scene())


def orbit_text(attrs: Mapping[str, Any], scene: Scene) -> str:
    """Summary of the periodic orbit that a file holds."""
    turns = scene.has_motor or turning_rotor(scene) is not None
    periods = counted(attrs["orbit_periods"], "turn" if turns else "period")
    stable = "stable" if attrs["orbit_stable"] else "unstable"
    return f"{periods}, {attrs['orbit_period_s']:.10g} s, {stable}, events {attrs['orbit_events'] or 'none'}"


def certificate_text(attrs: Mapping[str, Any]) -> str:
    """Whether every event is proved, or how many stretches are in doubt and since when."""
    if attrs["certified"]:
        return "no event missed, none invented: every stretch proved"
    count, first = attrs["uncertified"], attrs["first_uncertified_time"]
    return style(f"{counted(count, 'stretch')} in doubt, the first from {first:.6g} s on", fg="yellow")


def doubt_texts(result: Result) -> list[str]:
    """When, which events and why, of the doubts that are described: a line for those alike."""
    alike: dict[str, list[float]] = {}
    for doubt in result.doubts:
        text = ": ".join(filter(None, (" and ".join(doubt.events), doubt.reason)))
        alike.setdefault(text, []).append(doubt.time)
    lines = []
    for text, times in alike.items():
        again = f" ({len(times)} times until {times[-1]:.6g} s)" if len(times) > 1 else ""
        lines.append(f"{times[0]:.6g} s: {text}{again}")
    more = int(result.attrs.get("uncertified", 0)) - sum(map(len, alike.values()))
    if lines and more > 0:
        lines.append(f"and {more} more")
    return [style(line, fg="yellow") for line in lines]


def energy_text(attrs: Mapping[str, Any]) -> str:
    """Closure of the energy ledger, absolute and relative to its largest entry."""
    absolute, relative = (number(attrs[f"energy_residual{of}"], 2) for of in ("", "_relative"))
    return f"{absolute} J ({relative} relative)"


def trust_text(result: Result) -> str:
    """To what and until when a trajectory is right; its estimated error where it is to the end."""
    attrs, unit = result.attrs, result.error_unit
    tolerance, horizon = f"right to {number(attrs['trust_tolerance_m'], 2)} {unit}", attrs["trust_horizon_s"]
    if horizon < result.t_reached:
        return f"{tolerance} until {horizon:.4g} s{unknown_text(attrs)}"
    error = number(attrs["error_estimate_max"], 2)
    return f"{tolerance} over the whole run; estimated error up to {error} {unit}"


def last_sample(result: Result) -> float:
    """Time of the last sample [s]; 0 without any."""
    return float(result.column("time")[-1]) if len(result) else 0.0


def source_text(scene: Scene) -> str:
    """The source of excitation of the short form, its frequency in Hz and in rad/s."""
    if scene.motor is not None:
        return f"motor, {motor_text(scene.motor)}"
    for force in scene.forces:
        (term,) = force.terms
        constant = f" + {number(force.constant, 6)} N" if force.constant else ""
        frequency = f"{term.cycles + term.cycles_lo:.7g} Hz ({term.omega:.6g} rad/s)"
        return f"harmonic force, {number(term.amplitude, 6)} N{constant} at {frequency}"
    return "none"


def engine_text(attrs: dict[str, Any]) -> str:
    """Engine and method; order and tolerance of the Taylor method."""
    engine = {"c": "C", "python": "Python"}.get(attrs["engine"], attrs["engine"])
    method = METHODS.get(attrs["method"], attrs["method"])
    if "number_type" in attrs:
        engine += f" on {attrs['number_type']} numbers"
    if "taylor_order" in attrs:
        method += f" series of order {attrs['taylor_order']}"
    if "taylor_tolerance" in attrs:
        method += f", tolerance {number(attrs['taylor_tolerance'], 2)}"
    return f"{engine}, {method}"


def digits_text(attrs: dict[str, Any]) -> str:
    """Digits that a run carried, and those that are right at its end."""
    carried = f"{attrs['digits']} carried"
    if "digits_right" not in attrs:
        return carried
    return f"{carried}, {attrs['digits_right']} right at the end ({attrs['digits_right_from']})"


def motion_text(attrs: dict[str, Any]) -> str:
    """Counts of events; impacts passed on, ends of infinite sequences of impacts and rests, if any."""
    texts = [counted(attrs["impacts"], "impact")]
    if attrs.get("transmitted"):
        texts.append(f"{attrs['transmitted']} transmitted")
    texts += [counted(attrs[f"{word}s"], word) for word in ("chatter", "rest") if attrs.get(f"{word}s")]
    return ", ".join([*texts, counted(attrs["sticks"], "stick phase"), counted(attrs["events"], "event")])


def rest_distance_text(attrs: dict[str, Any], scene: Scene) -> str:
    """The rest distance that the run needs, and the one of the case."""
    needed = attrs.get("rest_distance_needed")
    text = "unknown: the samples are too far apart" if needed is None else f"needs {metres(needed)}"
    if not scene.clearances:
        return text
    text += f", has {metres(scene.clearances[0].distance)}"
    violations = attrs.get("violations", 0)
    if not violations:
        return text
    first = attrs["first_violation_time"]
    return text + style(f": {counted(violations, 'violation')}, first at {first:.3f} s", fg="yellow")


def print_lines(lines: Iterable[tuple[str, str]]) -> None:
    """Print labelled lines, the texts in one column."""
    for label, text in lines:
        padded = f"{label:{LABEL_WIDTH}}"
        say(f"  {style(padded if padded[-1] == ' ' else f'{padded}  ', dim=True)}{text}")


def print_columns(rows: Sequence[Sequence[str]], right: Collection[int] = (), indent: str = "  ") -> None:
    """Print rows of texts in columns as wide as they need be; right : columns with texts at the right."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        cells = (
            text.rjust(width) if i in right else text.ljust(width)
            for i, (text, width) in enumerate(zip(row, widths, strict=True))
        )
        say(f"{indent}{'  '.join(cells)}".rstrip())


def summary_object(result: Result, path: str | Path) -> dict[str, Any]:
    """The attributes of a trajectory for JSON: the case as an object, without its YAML text."""
    attrs = {name: plain(value) for name, value in result.attrs.items() if name not in NO_JSON}
    resolved = json.loads(attrs.pop("case_resolved_json"))
    if "lyapunov_exponents" in attrs:
        attrs |= plain(exponent_object(result))
    if "doubts_json" in attrs:
        attrs["doubts"] = json.loads(attrs.pop("doubts_json"))
    counts = counts_of(result)
    if counts:
        attrs["parts"] = counts
    return {"file": str(path), **attrs, "samples": len(result), "case": resolved}


# A scene made of parts in words: its bodies, its parts, what drives it.


MOST = 12  # bodies, parts or sources that are listed by name
KINDS = (("link", "links"), ("stop", "stops"), ("friction", "frictions"), ("clearance", "clearances"))

MASSES, FORCES = {"m": "kg", "rad": "kg m^2"}, {"m": "N", "rad": "N m"}  # by the unit of a displacement

Lines = Iterator[tuple[str, str]]


def scene_lines(scene: Scene, case: Case) -> Lines:
    """Label and text of what a scene is made of."""
    own = case.long_values()["bodies"] if scene.rotors else {}  # those of a scene hold the rotors on them
    masses = [float(own[body.name].value) if own else body.m for body in scene.line]
    bodies = zip(scene.line, masses, strict=True)
    texts = [f"{body.name} {number(m, 6)} {MASSES[scene.unit_of(body)]}" for body, m in bodies]
    yield "bodies", listed(texts)
    yield from _rotor_and_state_lines(scene)
    parts = [f"{word} {part.name}" for word, section in KINDS for part in getattr(scene, section)]
    if parts:
        yield "parts", listed(parts)
    none = "formulas of the time" if reads_time(scene) else "none"
    for i, text in enumerate(shortened(list(source_texts(scene)) or [none])):
        yield ("" if i else "source"), text
    for i, text in enumerate(shortened(formula_texts(case) if scene.has_formulas else [])):
        yield ("" if i else "formulas"), text


def _rotor_and_state_lines(scene: Scene) -> Lines:
    rotors = [f"{body.name} {number(body.m, 6)} kg m^2" for body in scene.bodies if body.kind == ROTOR]
    if rotors:
        yield "rotors", listed(rotors)
    units = dict(scene.state_units)
    states = [
        f"{body.name} {units.get(body.name, '')}".rstrip() for body in scene.bodies if body.kind == STATE
    ]
    if states:
        yield "states", listed(states)


def formula_texts(case: Case) -> list[str]:
    """The formulas of a case as it has them, each with its key, in the order of the case."""
    return [
        one_line(f"{key} = {value.text}")
        for key, value in case.values.items()
        if hasattr(value, "text") and not isinstance(value, Quantity)
    ]


def listed(texts: Sequence[str]) -> str:
    """Texts with commas between them, the first few of many."""
    return ", ".join(shortened(texts))


def shortened(texts: Sequence[str]) -> list[str]:
    """The first few of many texts, and how many more there are."""
    more = len(texts) - MOST
    return [*texts[:MOST], f"and {more} more"] if more > 1 else list(texts)


def source_texts(scene: Scene) -> Iterator[str]:
    """Each force on a body, torque on a rotor, the base and the motor, with its frequency in Hz and in rad/s;
    rates of states are none.
    """
    for force in scene.forces:
        on = scene.bodies[force.on]
        if on.kind == STATE:
            continue
        unit = FORCES[scene.unit_of(on)]
        constant = [f"{number(force.constant, 6)} {unit}"] if force.constant else []
        terms = [harmonic_text(term, f"{number(term.amplitude, 6)} {unit}") for term in force.terms]
        terms += ["a formula"] if force.formula is not None else []
        called = "torque" if on.kind == ROTOR and force.name == on.name else f"force {force.name}"
        yield f"{called} on {on.name}: {' + '.join([*terms, *constant]) or f'0 {unit}'}"
    if scene.base_formula is not None:
        yield "base: a formula"
    if scene.base:
        unit = scene.length_unit
        yield "base: " + " + ".join(harmonic_text(term, metres(term.amplitude, unit)) for term in scene.base)
    if scene.motor is not None:
        yield f"motor on {scene.end_name(scene.motor.on)}: {motor_text(scene.motor)}"


def harmonic_text(term: Harmonic, amplitude: str) -> str:
    """Amplitude, frequency and phase of one harmonic."""
    phase = f", {term.phase * 180 / pi:g} deg ahead" if term.phase else ""
    return f"{amplitude} at {term.cycles + term.cycles_lo:.7g} Hz ({term.omega:.6g} rad/s){phase}"


def motor_text(motor: Motor) -> str:
    """No-load speed and torque of a motor."""
    hertz = motor.Omega0 / (2 * pi)
    return f"no-load speed {hertz:.7g} Hz ({motor.Omega0:.6g} rad/s), torque {number(motor.M0, 6)} N m"


def count_lines(counts: Mapping[str, Mapping[str, int]]) -> Lines:
    """Counts of the events of each part, as lines from `part_counts`."""
    texts = [
        f"{name}: {', '.join(happened(number, word) for word, number in of_part.items())}"
        for name, of_part in counts.items()
        if of_part
    ]
    for i, text in enumerate(shortened(texts)):
        yield ("" if i else "by part"), text


def happened(number: int, word: str) -> str:
    """1 impact, 2 impacts; 2 transmitted."""
    return counted(number, word[:-1]) if word.endswith("s") else f"{number} {word}"


def clearance_lines(scene: Scene, attrs: Mapping[str, Any], counts: Mapping[str, Mapping[str, int]]) -> Lines:
    """Width that each clearance needs, and the one that it has, as lines."""
    needed = attrs.get("clearances_needed", [None] * len(scene.clearances))
    for i, (part, distance) in enumerate(zip(scene.clearances, needed, strict=True)):
        text, unit = "unknown: the samples are too far apart", scene.unit_between(part.P, part.Q)
        if distance is not None:
            text = f"needs {metres(distance, unit)}"
        text += f", has {metres(part.distance, unit)}"
        violations = counts[part.name].get("violations", 0)
        said = f": {counted(violations, 'violation')}" if violations else ""
        yield ("" if i else "clearances"), f"{part.name} {text}" + style(said, fg="yellow")


# The Lyapunov exponents that a run took along, for people (lines) and for programs (JSON).


def exponent_lines(result: Result) -> list[tuple[str, str]]:
    """Label and text: the exponents with their intervals, their span, and what speaks against them."""
    from vibsim.analysis.regime import stored_exponents

    lyapunov = stored_exponents(result)
    if lyapunov is None:
        return []
    pairs = zip(lyapunov.exponents.tolist(), lyapunov.half_widths.tolist(), strict=True)
    begin, end = lyapunov.span
    lines = [
        ("exponents", f"{', '.join(exponent_text(*pair) for pair in pairs)} 1/s"),
        ("", f"from {begin:.4g} to {end:.4g} s{checks(lyapunov, bool(result.case.scene().rigid_stops))}"),
    ]
    return lines + [("", style(warning, fg="yellow")) for warning in lyapunov.warnings]


def exponent_object(result: Result) -> dict[str, Any]:
    """Attributes of a run that hold its exponents, with their intervals and warnings."""
    from vibsim.analysis.regime import stored_exponents

    lyapunov = stored_exponents(result)
    if lyapunov is None:
        return {}
    return {"lyapunov_half_widths": lyapunov.half_widths, "lyapunov_warnings": list(lyapunov.warnings)}


def exponent_text(value: float, half_width: float) -> str:
    """1.27 +- 0.12; -inf where sticking took the direction, none where there is none."""
    if math.isnan(value):
        return "none"
    if math.isinf(value):
        return "-inf"
    text = number(value, 3)
    return text if math.isnan(half_width) else f"{text} +- {number(half_width, 2)}"


def checks(lyapunov: Lyapunov, rests: bool) -> str:
    """Rank losses, and how well volumes obey Liouville's identity."""
    parts = []
    if lyapunov.rank_losses:
        losses = counted(lyapunov.rank_losses, "rank loss")
        parts.append(f"{losses} by {'sticking, rest and impacts' if rests else 'sticking'}")
    if not math.isnan(lyapunov.volume_residual):
        parts.append(f"volume residual {number(lyapunov.volume_residual, 2)}")
    return "".join(f", {part}" for part in parts)


# Counts, lengths, durations and sizes as a summary writes them.


PREFIXES = ((1.0, "m"), (1e-3, "mm"), (1e-6, "um"), (1e-9, "nm"))
DURATIONS = ((1.0, "s"), (1e-3, "ms"), (1e-6, "us"), (1e-9, "ns"))
SIZES = ((1e9, "GB"), (1e6, "MB"), (1e3, "kB"))


def metres(x: float, unit: str = "m") -> str:
    """A length to four digits with the prefix that suits it, or an angle in rad; 0 has no sign."""
    if unit != "m":
        return f"{x + 0.0:.4g} {unit}"
    factor, unit = next(((f, u) for f, u in PREFIXES if abs(x) >= f), PREFIXES[-1]) if x else PREFIXES[0]
    return f"{x / factor + 0.0:.4g} {unit}"


def seconds(t: float) -> str:
    """A duration with the prefix that suits it: s, ms, us or ns, and below that s again."""
    factor, unit = next(((f, u) for f, u in DURATIONS if t >= f), (1.0, "s"))
    return f"{t / factor:g} {unit}"


def size(path: str | Path) -> str:
    """Size of a file with the prefix that suits it."""
    count = Path(path).stat().st_size
    factor, unit = next(((f, u) for f, u in SIZES if count >= 0.9995 * f), (1, "bytes"))
    return f"{count / factor:.3g} {unit}"


# What is said of files that the same command completes: sweeps, branches, fits, the paper's report.


def goes_on(path: str | Path) -> str:
    """Sentence on where an interrupted command has left what it did, and how that is completed."""
    return f"{path} holds what was done; the same command resumes it"


def completed_file(path: Path, count: int, had: int, took: float) -> str:
    """A file with its size, and how long its points took.

    count, had : of points that it holds, and that it held before; took : for the others [s]
    """
    text = f"{path} ({size(path)})"
    if had == count:
        return f"{text}, was complete: nothing to compute"
    return f"{text}, {took:.2f} s" + (f", {counted(had, 'point')} there before" if had else "")


# A Floquet multiplier in words.


def multiplier_text(mu: complex) -> str:
    """0.98837, or 0.88998 +- 0.42152i (magnitude 0.98475) for a pair."""
    real, imaginary, magnitude = (number(x, 8) for x in (mu.real, abs(mu.imag), abs(mu)))
    if mu.imag == 0:
        return real
    return f"{real} +- {imaginary}i (magnitude {magnitude})"
