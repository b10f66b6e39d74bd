"""All checks in the order of validation (V1 to V21, hard cases, V22 to V32); V1, the paper's cases.

V1 compares the paper's cases with published figures and with stored runs of 40 digits. Expected: 40- and
60-digit Taylor integrations by a program of its own, equal in all digits shown. Case I is regular; the others
are compared until chaos has taken the digits of a double.
"""

from collections.abc import Iterable, Iterator, Sequence
from decimal import Decimal
from functools import cache, partial
from math import inf, pi, sin, ulp

from vibsim.cases import Case, load_case
from vibsim.cases.problems import did_you_mean
from vibsim.engine.errors import EngineError
from vibsim.evidence.verification.checks import (
    SCENE_UNITS,
    STATE_UNITS,
    UNIT,
    Check,
    CheckPoint,
    CheckRow,
    compared,
    counted_row,
    flows_of,
    named_case,
    read_truth,
    run,
    worst_row,
)
from vibsim.evidence.verification.formulas import formula_checks
from vibsim.evidence.verification.hard_cases import BECAUSE as hard_cases_BECAUSE
from vibsim.evidence.verification.hard_cases import (
    LUCK,
    UNITS,
    closed_form_checks,
    hard_case_checks,
    hard_state_points,
    million_seconds_checks,
    reported_failures_checks,
)
from vibsim.evidence.verification.impact_orbits import (
    bouncing_ball_checks,
    impact_multiplier_checks,
    impact_orbit_checks,
)
from vibsim.evidence.verification.laws import (
    energy_ledger_checks,
    mirror_symmetry_checks,
    momentum_ledger_checks,
    monodromy_checks,
    motor_run_up_checks,
)
from vibsim.evidence.verification.oscillators import (
    friction_oscillator_checks,
    impact_oscillator_checks,
    several_impact_checks,
    stick_slip_checks,
)
from vibsim.evidence.verification.vibrations import (
    bilinear_cycle_checks,
    coulomb_friction_checks,
    free_vibration_checks,
    linear_theory_checks,
)
from vibsim.physics.parts import EVENT_NAMES
from vibsim.results import Result

# state at 300 s as decimal texts; impacts, sticks, events
CASE_I: dict[str, tuple[dict[str, str], tuple[int, int, int]]] = {
    "I-A": (
        {
            "x1": "0.0049838576146675",
            "x2": "0.0050150524787833",
            "v1": "-0.0017985024624189",
            "v2": "-0.00037796325802528",
        },
        (630, 419, 3780),
    ),
    "I-B": (
        {
            "x1": "-0.0208657036721520",
            "x2": "-0.0233895811558076",
            "v1": "0.0056039388001598",
            "v2": "-0.0015125299416625",
        },
        (1466, 0, 6232),
    ),
    "I-C": (
        {
            "x1": "-0.0846686050797213",
            "x2": "-0.0868864712155865",
            "v1": "0.0795244964939589",
            "v2": "-0.0094857232508406",
        },
        (1948, 0, 7794),
    ),
}
# time [s] -> x2 [m], w / 2 pi [Hz], impacts
II_B = {20: ("0.003511", "4.00240", 115), 50: ("0.014103", "5.27362", 339)}
# until when the others are compared: errors of 1e-16 have then grown to millimetres
SPANS = {
    "I-A-eq211": "40 s",
    "I-B-eq211": "40 s",
    "I-C-eq211": "40 s",
    "II-A": "60 s",
    "II-B": "80 s",
    "II-C": "60 s",
}
PUBLISHED = "half a unit of the last digit published, and twice the stray of runs kicked as doubles round"


def paper_case_checks() -> list[Check]:
    """One check per case and flow, and one of the checkpoints of II-B."""
    listed = []
    for name in (*CASE_I, *SPANS):
        case = judged_case(name)
        listed += [
            Check(f"V1/{name}/{flow}", case.title, partial(paper_case_rows, name, flow))
            for flow in flows_of(case)
        ]
    return [*listed, Check("V1/II-B-checkpoints/taylor", "II-B at 20 and 50 s, 50 digits", checkpoints)]


def judged_case(name: str) -> Case:
    """A case as it is verified: cut short where it turns chaotic."""
    return named_case(name, **({"run__t_end": SPANS[name]} if name in SPANS else {}))


def paper_case_rows(name: str, flow: str) -> Iterator[CheckRow]:
    """States against the stored truth; Case I against its published figures too."""
    case = judged_case(name)
    result = run(case, flow)
    truth = read_truth(name, case.sha256)
    if name in CASE_I:
        published, counts = CASE_I[name]
        points = [
            compared(
                f"{column} at 300 s",
                float(text),
                float(result[column][-1]),
                last_digit(text) / 2 + LUCK * truth.stray[flow][column][-1],
                UNITS[column],
            )
            for column, text in published.items()
        ]
        yield worst_row(f"V1/{name}/{flow}", points, PUBLISHED)
        for what, expected in zip(("impacts", "sticks", "events"), counts, strict=True):
            yield counted_row(f"V1/{name}/{flow}", what, expected, int(result.attrs[what]), "published count")
    yield worst_row(f"V1/{name}/{flow}", hard_state_points(truth, result, flow), hard_cases_BECAUSE)


