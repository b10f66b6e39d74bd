"""What a fit file must hold."""

from vibsim.fitting.plan import FitPlan
from vibsim.results.structure import TEXT, WHOLE, Attribute, Dataset
from vibsim.results.trajectory_structure import PROVENANCE
from vibsim.sweeps.columns import STATUS_FLAGS

ATTRIBUTES = [
    *PROVENANCE,
    *(Attribute(name, TEXT) for name in ("cases_resolved_json", "fit_settings_json", "fit_sha256", "engine")),
    *(Attribute(name, WHOLE) for name in ("runs", "n_fresh")),
    Attribute("complete", WHOLE, allowed=(0, 1)),
]
CANDIDATE, CASE, STATEMENT, START = "candidate", "case", "statement", "start"
RUN = (CANDIDATE, CASE, START)


def lengths_of(plan: FitPlan) -> dict[str, int]:
    """Lengths of the dimensions that the plan knows."""
    return {CASE: len(plan.cases), STATEMENT: len(plan.statements), START: plan.all_starts}


def datasets_of(plan: FitPlan) -> list[Dataset]:
    """The datasets of a fit that are read back."""
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
