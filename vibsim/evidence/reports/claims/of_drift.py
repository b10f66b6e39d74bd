"""Claims on the rate of displacement: how fast block 2 gets away, and why.

Two measures are told everywhere: the overall rate, displacement at the end over the whole time, which is what
the paper's figures show, and the drift rate of the second half, which leaves the transient out.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from vibsim.evidence.reports.claims.claim import (
    FAILS,
    HOLDS,
    ONLY_IF,
    OURS,
    PAPERS,
    Claim,
    Finding,
    Numbers,
    only_if,
)
from vibsim.evidence.reports.claims.evidence import MOST, in_reading, magnitudes, middle, share_above
from vibsim.evidence.reports.measured.paper_runs import EQUAL_FORCE, HERTZ, MOTORS, PRINTED, READINGS
from vibsim.evidence.reports.quotes import said
from vibsim.evidence.reports.wording import drift_rate, mm, mm_per_s, percent, words_of

MUCH = 5.0  # factor by which impacts must raise the overall displacement to be its cause


def drift_claims() -> list[Claim]:
    """In the order of the paper."""
    return [
        Claim(
            "drift-grows",
            "With the ideal source the overall displacement rate grows with frequency.",
            said("overall rate"),
            "|x2| at the end of the run grows from 3.5 to 5.5 to 6.5 Hz. (The drift rate of the second "
            "half, a measure of ours, is told beside it.)",
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
            "what it is with it, and there is no drift in the second half.",
            OURS,
            impacts_cause,
        ),
        Claim(
            "rates-higher",
            "The displacement rate is higher with the non-ideal source, at each frequency.",
            said("rates higher"),
            "At each frequency II is faster than I in four of five pairs of perturbed starts, in the "
            "overall rate or in the drift rate of the second half.",
            OURS,
            rates_higher,
            figures=("fig-08", "fig-09", "fig-10"),
            pictures=("drift",),
        ),
        Claim(
            "motor-drift-grows",
            "With the motor, too, the rate tends to grow with frequency.",
            said("rate tends"),
            "A tendency: the median over the perturbed starts, of the overall rate and of the drift rate in "
            "the second half, grows from II-A to II-B to II-C.",
            OURS,
            motor_drift_grows,
            figures=("fig-08", "fig-09", "fig-10"),
            pictures=("drift",),
        ),
        Claim(
            "drift-B-above-C",
            "II-B has a higher displacement rate than II-C.",
            said("higher at 5.5"),
            "II-B is faster in four of five pairs of perturbed starts, in the overall rate or in the drift "
            "rate of the second half.",
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
    condition = "the amplitudes are those of Table 1" if printed else "they follow Eq. (2.11)"
    verdict = only_if(printed, equal)
    return Finding(
        verdict,
        tuple(lines),
        (*PRINTED, *EQUAL_FORCE),
        condition=condition if verdict == ONLY_IF else "",
        remark=remark.strip(),
    )


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
    still = all(without[name]["drift"]["verdict"] == "none" for name in PRINTED)
    lines = tuple(
        f"{name}: |x2| at the end {mm(abs(runs[name]['overall']) * runs[name]['t_end'])}, without the stop "
        f"{mm(abs(without[name]['overall']) * runs[name]['t_end'])} (drift in the second half: "
        f"{without[name]['drift']['verdict']})"
        for name in (*PRINTED, *EQUAL_FORCE, *MOTORS)
    )
    equal = [name for name in EQUAL_FORCE if abs(without[name]["overall"]) > abs(runs[name]["overall"])]
    remark = (
        f"Not so with equal forces, where the start displaces the blocks: {words_of(equal)} get further "
        "without the stop than with it."
        if equal
        else ""
    )
    basis = "the same runs with a gap of 1000 m, which no motion closes"
    return Finding(HOLDS if less and still else FAILS, lines, PRINTED, remark=remark, basis=basis)


def rates_higher(numbers: Numbers) -> Finding:
    """II faster than I in pairs of perturbed starts, by both measures."""
    pairs = list(zip(MOTORS, PRINTED, HERTZ, strict=True))
    faster = [_faster(numbers, motor, ideal) for motor, ideal, _ in pairs]
    where = [hertz for (*_, hertz), each in zip(pairs, faster, strict=True) if each]
    lines = [_pair_line(numbers, motor, ideal) for motor, ideal, _ in pairs]
    lines += [_pair_line(numbers, motor, ideal) for motor, ideal in zip(MOTORS, EQUAL_FORCE, strict=True)]
    lines += [_pair_line(numbers, motor, ideal) for motor, ideal in zip(READINGS, PRINTED[1:], strict=True)]
    return Finding(
        only_if(all(faster), any(faster)),
        tuple(lines),
        (*MOTORS, *PRINTED, *EQUAL_FORCE, *READINGS),
        condition="" if all(faster) or not where else f"the frequency is {words_of(where, 'or')} Hz",
    )


def motor_drift_grows(numbers: Numbers) -> Finding:
    """Medians of Case II over frequency."""
    lines = []
    grows = []
    for key, what in (("overall", "overall rate"), ("drift", "second half")):
        medians = [middle(numbers, name, key) for name in MOTORS]
        grows.append(all(below < above for below, above in pairwise(medians)))
        each = (f"{name} {mm_per_s(value)}" for name, value in zip(MOTORS, medians, strict=True))
        lines.append(f"median of the {what}: {', '.join(each)}")
    lines += [_pair_line(numbers, above, below) for below, above in pairwise(MOTORS)]
    spread = "The scatter is large: of two starts the faster one is often that of the lower frequency."
    doubt = any(_share(numbers, above, below) < MOST for below, above in pairwise(MOTORS))
    return Finding(HOLDS if all(grows) else FAILS, tuple(lines), MOTORS, remark=spread if doubt else "")


def drift_b_above_c(numbers: Numbers) -> Finding:
    """II-B against II-C, as printed and in the readings: by the ensembles, a chaotic drift being chance."""
    printed, reading = ("II-B", "II-C"), READINGS
    verdict = only_if(_faster(numbers, *printed), _faster(numbers, *reading))
    rest = ", ".join(f"{name} {drift_rate(numbers['runs'][name]['drift'])}" for name in printed)
    return Finding(
        verdict,
        (f"from rest, second half: {rest}", _pair_line(numbers, *printed), _pair_line(numbers, *reading)),
        (*printed, *reading),
        condition=in_reading(numbers, reading[0]) if verdict == ONLY_IF else "",
    )


def _faster(numbers: Numbers, one: str, other: str) -> bool:
    return any(share_above(numbers, one, other, key) >= MOST for key in ("overall", "drift"))


def _share(numbers: Numbers, one: str, other: str) -> float:
    return max(share_above(numbers, one, other, key) for key in ("overall", "drift"))


def _pair_line(numbers: Numbers, one: str, other: str) -> str:
    overall, late = (percent(share_above(numbers, one, other, key)) for key in ("overall", "drift"))
    rate = numbers["runs"][other]["drift"]["rate"]
    rates = magnitudes(numbers, one, "drift")
    above = sum(each > abs(rate) for each in rates) if rate is not None else 0
    return (
        f"{one} faster than {other}: in {late} of the pairs in the second half, in {overall} overall; faster "
        f"than {other} from rest from {above} of {len(rates)} starts"
    )
