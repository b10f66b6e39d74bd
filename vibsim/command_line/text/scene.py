"""A scene made of parts in words: its bodies, its parts, what drives it."""

from collections.abc import Iterator, Mapping, Sequence
from math import pi
from typing import Any

from vibsim.cases.number import number
from vibsim.command_line.terminal.printing import style
from vibsim.command_line.text.quantities import counted, metres
from vibsim.physics.parts import Harmonic, Motor, Scene

MOST = 12  # bodies, parts or sources that are listed by name
KINDS = (("link", "links"), ("stop", "stops"), ("friction", "frictions"), ("clearance", "clearances"))

Lines = Iterator[tuple[str, str]]


def scene_lines(scene: Scene) -> Lines:
    """Label and text of what a scene is made of."""
    yield "bodies", listed([f"{body.name} {number(body.m, 6)} kg" for body in scene.bodies])
    parts = [f"{word} {part.name}" for word, section in KINDS for part in getattr(scene, section)]
    if parts:
        yield "parts", listed(parts)
    for i, text in enumerate(shortened(list(source_texts(scene)) or ["none"])):
        yield ("" if i else "source"), text


def listed(texts: Sequence[str]) -> str:
    """Texts with commas between them, the first few of many."""
    return ", ".join(shortened(texts))


def shortened(texts: Sequence[str]) -> list[str]:
    """The first few of many texts, and how many more there are."""
    more = len(texts) - MOST
    return [*texts[:MOST], f"and {more} more"] if more > 1 else list(texts)


def source_texts(scene: Scene) -> Iterator[str]:
    """Each force, the base and the motor, with its frequency in Hz and in rad/s."""
    for force in scene.forces:
        constant = [f"{number(force.constant, 6)} N"] if force.constant or not force.terms else []
        terms = [harmonic_text(term, f"{number(term.amplitude, 6)} N") for term in force.terms]
        yield f"force {force.name} on {scene.end_name(force.on)}: {' + '.join([*terms, *constant])}"
    if scene.base:
        yield "base: " + " + ".join(harmonic_text(term, metres(term.amplitude)) for term in scene.base)
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
    """What happened to each part, as counted by `part_counts`."""
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
    """What each clearance needs, and what it has."""
    needed = attrs.get("clearances_needed", [None] * len(scene.clearances))
    for i, (part, distance) in enumerate(zip(scene.clearances, needed, strict=True)):
        text = "unknown: the samples are too far apart" if distance is None else f"needs {metres(distance)}"
        text += f", has {metres(part.distance)}"
        violations = counts[part.name].get("violations", 0)
        said = f": {counted(violations, 'violation')}" if violations else ""
        yield ("" if i else "clearances"), f"{part.name} {text}" + style(said, fg="yellow")
