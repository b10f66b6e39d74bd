"""Claims on the rate of displacement: how fast block 2 gets away, and why.

Two measures are told everywhere: the overall rate, displacement at the end over the whole time, which is what
the paper's figures show, and the drift rate of the second half, which leaves the transient out.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
from statistics import median

from vibsim.evidence.reports.claims import (
    MOST,
    OPEN,
    OURS,
    PAPERS,
    Claim,
    ClaimVerdict,
    Finding,
    Numbers,
    count_of,
    drift_rate,
    grows,
    holds,
    in_reading,
    magnitudes,
    middle,
    mm,
    mm_per_s,
    mostly,
    only_if,
    percent,
    rest_value,
    said,
    share_above,
    with_numbers,
    words_of,
)
from vibsim.evidence.reports.measurements import EQUAL_FORCE, HERTZ, MOTORS, PRINTED, SHIPPED_READINGS, drifts

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
    printed, equal = (grows(abs(runs[name]["overall"]) for name in names) for names in (PRINTED, EQUAL_FORCE))
    late = {names: _grows(numbers, names) for names in (PRINTED, EQUAL_FORCE)}
    lines = [_ends(numbers, names) for names in (PRINTED, EQUAL_FORCE)]
    lines += [f"second half: {_rates(numbers, names)}" for names in (PRINTED, EQUAL_FORCE)]
    ways = [runs[name]["drift"]["verdict"] for name in PRINTED]
    directions = ", ".join(f"{name} {way}" for name, way in zip(PRINTED, ways, strict=True))
    remark = f"Not all drift the same way: {directions}." if len(set(ways)) > 1 else ""
    if equal and not late[EQUAL_FORCE]:
        remark += (
            " With equal forces the displacement is that of the start, a force A sin(ωt) that sets in at "
            "full size on blocks at rest; in the second half no growth can be distinguished from zero."
        )
    lines.append(f"medians of the starts: {_medians(numbers, PRINTED)}; {_medians(numbers, EQUAL_FORCE)}")
    laws = ("the amplitudes are those of Table 1", "they follow Eq. (2.11)")
    over = [grows(middle(numbers, name, "overall") for name in names) for names in (PRINTED, EQUAL_FORCE)]
    return Finding(
        (
            only_if(dict(zip(laws, (printed, equal), strict=True))),
            only_if(dict(zip(laws, over, strict=True))),
        ),
        tuple(lines),
        (*PRINTED, *EQUAL_FORCE),
        remark=remark.strip(),
    )


def _medians(numbers: Numbers, names: Sequence[str]) -> str:
    """Median displacement at the end."""
    spans = [numbers["runs"][name]["t_end"] for name in names]
    ends = [middle(numbers, name, "overall") * span for name, span in zip(names, spans, strict=True)]
    return ", ".join(f"{name} {mm(end)}" for name, end in zip(names, ends, strict=True))


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
    lines += [
        _pair_line(numbers, motor, ideal) for motor, ideal in zip(SHIPPED_READINGS, PRINTED[1:], strict=True)
    ]
    at = [
        {f"{hertz} Hz": faster(numbers, *pair) for hertz, pair in zip(HERTZ, pairs, strict=True)}
        for faster in (_faster_from_rest, _faster)
    ]
    return Finding(
        tuple(only_if(each, "the frequency is") for each in at),
        tuple(lines),
        (*MOTORS, *PRINTED, *EQUAL_FORCE, *SHIPPED_READINGS),
    )


def motor_drift_grows(numbers: Numbers) -> Finding:
    """Both measures of Case II over frequency: from rest, and medians."""
    lines = []
    grow: list[list[bool]] = [[], []]
    for key, what in MEASURES.items():
        for growing, words, value in zip(grow, WHENCE, (rest_value, middle), strict=True):
            rates = [value(numbers, name, key) for name in MOTORS]
            growing.append(grows(rates))
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
    printed, reading = ("II-B", "II-C"), SHIPPED_READINGS
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


# Claims on impacts, and on how far displacements and velocities go.


APART = 1.5  # factor between numbers that are "very different"
ALIKE = 0.2  # relative difference of numbers that do not "change considerably"

Steady = Callable[[Numbers, str], dict[str, float]]  # vibration and velocities of a case


def impact_claims() -> list[Claim]:
    """In the order of the paper."""
    return [
        Claim(
            "impacts",
            "With the ideal source, impacts become more frequent with frequency, and at 6.5 Hz every cycle "
            "has one.",
            said("impacts more frequent"),
            "More impacts in I-B than in I-A and in I-C than in I-B over the run (from starts: by the "
            "medians); at least one in every cycle of the second half of I-C (four of five starts).",
            PAPERS,
            impacts_every_cycle,
            figures=("fig-05", "fig-06", "fig-07"),
        ),
        Claim(
            "impacts-of-motor",
            "The number of impacts hardly changes from II-B to II-C.",
            said("number of impacts"),
            "The numbers from rest, and the medians over the perturbed starts, are within 20 % of each "
            "other.",
            OURS,
            impacts_of_motor,
            figures=("fig-09", "fig-10"),
        ),
        Claim(
            "impacts-differ",
            "The two sources cause very different numbers of impacts and rates of displacement.",
            said("very different"),
            "At each frequency the number of impacts and the drift rate in the second half differ by a "
            "factor of 1.5 or more: from rest, and by the medians over the perturbed starts.",
            OURS,
            impacts_differ,
            pictures=("drift",),
        ),
        Claim(
            "non-ideal-larger",
            "Displacements and velocities are larger with the non-ideal source.",
            said("much larger", "values much larger"),
            "In the second half of the run, the vibration of x1 − x2 and the greatest |v1| and |v2| are "
            "larger in II "
            "than in I at 3.5, 5.5 and 6.5 Hz: from rest, and by the medians over the perturbed starts.",
            OURS,
            non_ideal_larger,
            figures=("fig-11", "fig-12", "fig-13"),
        ),
    ]


def impacts_every_cycle(numbers: Numbers) -> Finding:
    """Impacts of Case I, and per cycle in I-C."""
    runs = numbers["runs"]
    cycles = runs["I-C"]["cycles"]
    counts = [runs[name]["impacts"] for name in PRINTED]
    medians = [middle(numbers, name, "impacts") for name in PRINTED]
    lines = [f"{name}: {runs[name]['impacts']} impacts, {runs[name]['cycles']['reason']}" for name in PRINTED]
    starts = ", ".join(f"{name} {value:.0f}" for name, value in zip(PRINTED, medians, strict=True))
    each = count_of(numbers, "I-C", strikes_every_cycle)
    lines.append(f"perturbed starts: median impacts {starts}; I-C strikes in every cycle from {each}")
    rest = holds(cycles["verdict"] == "every cycle" and grows(counts))
    if cycles["verdict"] == "undecided":
        rest = ClaimVerdict(OPEN)
    over = holds(mostly(numbers, "I-C", strikes_every_cycle) and grows(medians))
    return Finding((rest, over), tuple(lines), PRINTED)


def strikes_every_cycle(outcome: Numbers) -> bool:
    """Whether each cycle of the second half has at least one impact."""
    return outcome.get("cycles") == "every cycle"


def impacts_of_motor(numbers: Numbers) -> Finding:
    """Impacts in II-B and II-C."""
    names = ("II-B", "II-C")
    rest = [numbers["runs"][name]["impacts"] for name in names]
    medians = [middle(numbers, name, "impacts") for name in names]
    lines = tuple(_count_line(numbers, name) for name in names)
    return Finding(tuple(holds(_alike(*pair)) for pair in (rest, medians)), lines, names)


def _alike(one: float, other: float) -> bool:
    return bool(one) and abs(other / one - 1) <= ALIKE


def _count_line(numbers: Numbers, name: str) -> str:
    counts = magnitudes(numbers, name, "impacts")
    span = f", {min(counts):.0f} to {max(counts):.0f}" if counts else ""
    return (
        f"{name}: {numbers['runs'][name]['impacts']} from rest; perturbed starts: median "
        f"{middle(numbers, name, 'impacts'):.0f}{span}"
    )


def impacts_differ(numbers: Numbers) -> Finding:
    """Factor between II and I in impacts and in drift rate."""
    pairs = list(zip(MOTORS, PRINTED, strict=True))
    apart, lines = [], []
    for words, value in (("from rest", rest_value), ("medians of the starts", middle)):
        factors = [
            [_factor(value(numbers, motor, key), value(numbers, ideal, key)) for key in ("impacts", "drift")]
            for motor, ideal in pairs
        ]
        lines += [
            f"{motor} over {ideal}, {words}: impacts {row[0]:.3g}, drift rate {row[1]:.3g} times"
            for (motor, ideal), row in zip(pairs, factors, strict=True)
        ]
        apart.append([all(factor >= APART or factor <= 1 / APART for factor in row) for row in factors])
    at = [{f"{hertz} Hz": each for hertz, each in zip(HERTZ, row, strict=True)} for row in apart]
    return Finding(tuple(only_if(each, "the frequency is") for each in at), tuple(lines), (*MOTORS, *PRINTED))


def _factor(above: float, below: float) -> float:
    return above / below if below else float("inf")


def non_ideal_larger(numbers: Numbers) -> Finding:
    """II beside I, as printed and with equal forces."""
    pairs = [*zip(MOTORS, PRINTED, strict=True), *zip(MOTORS, EQUAL_FORCE, strict=True)]
    larger = [[_larger(value, numbers, *pair) for pair in pairs] for value in (_from_rest, _steady)]
    remark = "With equal forces it is the ideal source that moves the system more, at each frequency."
    return Finding(
        tuple(only_if(_by_force(row)) for row in larger),
        tuple(_beside(numbers, motor, ideal) for motor, ideal in pairs),
        (*MOTORS, *PRINTED, *EQUAL_FORCE),
        remark="" if any(each for row in larger for each in row[len(MOTORS) :]) else remark,
    )


def _by_force(larger: Sequence[bool]) -> dict[str, bool]:
    return {
        "the forces are unequal, as Table 1 prints them": all(larger[: len(MOTORS)]),
        "they are equal": all(larger[len(MOTORS) :]),
    }


def _larger(value: Steady, numbers: Numbers, one: str, other: str) -> bool:
    ours, theirs = (value(numbers, name) for name in (one, other))
    return all(ours[key] > theirs[key] for key in ours)


def _from_rest(numbers: Numbers, name: str) -> dict[str, float]:
    """Of the run from rest."""
    steady: dict[str, float] = numbers["runs"][name]["steady"]
    return steady


def _steady(numbers: Numbers, name: str) -> dict[str, float]:
    """Medians over the perturbed starts."""
    rows = [each["steady"] for each in numbers["ensembles"][name]["outcomes"] if "steady" in each]
    keys = ("relative", "v1", "v2")
    return {key: median(row[key] for row in rows) if rows else 0.0 for key in keys}


def _beside(numbers: Numbers, motor: str, ideal: str) -> str:
    ours, theirs = numbers["runs"][motor]["steady"], numbers["runs"][ideal]["steady"]
    medians = [mm(_steady(numbers, name)["relative"]) for name in (motor, ideal)]
    return (
        f"{motor} beside {ideal}: vibration {mm(ours['relative'])} and {mm(theirs['relative'])} (medians "
        f"{medians[0]} and {medians[1]}), |v1| {ours['v1']:.3g} and {theirs['v1']:.3g} m/s, "
        f"|v2| {ours['v2']:.3g} and {theirs['v2']:.3g} m/s"
    )
