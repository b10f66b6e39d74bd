"""Tables of the search: parameters one at a time, ensembles of starts, solvers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from vibsim.reports.claim import Numbers
from vibsim.reports.document import Table
from vibsim.reports.parameter_search import ALONE, NO_CONTACT, Sought
from vibsim.reports.search_figure import ABOUT, CAPTURED, LONG, class_of
from vibsim.reports.wording import between, hz, of_all, seconds

KINDS = ("captured", "escaped", "passed")


def search_table(rows: Sequence[Numbers]) -> Table:
    """For each parameter: where II-B is captured, and where II-C is held for about 100 s and escapes."""
    found = []
    for sought in ALONE:
        mine = [row for row in rows if sought.key in row["at"]]
        captured = [row["at"][sought.key] for row in mine if class_of(row["II-B"]) == CAPTURED]
        held = [row["at"][sought.key] for row in mine if class_of(row["II-C"]) in (ABOUT, LONG)]
        both = [value for value in captured if value in held]
        found.append((_tried(sought), *(_values(values) for values in (captured, held, both))))
    columns = ("Varied", "II-B captured for good", "II-C held for 67 s or longer, then escapes", "Both")
    return Table("One parameter at a time, the others as printed", columns, tuple(found))


def _tried(sought: Sought) -> str:
    values = [value for value in sought.values if value != NO_CONTACT]
    return f"{sought.symbol}, {between(min(values), max(values), sought.unit)}"


def _values(values: Sequence[float]) -> str:
    return ", ".join("no contact" if value == NO_CONTACT else f"{value:g}" for value in values) or "never"


def ensemble_table(ensembles: Mapping[str, Any]) -> Table:
    """Verdicts, holds and final speeds of the perturbed starts."""
    rows = tuple((name, *_ensemble(ensemble["outcomes"])) for name, ensemble in ensembles.items())
    columns = ("Case", "Captured", "Escaped", "Passed", "Hold ends", "Final speed: median, range")
    return Table("Perturbed starts", columns, rows)


def _ensemble(outcomes: Sequence[Numbers]) -> tuple[str, ...]:
    counts = [sum(each.get("verdict") == kind for each in outcomes) for kind in KINDS]
    ends = [each["until"] for each in outcomes if each.get("verdict") == "escaped"]
    finals = sorted(each["final_hz"] for each in outcomes if each.get("final_hz") is not None)
    middle = finals[len(finals) // 2] if finals else None
    return (
        *(of_all(count, len(outcomes)) for count in counts),
        between(min(ends), max(ends), "s") if ends else "",
        f"{hz(middle)}, {between(finals[0], finals[-1], 'Hz')}" if finals else "none",
    )


def solver_table(rows: Sequence[Numbers]) -> Table:
    """What each solver makes of II-B and II-C."""
    columns = ("Solver", "II-B", "II-C", "x2 of II-C at 300 s")
    found = tuple(
        (row["solver"], _solved(row["II-B"]), _solved(row["II-C"]), _drifted(row["II-C"])) for row in rows
    )
    return Table("The printed parameters by solvers without events", columns, found)


def capturing_solvers(rows: Sequence[Numbers]) -> str:
    """Which solvers capture which motor, in a sentence each."""
    sentences = []
    for name in ("II-B", "II-C"):
        names = [row["solver"] for row in rows if class_of(row[name]) == CAPTURED]
        sentences.append(f"{name} is captured for good by {' and '.join(names) or 'none of them'}.")
    return " ".join(sentences)


def _solved(outcome: Numbers) -> str:
    if "failed" in outcome:
        return outcome["failed"]
    held = ""
    if outcome["since"] is not None:
        until = "the end" if outcome["until"] is None else seconds(outcome["until"])
        held = f", held at {hz(outcome['speed_hz'])} until {until}"
    return f"{outcome['verdict']}{held}; final speed {hz(outcome['final_hz'])}"


def _drifted(outcome: Numbers) -> str:
    return "" if "failed" in outcome else f"{outcome['drifted']:.3g} m"
