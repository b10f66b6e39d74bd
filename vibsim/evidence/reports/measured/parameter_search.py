"""What would make the paper's account of II-B and II-C hold: readings of the printed numbers, ranked.

Table 1 has the amplitudes m3 e omega, so m3 e = 0.0033 kg m is fixed by it, and a reading that changes m3 or
e contradicts it. The others leave J, c, M0 and mu; `vibsim fit` found that M0 and mu do not help.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from vibsim.evidence.reports.measured.measurements import Numbers
from vibsim.evidence.reports.measured.outcomes import Advance
from vibsim.evidence.reports.measured.paper_runs import Interrupted
from vibsim.evidence.reports.measured.without_stop import NO_STOP
from vibsim.fitting.description import facts
from vibsim.fitting.fitting import make_plan, run_fit
from vibsim.fitting.goals.plan import Search

if TYPE_CHECKING:
    from vibsim.cases import Case


@dataclass(frozen=True)
class Said:
    """A statement on the motors, as `vibsim fit` takes it, and as the head of a column."""

    text: str
    head: str


# "captured" as `vibsim analyse` has it; about 100 s: a factor 1.5 to either side; 6.2 Hz and 170 s rounded
STATEMENTS = (
    Said("II-B: captured until the end", "II-B captured for good"),
    Said("II-C: held for at least 30 s", "II-C held 30 s or longer"),
    Said("II-C: passes 4.5 Hz between 67 and 150 s", "away 67 to 150 s after the start"),
    Said("II-C: settles between 6.1 and 6.3 Hz", "ends at 6.1 to 6.3 Hz"),
    Said("II-C: x2 peaks between 150 and 190 s", "x2 greatest at 150 to 190 s"),
    Said("II-C: x2 falls at least 10 %", "then falls by 10 %"),
    Said("II-B: held at 4 to 4.2 Hz", "II-B held at 4.1 Hz"),
)
WITHOUT_STOP = f"G={NO_STOP['stop.G']}"
SHIPPED = "J=0.0085 kg m^2, c=0.0035 N s/m"  # II-B-captured, II-C-escape
READINGS = (
    SHIPPED,
    "J=0.006 kg m^2, c=0.005 N s/m",
    "J=0.008 kg m^2, c=0.004 N s/m",
    "J=0.010 kg m^2, c=0.003 N s/m",
    "J=0.0085 kg m^2, c=0.0014 N s/m",
    "J=0.008 kg m^2",
    "J=0.010 kg m^2",
    "c=0.024 N s/m",
    "c=0.03 N s/m",
    "c=0.049 N s/m",
    "mu=0.014",
    "M0=0.004 N m",
    "m3=54 g",
    "m3=62 g, c=0.00175 N s/m",
    "G=252 mm",
    WITHOUT_STOP,
)
FREE = {"J": "0.5:20 g m^2", "c": "0.001:0.05 N s/m"}
SPREAD = {"x1": "1 mm", "phi": "0:360 deg"}  # no more than the gap; where the rotor stands nobody says
EVERY = "20 ms"  # a tenth of a turn
STARTS, FEW = 24, 2  # besides rest: of the readings, of each point of the plane
POINTS = 128
SEED = 1
CONTRADICTING = ("excitation.m3", "excitation.e")


def search_readings(cases: Sequence[Case], advance: Advance) -> Numbers:
    """The readings, judged from rest and from drawn starts, as `vibsim fit --json` has them."""
    return _fitted(cases, advance, {}, READINGS, STARTS, Search(seed=SEED))


def search_plane(cases: Sequence[Case], advance: Advance) -> Numbers:
    """Quasi-random points over J and c, all judged from a few starts."""
    search = Search(candidates=POINTS, seed=SEED, screen=1 + FEW, confirm=0, fresh=0)
    return _fitted(cases, advance, FREE, (), FEW, search)


def _fitted(
    cases: Sequence[Case],
    advance: Advance,
    free: dict[str, str],
    readings: Sequence[str],
    starts: int,
    search: Search,
) -> Numbers:
    sampled = [case.with_values({"run.every": EVERY}) for case in cases]
    statements = [statement.text for statement in STATEMENTS]
    plan = make_plan(sampled, free, statements, readings, {}, starts, SPREAD, search)
    fit, complete = run_fit(plan, watch=lambda step, done, total: advance(done, total))
    if not complete:
        raise Interrupted
    return {"ranking": facts(fit)["ranking"]}


def keeps_table_1(changes: dict[str, Any]) -> bool:
    """Whether changes leave m3 e as Table 1 has it."""
    return not any(key in changes for key in CONTRADICTING)


def made_of() -> list[Any]:
    """What the search depends on besides the cases."""
    statements = [statement.text for statement in STATEMENTS]
    return [statements, READINGS, FREE, SPREAD, EVERY, STARTS, FEW, POINTS, SEED]
