"""Claims on the models themselves: natural frequency, equal forces, motion without impacts."""

from __future__ import annotations

from vibsim.evidence.reports.claims.claim import (
    ONLY_IF,
    OUR_MARGIN,
    OURS,
    PAPERS,
    Claim,
    Finding,
    Numbers,
    Verdict,
    holds,
)
from vibsim.evidence.reports.claims.evidence import members
from vibsim.evidence.reports.claims.of_capture import is_captured
from vibsim.evidence.reports.quotes import said
from vibsim.evidence.reports.wording import hz, of_all

NATURAL_HZ = 4.1
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
    verdict = Verdict(ONLY_IF, held_way) if _rounds_to_natural(held) else holds(False)
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