def last_digit(text: str) -> float:
    """One unit in the last place of a decimal text."""
    return 10.0 ** -len(text.partition(".")[2])


def checkpoints() -> Iterator[CheckRow]:
    """II-B before its chaos: rounding is 1e-13 there, so half a unit of the last digit is all."""
    name = "V1/II-B-checkpoints/taylor"
    for t, (drift, frequency, impacts) in II_B.items():
        result = run(named_case("II-B", run__t_end=f"{t} s"))
        points = [
            compared(f"x2 at {t} s", float(drift), float(result["x2"][-1]), last_digit(drift) / 2, "m"),
            compared(
                f"speed at {t} s",
                float(frequency),
                float(result["phidot"][-1]) / (2 * pi),
                last_digit(frequency) / 2,
                "Hz",
            ),
        ]
        yield worst_row(name, points, "half a unit of the last digit published")
        yield counted_row(
            name, f"impacts until {t} s", impacts, int(result.attrs["impacts"]), "published count"
        )


# hard/spool-between-stops against 40 digits: 18 events in each period of the pressure, the same in all.
#
# The spool sticks near the right stop in each period. So from the first release there on, every period is the
# one before it, in exact numbers as well.


SPOOL = "hard/spool-between-stops"
METHODS = ("auto", "taylor")
SLOW = 1e-9  # [m/s]; a reversal is met with rounding for a speed, one by an impact with 1e-4 or more
PERIOD, PERIODS = Decimal("0.004"), 10  # [s]; the first of them starts otherwise
M, K, F0, A, N = 0.3361185937456267e-3, 1488.578099595049, 0.6064131049344343, 2.033654850633301, 1.0
OMEGA = 500 * pi
# the terms that the closed form adds: response to A, vibration of its own, offset, way between the stops
PLACE = 2 * A / (K - M * OMEGA**2) + F0 / K + 1.016e-3  # [m]
SPEED = 2 * OMEGA * A / (K - M * OMEGA**2) + 2.3  # likewise, and the fastest impact [m/s]
CONDITIONING = 0.027  # of the latest event: sum of |p dt/dp| over the numbers of the case [s]
# a period, from a run of 40 digits: kind, and time since the last multiple of 4 ms [s]
TRUTH = (
    ("stick_end", "1.239917297813318850519690e-4"),
    ("impact", "1.138185704841566212164555e-3"),
    ("reversal", "1.138185704841566212164555e-3"),
    ("reversal", "1.239975408375652638119714e-3"),
    ("stick_begin", "1.291179124651515739691084e-3"),
    ("stick_end", "2.044243403023824699878625e-3"),
    ("impact", "3.009198651444677335843665e-3"),
    ("reversal", "3.009198651444677335843665e-3"),
    ("reversal", "3.103895412910924765624844e-3"),
    ("impact", "3.346358923364531046297704e-3"),
    ("reversal", "3.346358923364531046297704e-3"),
    ("reversal", "3.357359996037581090840750e-3"),
    ("impact", "3.412978379597373024675994e-3"),
    ("reversal", "3.412978379597373024675994e-3"),
    ("reversal", "3.413525897175876066283987e-3"),
    ("impact", "3.422727660282692248814406e-3"),
    ("reversal", "3.422727660282692248814406e-3"),
    ("stick_begin", "3.422733384206404030483814e-3"),
)
BECAUSE = (
    "4 units x conditioning; 16 of place over speed of each impact, of speed over deceleration to a stop"
)


def spool_checks() -> list[Check]:
    """The case by both methods."""
    return [Check(f"{SPOOL}/{how}", load_case(SPOOL).title, partial(rows, how)) for how in METHODS]


def rows(method: str) -> Iterator[CheckRow]:
    """Every event of nine periods, none missed and none invented, and the certificate."""
    name = f"{SPOOL}/{method}"
    result = run(load_case(SPOOL), method)
    points: list[CheckPoint] = []
    wrong = 0
    for n in range(1, PERIODS):
        events = events_between(result, n * PERIOD, (n + 1) * PERIOD)
        wrong += int([kind for kind, *_ in events] != [kind for kind, _ in TRUTH])
        points += period_points(events, n * PERIOD)
    yield counted_row(name, "periods with other events", 0, wrong, "18 events in each of nine periods")
    yield worst_row(name, points, BECAUSE)
    doubts = int(result.attrs["uncertified"])
    yield counted_row(name, "stretches in doubt", 0, doubts, "no event is nearly missed")


