"""Claims on the models themselves: natural frequency, equal forces, motion without impacts."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from itertools import pairwise

from vibsim.evidence.reports.claims import (
    MOST,
    NATURAL_HZ,
    ONLY_IF,
    OPEN,
    OUR_MARGIN,
    OURS,
    PAPERS,
    Claim,
    ClaimVerdict,
    Finding,
    Numbers,
    commonest_regime,
    count_of,
    holds,
    how_many,
    hz,
    is_captured,
    members,
    mostly,
    of_all,
    only_if,
    said,
    words_of,
)
from vibsim.evidence.reports.measurements import EQUAL_FORCE, MOTORS, PRINTED
from vibsim.evidence.reports.readings import (
    DAMPINGS,
    IRREGULAR,
    LAWS,
    REGIMES_NEARBY_STARTS,
    counts_by_regime,
    rows_of,
)

ROUNDS = 0.05  # a number with one decimal
SAME_AMPLITUDE = SAME_SLOPE = 0.01  # relative


def models_claims() -> list[Claim]:
    """In the order of the paper."""
    return [
        Claim(
            "no-impacts",
            "Without impacts the motion is periodic.",
            said("no transition"),
            "With the stop out of reach, each of the nine cases settles in a periodic motion (judged over "
            "5000 to 10000 s, when the free vibration has died out).",
            OURS,
            periodic_without_stop,
        ),
        Claim(
            "natural-frequency",
            "The natural frequency is 4.1 Hz: 3.5 Hz lies below it, 5.5 and 6.5 Hz above.",
            said("control values"),
            "The free relative vibration of the non-ideal model, of which this is said, has a frequency that "
            "rounds to 4.1 Hz with the stop open.",
            PAPERS,
            natural_frequency,
        ),
        Claim(
            "amplitude",
            "The two sources push with similar force.",
            said("similar force", "amplitude"),
            "Each amplitude of Table 1 is within 1 % of m3 e ω², with the m3 and e of Case II.",
            OUR_MARGIN,
            amplitude,
        ),
        Claim(
            "voltage",
            "The voltage of the motor changes Ω0, the torque constant M0 being kept.",
            said("voltage", "torque constant kept"),
            "A DC motor with a constant field has M0 = kt V/R and Ω0 = V/ke: the voltage V changes both "
            "alike, and M0/Ω0 = kt ke/R is that of the motor. So the three characteristics would have one "
            "M0/Ω0, to within 1 %.",
            OURS,
            voltage,
            figures=("fig-04",),
        ),
    ]


def periodic_without_stop(numbers: Numbers) -> Finding:
    """Regimes with the stop out of reach."""
    rows = numbers["without_stop"]
    bad = [name for name, row in rows.items() if row["regime"]["verdict"] != "periodic" or row["impacts"]]
    periods = sorted({row["regime"]["period"] for row in rows.values() if row["regime"]["period"]})
    lines = (
        f"without the stop: {len(rows) - len(bad)} of {len(rows)} cases settle in a periodic motion, of "
        f"period {' or '.join(map(str, periods))} of the source",
        *(f"{name}: {rows[name]['regime']['verdict']}: {rows[name]['regime']['reason']}" for name in bad),
    )
    remark = (
        "Until the free vibration has died out (as exp(−t/540 s) with c = 0.001 N s/m) two frequencies are "
        "present, and a record of some hundred seconds looks quasi-periodic."
    )
    basis = "each case for 10000 s with a gap of 1000 m, which no motion closes"
    return Finding((holds(not bad),), lines, remark=remark, basis=basis)


def natural_frequency(numbers: Numbers) -> Finding:
    """Of the non-ideal model; and the others for comparison."""
    facts = numbers["facts"]
    motor, ideal, held = facts["free_hz_II"], facts["free_hz_I"], facts["held_hz"]
    lines = (
        f"non-ideal model, blocks free, stop open (m1 + m3, m2): {motor:.3f} Hz",
        f"ideal model (m1, m2): {ideal:.3f} Hz; block 1 alone with block 2 held: {held:.3f} Hz",
        f"with the stop, in the limit of large vibrations (bilinear): Case I {facts['bilinear_hz_I']:.2f} "
        f"Hz, Case II {facts['bilinear_hz_II']:.2f} Hz",
    )
    held_way = "block 2 is held and the motor not counted"
    if _rounds_to_natural(motor):
        remark = "It is not the frequency at which a motor is captured here: see there."
        return Finding((holds(True),), lines, remark=remark)
    verdict = ClaimVerdict(ONLY_IF, held_way) if _rounds_to_natural(held) else holds(False)
    return Finding((verdict,), lines)


def _rounds_to_natural(value: float) -> bool:
    return abs(value - NATURAL_HZ) < ROUNDS


def amplitude(numbers: Numbers) -> Finding:
    """Table 1 against m3 e omega^2, and against m3 e omega, whose value it has."""
    rows = numbers["facts"]["amplitudes"]
    ratios = [row["eq211"] / row["printed"] for row in rows]
    off = max(abs(row["printed"] / row["m3_e_omega"] - 1) for row in rows)
    lines = tuple(
        f"{row['omega_hz']:g} Hz: Table 1 {row['printed']:.4f}, m3 e ω² = {row['eq211']:.3f} N, "
        f"m3 e ω = {row['m3_e_omega']:.4f}"
        for row in rows
    )
    if all(abs(ratio - 1) <= SAME_AMPLITUDE for ratio in ratios):
        return Finding((holds(True),), lines)
    remark = (
        f"Eq. (2.11) demands {min(ratios):.0f} to {max(ratios):.0f} times as much. Table 1 is within "
        f"{100 * off:.1f} % of m3 e ω, prints m as the unit, and is used as N: unequal forces are compared. "
        "So Table 1 confirms m3 e = 0.0033 kg m."
    )
    return Finding((holds(False),), lines, remark=remark)


def voltage(numbers: Numbers) -> Finding:
    """M0/Omega0 of the three characteristics; and the motor of II-A at the voltages of the others."""
    rows = numbers["facts"]["characteristics"]
    slopes = [row["slope"] for row in rows]
    lines = [
        f"no-load speed {hz(row['no_load_hz'])}: M0/Ω0 = {1e3 * row['slope']:.3f} mN m s, "
        f"{row['slope'] / slopes[0]:.2f} times that of the first"
        for row in rows
    ]
    for row in rows[1:]:
        torque = 1e3 * slopes[0] * row["M0"] / row["slope"]
        lines.append(
            f"the motor of II-A at the voltage for {hz(row['no_load_hz'])} has M0 = {torque:.2f} mN m"
        )
    for name, ensemble in numbers["voltages"].items():
        outcomes = ensemble["outcomes"]
        captured = of_all(sum(map(is_captured, outcomes)), len(outcomes))
        printed = sum(map(is_captured, members(numbers, name)))
        lines.append(
            f"{name} with that M0: captured from {captured} perturbed starts, as printed from {printed}"
        )
    remark = (
        "The voltage alone cannot do it; a resistance that grows with the voltage could, or a field that is "
        "weakened as it grows."
    )
    same = max(slopes) / min(slopes) - 1 <= SAME_SLOPE
    return Finding((holds(same),), tuple(lines), remark="" if same else remark)


# Claims on the kind of motion: periodic, quasi-periodic, chaotic; and how regular it is.


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
            "half of 300 s: from rest, and from most starts.",
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
            "or when it is followed to 3000 s, and one of the three has no impacts; from starts: each is "
            "that of most starts of one case, and four of five starts of one case have no impacts.",
            OURS,
            three_regimes,
            figures=("fig-11", "fig-12", "fig-13"),
            pictures=("regimes",),
        ),
        Claim(
            "more-regular",
            "The motion becomes more regular with frequency, for both sources.",
            said("regular"),
            "From rest: the period of the motion, in cycles, does not grow from 3.5 to 5.5 to 6.5 Hz and is "
            "shorter at the last than at the first (without a period: longer than any). From starts: the "
            "share whose motion repeats itself, or comes closer to doing so, every cycle does not fall, "
            "and grows from the first to the last.",
            OURS,
            more_regular,
            figures=("fig-11", "fig-12", "fig-13"),
        ),
        Claim(
            "period-1-ideal",
            "The ideal source at 6.5 Hz leads to a period-1 motion with one impact in every cycle.",
            said("period-1"),
            "I-C settles in period 1 (followed to 3000 s) with one impact in each cycle of the second half; "
            "four of five perturbed starts have one impact in each cycle.",
            OURS,
            period_one_ideal,
            figures=("fig-07", "fig-13"),
        ),
        Claim(
            "period-1-motor",
            "So does the motor of 6.5 Hz: one impact in every turn.",
            said("period-1"),
            "II-C has one impact in each turn of the second half: from rest, and from four of five perturbed "
            "starts.",
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
    mostly_so = [name for name in numbers["ensembles"] if commonest_regime(numbers, name) == "chaotic"]
    lines = [
        f"chaotic from rest between 150 and 300 s: {', '.join(runs) or 'none of the cases'}; still so when "
        f"followed to 3000 s: {', '.join(lasting) or 'none'}; from most perturbed starts: "
        f"{', '.join(mostly_so) or 'none'}",
        *(_neighbours(rows, law, c) for law in LAWS for c in DAMPINGS),
    ]
    rest = bool(runs) or any(row["starts"][0]["regime"] == "chaotic" for row in rows)
    over = bool(mostly_so) or any(row["regime"] == "chaotic" for row in rows)
    remark = "Case II is chaotic on its way to where it settles: neighbouring starts part." if rest else ""
    basis = (
        f"runs of 300 s over frequency, amplitude and damping, {len(REGIMES_NEARBY_STARTS)} starts each; "
        "chaotic ones are known by their statistics"
    )
    return Finding((holds(rest), holds(over)), tuple(lines), tuple(runs), remark, basis)


def _neighbours(rows: Sequence[Numbers], law: str, c: float) -> str:
    counts = counts_by_regime(rows, law, c)
    words = ", ".join(f"{count} {regime}" for regime, count in counts.items())
    where = [
        f"{regime} at {_listed(rows_of(rows, regime, law, c))}" for regime in IRREGULAR if regime in counts
    ]
    of = (
        f"amplitude by {law}, c = {c:g} N s/m, {sum(counts.values())} frequencies from 3 to 7 Hz, most of "
        f"{len(REGIMES_NEARBY_STARTS)} starts: {words}"
    )
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
    common = {commonest_regime(numbers, name) for name in PRINTED}
    struck = [name for name in PRINTED if numbers["runs"][name]["impacts"]]
    lines = tuple(_regime_line(numbers, name) for name in (*PRINTED, *EQUAL_FORCE))
    rest = there >= set(NAMED) and len(struck) < len(PRINTED)
    over = common >= set(NAMED) and any(mostly(numbers, name, is_silent) for name in PRINTED)
    missing = [regime for regime in NAMED if regime not in there]
    nearest = [_where_found(numbers["nearby"], regime) for regime in missing]
    everyone = "All three strike from rest." if len(struck) == len(PRINTED) else ""
    silent = [f"{count_of(numbers, name, is_silent)} in {name}" for name in PRINTED if _some(numbers, name)]
    if silent:
        everyone += f" A motion without impacts coexists: it is reached from {words_of(silent)}."
    runs = (*PRINTED, *EQUAL_FORCE)
    return Finding((holds(rest), holds(over)), (*lines, *nearest), runs, remark=everyone)


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
    """Periods from rest, and share of period-1 motions over the starts, for both sources."""
    sources = {"the source is ideal": PRINTED, "the source is the motor": MOTORS}
    lines = [
        f"from rest: {', '.join(f'{name} {_kind(_regime_from_rest(numbers, name))}' for name in names)}"
        for names in sources.values()
    ]
    lines += [
        "period 1 from "
        + ", ".join(f"{count_of(numbers, name, is_period_one)} starts in {name}" for name in names)
        for names in sources.values()
    ]
    return Finding(
        tuple(
            only_if({source: grows(numbers, names) for source, names in sources.items()})
            for grows in (_periods_fall, _grows_regular)
        ),
        tuple(lines),
        (*PRINTED, *MOTORS),
    )


def _regime_from_rest(numbers: Numbers, name: str) -> Numbers:
    regime: Numbers = numbers["runs"][name]["regime"]
    return regime


def _periods_fall(numbers: Numbers, names: Sequence[str]) -> bool:
    regimes = [_regime_from_rest(numbers, name) for name in names]
    periods = [regime["period"] or float("inf") for regime in regimes]
    return all(below >= above for below, above in pairwise(periods)) and periods[0] > periods[-1]


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
    settles = later["verdict"] == "periodic" and later["period"] == 1
    rest = holds(settles and _one_each(numbers, "I-C"))
    if later["verdict"] == "undecided":
        rest = ClaimVerdict(OPEN)
    return Finding((rest, holds(mostly(numbers, "I-C", one_impact))), lines, ("I-C",))


def period_one_motor(numbers: Numbers) -> Finding:
    """Impacts per turn in II-C: from rest, and of the ensemble."""
    count, total = how_many(numbers, "II-C", one_impact)
    counts = numbers["runs"]["II-C"]["cycles"].get("impact_counts") or {}
    lines = (
        f"from rest: {_kind(numbers['runs']['II-C']['regime'])}; one impact in {counts.get('1', 0)} of "
        f"{sum(counts.values())} turns",
        f"perturbed starts: one impact in each turn from {of_all(count, total)}",
    )
    others = "Other starts end in coexisting motions of longer period."
    remark = others if 0 < count < MOST * total else ""
    return Finding(
        (holds(_one_each(numbers, "II-C")), holds(count >= MOST * total)), lines, ("II-C",), remark=remark
    )


def one_impact(outcome: Numbers) -> bool:
    """Whether each cycle of the second half has one impact."""
    return bool(outcome.get("one_per_cycle"))


def _one_each(numbers: Numbers, name: str) -> bool:
    counts = numbers["runs"][name]["cycles"].get("impact_counts") or {}
    return set(counts) == {"1"}


def _from_rest(numbers: Numbers, name: str) -> str:
    return "yes, from rest" if _one_each(numbers, name) else "no, from rest"
