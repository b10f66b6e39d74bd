"""Tables of the runs: regimes, and what was measured."""

from __future__ import annotations

from typing import Any

from vibsim.evidence.reports.claims.claim import Numbers
from vibsim.evidence.reports.pages.document import Table
from vibsim.evidence.reports.wording import drift_rate, hz, mm


def regime_table(numbers: Numbers) -> Table:
    """The regime of each run in the paper's span, and the one that the motion settles in."""
    columns = ("Run", "150 to 300 s", "1500 to 3000 s")
    rows = tuple(
        (name, _regime(run["regime"]), _regime(numbers["long_runs"][name]["regime"]))
        for name, run in numbers["runs"].items()
    )
    return Table(
        "Regime in cycles of the source, with its evidence; the largest Lyapunov exponent", columns, rows
    )


def _regime(regime: dict[str, Any]) -> str:
    period = f", period {regime['period']}" if regime["period"] else ""
    exponent = regime["exponent"]
    known = f"; exponent {exponent['value']:.2g} ± {exponent['half_width']:.1g} 1/s" if exponent else ""
    return f"{regime['verdict']}{period}: {regime['reason']}{known}"


def facts_table(numbers: Numbers) -> Table:
    """What was measured of each run."""
    columns = (
        "Run", "Right until", "Impacts", "Sticks", "Impacts per cycle", "Drift of block 2",
        "Strongest line of x1 − x2", "Rest distance needed", "How it is known",
    )  # fmt: skip
    rows = tuple((name, *_facts(run)) for name, run in numbers["runs"].items())
    return Table("Measured in the second half of each run; counts over all of it", columns, rows)


def _facts(run: Numbers) -> tuple[str, ...]:
    cycles, lines, horizon = run["cycles"], run["frequencies"]["lines"], run["trust_horizon"]
    per_cycle = "" if cycles["impacts"] is None else f"{cycles['impacts']:.3g} ({cycles['verdict']})"
    return (
        "unknown" if horizon is None else "the end" if horizon >= run["t_end"] else f"{horizon:.4g} s",
        str(run["impacts"]),
        str(run["sticks"]),
        per_cycle,
        drift_rate(run["drift"]),
        f"{hz(lines[0]['hz'])}, {mm(lines[0]['amplitude'])}" if lines else "none",
        mm(run["rest_distance_needed"]),
        run["how"] or "a run in double precision",
    )
