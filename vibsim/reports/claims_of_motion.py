"""Claims on Case I, on Case I beside Case II, and on drift: what moves how far."""

from __future__ import annotations

from itertools import pairwise, product

from vibsim.reports.claim import FAILS, HOLDS, ONLY_IF, OPEN, Claim, Finding, Numbers, only_if
from vibsim.reports.evidence import MOST
from vibsim.reports.paper_runs import EQUAL_FORCE, MOTORS, PRINTED
from vibsim.reports.wording import drift_rate, mm, mm_per_s


def motion_claims() -> list[Claim]:
    """In the order of the paper."""
    return [
        Claim(
            "drift-grows",
            "The drift rate grows with the frequency of the ideal source.",
            "Figs. 5 to 7",
            "The magnitude of the drift rate, second half of the run, grows from 3.5 to 5.5 to 6.5 Hz by "
            "more than its uncertainty.",
            drift_grows,
        ),
        Claim(
            "impacts",
            "At 6.5 Hz the ideal source causes an impact in every cycle.",
            "Fig. 7",
            "Every cycle of the second half of I-C has an impact.",
            impacts_every_cycle,
        ),
        Claim(
            "period-1",
            "At 6.5 Hz the motion under the ideal source has period 1.",
            "Figs. 7 and 13",
            "The regime of I-C is periodic, of period 1, in the second half of the 300 s.",
            period_one,
        ),
        Claim(
            "non-ideal-larger",
            "The non-ideal source moves the system more: displacements and velocities are larger than with "
            "the ideal source at each frequency.",
            "Figs. 5 to 13",
            "In the second half of the run, the vibration of x1 − x2 and the greatest |v1| and |v2| are "
            "larger in II than in I at 3.5, 5.5 and 6.5 Hz.",
            non_ideal_larger,
        ),
        Claim(
            "drift-B-above-C",
            "Case II-B drifts faster than case II-C.",
            "Figs. 9 and 10",
            "The magnitude of the drift rate of x2, second half of the run, is larger in II-B in four of "
            "five pairs of perturbed starts.",
            drift_b_above_c,
        ),
    ]


def drift_grows(numbers: Numbers) -> Finding:
    """As printed, and with equal forces."""
    printed, equal = (_grows(numbers, names) for names in (PRINTED, EQUAL_FORCE))
    ways = [numbers["runs"][name]["drift"]["verdict"] for name in PRINTED]
    directions = ", ".join(f"{name} {way}" for name, way in zip(PRINTED, ways, strict=True))
    return Finding(
        HOLDS if printed and equal else ONLY_IF if printed or equal else FAILS,
        (_rates(numbers, PRINTED), _rates(numbers, EQUAL_FORCE)),
        (*PRINTED, *EQUAL_FORCE),
        condition=_one_of(printed, equal, "the amplitudes are those of Table 1", "they follow Eq. (2.11)"),
        remark=f"Not all drift the same way: {directions}." if len(set(ways)) > 1 else "",
    )


def _grows(numbers: Numbers, names: tuple[str, ...]) -> bool:
    drifts = [numbers["runs"][name]["drift"] for name in names]
    if any(drift["rate"] is None for drift in drifts):
        return False
    return all(
        abs(above["rate"]) - above["half_width"] > abs(below["rate"]) + below["half_width"]
        for below, above in pairwise(drifts)
    )


def _rates(numbers: Numbers, names: tuple[str, ...]) -> str:
    return ", ".join(f"{name} {drift_rate(numbers['runs'][name]['drift'])}" for name in names)


def impacts_every_cycle(numbers: Numbers) -> Finding:
    """Impacts per cycle in I-C."""
    cycles = numbers["runs"]["I-C"]["cycles"]
    if cycles["verdict"] == "undecided":
        return Finding(OPEN, (cycles["reason"],), ("I-C",))
    lines = [f"{name}: {numbers['runs'][name]['cycles']['reason']}" for name in PRINTED]
    return Finding(HOLDS if cycles["verdict"] == "every cycle" else FAILS, tuple(lines), PRINTED)


