"""Claims on the motor: does it reach its speed, is it captured for good, and at which frequency."""

from __future__ import annotations

from itertools import pairwise

from vibsim.evidence.reports.claims.claim import (
    FAILS,
    HOLDS,
    OPEN,
    OUR_MARGIN,
    OURS,
    Claim,
    Finding,
    Numbers,
    only_if,
)
from vibsim.evidence.reports.claims.evidence import capture_line, count_of, in_reading, mostly
from vibsim.evidence.reports.measured.paper_runs import MOTORS
from vibsim.evidence.reports.quotes import said
from vibsim.evidence.reports.wording import hz, words_of

NEARLY = 0.02  # of Omega0
NATURAL_HZ = 4.1
NEAR_HZ = 0.1
RESONANT_HZ = 4.5  # a hold below this is one near half the bilinear frequency
TWICE = 0.02  # relative
DISTINCT = 0.03  # relative difference of two operating points

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
            "equilibria",
            "The motor reaches equilibrium, at another speed for each characteristic.",
            said("equilibrium"),
            "Each of II-A, II-B and II-C settles: the mean speed over 12 turns stays within 3 % up to the "
            "end, from four of five perturbed starts; their speeds differ by more than 3 %.",
            OURS,
            equilibria,
            figures=("fig-04",),
        ),
        Claim(
            "II-A-speed",
            "II-A reaches nearly its no-load speed of 3.5 Hz.",
            said("steady state"),
            "The mean speed over the last turns is within 2 % of 3.5 Hz.",
            OURS,
            speed_of_a,
            figures=("fig-14",),
        ),
        Claim(
            "sommerfeld",
            "II-B and II-C show the Sommerfeld effect.",
            said("Sommerfeld"),
            "The weakest form of it: each motor lingers well below its no-load speed, at least 3 times as "
            "long as it "
            "would take to run up freely through ±3 %, from rest and from four of five perturbed starts.",
            OURS,
            sommerfeld,
            figures=("fig-15", "fig-16"),
        ),
        Claim(
            "II-B-captured",
            "The motor of II-B is captured for good.",
            said("cannot escape", "cannot exceed"),
            "The hold lasts to the end of the run, well below the no-load speed: from rest, and from "
            "four of five perturbed starts.",
            OURS,
            b_captured,
            figures=("fig-15", "fig-15-reading"),
            pictures=("capture",),
        ),
        Claim(
            "capture-frequency",
            "The motors are captured at 4.1 Hz.",
            said("cannot escape", "initially captured"),
            "The mean speed during the hold of II-B and of II-C is within 0.1 Hz of 4.1 Hz.",
            OUR_MARGIN,
            capture_frequency,
            figures=("fig-15", "fig-16"),
            pictures=("capture",),
        ),
    ]


def equilibria(numbers: Numbers) -> Finding:
    """Final speeds of Case II."""
    finals = [numbers["runs"][name]["capture"]["final_speed_hz"] for name in MOTORS]
    lines = tuple(
        f"{name}: {hz(final)}; perturbed starts: settled in {count_of(numbers, name, is_settled)}"
        for name, final in zip(MOTORS, finals, strict=True)
    )
    distinct = all(above > below * (1 + DISTINCT) for below, above in pairwise(finals))
    settled = all(mostly(numbers, name, is_settled) for name in MOTORS)
    return Finding(HOLDS if distinct and settled else FAILS, lines, MOTORS)


def is_settled(outcome: Numbers) -> bool:
    """Whether the mean speed stays within the band up to the end."""
    return outcome.get("verdict") not in (None, "undecided")


def sommerfeld(numbers: Numbers) -> Finding:
    """Holds of any strength in II-B and II-C, and in the readings."""
    printed, reading = (all(_lingers(numbers, name) for name in pair) for pair in (PRINTED, READINGS))
    names = (*PRINTED, *READINGS)
    lines = tuple(
        f"{name}: {_lingering(numbers, name)}; perturbed starts: lingers in "
        f"{count_of(numbers, name, is_held)}"
        for name in names
    )
    changed = in_reading(numbers, READINGS[0]) if reading and not printed else ""
    shows = [name for name in PRINTED if _lingers(numbers, name)]
    remark = f"As printed {words_of(shows)} does so." if changed and shows else ""
    return Finding(only_if(printed, reading), lines, names, condition=changed, remark=remark)


def is_held(outcome: Numbers) -> bool:
    """Whether the motor lingers below its no-load speed for a while."""
    return outcome.get("since") is not None


def _lingers(numbers: Numbers, name: str) -> bool:
    return is_held(numbers["runs"][name]["capture"]) and mostly(numbers, name, is_held)


def _lingering(numbers: Numbers, name: str) -> str:
    capture = numbers["runs"][name]["capture"]
    return f"from rest {capture['verdict']}, {'' if is_held(capture) else 'not '}held on the way"


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
        tuple(
            f"{capture_line(numbers, name)}; perturbed starts: captured in "
            f"{count_of(numbers, name, is_captured)}"
            for name in names
        ),
        names,
        condition=in_reading(numbers, READINGS[0]) if reading and not printed else "",
    )


def _is_captured(numbers: Numbers, name: str) -> bool:
    return is_captured(numbers["runs"][name]["capture"]) and mostly(numbers, name, is_captured)


def is_captured(outcome: Numbers) -> bool:
    """Whether the motor is held up to the end."""
    return outcome.get("verdict") == "captured"


def capture_frequency(numbers: Numbers) -> Finding:
    """Speed during the holds, beside the relative vibration and half the bilinear frequency."""
    names = (*PRINTED, *READINGS)
    speeds = {name: numbers["runs"][name]["capture"]["speed_hz"] for name in names}
    held = [name for name in names if speeds[name] is not None]
    printed, reading = (all(_near_natural(speeds[name]) for name in pair) for pair in (PRINTED, READINGS))
    lines = [_frequency_line(numbers, name) for name in held]
    return Finding(
        only_if(printed, reading) if held else OPEN,
        (*lines, _without_stop(numbers)),
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


def _without_stop(numbers: Numbers) -> str:
    """What becomes of the motors where the blocks never touch."""
    captures = {name: numbers["without_stop"][name]["capture"] for name in PRINTED}
    return "without the stop: " + ", ".join(
        f"{name} {capture['verdict']} at {hz(capture['speed_hz'])}" for name, capture in captures.items()
    )
