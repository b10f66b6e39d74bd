"""Claims on II-C: captured for a while, then away, and what block 2 does meanwhile.

What follows the escape is chaotic. So the escape is judged by the run from rest and by the ensemble, and what
comes after it by the ensemble alone: a single run, the paper's or one here, shows one of many ends.
"""

from __future__ import annotations

from statistics import median

from vibsim.reports.claim import FAILS, HOLDS, ONLY_IF, Claim, Finding, Numbers, only_if
from vibsim.reports.evidence import at_times, capture_line, count_of, in_reading, mostly
from vibsim.reports.wording import hz, mm, seconds

ABOUT_100 = (67.0, 150.0)  # [s] a factor 1.5 to either side
JUMPED_HZ = (6.0, 6.4)  # 6.2 to either side
THROWN_BACK_HZ = 4.1  # a final speed below the resonance
ABOUT_170 = (150.0, 190.0)  # [s]
FALLEN = 0.1  # of the peak, at the end

PRINTED_C, READING_C = "II-C", "II-C-escape"


def escape_claims() -> list[Claim]:
    """In the order of the paper."""
    return [
        Claim(
            "II-C-escapes",
            "The motor of II-C is captured, gets away after about 100 s and jumps to 6.2 Hz.",
            "Fig. 16",
            "Captured, then escaped, the hold lasting 67 to 150 s: from rest, and from four of five "
            "perturbed starts; median of their final speeds 6.0 to 6.4 Hz.",
            c_escapes,
        ),
        Claim(
            "II-C-displacement",
            "The displacement of II-C rises until about 170 s, then falls.",
            "Fig. 10",
            "x2, averaged over 5 s, is greatest between 150 and 190 s, and 10 % or more lower at 300 s, from "
            "four of five perturbed starts (beyond the trust horizon a single run proves nothing).",
            c_displacement,
        ),
    ]


def c_escapes(numbers: Numbers) -> Finding:
    """II-C as printed, and in the reading."""
    printed, reading = (_escapes(numbers, name) for name in (PRINTED_C, READING_C))
    return Finding(
        only_if(printed, reading),
        tuple(capture_line(numbers, name, "escaped") for name in (PRINTED_C, READING_C)),
        (PRINTED_C, READING_C),
        condition=in_reading(numbers, READING_C) if reading and not printed else "",
        remark=_jumped(numbers) + _in_trust(numbers["runs"][READING_C]),
    )


def _escapes(numbers: Numbers, name: str) -> bool:
    finals = _final_speeds(numbers, name)
    from_rest = is_brief_hold(numbers["runs"][name]["capture"])
    if not from_rest or not mostly(numbers, name, is_brief_hold) or not finals:
        return False
    return JUMPED_HZ[0] <= median(finals) <= JUMPED_HZ[1]


def is_brief_hold(capture: Numbers) -> bool:
    """Captured for about 100 s, then escaped."""
    if capture.get("verdict") != "escaped":
        return False
    return ABOUT_100[0] <= capture["until"] - capture["since"] <= ABOUT_100[1]


def _final_speeds(numbers: Numbers, name: str) -> list[float]:
    """Final speeds of the perturbed starts that escape [Hz]."""
    outcomes = numbers["ensembles"][name]["outcomes"]
    finals = [outcome["final_hz"] for outcome in outcomes if outcome.get("verdict") == "escaped"]
    return [final for final in finals if final is not None]


def _jumped(numbers: Numbers) -> str:
    """What the perturbed starts of the reading end in."""
    finals = _final_speeds(numbers, READING_C)
    if not finals:
        return ""
    slow = sum(final < THROWN_BACK_HZ for final in finals)
    rest = f"; in {slow} the rotor is thrown back and has not run up again at 300 s" if slow else ""
    return f"{len(finals)} perturbed starts escape: median of their final speeds {hz(median(finals))}{rest}."


def _in_trust(run: Numbers) -> str:
    """Whether an escape is among what the run is right about."""
    until, horizon = run["capture"]["until"], run["trust_horizon"]
    within = until is not None and horizon is not None and until <= horizon
    return " From rest, capture and escape lie within the trust horizon." if within else ""


def c_displacement(numbers: Numbers) -> Finding:
    """Peak of x2 in II-C as printed and in the reading."""
    names = (PRINTED_C, READING_C)
    always = mostly(numbers, PRINTED_C, peaks_late)
    possible = any(at_times(numbers, name, peaks_late) for name in names)
    counts = " and ".join(f"{name} in {count_of(numbers, name, peaks_late)}" for name in names)
    return Finding(
        HOLDS if always else ONLY_IF if possible else FAILS,
        tuple(_peak_line(numbers, name) for name in names),
        names,
        condition="" if always or not possible else f"chance is kind: of perturbed starts {counts} do so",
        remark=CHANCE if possible and not always else "",
    )


CHANCE = (
    "The motion is chaotic by then, and ends in one of several coexisting motions: some drift back, some on."
)


def peaks_late(outcome: Numbers) -> bool:
    """Whether x2 is greatest at about 170 s, and lower at the end."""
    if "peak" not in outcome:
        return False
    peak = outcome["peak"]
    return ABOUT_170[0] <= peak["time"] <= ABOUT_170[1] and peak["end"] <= (1 - FALLEN) * peak["height"]


def _peak_line(numbers: Numbers, name: str) -> str:
    peak = numbers["runs"][name]["peak"]
    top = f"{name} from rest: greatest, {mm(peak['height'])}, at {seconds(peak['time'])}"
    return f"{top}; {mm(peak['end'])} at the end"
