"""What a bench is to do: which case over which span, compared when, by whom, for how long at most."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import ceil

import numpy as np

from vibsim.cases import Case, load_case
from vibsim.cases.resolved import fingerprint
from vibsim.cases.values.quantities import decimal_text
from vibsim.evidence.benchmark.errors import BenchError
from vibsim.evidence.benchmark.families import Family, families_named

LONGEST = Fraction(
    100
)  # s, unless the user says otherwise: doubles know II-B until then, all peers take minutes
INSTANTS = 2000  # about as many are compared
FEWEST = 10
LIMIT = 20.0  # s per run
SHARES = (0.1, 0.2, 0.5, 1.0)  # of the span: where errors are told
STOPS_A_RUN = ("rest_distance.on_violation", "run.on_violation")
NOT_TRUTH = ("name", "title", "run.trust_tolerance", "run.method", "run.order", "run.tol")


@dataclass(frozen=True)
class Plan:
    """A bench of `case`, whose run settings say span and instants.

    families : who takes part; limit : wall time of a run after which it is stopped [s]
    """

    case: Case
    families: tuple[Family, ...]
    limit: float

    @property
    def times(self) -> np.ndarray:
        """The instants compared [s]."""
        scene = self.case.scene()
        return np.array([scene.sample_time(i) for i in range(scene.sample_count)])

    @property
    def check_times(self) -> list[float]:
        """The instants at which errors are told [s], some of those compared."""
        times = self.times
        return sorted({float(times[round(share * (len(times) - 1))]) for share in SHARES})

    @property
    def fingerprint(self) -> str:
        """SHA-256 of what the truth depends on: two benches of one fingerprint share it."""
        values = {key: value for key, value in self.case.values.items() if key not in NOT_TRUTH}
        return fingerprint(values)

    def rows(self) -> Iterator[tuple[Family, str]]:
        """Family and setting of every row that can be run here."""
        scene = self.case.scene()
        for family in self.families:
            if family.installed and family.refusal(scene) is None:
                yield from ((family, setting) for setting, _ in family.ladder)

    def absent(self) -> list[Family]:
        """Families that could run the scene and are not installed."""
        scene = self.case.scene()
        return [family for family in self.families if not family.installed and family.refusal(scene) is None]


def make_plan(
    case: Case | str, t_end: str | None = None, methods: Sequence[str] = (), limit: float = LIMIT
) -> Plan:
    """The plan of a bench.

    Parameters
    ----------
    case : a Case, or what `load_case` takes
    t_end : end of the span, such as "50 s"; by default that of the case, 100 s at most
    methods : names of families; all for none
    limit : wall time of one run after which it is stopped [s]

    Raises CaseError for the case and its end, BenchError for unknown methods and for a span too short to
    compare.
    """
    case = load_case(case) if isinstance(case, str) else case
    families = tuple(families_named(methods))
    if t_end is None:
        t_end = f"{decimal_text(min(case.quantity('run.t_end').value, LONGEST))} s"
    case = case.with_values({"run.t_end": t_end})
    span, every = case.quantity("run.t_end").value, case.quantity("run.every").value
    changes = {"run.every": f"{decimal_text(every * max(ceil(span / every / INSTANTS), 1))} s"}
    changes |= {key: "warn" for key in STOPS_A_RUN if key in case.values}  # the peers know of no clearance
    plan = Plan(case.with_values(changes), families, limit)
    if len(plan.times) < FEWEST:
        raise BenchError(
            f"{t_end} is too short: a bench needs {FEWEST} samples, one every {case.quantity('run.every')}"
        )
    return plan
