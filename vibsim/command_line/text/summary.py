"""What a trajectory came to, for people (lines) and for programs (JSON)."""

import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vibsim.cases.number import number
from vibsim.cases.plain_text import one_line
from vibsim.command_line.terminal.printing import say, style
from vibsim.command_line.text.quantities import counted, metres, seconds
from vibsim.command_line.text.scene import clearance_lines, count_lines, motor_text, scene_lines
from vibsim.files.plain_data import plain
from vibsim.physics.parts import Scene
from vibsim.results import Result
from vibsim.results.telling import unknown_text

if TYPE_CHECKING:
    from vibsim.cases import Case

LABEL_WIDTH = 16
METHODS = {"closed_form": "closed form", "auto": "closed form or Taylor"}  # as one reads them
NO_JSON = ("case_yaml", "lyapunov_growth")  # as long as a file of its own


def heading(name: str, title: str) -> str:
    """Name (bold) and title of a case."""
    title = one_line(title)
    return style(one_line(name), bold=True) + (f"  {title}" if title and title != name else "")


def case_lines(case: "Case") -> list[tuple[str, str]]:
    """Label and text of what is run: bodies and parts of the long form, source and span."""
    scene = case.scene()
    every = seconds(scene.every_num / scene.every_den)
    return [
        *(scene_lines(scene) if case.is_long else [("source", source_text(scene))]),
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
    if "grazing_margin" in attrs:
        lines.append(
            ("grazing margin", f"{metres(attrs['grazing_margin'])} at {attrs['grazing_time']:.3f} s")
        )
    if "energy_residual" in attrs:
        lines.append(("energy residual", energy_text(attrs)))
    if "lyapunov_growth" in attrs:
        from vibsim.command_line.text.exponents import exponent_lines

        lines += exponent_lines(result)
    if case.is_long:
        lines += clearance_lines(scene, attrs, counts)
    elif "rest_distance_needed" in attrs or scene.clearances:
        lines.append(("rest distance", rest_distance_text(attrs, scene)))
    return lines


def counts_of(result: Result) -> dict[str, dict[str, int]]:
    """How often what happened to each part; nothing of the short form, which has one of each."""
    if not result.case.is_long:
        return {}
    from vibsim.results.motion.part_counts import part_counts

    return part_counts(result, result.case.scene())


def orbit_text(attrs: Mapping[str, Any], scene: Scene) -> str:
    """What is known of the periodic orbit that a file holds."""
    periods = counted(attrs["orbit_periods"], "turn" if scene.has_motor else "period")
    stable = "stable" if attrs["orbit_stable"] else "unstable"
    return f"{periods}, {attrs['orbit_period_s']:.10g} s, {stable}, events {attrs['orbit_events'] or 'none'}"


def certificate_text(attrs: Mapping[str, Any]) -> str:
    """Whether every event is proved, or how many stretches are in doubt and since when."""
    if attrs["certified"]:
        return "no event missed, none invented: every stretch proved"
    count, first = attrs["uncertified"], attrs["first_uncertified_time"]
    stretches = "1 stretch" if count == 1 else f"{count} stretches"
    return style(f"{stretches} in doubt, the first from {first:.6g} s on", fg="yellow")


def energy_text(attrs: Mapping[str, Any]) -> str:
    """Closure of the energy ledger, absolute and relative to its largest entry."""
    absolute, relative = (number(attrs[f"energy_residual{of}"], 2) for of in ("", "_relative"))
    return f"{absolute} J ({relative} relative)"


def trust_text(result: Result) -> str:
    """To what and until when a trajectory is right; its estimated error where it is to the end."""
    attrs = result.attrs
    tolerance, horizon = f"right to {number(attrs['trust_tolerance_m'], 2)} m", attrs["trust_horizon_s"]
    if horizon < result.t_reached:
        return f"{tolerance} until {horizon:.4g} s{unknown_text(attrs)}"
    error = number(attrs["error_estimate_max"], 2)
    return f"{tolerance} over the whole run; estimated error up to {error} m"


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
    """How many digits a run carried, and how many are right at its end."""
    carried = f"{attrs['digits']} carried"
    if "digits_right" not in attrs:
        return carried
    return f"{carried}, {attrs['digits_right']} right at the end ({attrs['digits_right_from']})"


def motion_text(attrs: dict[str, Any]) -> str:
    """How often what happened; blows passed on, ends of infinite sequences of impacts and rests, if any."""
    texts = [counted(attrs["impacts"], "impact")]
    if attrs.get("transmitted"):
        texts.append(f"{attrs['transmitted']} transmitted")
    texts += [counted(attrs[f"{word}s"], word) for word in ("chatter", "rest") if attrs.get(f"{word}s")]
    return ", ".join([*texts, *(counted(attrs[f"{word}s"], word) for word in ("stick", "event"))])


def rest_distance_text(attrs: dict[str, Any], scene: Scene) -> str:
    """What the run needs, and what the case has."""
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
        say(f"  {style(f'{label:{LABEL_WIDTH}}', dim=True)}{text}")


def summary_object(result: Result, path: str | Path) -> dict[str, Any]:
    """The attributes of a trajectory for JSON: the case as an object, without its YAML text."""
    attrs = {name: plain(value) for name, value in result.attrs.items() if name not in NO_JSON}
    resolved = json.loads(attrs.pop("case_resolved_json"))
    if "lyapunov_exponents" in attrs:
        from vibsim.command_line.text.exponents import exponent_object

        attrs |= plain(exponent_object(result))
    counts = counts_of(result)
    if counts:
        attrs["parts"] = counts
    return {"file": str(path), **attrs, "samples": len(result), "case": resolved}
