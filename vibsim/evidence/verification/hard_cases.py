"""The hard cases against their stored truths: states at several instants, and every event."""

from collections.abc import Iterator
from dataclasses import replace
from decimal import Decimal
from fractions import Fraction
from functools import partial
from math import atan, atan2, isfinite, pi, sqrt, ulp
from typing import Any

import numpy as np

from vibsim.cases import hard_case_names, load_case
from vibsim.cases.problems import counted
from vibsim.evidence.verification.checks import (
    BOTH,
    REASON,
    SCENE_UNITS,
    STATE_UNITS,
    UNIT,
    Check,
    CheckPoint,
    CheckRow,
    Event,
    Matching,
    StoredTruth,
    bare_run,
    compared,
    counted_row,
    flows_of,
    match_events,
    named_case,
    number_row,
    outside,
    reach,
    read_truth,
    relative_rounding,
    roundings,
    run,
    time_rounding,
    worst_row,
)
from vibsim.evidence.verification.impact_orbits import rest_bound
from vibsim.evidence.verification.vibrations import (
    FREE_RATE,
    K1,
    M1,
    conditioning,
    contact_begin,
    contacts,
    energy,
    impedance,
    relative_displacement,
)
from vibsim.physics.parts import EVENT_KINDS, EVENT_NAMES
from vibsim.results import Result

PERIODIC = "hard/a-million-seconds"  # judged in million_seconds
CLOSED_FORMS = ("hard/a-million-seconds-linear", "hard/tiny-amplitude", "hard/conservative")
# of named parts: judged in reported_failures and spool
REPORTED = (
    "hard/spool-between-stops",
    "hard/zeno-ball",
    "hard/pressed-on-a-stop",
    "hard/held-by-friction",
    "hard/touch-within-a-step",
)
# the largest stray of eight kicked runs lies below half its standard deviation once in 2,000 sets
LUCK = 2.0
TELLING = 1e-2  # of the motion: where the bound is wider, chaos has taken over and nothing is compared
UNITS = {"x1": "m", "x2": "m", "v1": "m/s", "v2": "m/s", "phi": "rad", "phidot": "rad/s"}
BECAUSE = "twice the stray of runs of 30 digits that are kicked as doubles round"


def hard_case_checks() -> list[Check]:
    """One check per case and flow."""
    return [
        Check(f"{name}/{flow}", case.title, partial(hard_case_rows, name, flow))
        for name, case in ((name, load_case(name)) for name in judged_names())
        for flow in flows_of(case)
    ]


def judged_names() -> list[str]:
    """Names of the hard cases that are judged here."""
    return [name for name in hard_case_names() if name not in (PERIODIC, *CLOSED_FORMS, *REPORTED)]


def hard_case_rows(name: str, flow: str) -> Iterator[CheckRow]:
    """States and events of a hard case against its truth."""
    case = load_case(name)
    truth = read_truth(name, case.sha256)
    result = run(case, flow)
    yield worst_row(f"{name}/{flow}", hard_state_points(truth, result, flow), BECAUSE)
    yield event_row(f"{name}/{flow}", truth, result, flow)


def hard_state_points(truth: StoredTruth, result: Result, flow: str) -> Iterator[CheckPoint]:
    """Every stored state that rounding leaves something of."""
    at = np.searchsorted(result.time, truth.time)
    sizes: dict[str, float] = {}
    for name, column in truth.states.items():
        sizes[UNITS[name]] = max(sizes.get(UNITS[name], 0.0), *(float(abs(value)) for value in column))
    for name, column in truth.states.items():
        size = sizes[UNITS[name]]
        values = result[name][at].tolist()
        for t, value, expected, stray in zip(
            truth.time, values, column, truth.stray[flow][name], strict=True
        ):
            bound = LUCK * stray + 2.0**-53 * float(abs(expected))
            if bound <= TELLING * size:
                yield compared(
                    f"{name} at {t:g} s",
                    float(expected),
                    value,
                    bound,
                    UNITS[name],
                    distance(value, expected),
                )


def distance(value: float, expected: Decimal) -> float:
    """Distance of a double from a decimal, not rounded before the subtraction."""
    return float(abs(Decimal(value) - expected)) if isfinite(value) else value


