"""Which regimes the ideal source causes beside the three frequencies of Table 1.

The frequency is varied finely, the damping in a few steps, with the amplitude of Table 1's rule (m3 e omega)
and with that of Eq. (2.11) (m3 e omega^2). At the frequencies of Table 1 the shipped cases are run, with
their own amplitudes: several motions coexist there, and a change of the seventh digit selects another. For
that reason each point is run from rest and from starts to either side, and has the regime of most of them.
The first of the quasi-periodic and chaotic ones of each row are followed ten times as long: what 300 s show
can be a transient.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from functools import partial
from math import isclose, pi
from typing import TYPE_CHECKING

from vibsim.analysis import judge_regime, largest_exponent
from vibsim.engine.errors import EngineError
from vibsim.evidence.reports.measured.measurements import Numbers
from vibsim.evidence.reports.measured.outcomes import Advance, run_all
from vibsim.results import simulate

if TYPE_CHECKING:
    from vibsim.cases import Case

FREQUENCIES = tuple(round(3 + 0.1 * i, 1) for i in range(41))  # [Hz] 3 to 7
DAMPINGS = (0.0, 0.001)  # [N s/m]
FOLLOWED = 2  # of each of the regimes below, of each law and damping
IRREGULAR = ("quasi-periodic", "chaotic")
STARTS = (0.0, 6e-4, -6e-4, 1.2e-3, -1.2e-3)  # [m] x1(0): rest, and half and all of the ensemble's reach
LONGER = {"run.t_end": "3000 s"}
LAWS = {"Table 1": 1, "Eq. (2.11)": 2}  # law of the amplitude -> power of omega behind m3 e


def measure_nearby(
    shipped: Mapping[str, Sequence[Case]], unbalance: float, advance: Advance
) -> list[Numbers]:
    """A row for each point: law, frequency [Hz], damping [N s/m], regime and period of most starts, regime
    and period of each start; `later` where followed.

    shipped : for each law the cases with an ideal source by that law; unbalance : m3 e [kg m]
    """
    points = [(law, hz, c) for law in LAWS for c in DAMPINGS for hz in FREQUENCIES]
    cases = [
        [_from(at_point(shipped[point[0]], unbalance, *point), start) for start in STARTS] for point in points
    ]
    verdicts = run_all([partial(_regime, each) for group in cases for each in group], advance)
    rows = [
        {"law": law, "hz": hz, "c": c, **most_common(group)}
        for (law, hz, c), group in zip(points, _groups(verdicts, len(STARTS)), strict=True)
    ]
    places = followed(rows)
    chosen = [cases[place][_first_of(rows[place])].with_values(LONGER) for place in places]
    later = run_all([partial(_regime, each) for each in chosen], advance)
    for place, regime in zip(places, later, strict=True):
        rows[place]["later"] = regime
    return rows


def most_common(regimes: Sequence[Numbers]) -> Numbers:
    """Regime and period of most of the starts, of the earlier start where two are as common; in `starts`
    those of each of them, rest first.
    """
    regime, _ = Counter(each["regime"] for each in regimes).most_common(1)[0]
    periods = [each["period"] for each in regimes if each["regime"] == regime]
    return {"regime": regime, "period": Counter(periods).most_common(1)[0][0], "starts": list(regimes)}


def _groups(values: Sequence[Numbers], size: int) -> list[Sequence[Numbers]]:
    return [values[i : i + size] for i in range(0, len(values), size)]


def _first_of(row: Numbers) -> int:
    """Number of the first start that has the regime of its row."""
    return next(i for i, each in enumerate(row["starts"]) if each["regime"] == row["regime"])


def followed(rows: Sequence[Numbers]) -> list[int]:
    """Places of the rows to follow for longer."""
    groups: dict[tuple[str, float, str], list[int]] = {}
    for place, row in enumerate(rows):
        if row["regime"] in IRREGULAR:
            groups.setdefault((row["law"], row["c"], row["regime"]), []).append(place)
    return [place for places in groups.values() for place in places[:FOLLOWED]]


def at_point(shipped: Sequence[Case], unbalance: float, law: str, hz: float, c: float) -> Case:
    """The case at a frequency and damping: a shipped one where there is one at this frequency, else the first
    of them with the frequency changed and the amplitude by the law, to all digits.
    """
    damping = {"coupling.c": f"{c:g} N s/m"}
    for case in shipped:
        if isclose(case.two_blocks().omega, 2 * pi * hz):
            return case if case.number("coupling.c") == c else case.with_values(damping)
    amplitude = unbalance * (2 * pi * hz) ** LAWS[law]
    changes = {"excitation.omega": f"{hz:g} Hz", "excitation.A": f"{amplitude!r} N"}
    return shipped[0].with_values({**changes, **damping})


def _from(case: Case, start: float) -> Case:
    """The case with block 1 displaced at the start [m]."""
    return case.with_values({"initial.x1": f"{start!r} m"}) if start else case


def _regime(case: Case) -> Numbers:
    try:
        result = simulate(case.with_values({"run.every": "50 ms"}), trust=False)
    except EngineError as error:
        return {"regime": "failed", "period": None, "why": str(error)}
    judged = judge_regime(result, exponent=largest_exponent(result))
    return {"regime": judged.verdict, "period": judged.period}


def counts_by_regime(rows: Sequence[Numbers], law: str, c: float) -> dict[str, int]:
    """How many frequencies have each regime, the commonest first."""
    return dict(Counter(row["regime"] for row in rows if (row["law"], row["c"]) == (law, c)).most_common())


def rows_of(rows: Sequence[Numbers], regime: str, law: str, c: float) -> list[Numbers]:
    """The rows of a regime."""
    return [row for row in rows if (row["regime"], row["law"], row["c"]) == (regime, law, c)]
