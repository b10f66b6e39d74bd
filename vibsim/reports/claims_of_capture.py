"""Claims on the motor: does it reach its speed, is it captured for good, and at which frequency."""

from __future__ import annotations

from vibsim.reports.claim import FAILS, HOLDS, OPEN, Claim, Finding, Numbers, only_if
from vibsim.reports.evidence import capture_line, in_reading, mostly
from vibsim.reports.parameter_search import NO_CONTACT
from vibsim.reports.wording import hz

NEARLY = 0.02  # of Omega0
NATURAL_HZ = 4.1
NEAR_HZ = 0.1
RESONANT_HZ = 4.5  # a hold below this is one near half the bilinear frequency
TWICE = 0.02  # relative

PRINTED, READINGS = ("II-B", "II-C"), ("II-B-captured", "II-C-escape")

EXPLANATION = (
    "In each hold the blocks vibrate at twice the speed of the motor and strike twice in a turn. What "
    "holds the motor is a superharmonic resonance: the turning mass drives, at half its frequency, the "
    "large vibration against the stop, and that has the bilinear frequency. 4.1 Hz belongs to a system "
    "without a stop."
)


def capture_claims() -> list[Claim]:
    """In the order of the paper."""
    return [
        Claim(
            "II-A-speed",
            "II-A reaches nearly its no-load speed of 3.5 Hz.",
            "Fig. 14",
            "The mean speed over the last turns is within 2 % of 3.5 Hz.",
            speed_of_a,
        ),
        Claim(
            "II-B-captured",
            "The motor of II-B is captured for good.",
            "Fig. 15",
            "The hold lasts to the end of the 300 s, well below the no-load speed: from rest, and from "
            "four of five perturbed starts.",
            b_captured,
        ),
        Claim(
            "capture-frequency",
            "The motors are captured at the natural frequency, 4.1 Hz.",
            "Figs. 15 and 16",
            "The mean speed during the hold of II-B and of II-C is within 0.1 Hz of 4.1 Hz.",
            capture_frequency,
        ),
    ]


def speed_of_a(numbers: Numbers) -> Finding:
    """Final speed of II-A."""
    capture = numbers["runs"]["II-A"]["capture"]
    share = capture["final_speed_hz"] / capture["no_load_speed_hz"]
    line = f"{hz(capture['final_speed_hz'])}, {100 * share:.1f} % of the no-load speed"
    return Finding(HOLDS if abs(share - 1) <= NEARLY else FAILS, (line,), ("II-A",))


def b_captured(numbers: Numbers) -> Finding:
    """II-B as printed, and in the reading."""
    names = (PRINTED[0], READINGS[0])
    printed, reading = (_is_captured(numbers, name) for name in names)
    return Finding(
        only_if(printed, reading),
        tuple(capture_line(numbers, name, "captured") for name in names),
        names,
        condition=in_reading(numbers, READINGS[0]) + _alone(numbers) if reading and not printed else "",
    )


def _is_captured(numbers: Numbers, name: str) -> bool:
    captured = numbers["runs"][name]["capture"]["verdict"] == "captured"
    return captured and mostly(numbers, name, lambda outcome: outcome.get("verdict") == "captured")


def _alone(numbers: Numbers) -> str:
    """Which single parameters capture II-B for good, near a resonance."""
    found: dict[str, list[float]] = {}
    for row in numbers["search"]["alone"]:
        (key, value), outcome = next(iter(row["at"].items())), row["II-B"]
        if outcome.get("verdict") == "captured" and outcome["speed_hz"] < RESONANT_HZ:
            found.setdefault(key.split(".")[-1], []).append(value)
    words = [
        f"{key} = {' to '.join(dict.fromkeys((f'{min(values):g}', f'{max(values):g}')))}"
        for key, values in found.items()
    ]
    return "; or, of single values tried (SI): " + ", ".join(words) if words else ""


def capture_frequency(numbers: Numbers) -> Finding:
    """Speed during the holds, beside the relative vibration and half the bilinear frequency."""
    names = (*PRINTED, *READINGS)
    speeds = {name: numbers["runs"][name]["capture"]["speed_hz"] for name in names}
    held = [name for name in names if speeds[name] is not None]
    printed, reading = (all(_near_natural(speeds[name]) for name in pair) for pair in (PRINTED, READINGS))
    lines = [_frequency_line(numbers, name) for name in held]
    return Finding(
        only_if(printed, reading) if held else OPEN,
        (*lines, *_without_stop(numbers)),
        names,
        condition=in_reading(numbers, READINGS[0]) if reading and not printed else "",
        remark=EXPLANATION if held and all(_is_twice(numbers, name) for name in held) else "",
    )


def _near_natural(speed: float | None) -> bool:
    return speed is not None and abs(speed - NATURAL_HZ) <= NEAR_HZ


def _frequency_line(numbers: Numbers, name: str) -> str:
    run, ratio = numbers["runs"][name], _ratio(numbers, name)
    near = run["capture"]["resonance"]
    resonance = f", {near['name']} {hz(near['hz'])}" if near else ""
    speed = f"{name}: held at {hz(run['capture']['speed_hz'])}{resonance}"
    if ratio is None:
        return speed
    vibration = hz(run["held"]["lines"][0]["hz"])
    return f"{speed}; strongest line of x1 − x2 {vibration}, {ratio:.3f} times the speed"


def _ratio(numbers: Numbers, name: str) -> float | None:
    """Strongest line of x1 - x2 during the hold, over the speed of the motor."""
    run = numbers["runs"][name]
    lines = run.get("held", {}).get("lines") or []
    return lines[0]["hz"] / run["capture"]["speed_hz"] if lines else None


def _is_twice(numbers: Numbers, name: str) -> bool:
    ratio = _ratio(numbers, name)
    return ratio is not None and abs(ratio / 2 - 1) <= TWICE


def _without_stop(numbers: Numbers) -> list[str]:
    """At which speed the motors are captured where the blocks never touch."""
    rows = [row for row in numbers["search"]["alone"] if row["at"].get("stop.G") == NO_CONTACT]
    return [
        "without the stop: "
        + ", ".join(f"{name} {row[name]['verdict']} at {hz(row[name]['speed_hz'])}" for name in PRINTED)
        for row in rows
    ]
