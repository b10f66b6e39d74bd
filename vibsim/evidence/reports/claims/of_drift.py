"""Claims on the rate of displacement: how fast block 2 gets away, and why.

Two measures are told everywhere: the overall rate, displacement at the end over the whole time, which is what
the paper's figures show, and the drift rate of the second half, which leaves the transient out.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from vibsim.evidence.reports.claims.claim import (
    OURS,
    PAPERS,
    Claim,
    Finding,
    Numbers,
    holds,
    only_if,
    with_numbers,
)
from vibsim.evidence.reports.claims.evidence import (
    MOST,
    in_reading,
    magnitudes,
    middle,
    rest_value,
    share_above,
)
from vibsim.evidence.reports.measured.measurements import drifts
from vibsim.evidence.reports.measured.paper_runs import EQUAL_FORCE, HERTZ, MOTORS, PRINTED, READINGS
from vibsim.evidence.reports.quotes import said
from vibsim.evidence.reports.wording import drift_rate, mm, mm_per_s, percent, words_of

MEASURES = {"overall": "overall rate", "drift": "second half"}
WHENCE = ("from rest", "medians of the starts")
MUCH = 5.0  # factor by which impacts must raise the overall displacement to be its cause


def drift_claims() -> list[Claim]:
    """In the order of the paper."""
    return [
        Claim(
            "drift-grows",
            "With the ideal source the overall displacement rate grows with frequency.",
            said("overall rate"),
            "|x2| at the end of the run grows from 3.5 to 5.5 to 6.5 Hz; from starts the median does. (The "
            "drift rate of the second half, a measure of ours, is given beside it.)",
            PAPERS,
            drift_grows,
            figures=("fig-05", "fig-06", "fig-07"),
            pictures=("drift",),
        ),
        Claim(
            "impacts-cause",
            "Impacts can be the cause of that displacement.",
            said("cause"),
            "With the stop out of reach the overall displacement of I-A, I-B and I-C is at most a fifth of "
            "what it is with it (from starts: by the medians), and there is no drift in the second half.",
            OURS,
            impacts_cause,
        ),
        Claim(
            "rates-higher",
            "The displacement rate is higher with the non-ideal source, at each frequency.",
            said("rates higher"),
            "At each frequency II is faster than I in the overall rate or in the drift rate of the second "
            "half: from rest, and in four of five pairs of perturbed starts.",
            OURS,
            rates_higher,
            figures=("fig-08", "fig-09", "fig-10"),
            pictures=("drift",),
        ),
        Claim(
            "motor-drift-grows",
            "With the motor, too, the rate tends to grow with frequency.",
            said("rate tends"),
            "The overall rate and the drift rate in the second half grow from II-A to II-B to II-C: from "
            "rest, and by the medians over the perturbed starts.",
            OURS,
            motor_drift_grows,
            figures=("fig-08", "fig-09", "fig-10"),
            pictures=("drift",),
        ),
        Claim(
            "drift-B-above-C",
            "II-B has a higher displacement rate than II-C.",
            said("higher at 5.5"),
            "II-B is faster in the overall rate or in the drift rate of the second half: from rest, and in "
            "four of five pairs of perturbed starts.",
            OURS,
            drift_b_above_c,
            figures=("fig-09", "fig-10"),
            pictures=("drift",),
        ),
    ]


def drift_grows(numbers: Numbers) -> Finding:
    """By the overall rate; and by the drift rate of the second half, as printed and with equal forces."""
    runs = numbers["runs"]
    printed, equal = (_ends_grow(numbers, names) for names in (PRINTED, EQUAL_FORCE))
    late = {names: _grows(numbers, names) for names in (PRINTED, EQUAL_FORCE)}
    lines = [_ends(numbers, names) for names in (PRINTED, EQUAL_FORCE)]
    lines += [f"second half: {_rates(numbers, names)}" for names in (PRINTED, EQUAL_FORCE)]
    ways = [runs[name]["drift"]["verdict"] for name in PRINTED]
    directions = ", ".join(f"{name} {way}" for name, way in zip(PRINTED, ways, strict=True))
    remark = f"Not all drift the same way: {directions}." if len(set(ways)) > 1 else ""
    if equal and not late[EQUAL_FORCE]:
        remark += (
            " With equal forces the displacement is that of the start, a force A sin(ωt) that sets in at "
            "full size on blocks at rest; in the second half no growth can be told from nothing."
        )
    lines.append(f"medians of the starts: {_medians(numbers, PRINTED)}; {_medians(numbers, EQUAL_FORCE)}")
    laws = ("the amplitudes are those of Table 1", "they follow Eq. (2.11)")
    over = [_medians_grow(numbers, names) for names in (PRINTED, EQUAL_FORCE)]
    return Finding(
        (
            only_if(dict(zip(laws, (printed, equal), strict=True))),
            only_if(dict(zip(laws, over, strict=True))),
        ),
        tuple(lines),
        (*PRINTED, *EQUAL_FORCE),
        remark=remark.strip(),
    )


def _medians_grow(numbers: Numbers, names: Sequence[str], key: str = "overall") -> bool:
    medians = [middle(numbers, name, key) for name in names]
    return all(below < above for below, above in pairwise(medians))


def _medians(numbers: Numbers, names: Sequence[str]) -> str:
    """Median displacement at the end."""
    spans = [numbers["runs"][name]["t_end"] for name in names]
    ends = [middle(numbers, name, "overall") * span for name, span in zip(names, spans, strict=True)]
    return ", ".join(f"{name} {mm(end)}" for name, end in zip(names, ends, strict=True))


def _ends_grow(numbers: Numbers, names: Sequence[str]) -> bool:
    ends = [abs(numbers["runs"][name]["overall"]) for name in names]
    return all(below < above for below, above in pairwise(ends))


def _ends(numbers: Numbers, names: Sequence[str]) -> str:
    runs = numbers["runs"]
    each = (f"{name} {mm(abs(runs[name]['overall'] * runs[name]['t_end']))}" for name in names)
    return f"|x2| at the end: {', '.join(each)}"


def _grows(numbers: Numbers, names: Sequence[str]) -> bool:
    """Whether the drift rate of the second half grows by more than its uncertainty."""
    drifts = [numbers["runs"][name]["drift"] for name in names]
    if any(drift["rate"] is None for drift in drifts):
        return False
    return all(
        abs(above["rate"]) - above["half_width"] > abs(below["rate"]) + below["half_width"]
        for below, above in pairwise(drifts)
    )


def _rates(numbers: Numbers, names: Sequence[str]) -> str:
    return ", ".join(f"{name} {drift_rate(numbers['runs'][name]['drift'])}" for name in names)


def impacts_cause(numbers: Numbers) -> Finding:
    """Displacement with and without the stop."""
    runs, without = numbers["runs"], numbers["without_stop"]
    less = all(abs(runs[name]["overall"]) >= MUCH * abs(without[name]["overall"]) for name in PRINTED)
    still = not any(drifts(without[name]["drift"]) for name in PRINTED)
    lines = [
        f"{name}: |x2| at the end {mm(abs(runs[name]['overall']) * runs[name]['t_end'])}, without the stop "
        f"{mm(abs(without[name]['overall']) * runs[name]['t_end'])} (drift in the second half: "
        f"{drift_rate(without[name]['drift'])})"
        for name in (*PRINTED, *EQUAL_FORCE, *MOTORS)
    ]
    lines += [
        f"{name}, medians of the starts: {mm(middle(numbers, name, 'overall') * runs[name]['t_end'])}, "
        f"without the stop {mm(without[name]['starts_overall'] * runs[name]['t_end'])}"
        for name in PRINTED
    ]
    less_from_starts = all(
        middle(numbers, name, "overall") >= MUCH * without[name]["starts_overall"] for name in PRINTED
    )
    still_from_starts = not any(without[name]["starts_drifting"] for name in PRINTED)
    equal = [name for name in EQUAL_FORCE if abs(without[name]["overall"]) > abs(runs[name]["overall"])]
    remark = (
        f"Not so with equal forces, where the start displaces the blocks: {words_of(equal)} get further "
        "without the stop than with it."
        if equal
        else ""
    )
    return Finding(
        (holds(less and still), holds(less_from_starts and still_from_starts)),
        tuple(lines),
        PRINTED,
        remark=remark,
        basis="the same runs with a gap of 1000 m, which no motion closes",
    )


def rates_higher(numbers: Numbers) -> Finding:
    """II faster than I by one of both measures, from rest and in pairs of perturbed starts."""
    pairs = list(zip(MOTORS, PRINTED, strict=True))
    lines = [_rest_line(numbers, motor, ideal) for motor, ideal in pairs]
    lines += [_pair_line(numbers, motor, ideal) for motor, ideal in pairs]
    lines += [_pair_line(numbers, motor, ideal) for motor, ideal in zip(MOTORS, EQUAL_FORCE, strict=True)]
    lines += [_pair_line(numbers, motor, ideal) for motor, ideal in zip(READINGS, PRINTED[1:], strict=True)]
    at = [
        {f"{hertz} Hz": faster(numbers, *pair) for hertz, pair in zip(HERTZ, pairs, strict=True)}
        for faster in (_faster_from_rest, _faster)
    ]
    return Finding(
        tuple(only_if(each, "the frequency is") for each in at),
        tuple(lines),
        (*MOTORS, *PRINTED, *EQUAL_FORCE, *READINGS),
    )


def motor_drift_grows(numbers: Numbers) -> Finding:
    """Both measures of Case II over frequency: from rest, and medians."""
    lines = []
    grow: list[list[bool]] = [[], []]
    for key, what in MEASURES.items():
        for grows, words, value in zip(grow, WHENCE, (rest_value, middle), strict=True):
            rates = [value(numbers, name, key) for name in MOTORS]
            grows.append(all(below < above for below, above in pairwise(rates)))
            each = (f"{name} {mm_per_s(rate)}" for name, rate in zip(MOTORS, rates, strict=True))
            lines.append(f"{what}, {words}: {', '.join(each)}")
    lines += [_pair_line(numbers, above, below) for below, above in pairwise(MOTORS)]
    spread = "The scatter is large: of two starts the faster one is often that of the lower frequency."
    doubt = any(_share(numbers, above, below) < MOST for below, above in pairwise(MOTORS))
    return Finding(
        tuple(holds(all(each)) for each in grow), tuple(lines), MOTORS, remark=spread if doubt else ""
    )


def drift_b_above_c(numbers: Numbers) -> Finding:
    """II-B against II-C, as printed and in the readings."""
    printed, reading = ("II-B", "II-C"), READINGS
    changed = in_reading(numbers, reading[0])
    return Finding(
        tuple(
            with_numbers([faster(numbers, *pair) for pair in (printed, reading)], changed)
            for faster in (_faster_from_rest, _faster)
        ),
        (
            _rest_line(numbers, *printed),
            _rest_line(numbers, *reading),
            _pair_line(numbers, *printed),
            _pair_line(numbers, *reading),
        ),
        (*printed, *reading),
    )


def _faster_from_rest(numbers: Numbers, one: str, other: str) -> bool:
    return any(rest_value(numbers, one, key) > rest_value(numbers, other, key) for key in MEASURES)


def _faster(numbers: Numbers, one: str, other: str) -> bool:
    return any(share_above(numbers, one, other, key) >= MOST for key in MEASURES)


def _share(numbers: Numbers, one: str, other: str) -> float:
    return max(share_above(numbers, one, other, key) for key in MEASURES)


def _rest_line(numbers: Numbers, one: str, other: str) -> str:
    """Both measures of two runs from rest."""
    runs = [numbers["runs"][name] for name in (one, other)]
    ends = (
        f"{name} {mm(abs(run['overall']) * run['t_end'])}"
        for name, run in zip((one, other), runs, strict=True)
    )
    rates = (f"{name} {drift_rate(run['drift'])}" for name, run in zip((one, other), runs, strict=True))
    return f"from rest, |x2| at the end: {', '.join(ends)}; second half: {', '.join(rates)}"


def _pair_line(numbers: Numbers, one: str, other: str) -> str:
    overall, late = (percent(share_above(numbers, one, other, key)) for key in MEASURES)
    rate = numbers["runs"][other]["drift"]["rate"]
    rates = magnitudes(numbers, one, "drift")
    above = sum(each > abs(rate) for each in rates) if rate is not None else 0
    return (
        f"{one} faster than {other}: in {late} of the pairs in the second half, in {overall} overall; faster "
        f"than {other} from rest from {above} of {len(rates)} starts"
    )
