"""What a fit file must hold."""

from vibsim.fitting.plan import FitPlan
from vibsim.results.structure import TEXT, WHOLE, Attribute, Dataset
from vibsim.results.trajectory_structure import PROVENANCE
from vibsim.sweeps.statistics.columns import STATUS_FLAGS

ATTRIBUTES = [
    *PROVENANCE,
    *(Attribute(name, TEXT) for name in ("cases_resolved_json", "fit_settings_json", "fit_sha256", "engine")),
    *(Attribute(name, WHOLE) for name in ("runs", "n_fresh")),
    Attribute("complete", WHOLE, allowed=(0, 1)),
]
CANDIDATE, CASE, STATEMENT, START = "candidate", "case", "statement", "start"
DIMENSIONS = (CANDIDATE, CASE, STATEMENT, START)
RUN = (CANDIDATE, CASE, START)


def lengths_of(plan: FitPlan) -> dict[str, int]:
    """Lengths of the dimensions that the plan knows."""
    return {CASE: len(plan.cases), STATEMENT: len(plan.statements), START: plan.all_starts}


def datasets_of(plan: FitPlan) -> list[Dataset]:
    """The datasets of a fit: what it is read back from, and what was made of it for other readers."""
    return [*_measured(), *_judged(plan), *(Dataset(name, "i4", (name,)) for name in DIMENSIONS)]


def _measured() -> list[Dataset]:
    return [
        Dataset("origin", "text", (CANDIDATE,)),
        Dataset("changes", "text", (CANDIDATE,)),
        Dataset("leaving", "f8", (CANDIDATE,)),
        Dataset("status", "i1", RUN, frozenset(STATUS_FLAGS.values())),
        Dataset("sha256", "text", RUN),
        Dataset("error", "text", RUN),
        Dataset("value", "f8", (CANDIDATE, STATEMENT, START), missing=True),
        Dataset("trust_horizon", "f8", (CANDIDATE, CASE), missing=True),
    ]


def _judged(plan: FitPlan) -> list[Dataset]:
    per_candidate = ("price", *(f"value_{free.name}" for free in plan.free))
    return [
        Dataset("case_name", "text", (CASE,)),
        Dataset("statement_text", "text", (STATEMENT,)),
        Dataset("statement_case", "i8", (STATEMENT,), frozenset(range(len(plan.cases)))),
        *(Dataset(name, "f8", (CANDIDATE,), missing=True) for name in per_candidate),
        Dataset("rank", "i8", (CANDIDATE,)),
        *(Dataset(name, "f8", (CANDIDATE, STATEMENT), missing=True) for name in ("share", "shortfall")),
    ]