def period_one(numbers: Numbers) -> Finding:
    """The regime of I-C in the run shown, and when the run is followed for longer."""
    shown, later = numbers["runs"]["I-C"]["regime"], numbers["long_runs"]["I-C"]["regime"]
    lines = (
        f"300 s: {shown['verdict']}: {shown['reason']}",
        f"followed to {later['span']['end']:.0f} s: {later['verdict']}: {later['reason']}",
    )
    printed, followed = (each["verdict"] == "periodic" and each["period"] == 1 for each in (shown, later))
    if not printed and not followed and "undecided" in (shown["verdict"], later["verdict"]):
        return Finding(OPEN, lines, ("I-C",))
    condition = "the motion is followed for longer than the 300 s, in which it only comes close to it"
    return Finding(only_if(printed, followed), lines, ("I-C",), "" if printed or not followed else condition)


def non_ideal_larger(numbers: Numbers) -> Finding:
    """II beside I, as printed and with equal forces."""
    pairs = [*zip(MOTORS, PRINTED, strict=True), *zip(MOTORS, EQUAL_FORCE, strict=True)]
    larger = [_larger(numbers, motor, ideal) for motor, ideal in pairs]
    printed, equal = all(larger[: len(MOTORS)]), all(larger[len(MOTORS) :])
    remark = "With equal forces it is the ideal source that moves the system more, at each frequency."
    return Finding(
        HOLDS if printed and equal else ONLY_IF if printed or equal else FAILS,
        tuple(_beside(numbers, motor, ideal) for motor, ideal in pairs),
        (*MOTORS, *PRINTED, *EQUAL_FORCE),
        condition=_one_of(printed, equal, "the forces are unequal, as Table 1 prints them", "they are equal"),
        remark="" if any(larger[len(MOTORS) :]) else remark,
    )


def _larger(numbers: Numbers, one: str, other: str) -> bool:
    ours, theirs = numbers["runs"][one]["steady"], numbers["runs"][other]["steady"]
    return all(ours[key] > theirs[key] for key in ("relative", "v1", "v2"))


def _beside(numbers: Numbers, motor: str, ideal: str) -> str:
    ours, theirs = numbers["runs"][motor]["steady"], numbers["runs"][ideal]["steady"]
    return (
        f"{motor} beside {ideal}: vibration {mm(ours['relative'])} and {mm(theirs['relative'])}, "
        f"|v1| {ours['v1']:.3g} and {theirs['v1']:.3g} m/s, |v2| {ours['v2']:.3g} and {theirs['v2']:.3g} m/s"
    )


def drift_b_above_c(numbers: Numbers) -> Finding:
    """As printed, and in the readings: by the ensembles, since the drift of a chaotic run is chance."""
    printed, reading = ("II-B", "II-C"), ("II-B-captured", "II-C-escape")
    share, read = (_share_above(numbers, *pair)[0] for pair in (printed, reading))
    verdict = HOLDS if share >= MOST else ONLY_IF if read >= MOST or share > 1 - MOST else FAILS
    by_chance = f"chance is kind: the coexisting motions drift differently ({100 * share:.0f} % of the pairs)"
    return Finding(
        verdict,
        (_pair_line(numbers, *printed), _pair_line(numbers, *reading)),
        (*printed, *reading),
        condition=""
        if verdict != ONLY_IF
        else "m3 and c are as in the readings"
        if read >= MOST
        else by_chance,
    )


def _pair_line(numbers: Numbers, one: str, other: str) -> str:
    share, pairs = _share_above(numbers, one, other)
    rates = ", ".join(f"{name} {mm_per_s(numbers['runs'][name]['drift']['rate'])}" for name in (one, other))
    return f"{rates}; perturbed starts: faster in {100 * share:.0f} % of {pairs} pairs"


def _share_above(numbers: Numbers, one: str, other: str) -> tuple[float, int]:
    """Share of the pairs of starts, one of each case, in which the first drifts faster; number of pairs."""
    rates = ([each.get("drift") for each in numbers["ensembles"][name]["outcomes"]] for name in (one, other))
    pairs = [pair for pair in product(*rates) if None not in pair]
    return (sum(_above(*pair) for pair in pairs) / len(pairs) if pairs else 0.0), len(pairs)


def _above(ours: float | None, theirs: float | None) -> bool:
    return ours is not None and theirs is not None and abs(ours) > abs(theirs)


def _one_of(first: bool, second: bool, if_first: str, if_second: str) -> str:
    """The condition under which a claim holds that is true of one of two."""
    return "" if first == second else if_first if first else if_second
