"""What a fit file holds."""

from vibsim.files.declarations import TEXT, WHOLE, Attribute, Column, Dataset
from vibsim.files.provenance import ENGINE, PROVENANCE
from vibsim.fitting.goals.free_parameter import FreeParameter
from vibsim.fitting.goals.plan import FitPlan
from vibsim.sweeps.statistics.columns import STATUS_FLAGS

ATTRIBUTES = [
    *PROVENANCE,
    *(Attribute(name, TEXT) for name in ("cases_resolved_json", "fit_settings_json", "fit_sha256")),
    ENGINE,
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
    scales = [Dataset(name, Column("1", f"number of the {name}", dtype="i4"), (name,)) for name in DIMENSIONS]
    return [*scales, *_measured(), *_judged(plan), *map(_value_of, plan.free)]


def _measured() -> list[Dataset]:
    return [
        _text("origin", "where the candidate comes from", CANDIDATE),
        _text("changes", "values changed, as JSON", CANDIDATE),
        Dataset("leaving", Column("1", "price of leaving the printed values"), (CANDIDATE,)),
        Dataset("status", Column("1", "whether it was run", dtype="i1", flags=STATUS_FLAGS), RUN),
        _text("sha256", "SHA-256 of the case of a run", *RUN),
        _text("error", "why a run failed", *RUN),
        _number("value", Column("1", "what was measured, in SI units and Hz"), CANDIDATE, STATEMENT, START),
        _number("trust_horizon", Column("s", "of the run from the case's own start"), CANDIDATE, CASE),
    ]


def _judged(plan: FitPlan) -> list[Dataset]:
    of_case = frozenset(range(len(plan.cases)))
    rank = Column("1", "place in the ranking, from 1; 0: not judged from all starts", dtype="i8")
    return [
        _text("case_name", "name of the case", CASE),
        _text("statement_text", "as given", STATEMENT),
        Dataset("statement_case", Column("1", "position of its case", dtype="i8"), (STATEMENT,), of_case),
        _number("price", Column("1", "see the attribute `definitions`"), CANDIDATE),
        Dataset("rank", rank, (CANDIDATE,)),
        _number("share", Column("1", "share of the starts from which it holds"), CANDIDATE, STATEMENT),
        _number("shortfall", Column("1", "mean"), CANDIDATE, STATEMENT),
    ]


def _value_of(free: FreeParameter) -> Dataset:
    column = Column(free.unit or "1", f"{free.key}, as printed where NaN")
    return _number(f"value_{free.name}", column, CANDIDATE)


def _number(name: str, column: Column, *dims: str) -> Dataset:
    return Dataset(name, column, dims, gaps=True)


def _text(name: str, long_name: str, *dims: str) -> Dataset:
    return Dataset(name, Column(None, long_name, dtype="text"), dims)
