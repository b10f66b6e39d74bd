"""The page of benchmarks, from the history that `make budgets` appends to."""

import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from from_code.markdown import code, plain, table

HISTORY = Path(__file__).parents[1] / "benchmarks" / "history.json"
SHOWN = 12  # runs in the history of a budget: the latest

HEAD = """# Benchmarks and their history

What `make budgets` measures on a quiet machine, held against limits that vibsim sets itself. Each run of it
is appended to `docs/benchmarks/history.json`, and this page is made from that file. A figure is the median of
its repetitions, the smallest and largest in brackets. Figures of different machines are not to be compared.

"""
NONE_YET = "No run has been stored yet: `make budgets` stores one.\n"


def page(history: Path = HISTORY) -> str:
    """The page of a history."""
    runs = json.loads(history.read_text(encoding="utf-8"))["runs"] if history.exists() else []
    if not runs:
        return HEAD + NONE_YET
    return HEAD + _latest(runs[-1]) + "\n" + "\n".join(_histories(runs))


def _latest(run: Mapping[str, Any]) -> str:
    versions = ", ".join(f"{plain(name)} {plain(version)}" for name, version in run["versions"].items())
    words = f"## The latest run\n\n{_when(run)}, {plain(run['machine'])}; {versions}.\n\n"
    rows = [[plain(each["name"]), _limit(each), _figure(each), _met(each)] for each in run["budgets"]]
    return words + table(("budget", "limit", "measured", ""), rows)


def _histories(runs: Sequence[Mapping[str, Any]]) -> Iterable[str]:
    """A table of each budget that was measured more than once, the latest run first."""
    measured: dict[str, list[list[str]]] = {}
    for run in reversed(runs):
        for budget in run["budgets"]:
            line = [_when(run), plain(run["machine"]), _figure(budget), _limit(budget), _met(budget)]
            measured.setdefault(budget["name"], []).append(line)
    repeated = {name: lines for name, lines in measured.items() if len(lines) > 1}
    if repeated:
        yield "## History\n"
    for name, lines in repeated.items():
        head = ("run", "machine", "measured", "limit", "")
        yield f"### {plain(name)}\n\n" + table(head, lines[:SHOWN])


def _when(run: Mapping[str, Any]) -> str:
    day = run["date"].partition("T")[0]
    return f"{day} ({code(run['commit'])})" if run["commit"] else day


def _figure(budget: Mapping[str, Any]) -> str:
    low, middle, high = (f"{budget[name]:.4g}" for name in ("smallest", "median", "largest"))
    spread = f" ({low} to {high})" if budget["repetitions"] > 1 else ""
    return f"{middle} {plain(budget['unit'])}{spread}".strip()


def _limit(budget: Mapping[str, Any]) -> str:
    if budget["limit"] is None:
        return ""
    words = "at least" if budget["at_least"] else "at most"
    return f"{words} {budget['limit']:.4g} {plain(budget['unit'])}".strip()


def _met(budget: Mapping[str, Any]) -> str:
    return {True: "met", False: "**not met**", None: ""}[budget["met"]]