def events_between(result: Result, low: Decimal, high: Decimal) -> list[tuple[str, float, float, float]]:
    """Kind, time [s], speed before [m/s] and place [m] of the events between two times."""
    columns = (result.events[name].tolist() for name in ("kind", "t", "before_v_spool", "x_spool"))
    named = [(EVENT_NAMES[kind], t, abs(v), x) for kind, t, v, x in zip(*columns, strict=True)]
    inner = [event for event in named if low < Decimal(event[1]) < high]
    return [event for event in inner if event[0] != "end"]


def period_points(events: list[tuple[str, float, float, float]], start: Decimal) -> Iterator[CheckPoint]:
    """Times of one period's events. An impact at the speed v comes late by an error of place over v, and
    so do all after it; the end of slip by an error of speed over the deceleration.
    """
    late = 0.0
    for (kind, expected), (_, t, speed, x) in zip(TRUTH, events, strict=False):
        late += STATE_UNITS * UNIT * PLACE / speed if kind == "impact" else 0.0
        ends = kind == "stick_begin" or (kind == "reversal" and speed < SLOW)
        stopping = STATE_UNITS * UNIT * SPEED / deceleration(t, x) if ends else 0.0
        true = start + Decimal(expected)
        bound = SCENE_UNITS * UNIT * CONDITIONING + late + stopping + 2 * ulp(t)
        yield compared(f"{kind} at {t:.6g} s", float(true), t, bound, "s", float(abs(Decimal(t) - true)))


def deceleration(t: float, x: float) -> float:
    """Of slip at its end, the smaller one of the two directions [m/s^2]."""
    force = F0 + A * sin(OMEGA * t) - K * x
    return min(abs(force - N), abs(force + N)) / M


# All checks, in the order of validation: V1 to V21, the hard cases, V22 to V32.


FAMILIES = (
    paper_case_checks,
    free_vibration_checks,
    linear_theory_checks,
    coulomb_friction_checks,
    mirror_symmetry_checks,
    motor_run_up_checks,
    monodromy_checks,
    energy_ledger_checks,
    bilinear_cycle_checks,
    impact_oscillator_checks,
    impact_multiplier_checks,
    impact_orbit_checks,
    bouncing_ball_checks,
    stick_slip_checks,
    friction_oscillator_checks,
    several_impact_checks,
    momentum_ledger_checks,
    hard_case_checks,
    million_seconds_checks,
    closed_form_checks,
    reported_failures_checks,
    spool_checks,
    formula_checks,
)


@cache
def all_checks() -> tuple[Check, ...]:
    """Every check of every family."""
    return tuple(check for checks in FAMILIES for check in checks())


# Which checks a list of names and prefixes stands for.


class UnknownCheckError(ValueError):
    """A name that no check has or begins with; the message names the nearest."""


def selected(checks: Sequence[Check], names: Iterable[str]) -> list[Check]:
    """The checks that the names stand for, in the order of the catalogue; all where there are none.

    V1 stands for V1/..., not for V10; hard/stiff for every check that begins so. Letter case does not matter.
    """
    chosen = {check.name for name in names for check in _named(checks, name)}
    return [check for check in checks if check.name in chosen] if chosen else list(checks)


def _named(checks: Sequence[Check], name: str) -> list[Check]:
    plain = name.strip().rstrip("/").casefold()
    whole = [check for check in checks if f"{check.name}/".casefold().startswith(f"{plain}/")]
    begun = [check for check in checks if check.name.casefold().startswith(plain)]
    if not plain or not (whole or begun):
        raise UnknownCheckError(f"no check {name!r}{did_you_mean(name, spellings(checks))}; see --list")
    return whole or begun


def spellings(checks: Sequence[Check]) -> list[str]:
    """Everything that names one check or several: V3, V3/taylor, hard/stiff-stop, ..."""
    names: dict[str, None] = {}
    for check in checks:
        parts = check.name.split("/")
        names |= {"/".join(parts[:count]): None for count in range(1, len(parts) + 1)}
    return list(names)


# Run checks one by one and hand on their rows.


def verify(names: Iterable[str] | None = None) -> Iterator[CheckRow]:
    """Compute the checks named (names or how they begin; None: all) and yield their rows.

    Raises UnknownCheckError before the first row.
    """
    return rows_of(selected(all_checks(), list(names or ())))


def rows_of(checks: Sequence[Check]) -> Iterator[CheckRow]:
    """The rows of the checks; a run that fails is a row that falls short."""
    for check in checks:
        try:
            yield from check.rows()
        except EngineError as error:
            yield CheckRow(
                check.name, "run", "its end", f"failed: {error}", inf, 0.0, "", "every run reaches its end"
            )
