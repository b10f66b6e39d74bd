"""Claims on impacts, and on how far displacements and velocities go."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
from statistics import median

from vibsim.evidence.reports.claims.claim import (
    OPEN,
    OURS,
    PAPERS,
    Claim,
    Finding,
    Numbers,
    Verdict,
    holds,
    only_if,
)
from vibsim.evidence.reports.claims.evidence import count_of, magnitudes, middle, mostly, rest_value
from vibsim.evidence.reports.measured.paper_runs import EQUAL_FORCE, HERTZ, MOTORS, PRINTED
from vibsim.evidence.reports.quotes import said
from vibsim.evidence.reports.wording import mm

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
    rest = holds(cycles["verdict"] == "every cycle" and _grow(counts))
    if cycles["verdict"] == "undecided":
        rest = Verdict(OPEN)
    over = holds(mostly(numbers, "I-C", strikes_every_cycle) and _grow(medians))
    return Finding((rest, over), tuple(lines), PRINTED)


def strikes_every_cycle(outcome: Numbers) -> bool:
    """Whether each cycle of the second half has at least one impact."""
    return outcome.get("cycles") == "every cycle"


def _grow(values: Sequence[float]) -> bool:
    return all(below < above for below, above in pairwise(values))


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
