"""Which regimes the ideal source causes beside the three frequencies of Table 1.

The frequency is varied finely, the damping in a few steps, with the amplitude of Table 1's rule (m3 e omega)
and with that of Eq. (2.11) (m3 e omega^2); each run starts at rest and lasts as long as the shipped case.
The first of the quasi-periodic and chaotic ones of each row are followed ten times as long: what 300 s show
can be a transient.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from functools import partial
from math import pi
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
LONGER = {"run.t_end": "3000 s"}
LAWS = {"Table 1": 1, "Eq. (2.11)": 2}  # law of the amplitude -> power of omega behind m3 e


def measure_nearby(case: Case, unbalance: float, advance: Advance) -> list[Numbers]:
    """A row for each point: law, frequency [Hz], damping [N s/m], regime, period; `later` where followed.

    case : one with an ideal source; unbalance : m3 e [kg m]
    """
    points = [(law, hz, c) for law in LAWS for c in DAMPINGS for hz in FREQUENCIES]
    cases = [at_point(case, unbalance, *point) for point in points]
    verdicts = run_all([partial(_regime, each) for each in cases], advance)
    keys = ("law", "hz", "c")
    rows = [
        {**dict(zip(keys, point, strict=True)), **row} for point, row in zip(points, verdicts, strict=True)
    ]
    places = followed(rows)
    later = run_all([partial(_regime, cases[place].with_values(LONGER)) for place in places], advance)
    for place, regime in zip(places, later, strict=True):
        rows[place]["later"] = regime
    return rows


def followed(rows: Sequence[Numbers]) -> list[int]:
    """Places of the rows to follow for longer."""
    groups: dict[tuple[str, float, str], list[int]] = {}
    for place, row in enumerate(rows):
        if row["regime"] in IRREGULAR:
            groups.setdefault((row["law"], row["c"], row["regime"]), []).append(place)
    return [place for places in groups.values() for place in places[:FOLLOWED]]


def at_point(case: Case, unbalance: float, law: str, hz: float, c: float) -> Case:
    """The case at another frequency and damping, its amplitude by one of LAWS."""
    amplitude = unbalance * (2 * pi * hz) ** LAWS[law]
    return case.with_values({
        "excitation.omega": f"{hz:g} Hz",
        "excitation.A": f"{amplitude:.6g} N",
        "coupling.c": f"{c:g} N s/m",
    })  # fmt: skip


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
