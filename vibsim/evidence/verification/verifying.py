"""Run checks one by one and hand on their rows."""

from collections.abc import Iterable, Iterator, Sequence
from math import inf

from vibsim.engine.choice import engine_name
from vibsim.engine.errors import EngineError
from vibsim.evidence.verification.catalogue import all_checks
from vibsim.evidence.verification.check import Check
from vibsim.evidence.verification.row import Row
from vibsim.evidence.verification.selection import selected


def verify(names: Iterable[str] | None = None, engine: str = "auto") -> Iterator[Row]:
    """Compute the checks named (names or how they begin; None: all) and yield their rows.

    engine : "auto", "c" or "python". On the Python engine, checks that take it minutes are left out unless
    they are named.

    Raises UnknownCheckError before the first row.
    """
    computed_by = engine_name(engine)
    chosen, _ = chosen_checks(list(names or ()), computed_by)
    return rows_of(chosen, computed_by)


def chosen_checks(names: Sequence[str], engine: str) -> tuple[list[Check], list[Check]]:
    """The checks to compute, and those left out because the Python engine would take minutes."""
    chosen = selected(all_checks(), names)
    if engine == "c" or names:
        return chosen, []
    return [check for check in chosen if not check.long], [check for check in chosen if check.long]


def rows_of(checks: Sequence[Check], engine: str) -> Iterator[Row]:
    """The rows of the checks; a run that fails is a row that falls short."""
    for check in checks:
        try:
            yield from check.rows(engine)
        except EngineError as error:
            yield Row(
                check.name, "run", "its end", f"failed: {error}", inf, 0.0, "", "every run reaches its end"
            )