def event_row(name: str, truth: StoredTruth, result: Result, flow: str) -> CheckRow:
    """All events: the one that comes nearest to its bound, or how many are missed or spurious."""
    events = outside(events_of(result), truth.undecided)
    matching = match_events(truth.events, reach(truth.events), events)
    points = [
        event_point(truth.events[i], events[j], LUCK * truth.event_stray[flow][i]) for i, j in matching.pairs
    ]
    wrong = len(matching.missed) + len(matching.spurious)
    shown, because = compared("events", 0.0, wrong, 0.0), "every event once"
    if points and not wrong:
        shown, because = max(points, key=lambda point: point.share), BECAUSE
    return CheckRow(
        name,
        shown.what if shown.what == "events" else f"events, {shown.what}",
        f"{counted(len(truth.events), 'event')}{_open(len(truth.undecided))}",
        f"{counted(len(events), 'event')}{_flaws(matching)}, {certificate(result)}",
        shown.error,
        shown.bound,
        shown.unit,
        because,
        tuple(points),
    )


def event_point(truth: Event, event: Event, bound: float) -> CheckPoint:
    """The time of one event, which lies on the grid of doubles."""
    kind, t = truth
    late = float(abs(event[1] - t))
    what = f"{kind} at {t:.6g} s"
    return compared(what, float(t), float(event[1]), bound + ulp(float(t)), "s", late)


def _flaws(matching: Matching) -> str:
    missed, spurious = len(matching.missed), len(matching.spurious)
    return f", {missed} missed, {spurious} spurious" if missed or spurious else ""


def _open(touches: int) -> str:
    return f", {counted(touches, 'touch')} open" if touches else ""


def certificate(result: Result) -> str:
    """Certificate of the event search of a run, in words."""
    uncertified = int(result.attrs["uncertified"])
    return "certified" if uncertified == 0 else f"{counted(uncertified, 'stretch')} in doubt"


def events_of(result: Result) -> list[Event]:
    """Kind and time of every event of a run, without start and end."""
    kinds, times = result.events["kind"].tolist(), result.events["t"].tolist()
    return [(EVENT_NAMES[kind], Decimal(t)) for kind, t in zip(kinds, times, strict=True)][1:-1]


# The hard cases whose truth is a closed form: a linear vibration, tiny amplitudes, impacts without loss.


LINEAR, TINY, CONSERVATIVE = "hard/a-million-seconds-linear", "hard/tiny-amplitude", "hard/conservative"
SHORTER = "1e5 s"  # what the Taylor flow does of LINEAR: three steps a period
SUBNORMAL = 2.0**-1040  # an amplitude with 34 bits left [m]
LAST_PLACE = 2.0**-1074  # of a subnormal number
CONSTANT = 1e-12  # of the energy: so far it may be off over 100,000 cycles


def closed_form_checks() -> list[Check]:
    """The three cases by both flows."""
    makers = (
        (LINEAR, linear, "A linear vibration for a million seconds"),
        (TINY, tiny, "Impacts of 1e-307 m, and of subnormal ones"),
        (CONSERVATIVE, conservative, "Impacts without loss, 100,000 cycles"),
    )
    return [
        Check(f"{name}/{flow}", title, partial(rows, flow)) for name, rows, title in makers for flow in BOTH
    ]


def linear(flow: str) -> Iterator[CheckRow]:
    """The steady state, its phase taken from the exact fraction 5.3 t of turns."""
    case = load_case(LINEAR, {"run.t_end": SHORTER} if flow == "taylor" else {})
    result = bare_run(case.two_blocks(), flow)
    omega, c, force = 2 * pi * 5.3, 0.3, 0.5
    size, lag = force / impedance(omega, c), atan2(c * omega, K1 - M1 * omega**2)
    bound = size * relative_rounding(result, conditioning(omega, c), memory=2 * M1 / c)
    points = []
    for i in range(1, len(result)):
        turns = Fraction("5.3") * Fraction(float(result.time[i])) % 1
        angle = 2 * pi * float(turns) - lag
        at = f"{result.time[i]:.9g} s"
        x, v = float(result["x1"][i]), float(result["v1"][i])
        points.append(compared(f"x1 at {at}", size * np.sin(angle), x, bound, "m"))
        points.append(compared(f"v1 at {at}", omega * size * np.cos(angle), v, omega * bound, "m/s"))
    yield worst_row(f"{LINEAR}/{flow}", points, REASON)


