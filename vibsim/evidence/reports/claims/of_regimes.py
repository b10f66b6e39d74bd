"""Claims on the kind of motion: periodic, quasi-periodic, chaotic; and how regular it is."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from itertools import pairwise

from vibsim.evidence.reports.claims.claim import (
    FAILS,
    HOLDS,
    OPEN,
    OURS,
    Claim,
    Finding,
    Numbers,
    either,
    one_of,
)
from vibsim.evidence.reports.claims.evidence import MOST, count_of, how_many, members, mostly
from vibsim.evidence.reports.measured.paper_runs import EQUAL_FORCE, MOTORS, PRINTED
from vibsim.evidence.reports.measured.regimes_nearby import (
    DAMPINGS,
    IRREGULAR,
    LAWS,
    counts_by_regime,
    rows_of,
)
from vibsim.evidence.reports.quotes import said
from vibsim.evidence.reports.wording import of_all, words_of

NAMED = ("periodic", "quasi-periodic", "chaotic")


def regime_claims() -> list[Claim]:
    """In the order of the paper."""
    return [
        Claim(
            "chaotic",
            "For certain parameters the motion is chaotic.",
            said("chaotic"),
            "Among the cases shown or beside them (frequency, damping, law of the amplitude) there are "
            "motions that the 0-1 test or a positive largest Lyapunov exponent calls chaotic in the second "
            "half of 300 s.",
            OURS,
            chaotic_somewhere,
            pictures=("regimes",),
        ),
        Claim(
            "three-regimes",
            "The three frequencies of Case I give periodic, quasi-periodic and chaotic motion, with and "
            "without impacts.",
            said("responses"),
            "Each of the three regimes is found in one of I-A, I-B and I-C, in the second half of the run "
            "or when it is followed to 3000 s, and one of the three has no impacts.",
            OURS,
            three_regimes,
            figures=("fig-11", "fig-12", "fig-13"),
            pictures=("regimes",),
        ),
        Claim(
            "more-regular",
            "The motion becomes more regular with frequency, for both sources.",
            said("regular"),
            "The share of perturbed starts whose motion repeats itself, or comes closer to doing so, every "
            "cycle (period 1) does not fall from 3.5 to 5.5 to 6.5 Hz, and grows from the first to the last.",
            OURS,
            more_regular,
            figures=("fig-11", "fig-12", "fig-13"),
        ),
        Claim(
            "period-1-ideal",
            "The ideal source at 6.5 Hz leads to a period-1 motion with one impact in every cycle.",
            said("period-1"),
            "I-C settles in period 1 (followed to 3000 s), and four of five perturbed starts have one "
            "impact in each cycle of the second half.",
            OURS,
            period_one_ideal,
            figures=("fig-07", "fig-13"),
        ),
        Claim(
            "period-1-motor",
            "So does the motor of 6.5 Hz: one impact in every turn.",
            said("period-1"),
            "The run from rest and four of five perturbed starts of II-C have one impact in each turn of "
            "the second half.",
            OURS,
            period_one_motor,
            figures=("fig-10", "fig-13"),
        ),
    ]


def chaotic_somewhere(numbers: Numbers) -> Finding:
    """Cases and neighbours that are chaotic."""
    rows = numbers["nearby"]
    runs = [name for name, run in numbers["runs"].items() if run["regime"]["verdict"] == "chaotic"]
    lasting = [name for name, run in numbers["long_runs"].items() if run["regime"]["verdict"] == "chaotic"]
    lines = [
        f"chaotic between 150 and 300 s: {', '.join(runs) or 'none of the cases'}; still so when followed to "
        f"3000 s: {', '.join(lasting) or 'none'}",
        *(_neighbours(rows, law, c) for law in LAWS for c in DAMPINGS),
    ]
    chaotic = bool(runs) or any(row["regime"] == "chaotic" for row in rows)
    remark = "Case II is chaotic for a while: see its trust horizons." if chaotic else ""
    return Finding(HOLDS if chaotic else FAILS, tuple(lines), tuple(runs), remark=remark)


def _neighbours(rows: Sequence[Numbers], law: str, c: float) -> str:
    counts = counts_by_regime(rows, law, c)
    words = ", ".join(f"{count} {regime}" for regime, count in counts.items())
    where = [
        f"{regime} at {_listed(rows_of(rows, regime, law, c))}" for regime in IRREGULAR if regime in counts
    ]
    of = f"amplitude by {law}, c = {c:g} N s/m, {sum(counts.values())} frequencies from 3 to 7 Hz: {words}"
    return "; ".join([of, *where])


def _listed(rows: Sequence[Numbers]) -> str:
    """Frequencies, and what becomes of the first ones when they are followed."""
    few = [f"{row['hz']:g}" for row in rows[:6]]
    later = [f"{row['hz']:g} Hz {_kind(row['later'])}" for row in rows if "later" in row]
    longer = f" (followed to 3000 s: {words_of(later)})" if later else ""
    return ", ".join(few) + (" Hz and more" if len(rows) > len(few) else " Hz") + longer


def three_regimes(numbers: Numbers) -> Finding:
    """Regimes and impacts of I-A, I-B and I-C; and where the missing ones are found."""
    regimes = {name: _regimes_of(numbers, name) for name in (*PRINTED, *EQUAL_FORCE)}
    there = {regime for name in PRINTED for regime in regimes[name]}
    struck = [name for name in PRINTED if numbers["runs"][name]["impacts"]]
    lines = tuple(_regime_line(numbers, name) for name in (*PRINTED, *EQUAL_FORCE))
    holds = there >= set(NAMED) and len(struck) < len(PRINTED)
    missing = [regime for regime in NAMED if regime not in there]
    nearest = [_where_found(numbers["nearby"], regime) for regime in missing]
    everyone = "All three strike from rest." if len(struck) == len(PRINTED) else ""
    silent = [f"{count_of(numbers, name, is_silent)} in {name}" for name in PRINTED if _some(numbers, name)]
    if silent:
        everyone += f" A motion without impacts coexists: it is reached from {words_of(silent)}."
    return Finding(HOLDS if holds else FAILS, (*lines, *nearest), (*PRINTED, *EQUAL_FORCE), remark=everyone)


def is_silent(outcome: Numbers) -> bool:
    """Whether there are no impacts in the second half."""
    return outcome.get("cycles") == "no impacts"


def _some(numbers: Numbers, name: str) -> bool:
    return any(is_silent(each) for each in members(numbers, name))


def _regimes_of(numbers: Numbers, name: str) -> set[str]:
    return {numbers[which][name]["regime"]["verdict"] for which in ("runs", "long_runs")}


def _regime_line(numbers: Numbers, name: str) -> str:
    run, later = (numbers[which][name]["regime"] for which in ("runs", "long_runs"))
    kinds = Counter(_kind(each) for each in members(numbers, name) if "regime" in each).most_common(4)
    starts = ", ".join(f"{count} {kind}" for kind, count in kinds)
    return f"{name}: {_kind(run)}, followed to 3000 s {_kind(later)}; perturbed starts: {starts}"


def _kind(regime: Numbers) -> str:
    verdict = regime.get("verdict") or regime.get("regime")
    period = regime["period"]
    toward = "towards" if verdict == "transient" else "with"
    return f"{verdict} {toward} period {period}" if period else str(verdict)


def _where_found(rows: Sequence[Numbers], regime: str) -> str:
    places = [
        f"with the amplitude by {law} and c = {c:g} N s/m at {_listed(rows_of(rows, regime, law, c))}"
        for law in LAWS
        for c in DAMPINGS
        if rows_of(rows, regime, law, c)
    ]
    matching = [row for row in rows if row["regime"] == regime and "later" in row]
    lasts = any(row["later"]["regime"] == regime for row in matching)
    passing = " None of those that were followed lasts." if matching and not lasts else ""
    return f"Nearest {regime} motion: {'; '.join(places) or 'none found'}.{passing}"


def more_regular(numbers: Numbers) -> Finding:
    """Share of period-1 motions over frequency, for both sources."""
    ideal, motor = (_grows_regular(numbers, names) for names in (PRINTED, MOTORS))
    lines = tuple(
        "period 1 from "
        + ", ".join(f"{count_of(numbers, name, is_period_one)} starts in {name}" for name in names)
        for names in (PRINTED, MOTORS)
    )
    return Finding(
        either(ideal, motor),
        lines,
        (*PRINTED, *MOTORS),
        condition=one_of(ideal, motor, "the source is ideal", "the source is the motor"),
    )


def is_period_one(outcome: Numbers) -> bool:
    """Whether a motion repeats itself every cycle, or comes closer to it."""
    return outcome.get("regime") in ("periodic", "transient") and outcome["period"] == 1


def _grows_regular(numbers: Numbers, names: Sequence[str]) -> bool:
    counts = [how_many(numbers, name, is_period_one) for name in names]
    shares = [count / max(1, total) for count, total in counts]
    return all(below <= above for below, above in pairwise(shares)) and shares[0] < shares[-1]


def period_one_ideal(numbers: Numbers) -> Finding:
    """The regime of I-C when followed, and impacts per cycle of the ensemble."""
    shown, later = numbers["runs"]["I-C"]["regime"], numbers["long_runs"]["I-C"]["regime"]
    lines = (
        f"300 s: {shown['verdict']}: {shown['reason']}",
        f"followed to {later['span']['end']:.0f} s: {later['verdict']}: {later['reason']}",
        f"one impact in each cycle: {_from_rest(numbers, 'I-C')}; perturbed starts: "
        f"{count_of(numbers, 'I-C', one_impact)}",
    )
    if later["verdict"] == "undecided":
        return Finding(OPEN, lines, ("I-C",))
    settles = later["verdict"] == "periodic" and later["period"] == 1
    holds = settles and _one_each(numbers, "I-C") and mostly(numbers, "I-C", one_impact)
    return Finding(HOLDS if holds else FAILS, lines, ("I-C",))


def period_one_motor(numbers: Numbers) -> Finding:
    """Impacts per turn in II-C: from rest, and of the ensemble."""
    count, total = how_many(numbers, "II-C", one_impact)
    lines = (
        f"from rest: {_kind(numbers['runs']['II-C']['regime'])}",
        f"one impact in each turn: {_from_rest(numbers, 'II-C')}; perturbed starts: {of_all(count, total)}",
    )
    holds = _one_each(numbers, "II-C") and count >= MOST * total
    alone = "From rest it is as the paper says. " if _one_each(numbers, "II-C") else ""
    others = "Other starts end in coexisting motions of longer period."
    remark = alone + others if 0 < count < MOST * total else ""
    return Finding(HOLDS if holds else FAILS, lines, ("II-C",), remark=remark)


def one_impact(outcome: Numbers) -> bool:
    """Whether each cycle of the second half has one impact."""
    return bool(outcome.get("one_per_cycle"))


def _one_each(numbers: Numbers, name: str) -> bool:
    counts = numbers["runs"][name]["cycles"].get("impact_counts") or {}
    return set(counts) == {"1"}


def _from_rest(numbers: Numbers, name: str) -> str:
    return "yes, from rest" if _one_each(numbers, name) else "no, from rest"
