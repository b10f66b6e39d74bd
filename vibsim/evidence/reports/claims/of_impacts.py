"""Claims on impacts, and on how far displacements and velocities go."""

from __future__ import annotations

from itertools import pairwise
from statistics import median

from vibsim.evidence.reports.claims.claim import (
    FAILS,
    HOLDS,
    OPEN,
    OURS,
    PAPERS,
    Claim,
    Finding,
    Numbers,
    either,
    one_of,
    only_if,
)
from vibsim.evidence.reports.claims.evidence import magnitudes, middle
from vibsim.evidence.reports.measured.paper_runs import EQUAL_FORCE, HERTZ, MOTORS, PRINTED
from vibsim.evidence.reports.quotes import said
from vibsim.evidence.reports.wording import mm, words_of

APART = 1.5  # factor between numbers that are "very different"
ALIKE = 0.2  # relative difference of numbers that do not "change considerably"


def impact_claims() -> list[Claim]:
    """In the order of the paper."""
    return [
        Claim(
            "impacts",
            "With the ideal source, impacts become more frequent with frequency, and at 6.5 Hz every cycle "
            "has one.",
            said("impacts more frequent"),
            "More impacts in I-B than in I-A and in I-C than in I-B over the run; at least one in every "
            "cycle of the second half of I-C.",
            PAPERS,
            impacts_every_cycle,
            figures=("fig-05", "fig-06", "fig-07"),
        ),
        Claim(
            "impacts-of-motor",
            "The number of impacts hardly changes from II-B to II-C.",
            said("number of impacts"),
            "The medians over the perturbed starts, and the numbers from rest, are within 20 % of each "
            "other.",
            OURS,
            impacts_of_motor,
            figures=("fig-09", "fig-10"),
        ),
        Claim(
            "impacts-differ",
            "The two sources cause very different numbers of impacts and rates of displacement.",
            said("very different"),
            "At each frequency the medians over the perturbed starts, of the number of impacts and of the "
            "drift rate in the second half, differ by a factor of 1.5 or more.",
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
    cycles, counts = runs["I-C"]["cycles"], [runs[name]["impacts"] for name in PRINTED]
    if cycles["verdict"] == "undecided":
        return Finding(OPEN, (cycles["reason"],), ("I-C",))
    lines = tuple(
        f"{name}: {runs[name]['impacts']} impacts, {runs[name]['cycles']['reason']}" for name in PRINTED
    )
    holds = cycles["verdict"] == "every cycle" and all(a < b for a, b in pairwise(counts))
    return Finding(HOLDS if holds else FAILS, lines, PRINTED)


def impacts_of_motor(numbers: Numbers) -> Finding:
    """Impacts in II-B and II-C."""
    names = ("II-B", "II-C")
    rest = [numbers["runs"][name]["impacts"] for name in names]
    medians = [middle(numbers, name, "impacts") for name in names]
    lines = tuple(_count_line(numbers, name) for name in names)
    alike = all(abs(c / b - 1) <= ALIKE if b else False for b, c in (rest, medians))
    return Finding(HOLDS if alike else FAILS, lines, names)


def _count_line(numbers: Numbers, name: str) -> str:
    counts = magnitudes(numbers, name, "impacts")
    span = f", {min(counts):.0f} to {max(counts):.0f}" if counts else ""
    return (
        f"{name}: {numbers['runs'][name]['impacts']} from rest; perturbed starts: median "
        f"{middle(numbers, name, 'impacts'):.0f}{span}"
    )


def impacts_differ(numbers: Numbers) -> Finding:
    """Factor between II and I in impacts and in drift rate."""
    pairs = list(zip(MOTORS, PRINTED, HERTZ, strict=True))
    factors = [
        [_factor(numbers, motor, ideal, key) for key in ("impacts", "drift")] for motor, ideal, _ in pairs
    ]
    apart = [all(factor >= APART or factor <= 1 / APART for factor in row) for row in factors]
    lines = tuple(
        f"{motor} over {ideal}: impacts {row[0]:.3g}, drift rate {row[1]:.3g} times"
        for (motor, ideal, _), row in zip(pairs, factors, strict=True)
    )
    where = [hertz for (*_, hertz), each in zip(pairs, apart, strict=True) if each]
    return Finding(
        only_if(all(apart), any(apart)),
        lines,
        (*MOTORS, *PRINTED),
        condition="" if all(apart) or not where else f"the frequency is {words_of(where, 'or')} Hz",
    )


def _factor(numbers: Numbers, motor: str, ideal: str, key: str) -> float:
    below = middle(numbers, ideal, key)
    return middle(numbers, motor, key) / below if below else float("inf")


def non_ideal_larger(numbers: Numbers) -> Finding:
    """II beside I, as printed and with equal forces."""
    pairs = [*zip(MOTORS, PRINTED, strict=True), *zip(MOTORS, EQUAL_FORCE, strict=True)]
    larger = [_larger(numbers, motor, ideal) for motor, ideal in pairs]
    printed, equal = all(larger[: len(MOTORS)]), all(larger[len(MOTORS) :])
    remark = "With equal forces it is the ideal source that moves the system more, at each frequency."
    return Finding(
        either(printed, equal),
        tuple(_beside(numbers, motor, ideal) for motor, ideal in pairs),
        (*MOTORS, *PRINTED, *EQUAL_FORCE),
        condition=one_of(printed, equal, "the forces are unequal, as Table 1 prints them", "they are equal"),
        remark="" if any(larger[len(MOTORS) :]) else remark,
    )


def _larger(numbers: Numbers, one: str, other: str) -> bool:
    ours, theirs = (numbers["runs"][name]["steady"] for name in (one, other))
    starts = [_steady(numbers, name) for name in (one, other)]
    keys = ("relative", "v1", "v2")
    return all(ours[key] > theirs[key] and starts[0][key] > starts[1][key] for key in keys)


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