def tiny(flow: str) -> Iterator[CheckRow]:
    """The amplitude of the case, and a subnormal one, which no case file may have."""
    scene = load_case(TINY).two_blocks()
    for amplitude in (scene.x1, SUBNORMAL):
        result = bare_run(replace(scene, x1=amplitude), flow)
        yield from tiny_rows(f"{TINY}/{flow}", result, amplitude)


def tiny_rows(name: str, result: Result, size: float) -> Iterator[CheckRow]:
    """Displacements and contacts of a bilinear oscillator released from x1 = `size` [m]."""
    t, y = result.time, result["x1"] - result["x2"]
    expected = size * relative_displacement(t)
    coarse = LAST_PLACE * STATE_UNITS * roundings(result)
    points = [
        compared(
            f"x1 - x2 of {size:.2g} m at {t[i]:g} s",
            expected[i],
            y[i],
            size * relative_rounding(result, FREE_RATE * t[i]) + coarse,
            "m",
        )
        for i in range(0, len(t), 10)
    ]
    yield worst_row(name, points, f"{REASON}; no finer than 2^-1074 m")
    count = contacts(result.t_reached)
    yield counted_row(name, f"impacts of {size:.2g} m", count, result.attrs["impacts"], "one in each period")


def conservative(flow: str) -> Iterator[CheckRow]:
    """Contacts, the time of the last one, and the energy."""
    name = f"{CONSERVATIVE}/{flow}"
    result = bare_run(load_case(CONSERVATIVE).two_blocks(), flow)
    count = contacts(result.t_reached)
    begins = result.events["t"][result.events["kind"] == 1]
    yield counted_row(name, "impacts", count, len(begins), "one in each period")
    expected = contact_begin(len(begins))
    bound = time_rounding(result, expected, rate=FREE_RATE)
    yield number_row(name, compared("last impact", expected, float(begins[-1]), bound, "s"), REASON)
    values = energy(result)
    far = int(np.argmax(np.abs(values - values[0])))
    share, because = energy_bound(result)
    point = compared(f"energy at {result.time[far]:g} s", values[0], values[far], share * values[0], "J")
    yield number_row(name, point, because)


def energy_bound(result: Result) -> tuple[float, str]:
    """By what part the energy may be off, and why.

    1e-12 is demanded of the closed form, which rounds at events only. The Taylor flow rounds at every step,
    800,000 times in all; kicks of random sign add up as the square root of their number.
    """
    if result.attrs["method"] == "closed_form":
        return CONSTANT, "demanded: 1e-12 over 100,000 cycles"
    walk = 2 * STATE_UNITS * UNIT * sqrt(roundings(result))
    return LUCK * walk, "twice the random walk of 16 units per event and step; energy is quadratic"


# hard/a-million-seconds: impacts, periodic from early on, so that the truth of one period is that of all.


PERIOD = 8.0  # of the force [s]
SETTLED = 1600.0  # errors fall by exp(-c 8 s / (2 m1)) = 0.2 in each period: to 1e-139 in 200 of them


def million_seconds_checks() -> list[Check]:
    """The case by both flows."""
    case = load_case(PERIODIC)
    return [Check(f"{PERIODIC}/{flow}", case.title, partial(rows, flow)) for flow in flows_of(case)]


def rows(flow: str) -> Iterator[CheckRow]:
    """States and events of all settled periods."""
    name = f"{PERIODIC}/{flow}"
    case = load_case(PERIODIC)
    truth = read_truth(PERIODIC, case.sha256)
    result = bare_run(case.two_blocks(), flow)
    yield worst_row(name, million_state_points(truth, result, flow), BECAUSE)
    yield from event_rows(name, truth, result, flow)


