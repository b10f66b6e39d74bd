"""Claims on the motor: does it reach its speed, is it captured, at which frequency, and does it get away."""

from __future__ import annotations

from collections.abc import Callable

from vibsim.reports.claim import FAILS, HOLDS, OPEN, Claim, Finding, Numbers, only_if
from vibsim.reports.claims_of_motion import MOST
from vibsim.reports.parameter_search import NO_CONTACT
from vibsim.reports.wording import hz, mm, of_all, seconds

NEARLY = 0.02  # of Omega0
NATURAL_HZ = 4.1
NEAR_HZ = 0.1
ABOUT_100 = (67.0, 150.0)  # [s] a factor 1.5 to either side
JUMPED_HZ = (6.1, 6.3)
ABOUT_170 = (150.0, 190.0)  # [s]
FALLEN = 0.1  # of the peak, at the end
TWICE = 0.02  # relative

READING_B, READING_C = "II-B-captured", "II-C-escape"


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
            "The hold lasts to the end of the 300 s, well below the no-load speed; from rest, and from "
            "four of five perturbed starts.",
            b_captured,
        ),
        Claim(
            "II-C-escapes",
            "The motor of II-C is captured, gets away after about 100 s and jumps to 6.2 Hz.",
            "Fig. 16",
            "Captured, then escaped, the hold lasting 67 to 150 s; final speed 6.1 to 6.3 Hz; such a hold "
            "and escape from rest, and from four of five perturbed starts.",
            c_escapes,
        ),
        Claim(
            "capture-frequency",
            "The motors are captured at the natural frequency, 4.1 Hz.",
            "Figs. 15 and 16",
            "The mean speed during the hold of II-B and of II-C is within 0.1 Hz of 4.1 Hz.",
            capture_frequency,
        ),
        Claim(
            "II-C-displacement",
            "The displacement of II-C rises until about 170 s, then falls.",
            "Fig. 10",
            "x2, averaged over 5 s, is greatest between 150 and 190 s, and 10 % or more lower at 300 s.",
            c_displacement,
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
    printed, reading = (_is_captured(numbers, name) for name in ("II-B", READING_B))
    return Finding(
        only_if(printed, reading),
        tuple(_capture_line(numbers, name, "captured") for name in ("II-B", READING_B)),
        ("II-B", READING_B),
        condition=_reading(numbers, READING_B) + _alone(numbers) if reading and not printed else "",
    )


def c_escapes(numbers: Numbers) -> Finding:
    """II-C as printed, and in the reading."""
    printed, reading = (_escapes(numbers, name) for name in ("II-C", READING_C))
    return Finding(
        only_if(printed, reading),
        tuple(_capture_line(numbers, name, "escaped") for name in ("II-C", READING_C)),
        ("II-C", READING_C),
        condition=_reading(numbers, READING_C) if reading and not printed else "",
        remark=_jumped(numbers) + _in_trust(numbers["runs"][READING_C]),
    )


def capture_frequency(numbers: Numbers) -> Finding:
    """Speed during the holds, beside the relative vibration and half the bilinear frequency."""
    names = ("II-B", "II-C", READING_B, READING_C)
    speeds = {name: numbers["runs"][name]["capture"]["speed_hz"] for name in names}
    held = [name for name in names if speeds[name] is not None]
    printed, reading = (
        all(_near_natural(speeds[name]) for name in pair)
        for pair in (("II-B", "II-C"), (READING_B, READING_C))
    )
    lines = [_frequency_line(numbers, name) for name in held]
    return Finding(
        only_if(printed, reading) if held else OPEN,
        (*lines, *_without_stop(numbers)),
        names,
        condition=_reading(numbers, READING_B) if reading and not printed else "",
        remark=EXPLANATION if held and all(_is_twice(numbers, name) for name in held) else "",
    )


EXPLANATION = (
    "In each hold the blocks vibrate at twice the speed of the motor and strike twice in a turn. What "
    "holds the motor is a superharmonic resonance: the turning mass drives, at half its frequency, the "
    "large vibration against the stop, and that has the bilinear frequency. 4.1 Hz belongs to a system "
    "without a stop."
)


def c_displacement(numbers: Numbers) -> Finding:
    """Peak of x2 in II-C as printed and in the reading, from rest; and in the ensemble."""
    peaks = {name: numbers["runs"][name]["peak"] for name in ("II-C", READING_C)}
    printed, reading = (_rises_and_falls(peaks[name]) for name in ("II-C", READING_C))
    chance = reading and not _mostly(numbers, READING_C, _peaks_late)
    return Finding(
        only_if(printed, reading),
        (
            *(
                f"{name}: greatest, {mm(peak['height'])}, at {seconds(peak['time'])}; {mm(peak['end'])} at "
                "the end"
                for name, peak in peaks.items()
            ),
            f"perturbed starts of {READING_C}: so in {_count(numbers, READING_C, _peaks_late)}",
        ),
        ("II-C", READING_C),
        condition=_reading(numbers, READING_C) if reading and not printed else "",
        remark="From rest it is so; from most perturbed starts it turns earlier, later or not at all. What "
        "follows the escape is chaotic, and ends in one of several coexisting motions that drift "
        "differently."
        if chance
        else "",
    )


def _is_captured(numbers: Numbers, name: str) -> bool:
    captured = numbers["runs"][name]["capture"]["verdict"] == "captured"
    return captured and _mostly(numbers, name, lambda each: each.get("verdict") == "captured")


def _escapes(numbers: Numbers, name: str) -> bool:
    capture = numbers["runs"][name]["capture"]
    if not _is_brief_hold(capture):
        return False
    jumped = JUMPED_HZ[0] <= capture["final_speed_hz"] <= JUMPED_HZ[1]
    return jumped and _mostly(numbers, name, _is_brief_hold)


def _is_brief_hold(capture: Numbers) -> bool:
    """Captured for about 100 s, then escaped."""
    if capture.get("verdict") != "escaped":
        return False
    return ABOUT_100[0] <= capture["until"] - capture["since"] <= ABOUT_100[1]


def _rises_and_falls(peak: Numbers) -> bool:
    return ABOUT_170[0] <= peak["time"] <= ABOUT_170[1] and peak["end"] <= (1 - FALLEN) * peak["height"]


def _peaks_late(outcome: Numbers) -> bool:
    return "peak" in outcome and _rises_and_falls(outcome["peak"])


def _near_natural(speed: float | None) -> bool:
    return speed is not None and abs(speed - NATURAL_HZ) <= NEAR_HZ


def _how_many(numbers: Numbers, name: str, true: Callable[[Numbers], bool]) -> tuple[int, int]:
    """For how many members of an ensemble something is true, and of how many."""
    outcomes = numbers["ensembles"][name]["outcomes"]
    return sum(true(outcome) for outcome in outcomes), len(outcomes)


def _count(numbers: Numbers, name: str, true: Callable[[Numbers], bool]) -> str:
    return of_all(*_how_many(numbers, name, true))


def _mostly(numbers: Numbers, name: str, true: Callable[[Numbers], bool]) -> bool:
    count, total = _how_many(numbers, name, true)
    return count >= MOST * total


def _capture_line(numbers: Numbers, name: str, wanted: str) -> str:
    """Verdict, hold, how far the vibration has grown at its end, final speed, and the ensemble."""
    run = numbers["runs"][name]
    capture, held = run["capture"], ""
    if capture["since"] is not None:
        until = "the end" if capture["until"] is None else seconds(capture["until"])
        held = f", held at {hz(capture['speed_hz'])} from {seconds(capture['since'])} to {until}{_reach(run)}"
    count = _count(numbers, name, lambda each: each.get("verdict") == wanted)
    final = f"final speed {hz(capture['final_speed_hz'])}"
    return f"{name}: {capture['verdict']}{held}; {final}; perturbed starts: {wanted} in {count}"


def _reach(run: Numbers) -> str:
    reach = run["held"]["reach"]
    if reach["last"] is None or reach["before"] is None:
        return ""
    growth = 100 * (reach["last"] / reach["before"] - 1)
    return f", when x1 − x2 reaches {mm(reach['last'])} ({growth:+.1f} % in 50 s)"


def _jumped(numbers: Numbers) -> str:
    """What the perturbed starts of the reading end in."""
    finals = [
        each["final_hz"]
        for each in numbers["ensembles"][READING_C]["outcomes"]
        if each.get("verdict") == "escaped" and each["final_hz"] is not None
    ]
    jumped = sum(JUMPED_HZ[0] - NEAR_HZ <= final <= JUMPED_HZ[1] for final in finals)
    slow = sum(final < NATURAL_HZ for final in finals)
    rest = f"; in {slow} the rotor is thrown back and has not run up again at 300 s" if slow else ""
    return (
        f"Of {len(finals)} perturbed starts of {READING_C} that escape, {jumped} end at 6.0 to 6.3 Hz{rest}."
    )


def _in_trust(run: Numbers) -> str:
    """Whether an escape is among what the run is right about."""
    until, horizon = run["capture"]["until"], run["trust_horizon"]
    within = until is not None and horizon is not None and until <= horizon
    return " From rest, capture and escape lie within the trust horizon." if within else ""


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
        + ", ".join(
            f"{name} {row[name]['verdict']} at {hz(row[name]['speed_hz'])}" for name in ("II-B", "II-C")
        )
        for row in rows
    ]


def _reading(numbers: Numbers, name: str) -> str:
    """The numbers that a reading changes, in words."""
    changes = numbers["runs"][name]["changes"]
    return " and ".join(f"{key} is {now} (printed: {printed})" for key, (now, printed) in changes.items())


def _alone(numbers: Numbers) -> str:
    """Which single parameters capture II-B for good, near a resonance."""
    found: dict[str, list[float]] = {}
    for row in numbers["search"]["alone"]:
        (key, value), outcome = next(iter(row["at"].items())), row["II-B"]
        if outcome.get("verdict") == "captured" and outcome["speed_hz"] < 4.5:
            found.setdefault(key.split(".")[-1], []).append(value)
    words = [
        f"{key} = {' to '.join(dict.fromkeys((f'{min(values):g}', f'{max(values):g}')))}"
        for key, values in found.items()
    ]
    return "; or, of single values tried (SI): " + ", ".join(words) if words else ""
