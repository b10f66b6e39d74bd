"""Claims on the motor: does it reach its speed, is it captured for good, and at which frequency."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from statistics import median

from vibsim.evidence.reports.claims import (
    IN_KIND,
    OPEN,
    OUR_MARGIN,
    OURS,
    Claim,
    ClaimVerdict,
    Finding,
    Numbers,
    between,
    capture_line,
    count_of,
    holds,
    hz,
    in_reading,
    is_brief_hold,
    is_captured,
    is_held,
    is_held_for_100,
    is_near_no_load,
    is_released_at_100,
    is_settled,
    members,
    mm,
    mostly,
    near_natural,
    of_all,
    percent,
    said,
    seconds,
    typeset,
    with_numbers,
    words_of,
)
from vibsim.evidence.reports.measurements import MOTORS

NEARLY_CAPTURED = 0.02  # of Omega0
TWICE = 0.02  # relative
DISTINCT = 0.03  # relative difference of two operating points
LITTLE = 5.0  # factor by which the amplitude must grow more than the speed

PRINTED, READINGS = ("II-B", "II-C"), ("II-B-captured", "II-C-escape")

EXPLANATION = (
    "In each hold the blocks vibrate at twice the speed of the motor and strike twice in a turn. What "
    "holds the motor is a superharmonic resonance: the turning mass drives, at half its frequency, the "
    "large vibration against the stop, and that has the bilinear frequency. 4.1 Hz belongs to a system "
    "without a stop."
)


def capture_claims() -> list[Claim]:
    """In the order of the paper."""
    return [
        Claim(
            "equilibria",
            "The motor reaches equilibrium, at another speed for each characteristic.",
            said("equilibrium"),
            "Each of II-A, II-B and II-C settles: the mean speed over 12 turns stays within 3 % up to the "
            "end, from rest and from four of five perturbed starts; their speeds (from starts: the medians) "
            "differ by more than 3 %.",
            OURS,
            equilibria,
            figures=("fig-04",),
        ),
        Claim(
            "one-speed",
            "Each characteristic determines the speed at which the motor settles.",
            said("determines a speed"),
            "Each motor settles from rest; and from all perturbed starts from which it settles it comes to "
            "one speed, to within 3 %.",
            OURS,
            one_speed,
            figures=("fig-04",),
        ),
        Claim(
            "power",
            "Near the resonance more power increases the amplitude, with little effect on the speed.",
            said("additional power"),
            "Over the last doubling of the power along the orbits held near half the bilinear frequency, up "
            "to where they end, the amplitude grows at least five times as much, relatively, as the speed; "
            "as printed and in the reading.",
            OURS,
            power,
            figures=("load-curves",),
        ),
        Claim(
            "II-A-speed",
            "II-A reaches nearly its no-load speed of 3.5 Hz.",
            said("steady state"),
            "The mean speed over the last turns is within 2 % of 3.5 Hz: from rest, and from four of five "
            "perturbed starts.",
            OURS,
            speed_of_a,
            figures=("fig-14",),
        ),
        Claim(
            "sommerfeld",
            "II-B and II-C show the Sommerfeld effect.",
            said("Sommerfeld"),
            "The weakest form of it: each motor lingers well below its no-load speed, at least 3 times as "
            "long as it would take to run up freely through ±3 %: from rest, and from four of five perturbed "
            "starts.",
            OURS,
            sommerfeld,
            figures=("fig-15", "fig-16"),
        ),
        Claim(
            "II-B-captured",
            "The motor of II-B is captured for good.",
            said("cannot escape", "cannot exceed"),
            "The hold lasts to the end of the run, well below the no-load speed: from rest, and from "
            "four of five perturbed starts.",
            OURS,
            b_captured,
            figures=("fig-15", "fig-15-reading"),
            pictures=("capture",),
        ),
        Claim(
            "capture-frequency",
            "The motors are captured at 4.1 Hz.",
            said("cannot escape", "initially captured"),
            "The mean speed during the hold of II-B and of II-C is within 0.1 Hz of 4.1 Hz: from rest, and "
            "from four of five perturbed starts.",
            OUR_MARGIN,
            capture_frequency,
            figures=("fig-15", "fig-16"),
            pictures=("capture",),
        ),
    ]


def equilibria(numbers: Numbers) -> Finding:
    """Final speeds of Case II."""
    captures = [numbers["runs"][name]["capture"] for name in MOTORS]
    finals = [capture["final_speed_hz"] for capture in captures]
    medians = [median(_settled_speeds(numbers, name) or [0.0]) for name in MOTORS]
    lines = tuple(
        f"{name}: {hz(final)}; perturbed starts: settled in {count_of(numbers, name, is_settled)}, median "
        f"{hz(middle)}"
        for name, final, middle in zip(MOTORS, finals, medians, strict=True)
    )
    rest = all(is_settled(capture) for capture in captures) and _distinct(finals)
    over = all(mostly(numbers, name, is_settled) for name in MOTORS) and _distinct(medians)
    return Finding((holds(rest), holds(over)), lines, MOTORS)


def _distinct(speeds: Sequence[float]) -> bool:
    return all(above > below * (1 + DISTINCT) for below, above in pairwise(speeds))


def _settled_speeds(numbers: Numbers, name: str) -> list[float]:
    """Final speeds of the perturbed starts from which a motor settles [Hz]."""
    outcomes = [each for each in members(numbers, name) if is_settled(each)]
    return [each["final_hz"] for each in outcomes if each["final_hz"] is not None]


def one_speed(numbers: Numbers) -> Finding:
    """Spread of the final speeds of each motor."""
    speeds = {name: _settled_speeds(numbers, name) for name in MOTORS}
    lines = [
        f"{name}: from rest {hz(numbers['runs'][name]['capture']['final_speed_hz'])}; from {len(each)} "
        f"perturbed starts that settle {between(min(each), max(each), 'Hz') if each else 'unknown'}"
        for name, each in speeds.items()
    ]
    several = [name for name, each in speeds.items() if each and max(each) > min(each) * (1 + DISTINCT)]
    rest = all(is_settled(numbers["runs"][name]["capture"]) for name in MOTORS)
    remark = (
        f"Several motions of {words_of(several)} coexist, each with its own mean speed: the start decides."
        if several
        else ""
    )
    return Finding((holds(rest), holds(not several)), tuple(lines), MOTORS, remark=remark)


def power(numbers: Numbers) -> Finding:
    """Relative growth of amplitude and speed over the last doubling of the power along held orbits."""
    lines, little = [], []
    for words in ("as printed", "the reading"):
        end = numbers["ends"][words]
        half = end["half"]
        if half is None:
            return Finding((ClaimVerdict(OPEN),), (f"{words}: no orbit takes half the power of the last",))
        faster, wider = (end[key] / half[key] - 1 for key in ("speed_hz", "amplitude"))
        little.append(wider >= LITTLE * faster)
        lines.append(
            f"{words}: from {_power(half)} to {_power(end)} the amplitude grows by {percent(wider)}, from "
            f"{mm(half['amplitude'])} to {mm(end['amplitude'])}, the speed by {100 * faster:.1f} %, from "
            f"{half['speed_hz']:.3f} to {end['speed_hz']:.3f} Hz (no-load speed {half['no_load_hz']:.2f} to "
            f"{end['no_load_hz']:.2f} Hz)"
        )
    basis = "orbits followed over the no-load speed; no run enters, and no start"
    return Finding((holds(all(little)),), tuple(lines), basis=basis)


def _power(point: Numbers) -> str:
    return f"{1e3 * point['power']:.3g} mW"


def sommerfeld(numbers: Numbers) -> Finding:
    """Holds of any strength in II-B and II-C, and in the readings."""
    names = (*PRINTED, *READINGS)
    lines = tuple(
        f"{name}: {_lingering(numbers, name)}; perturbed starts: lingers in "
        f"{count_of(numbers, name, is_held)}"
        for name in names
    )
    rest = {name: is_held(numbers["runs"][name]["capture"]) for name in names}
    starts = {name: mostly(numbers, name, is_held) for name in names}
    shows = [name for name in PRINTED if rest[name] and starts[name]]
    remark = f"As printed {words_of(shows)} does so." if len(shows) == 1 else ""
    return Finding(tuple(_of_both(numbers, each) for each in (rest, starts)), lines, names, remark=remark)


def _of_both(numbers: Numbers, true: Mapping[str, bool]) -> ClaimVerdict:
    """The verdict on a claim about II-B and II-C: as printed, or in the readings."""
    both = [all(true[name] for name in pair) for pair in (PRINTED, READINGS)]
    return with_numbers(both, in_reading(numbers, READINGS[0]))


def _lingering(numbers: Numbers, name: str) -> str:
    capture = numbers["runs"][name]["capture"]
    return f"from rest {capture['verdict']}, {'' if is_held(capture) else 'not '}held on the way"


def speed_of_a(numbers: Numbers) -> Finding:
    """Final speed of II-A."""
    capture = numbers["runs"]["II-A"]["capture"]
    no_load = capture["no_load_speed_hz"]

    def near(speed_hz: float | None) -> bool:
        return speed_hz is not None and abs(speed_hz / no_load - 1) <= NEARLY_CAPTURED

    def ends_near(outcome: Numbers) -> bool:
        return near(outcome.get("final_hz"))

    line = (
        f"{hz(capture['final_speed_hz'])}, {100 * capture['final_speed_hz'] / no_load:.1f} % of the no-load "
        f"speed; perturbed starts: within 2 % in {count_of(numbers, 'II-A', ends_near)}"
    )
    rest, over = near(capture["final_speed_hz"]), mostly(numbers, "II-A", ends_near)
    return Finding((holds(rest), holds(over)), (line,), ("II-A",))


def b_captured(numbers: Numbers) -> Finding:
    """II-B as printed, and in the reading."""
    names = (PRINTED[0], READINGS[0])
    changed = in_reading(numbers, READINGS[0])
    lines = [
        f"{capture_line(numbers, name)}; perturbed starts: captured in {count_of(numbers, name, is_captured)}"
        for name in names
    ]
    rest = [is_captured(numbers["runs"][name]["capture"]) for name in names]
    over = [mostly(numbers, name, is_captured) for name in names]
    others = _single_changes(numbers)
    return Finding(
        (with_numbers(rest, changed), with_numbers(over, changed)),
        (*lines, f"single changes from which it is captured as well: {others}") if others else tuple(lines),
        names,
        remark="Many other numbers do it: those above are one example." if others else "",
    )


def _single_changes(numbers: Numbers) -> str:
    """Readings of one number under which II-B is captured for good from four of five starts."""
    captured = [(row, row["statements"][0]) for row in numbers["search"]["readings"]["ranking"]]
    return ", ".join(
        typeset(f"{key.rpartition('.')[2]} = {value} ({of_all(share['count'], share['of'])} starts)")
        for row, share in captured
        if len(row["changes"]) == 1 and share["holds"]
        for key, value in row["changes"].items()
    )


def capture_frequency(numbers: Numbers) -> Finding:
    """Speed during the holds, beside the relative vibration and half the bilinear frequency."""
    names = (*PRINTED, *READINGS)
    speeds = {name: numbers["runs"][name]["capture"]["speed_hz"] for name in names}
    held = [name for name in names if speeds[name] is not None]
    near = {name: near_natural(speeds[name]) for name in names}
    near_from_starts = {name: mostly(numbers, name, _held_near_natural) for name in names}
    counts = ", ".join(f"{name} {count_of(numbers, name, _held_near_natural)}" for name in names)
    lines = [_frequency_line(numbers, name) for name in held]
    return Finding(
        (_of_both(numbers, near) if held else ClaimVerdict(OPEN), _of_both(numbers, near_from_starts)),
        (
            *lines,
            f"perturbed starts held within 0.1 Hz of 4.1 Hz: {counts}",
            _without_stop(numbers),
            _with_gaps(numbers),
        ),
        names,
        remark=EXPLANATION if held and all(_is_twice(numbers, name) for name in held) else "",
    )


def _held_near_natural(outcome: Numbers) -> bool:
    return near_natural(outcome.get("speed_hz"))


def _with_gaps(numbers: Numbers) -> str:
    """From which gap on II-B is held at 4.0 Hz, and how often it strikes then."""
    rows = numbers["gaps"]
    tried = (
        f"gaps from {rows[0]['gap_mm']:g} to {rows[-1]['gap_mm']:g} mm, {len(rows)} values, II-B from rest"
    )
    wide = [row for row in rows if row["speed_hz"] is not None and near_natural(row["speed_hz"])]
    if not wide:
        return f"{tried}: held at 4.0 to 4.2 Hz with none"
    first = wide[0]
    strikes = [row for row in rows if row["impacts_per_turn"]]
    widest = f"; the widest that is struck in the end has {strikes[-1]['gap_mm']:g} mm" if strikes else ""
    count = f"{first['impacts_per_turn']:.3g} impacts a turn" if first["impacts_per_turn"] else "no impacts"
    return (
        f"{tried}: held at 4.0 to 4.2 Hz from {first['gap_mm']:g} mm on, at {hz(first['speed_hz'])} with "
        f"{count} in the end{widest}"
    )


def _frequency_line(numbers: Numbers, name: str) -> str:
    run, ratio = numbers["runs"][name], _ratio(numbers, name)
    near = run["capture"]["resonance"]
    resonance = f", {near['name']} {hz(near['hz'])}" if near else ""
    speed = f"{name}: held at {hz(run['capture']['speed_hz'])}{resonance}"
    if ratio is None:
        return speed
    vibration = hz(run["held"]["lines"][0]["hz"])
    return f"{speed}; strongest line of x1 − x2 {vibration}, {ratio:.3f} times the speed"


def _ratio(numbers: Numbers, name: str) -> float | None:
    """Strongest line of x1 - x2 during the hold, over the speed of the motor."""
    run = numbers["runs"][name]
    lines = run.get("held", {}).get("lines") or []
    return lines[0]["hz"] / run["capture"]["speed_hz"] if lines else None


def _is_twice(numbers: Numbers, name: str) -> bool:
    ratio = _ratio(numbers, name)
    return ratio is not None and abs(ratio / 2 - 1) <= TWICE


def _without_stop(numbers: Numbers) -> str:
    """End of the motors where the blocks never touch, in words."""
    captures = {name: numbers["without_stop"][name]["capture"] for name in PRINTED}
    return "without the stop: " + ", ".join(
        f"{name} {capture['verdict']} at {hz(capture['speed_hz'])}" for name, capture in captures.items()
    )


# Claims on II-C: captured for a while, then away, and what block 2 does meanwhile.
#
# What follows the escape depends on the start: the motion from rest, the paper's or the one here, shows one
# of many ends.


JUMPED_HZ = (6.0, 6.4)  # 6.2 to either side
THROWN_BACK_HZ = 4.1  # a final speed below the resonance
ABOUT_170 = (150.0, 190.0)  # [s]
FALLEN = 0.1  # of the peak, at the end

PRINTED_C, READING_C = "II-C", "II-C-escape"


def escape_claims() -> list[Claim]:
    """In the order of the paper."""
    return [
        Claim(
            "II-C-escapes",
            "The motor of II-C is captured, gets away after about 100 s and jumps to 6.2 Hz.",
            said("initially captured", "jumps"),
            "Held and let go, either 67 to 150 s after the start or after a hold of 67 to 150 s (the words "
            "allow both), and in the end at 6.0 to 6.4 Hz: from rest, and from four of five perturbed starts "
            "(by the median of their final speeds).",
            OUR_MARGIN,
            c_escapes,
            figures=("fig-16", "fig-16-reading"),
            pictures=("capture",),
        ),
        Claim(
            "II-C-speed",
            "The motor of II-C reaches its angular velocity constant.",
            said("reaches constant"),
            "The mean speed over the last turns is within 2 % of 6.5 Hz: from rest, and from four of five "
            "perturbed starts.",
            OUR_MARGIN,
            c_speed,
            figures=("fig-16",),
        ),
        Claim(
            "II-C-displacement",
            "The displacement of II-C rises until about 170 s, then falls.",
            said("until 170 s"),
            "x2, averaged over 5 s, is greatest between 150 and 190 s, and 10 % or more lower at the end: "
            "from rest (in kind: greatest at another time), and from four of five perturbed starts.",
            OUR_MARGIN,
            c_displacement,
            figures=("fig-10", "fig-10-reading"),
        ),
    ]


def c_escapes(numbers: Numbers) -> Finding:
    """II-C as printed, and in the reading."""
    changed = in_reading(numbers, READING_C)
    rest, over = (
        [escapes(numbers, name) for name in (PRINTED_C, READING_C)] for escapes in (_from_rest, _from_starts)
    )
    return Finding(
        (with_numbers(rest, changed), with_numbers(over, changed)),
        tuple(line for name in (PRINTED_C, READING_C) for line in _escape_lines(numbers, name)),
        (PRINTED_C, READING_C),
        remark=_jumped(numbers) + _in_trust(numbers["runs"][READING_C]),
    )


def _escape_lines(numbers: Numbers, name: str) -> tuple[str, str]:
    at, lasting = (count_of(numbers, name, true_of) for true_of in (is_released_at_100, is_held_for_100))
    return (
        capture_line(numbers, name),
        f"{name}, perturbed starts: let go 67 to 150 s after the start in {at}, after a hold of 67 to 150 s "
        f"in {lasting}",
    )


def _from_rest(numbers: Numbers, name: str) -> bool:
    capture = numbers["runs"][name]["capture"]
    return is_brief_hold(capture) and _has_jumped(capture["final_speed_hz"])


def _from_starts(numbers: Numbers, name: str) -> bool:
    finals = _final_speeds(numbers, name)
    return bool(finals) and mostly(numbers, name, is_brief_hold) and _has_jumped(median(finals))


def _has_jumped(speed_hz: float | None) -> bool:
    return speed_hz is not None and JUMPED_HZ[0] <= speed_hz <= JUMPED_HZ[1]


def _final_speeds(numbers: Numbers, name: str) -> list[float]:
    """Final speeds of the perturbed starts that are held and let go after about 100 s [Hz]."""
    outcomes = numbers["ensembles"][name]["outcomes"]
    finals = [outcome["final_hz"] for outcome in outcomes if is_brief_hold(outcome)]
    return [final for final in finals if final is not None]


def _jumped(numbers: Numbers) -> str:
    """Ends of the perturbed starts of the reading, in words."""
    finals = _final_speeds(numbers, READING_C)
    if not finals:
        return ""
    slow = sum(final < THROWN_BACK_HZ for final in finals)
    rest = f"; in {slow} the rotor is thrown back and has not run up again at 300 s" if slow else ""
    middle = hz(median(finals))
    return f"{len(finals)} perturbed starts are let go in time: median of their final speeds {middle}{rest}."


def _in_trust(run: Numbers) -> str:
    """Whether an escape is among what the run is right about."""
    until, horizon = run["capture"]["until"], run["trust_horizon"]
    within = until is not None and horizon is not None and until <= horizon
    return " From rest, capture and escape lie within the trust horizon." if within else ""


def c_speed(numbers: Numbers) -> Finding:
    """Final speed of II-C against its no-load speed."""
    final = numbers["runs"][PRINTED_C]["capture"]["final_speed_hz"]
    finals = [each["final_hz"] for each in members(numbers, PRINTED_C) if each.get("final_hz") is not None]
    starts = f"median {hz(median(finals))}, {min(finals):.2f} to {max(finals):.2f} Hz" if finals else "none"
    rest, over = is_near_no_load(final), mostly(numbers, PRINTED_C, _ends_at_no_load)
    within = count_of(numbers, PRINTED_C, _ends_at_no_load)
    lines = (
        f"{PRINTED_C} from rest: {hz(final)}",
        f"perturbed starts: {starts}, within 2 % of 6.5 Hz in {within}",
    )
    remark = (
        "The motor bears the load of the vibration and settles 2 to 4 % lower. The next paragraph of the "
        "paper has 6.2 Hz for the same motor, 4.6 % below its constant: that is nearer."
    )
    return Finding((holds(rest), holds(over)), lines, (PRINTED_C,), remark="" if rest and over else remark)


def _ends_at_no_load(outcome: Numbers) -> bool:
    return is_near_no_load(outcome.get("final_hz"))


def c_displacement(numbers: Numbers) -> Finding:
    """Peak of x2 in II-C as printed and in the reading."""
    names = (PRINTED_C, READING_C)
    changed = in_reading(numbers, READING_C)
    over = [mostly(numbers, name, peaks_late) for name in names]
    counts = " and ".join(f"{name} in {count_of(numbers, name, peaks_late)}" for name in names)
    some = any(peaks_late(each) for name in names for each in numbers["ensembles"][name]["outcomes"])
    rest = _peak_from_rest([numbers["runs"][name] for name in names], changed)
    return Finding(
        (rest, with_numbers(over, changed)),
        (*(_peak_line(numbers, name) for name in names), f"so from perturbed starts: {counts}"),
        names,
        remark=CHANCE if some and not over[0] else "",
    )


def _peak_from_rest(runs: Sequence[Numbers], changed: str) -> ClaimVerdict:
    """As printed and in the reading; in kind where x2 rises and falls, but not then."""
    printed, reading = runs
    peak = printed["peak"]
    if not peaks_late(printed) and peak["height"] > 0 and _has_fallen(peak):
        example = f"; at {seconds(reading['peak']['time'])} with {changed}" if peaks_late(reading) else ""
        return ClaimVerdict(IN_KIND, f"with the peak at {seconds(peak['time'])}{example}")
    return with_numbers([peaks_late(run) for run in runs], changed)


def _has_fallen(peak: Numbers) -> bool:
    """Whether x2 is lower at the end than at its peak, by more than FALLEN."""
    return bool(peak["end"] <= (1 - FALLEN) * peak["height"])


CHANCE = (
    "The motion ends in one of several coexisting motions: some drift back, some on. Another start than "
    "rest, or a coarse solver, may well do as the paper shows."
)


def peaks_late(outcome: Numbers) -> bool:
    """Whether x2 is greatest at about 170 s, and lower at the end."""
    if "peak" not in outcome:
        return False
    peak = outcome["peak"]
    return bool(ABOUT_170[0] <= peak["time"] <= ABOUT_170[1]) and _has_fallen(peak)


def _peak_line(numbers: Numbers, name: str) -> str:
    peak = numbers["runs"][name]["peak"]
    top = f"{name} from rest: greatest, {mm(peak['height'])}, at {seconds(peak['time'])}"
    return f"{top}; {mm(peak['end'])} at the end"