def million_state_points(truth: StoredTruth, result: Result, flow: str) -> Iterator[Any]:
    """Every settled sample against the truth at its phase."""
    phases = {t: i for i, t in enumerate(truth.time)}
    for k in np.flatnonzero(result.time >= SETTLED):
        t = float(result.time[k])
        i = phases[t % PERIOD]
        for column, values in truth.states.items():
            value, bound = float(result[column][k]), LUCK * truth.stray[flow][column][i]
            yield compared(
                f"{column} at {t:g} s",
                float(values[i]),
                value,
                bound + 2.0**-53 * abs(value),
                UNITS[column],
                distance(value, values[i]),
            )


def event_rows(name: str, truth: StoredTruth, result: Result, flow: str) -> Iterator[CheckRow]:
    """Number of the settled events, and how far they are from where the period has them."""
    kinds, times = result.events["kind"][1:-1], result.events["t"][1:-1]
    late, each = times >= SETTLED, len(truth.events)
    expected = round((result.time[-1] - SETTLED) / PERIOD) * each
    what = f"settled events ({certificate(result)})"
    yield counted_row(name, what, expected, int(late.sum()), "all periods are alike")
    if late.sum() != expected:
        return
    known = [EVENT_KINDS[kind] for kind, _ in truth.events]
    wrong = int(np.count_nonzero(kinds[late].reshape(-1, each) != known))
    yield counted_row(name, "events of another kind", 0, wrong, "all periods are alike")
    phases = np.fmod(times[late], PERIOD).reshape(-1, each)
    points = []
    for i, (kind, t) in enumerate(truth.events):
        far = phases[np.argmax(np.abs(phases[:, i] - float(t))), i]
        bound = LUCK * truth.event_stray[flow][i] + ulp(result.t_reached)
        points.append(compared(f"{kind} within a period", float(t), float(far), bound, "s"))
    yield worst_row(name, points, f"{BECAUSE}; the grid of time is 1.2e-10 s at the end")


# Hard cases that others report as failures, with truths in closed form; docs/what-others-do.md names them.
#
# A ball that rests after infinitely many bounces, a mass pressed on a stop, a body held by friction against
# its weight, and a contact within one smooth flight.


ZENO, PRESSED = "hard/zeno-ball", "hard/pressed-on-a-stop"
HELD, TOUCH = "hard/held-by-friction", "hard/touch-within-a-step"
METHODS = ("auto", "taylor")


def reported_failures_checks() -> list[Check]:
    """The four cases by both methods."""
    makers = ((ZENO, zeno), (PRESSED, pressed), (HELD, held), (TOUCH, touch))
    return [
        Check(f"{name}/{how}", load_case(name).title, partial(rows, how))
        for name, rows in makers
        for how in METHODS
    ]


def times(result: Result, kind: str) -> np.ndarray:
    """Times of the events of a kind [s]."""
    return np.asarray(result.events["t"][result.events["kind"] == EVENT_KINDS[kind]])


def stays(result: Result, column: str, since: float, place: float) -> CheckPoint:
    """Distance of the body from `place` [m] after `since` [s]: not one bit."""
    values = result[column][result.time > since]
    far = float(values[np.argmax(np.abs(values - place))])
    return compared("place after that", place, far, 0.0, "m")


def zeno(method: str) -> Iterator[CheckRow]:
    """Rest after sqrt(2 h / g) (1 + e) / (1 - e), never below the floor, and on it for ever."""
    name, end = f"{ZENO}/{method}", sqrt(2 / 9.81) * 1.7 / 0.3
    result = run(load_case(ZENO), method)
    rested = times(result, "rest_begin")
    yield counted_row(name, "times that it comes to rest", 1, len(rested), "once, and for ever")
    fall, first = sqrt(2 / 9.81), float(times(result, "impact")[0])
    bound = UNIT * (SCENE_UNITS + STATE_UNITS) * fall + ulp(fall)
    yield number_row(name, compared("first impact", fall, first, bound, "s"), REASON)
    point = compared("rest", end, float(rested[0]), rest_bound(result, end, 0.7), "s")
    yield number_row(name, point, "grid of t and 16 units of speed per impact, and what was cut off")
    yield number_row(name, stays(result, "x_ball", end, 0.0), "it stays on the floor, to the last bit")
    lowest = float(result["x_ball"].min())
    below = compared("depth below the floor", 0.0, max(0.0, -lowest), STATE_UNITS * UNIT, "m")
    yield number_row(name, below, "16 units of the height of 1 m")


