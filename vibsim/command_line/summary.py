"""What a trajectory came to, for people (lines) and for programs (JSON)."""

import json
import math
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from vibsim.cases.plain_text import one_line
from vibsim.command_line.terminal import plain, say, style
from vibsim.physics.scene import Scene
from vibsim.results import Result

PREFIXES = ((1.0, "m"), (1e-3, "mm"), (1e-6, "um"), (1e-9, "nm"))
DURATIONS = ((1.0, "s"), (1e-3, "ms"), (1e-6, "us"), (1e-9, "ns"))
SIZES = ((1e9, "GB"), (1e6, "MB"), (1e3, "kB"))
LABEL_WIDTH = 16
NO_JSON = ("case_yaml", "lyapunov_growth")  # as long as a file of its own


def heading(name: str, title: str) -> str:
    """Name (bold) and title of a case."""
    title = one_line(title)
    return style(one_line(name), bold=True) + (f"  {title}" if title and title != name else "")


def case_lines(scene: Scene) -> list[tuple[str, str]]:
    """Label and text of what is run: source and span."""
    every = seconds(scene.every_num / scene.every_den)
    return [
        ("source", source_text(scene)),
        ("span", f"{seconds(scene.t_end)}, a sample every {every}: {counted(scene.sample_count, 'sample')}"),
    ]


def result_lines(result: Result, scene: Scene) -> list[tuple[str, str]]:
    """Label and text of everything that is known of a trajectory; what is not known has no line."""
    attrs = result.attrs
    lines = [*case_lines(scene), ("engine", engine_text(attrs))]
    if not result.complete:
        lines.append(("incomplete", style(f"samples end at {last_sample(result):g} s", fg="yellow")))
    elif result.t_reached < scene.t_end:
        lines.append(("stopped", style(f"at {result.t_reached:.6g} s, by the rest distance", fg="yellow")))
    if "events" in attrs:
        lines.append(("motion", motion_text(attrs)))
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
        from vibsim.command_line.exponent_text import exponent_lines

        lines += exponent_lines(result)
    if "rest_distance_needed" in attrs or scene.rest_distance is not None:
        lines.append(("rest distance", rest_distance_text(attrs, scene)))
    return lines


def certificate_text(attrs: Mapping[str, Any]) -> str:
    """Whether every event is proved, or how many stretches are in doubt and since when."""
    if attrs["certified"]:
        return "no event missed, none invented: every stretch proved"
    count, first = attrs["uncertified"], attrs["first_uncertified_time"]
    stretches = "1 stretch" if count == 1 else f"{count} stretches"
    return style(f"{stretches} in doubt, the first from {first:.6g} s on", fg="yellow")


def energy_text(attrs: Mapping[str, Any]) -> str:
    """Closure of the energy ledger, absolute and relative to its largest entry."""
    return f"{attrs['energy_residual']:.1e} J ({attrs['energy_residual_relative']:.1e} relative)"


def trust_text(result: Result) -> str:
    """To what and until when a trajectory is right; its estimated error where it is to the end."""
    attrs = result.attrs
    tolerance, horizon = f"right to {short(attrs['trust_tolerance_m'])} m", attrs["trust_horizon_s"]
    if horizon < result.t_reached:
        return f"{tolerance} until {horizon:.4g} s"
    return f"{tolerance} over the whole run; estimated error up to {short(attrs['error_estimate_max'])} m"


def short(x: float) -> str:
    """A number to two digits: 1e-6, 0.0025."""
    return f"{x:.2g}".replace("e-0", "e-")


def last_sample(result: Result) -> float:
    """Time of the last sample [s]; 0 without any."""
    return float(result.column("time")[-1]) if len(result) else 0.0


def source_text(scene: Scene) -> str:
    """The source of excitation, its frequency in Hz and in rad/s."""
    if scene.source == "harmonic":
        constant = f" + {scene.F0:g} N" if scene.F0 else ""
        frequency = f"{scene.cycles + scene.cycles_lo:.7g} Hz ({scene.omega:.6g} rad/s)"
        return f"harmonic force, {scene.A:.6g} N{constant} at {frequency}"
    if scene.source == "motor":
        hertz = scene.Omega0 / (2 * math.pi)
        return f"motor, no-load speed {hertz:.7g} Hz ({scene.Omega0:.6g} rad/s), torque {scene.M0:g} N m"
    return "none"


def engine_text(attrs: dict[str, Any]) -> str:
    """Engine and method; order and tolerance of the Taylor method."""
    engine = {"c": "C", "python": "Python"}.get(attrs["engine"], attrs["engine"])
    method = attrs["method"].replace("_", " ")
    if "number_type" in attrs:
        engine += f" on {attrs['number_type']} numbers"
    if "taylor_order" in attrs:
        method += f" series of order {attrs['taylor_order']}"
    if "taylor_tolerance" in attrs:
        method += f", tolerance {attrs['taylor_tolerance']:.2g}"
    return f"{engine}, {method}"


def digits_text(attrs: dict[str, Any]) -> str:
    """How many digits a run carried, and how many are right at its end."""
    carried = f"{attrs['digits']} carried"
    if "digits_right" not in attrs:
        return carried
    return f"{carried}, {attrs['digits_right']} right at the end ({attrs['digits_right_from']})"


def motion_text(attrs: dict[str, Any]) -> str:
    """How often what happened."""
    return ", ".join(counted(attrs[f"{word}s"], word) for word in ("impact", "stick", "event"))


def rest_distance_text(attrs: dict[str, Any], scene: Scene) -> str:
    """What the run needs, and what the case has."""
    needed = attrs.get("rest_distance_needed")
    text = "unknown: the samples are too far apart" if needed is None else f"needs {metres(needed)}"
    if scene.rest_distance is None:
        return text
    text += f", has {metres(scene.rest_distance)}"
    violations = attrs.get("violations", 0)
    if not violations:
        return text
    first = attrs["first_violation_time"]
    return text + style(f": {counted(violations, 'violation')}, first at {first:.3f} s", fg="yellow")


def print_lines(lines: Iterable[tuple[str, str]]) -> None:
    """Print labelled lines, the texts in one column."""
    for label, text in lines:
        shown = text.replace("\n", "\\n")  # of a user's; no text of vibsim's has line ends
        say(f"  {style(f'{label:{LABEL_WIDTH}}', dim=True)}{shown}")


def summary_object(result: Result, path: str | Path) -> dict[str, Any]:
    """The attributes of a trajectory for JSON: the case as an object, without its YAML text."""
    attrs = {name: plain(value) for name, value in result.attrs.items() if name not in NO_JSON}
    resolved = json.loads(attrs.pop("case_resolved_json"))
    if "lyapunov_exponents" in attrs:
        from vibsim.command_line.exponent_text import exponent_object

        attrs |= plain(exponent_object(result))
    return {"file": str(path), **attrs, "samples": len(result), "case": resolved}


def counted(number: int, word: str) -> str:
    """1 impact, 2 impacts."""
    return f"{number} {word}{'' if number == 1 else 's'}"


def metres(x: float) -> str:
    """A length to four digits with the prefix that suits it; 0 has no sign."""
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
