"""Tables of the search: readings ranked, ensembles of starts, solvers.

A stop that is out of reach is no stop, and its gap says nothing: taking it away costs as much as a factor
of 10.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from vibsim.evidence.reports.claims.claim import Numbers
from vibsim.evidence.reports.measured.paper_runs import MOTORS, READINGS
from vibsim.evidence.reports.measured.parameter_search import STATEMENTS, keeps_table_1
from vibsim.evidence.reports.measured.without_stop import NO_STOP
from vibsim.evidence.reports.pages.document import Table
from vibsim.evidence.reports.wording import between, hz, of_all, seconds, typeset
from vibsim.fitting.goals.free_parameter import LEAVE

RESONANT_HZ = 4.5  # a hold below this is one near half the bilinear frequency
KINDS = ("captured", "escaped", "passed", "not met", "undecided")


def readings_table(ranking: Sequence[Numbers]) -> Table:
    """Every reading: what it changes, from how many starts each statement then holds, and its price."""
    heads = ("Changed", "Table 1", *(statement.head for statement in STATEMENTS), "Hold", "Price")
    return Table(
        "Readings of the printed numbers, the cheapest first",
        heads,
        tuple(_reading(row) for row in sorted(ranking, key=price_of)),
    )


def _reading(row: Numbers) -> tuple[str, ...]:
    changes = row["changes"]
    counts = (f"{share['count']}/{share['of']}" for share in row["statements"])
    explained = f"{row['explained']}/{len(row['statements'])}"
    table_1 = "kept" if keeps_table_1(changes) else "contradicted"
    return named(changes) or "nothing, as printed", table_1, *counts, explained, f"{price_of(row):.2f}"


def named(changes: Mapping[str, str]) -> str:
    """Changes in words: "J = 0.01 kg m², c = 0.003 N s/m"."""
    return ", ".join(_named(key, text) for key, text in changes.items())


def _named(key: str, text: str) -> str:
    return "no stop" if {key: text} == NO_STOP else typeset(f"{key.rpartition('.')[2]} = {text}")


def price_of(row: Numbers) -> float:
    """The price of a reading."""
    price: float = row["price"]
    return price - row["leaving"] + LEAVE if row["changes"] == NO_STOP else price


def captured_by(ranking: Sequence[Numbers]) -> str:
    """Which single changes capture II-B for good, in a sentence."""
    alone = [row for row in ranking if len(row["changes"]) == 1 and row["statements"][0]["holds"]]
    names = sorted(named(row["changes"]) for row in alone)
    return f"Of single changes, {', '.join(names) or 'none tried'} capture II-B for good."


def ensemble_table(ensembles: Mapping[str, Any]) -> Table:
    """Verdicts, holds and final speeds of the perturbed starts."""
    motors = {name: each["outcomes"] for name, each in ensembles.items() if name in (*MOTORS, *READINGS)}
    rows = tuple((name, *_ensemble(outcomes)) for name, outcomes in motors.items())
    columns = (
        "Case", "Captured", "Escaped", "Passed", "Not met", "Undecided", "Held until",
        "Final speed: median, range",
    )  # fmt: skip
    return Table("Perturbed starts of the motors", columns, rows)


def _ensemble(outcomes: Sequence[Numbers]) -> tuple[str, ...]:
    counts = [sum(each.get("verdict") == kind for each in outcomes) for kind in KINDS]
    ends = [each["until"] for each in outcomes if each.get("until") is not None]
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
    outcomes = tuple(
        (row["solver"], _solved(row["II-B"]), _solved(row["II-C"]), _drifted(row["II-C"])) for row in rows
    )
    return Table("The printed parameters by solvers without events", columns, outcomes)


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
        return str(outcome["failed"])
    held = ""
    if outcome["since"] is not None:
        until = "the end" if outcome["until"] is None else seconds(outcome["until"])
        held = f", held at {hz(outcome['speed_hz'])} until {until}"
    return f"{outcome['verdict']}{held}; final speed {hz(outcome['final_hz'])}"


def _drifted(outcome: Numbers) -> str:
    return "" if "failed" in outcome else f"{outcome['drifted']:.3g} m"