def pressed(method: str) -> Iterator[CheckRow]:
    """With (5 - 1) N on 1 kg it is at the stop after sqrt(2 / 4) s, where nothing more happens."""
    name, end = f"{PRESSED}/{method}", sqrt(0.5)
    result = run(load_case(PRESSED), method)
    impact = float(times(result, "impact")[0])
    yield number_row(name, compared("impact", end, impact, time_rounding(result, end, 2), "s"), REASON)
    kinds = sorted(result.events["kind"][1:-1].tolist())
    expected = sorted(EVENT_KINDS[kind] for kind in ("impact", "rest_begin", "stick_begin"))
    wrong = int(kinds != expected)
    yield counted_row(name, "events but one impact, rest and stick", 0, wrong, "it is pressed on and stays")
    yield number_row(name, stays(result, "x_mass", end, 1.0), "it stays, to the last bit")


def held(method: str) -> Iterator[CheckRow]:
    """Slip stops after v m / (2 mu N - W), on half of v times that; then it hangs."""
    name, load = f"{HELD}/{method}", 2 * 0.7 * 12 - 0.44145
    end = 0.1 * 0.045 / load
    result = run(load_case(HELD), method)
    stuck = float(times(result, "stick_begin")[0])
    yield number_row(name, compared("stick", end, stuck, time_rounding(result, end, 4, 1 / end), "s"), REASON)
    way, last = -0.1 * end / 2, float(result["x_capsule"][-1])
    bound = abs(way) * UNIT * (SCENE_UNITS * 5 + STATE_UNITS * 3)
    yield number_row(name, compared("place after 1000 s", way, last, bound, "m"), REASON)
    moved = float(np.ptp(result["x_capsule"][result.time > end]))
    yield number_row(name, compared("creep in 1000 s", 0.0, moved, 0.0, "m"), "it stays, to the last bit")
    slips = len(times(result, "stick_end"))
    yield counted_row(name, "slips after that", 0, slips, "the limit is 38 times the weight")


def touch(method: str) -> Iterator[CheckRow]:
    """Contacts by which the flight, 5 m high, goes too far by 10^-2 to 10^-12 m; begin and end of each."""
    name, missed = f"{TOUCH}/{method}", 0
    points: list[CheckPoint] = []
    for k in range(2, 13):
        result = run(named_case(TOUCH, stops__spring__gap=5 - 10.0**-k), method)
        begins, ends = times(result, "contact_begin"), times(result, "contact_end")
        missed += int((len(begins), len(ends)) != (1, 1))
        points += touch_points(result, k, begins[:1], ends[:1])
    yield counted_row(name, "contacts missed or invented", 0, missed, "11 flights with one contact each")
    yield worst_row(name, points, "rounding of a height of 5 m over the speed at contact")


def touch_points(result: Result, k: int, begins: np.ndarray, ends: np.ndarray) -> Iterator[CheckPoint]:
    """The ball meets the spring at w = sqrt(2 g d), and is back after 2 / q atan(q w / g), q^2 = k / m.

    d is 5 m less the gap, as doubles have it, exactly.
    """
    depth, q = 5 - (5 - 10.0**-k), sqrt(1000.0)
    w = sqrt(2 * 10 * depth)
    begin = (10 - w) / 10
    end = begin + 2 / q * atan(q * w / 10)
    steps = result.attrs["steps"] if method_steps(result) else 0
    late = 5 * UNIT * (SCENE_UNITS * 3 + STATE_UNITS * (1 + steps)) / w + ulp(1.0)
    for what, expected, computed in (("begin", begin, begins), ("end", end, ends)):
        for t in computed:
            yield compared(f"{what} of contact 1e-{k} m deep", expected, float(t), 2 * late, "s")


def method_steps(result: Result) -> bool:
    """Whether the run took Taylor steps, which round as well."""
    return bool(result.attrs["method"] != "closed_form")
