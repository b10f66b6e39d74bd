"""Claims on the models themselves: natural frequency, amplitudes, validity."""

from __future__ import annotations

from vibsim.reports.claim import FAILS, HOLDS, ONLY_IF, OPEN, Claim, Finding, Numbers
from vibsim.reports.paper_runs import MOTORS, PRINTED
from vibsim.reports.wording import between, mm

NATURAL_HZ = 4.1
ROUNDS = 0.05  # a number with one decimal
SAME_AMPLITUDE = 0.01  # relative


def models_claims() -> list[Claim]:
    """In the order of the paper."""
    return [
        Claim(
            "natural-frequency",
            "The natural frequency of the system is 4.1 Hz.",
            "text",
            "The free relative vibration of the blocks, stop open, has a frequency that rounds to 4.1 Hz, "
            "in Case I and in Case II.",
            natural_frequency,
        ),
        Claim(
            "amplitude",
            "The ideal source of Table 1 has the amplitude of Eq. (2.11), m3 e ω².",
            "Table 1, Eq. (2.11)",
            "Each amplitude of Table 1 is within 1 % of m3 e ω² with the m3 and e of Case II.",
            amplitude,
        ),
        Claim(
            "validity",
            "The motions shown are valid: block 1 never passes block 2.",
            "text",
            "x1 − x2 stays below the distance of the blocks at rest. The paper gives none, so each run says "
            "what it would need.",
            validity,
        ),
    ]


def natural_frequency(numbers: Numbers) -> Finding:
    """Of both cases, free-free; and of block 1 alone, which is where 4.1 Hz comes from."""
    facts = numbers["facts"]
    ideal, motor, held = facts["free_hz_I"], facts["free_hz_II"], facts["held_hz"]
    ways = (
        (held, f"block 2 is held and the motor not counted (√(k1/m1)/2π = {held:.3f} Hz)"),
        (motor, f"the blocks are free and m3 counts to block 1 ({motor:.3f} Hz)"),
        (ideal, f"the blocks are free, without the motor ({ideal:.3f} Hz)"),
    )
    conditions = [text for value, text in ways if _rounds_to_natural(value)]
    right = _rounds_to_natural(ideal) and _rounds_to_natural(motor)
    return Finding(
        HOLDS if right else ONLY_IF if conditions else FAILS,
        (
            f"free-free, Case I (m1, m2): {ideal:.3f} Hz; Case II (m1 + m3, m2): {motor:.3f} Hz",
            f"with the stop, in the limit of large vibrations (bilinear): Case I "
            f"{facts['bilinear_hz_I']:.2f} Hz, Case II {facts['bilinear_hz_II']:.2f} Hz",
        ),
        condition="" if right else "; or ".join(conditions),
        remark="It is not the frequency at which a motor is captured: see there.",
    )


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
        return Finding(HOLDS, lines)
    remark = (
        f"Eq. (2.11) demands {min(ratios):.0f} to {max(ratios):.0f} times as much. Table 1 is within "
        f"{100 * off:.1f} % of m3 e ω, prints m as the unit, and is used as N: unequal forces are compared."
    )
    return Finding(FAILS, lines, remark=remark)


def validity(numbers: Numbers) -> Finding:
    """The rest distance that the paper's runs need; for the others it is only told."""
    needed = {name: run["rest_distance_needed"] for name, run in numbers["runs"].items()}
    lines = tuple(f"{name}: {mm(value)}" for name, value in needed.items())
    shown = [needed[name] for name in (*PRINTED, *MOTORS)]
    if None in shown:
        return Finding(OPEN, lines, tuple(needed))
    span = between(1e3 * min(shown), 1e3 * max(shown), "mm")
    return Finding(
        ONLY_IF,
        lines,
        tuple(needed),
        condition=f"the blocks are at least {mm(max(shown))} apart at rest (the printed cases need {span})",
    )
