"""Tables of the search: readings ranked, ensembles of starts, solvers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from vibsim.reports.claim import Numbers
from vibsim.reports.document import Table
from vibsim.reports.parameter_search import STATEMENTS, keeps_table_1
from vibsim.reports.wording import between, hz, of_all, seconds

RESONANT_HZ = 4.5  # a hold below this is one near half the bilinear frequency
KINDS = ("captured", "escaped", "passed")


def readings_table(ranking: Sequence[Numbers]) -> Table:
    """Every reading: what it changes, from how many starts each statement then holds, and its price."""
    heads = ("Changed", "Table 1", *(said.head for said in STATEMENTS), "Hold", "Price")
    return Table(
        "Readings of the printed numbers, the cheapest first",
        heads,
        tuple(_reading(row) for row in ranking),
    )


def _reading(row: Numbers) -> tuple[str, ...]:
    changes = row["changes"]
    named = ", ".join(f"{key.rpartition('.')[2]} = {text}" for key, text in changes.items())
    counts = (f"{found['count']}/{found['of']}" for found in row["statements"])
    explained = of_all(row["explained"], len(row["statements"]))
    kept = "kept" if keeps_table_1(changes) else "contradicted"
    return named or "nothing, as printed", kept, *counts, explained, f"{row['price']:.2f}"


def captured_by(ranking: Sequence[Numbers]) -> str:
    """Which changes of a single number capture II-B for good, in a sentence."""
    alone = [row for row in ranking if len(row["changes"]) == 1 and row["statements"][0]["holds"]]
    named = [f"{key.rpartition('.')[2]} = {text}" for row in alone for key, text in row["changes"].items()]
    return f"Of single numbers, {', '.join(sorted(named)) or 'none tried'} capture II-B for good."


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
        names = [row["solver"] for row in rows if is_captured(row[name])]
        sentences.append(f"{name} is captured for good by {' and '.join(names) or 'none of them'}.")
    return " ".join(sentences)


def is_captured(outcome: Numbers) -> bool:
    """Whether a run ends captured near half the bilinear frequency."""
    return outcome.get("verdict") == "captured" and outcome["speed_hz"] < RESONANT_HZ


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
