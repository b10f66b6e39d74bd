"""A branch in words and as plain data: what it is, and its special points."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from vibsim.cases.quantities import number
from vibsim.orbits.branches.node import ENERGY
from vibsim.orbits.branches.special_points import BIFURCATIONS, UNRESOLVED

if TYPE_CHECKING:
    from vibsim.orbits.branches.branch import Branch, SpecialPoint
    from vibsim.orbits.branches.locus_result import Locus, LocusPlan

DIGITS = 12  # of a parameter: special points are located to 1e-11 of it


def branch_lines(branch: Branch) -> list[tuple[str, str]]:
    """Lines (name, text) about a branch."""
    low, high = reach(branch)
    span = f"{branch.key} from {number(low, 6)} to {number(high, 6)} {branch.unit}".rstrip()
    count = int(branch["stable"].sum())
    stable = "without a multiplier outside the unit circle" if branch.key == ENERGY else "stable"
    turns = branch.map.section.of_return.partition(" ")[0] + "s" * (branch.plan.n > 1)
    lines = [
        ("branch", f"{branch.case.name}: orbits of {branch.plan.n} {turns} over {span}"),
        ("points", f"{len(branch)}, {count} of them {stable}"),
        ("ends", _ends(branch)),
    ]
    if branch.key == ENERGY:
        lines.append(("frequency", frequencies(branch)))
    unresolved = [one for one in branch.specials if one.kind == UNRESOLVED]
    where = ", ".join(f"{number(one.parameter, 8)}" for one in unresolved)
    held = "holds everywhere" if not unresolved else f"does not hold at {where} {branch.unit}".rstrip()
    return [*lines, ("index check", held)]


def frequencies(branch: Branch) -> str:
    """Of its first and its last orbit."""
    rates = 1.0 / branch["period"]
    return f"{number(rates[0], 8)} Hz at the least energy, {number(rates[-1], 8)} Hz at the greatest"


def reach(branch: Branch) -> tuple[float, float]:
    """Least and greatest parameter of a branch, its folds included."""
    values = [*branch["parameter"].tolist(), *(one.parameter for one in branch.specials)]
    return min(values), max(values)


def _ends(branch: Branch) -> str:
    if branch.closed:
        return "none: it is closed"
    first, last = (end or "not followed further" for end in branch.ends)
    return first if first == last else f"{first}; {last}"


def special_table(branch: Branch) -> list[tuple[str, ...]]:
    """A row of texts per special point: label, kind, parameter, period, change of the index, word."""
    return [
        (
            one.label,
            one.kind,
            f"{one.parameter:.{DIGITS}g} {branch.unit}".rstrip(),
            f"{one.period:.8g} s",
            f"{one.jump:+d} outside" if one.kind in BIFURCATIONS or one.jump else "",
            _words(branch, one),
        )
        for one in branch.specials
    ]


def _words(branch: Branch, one: SpecialPoint) -> str:
    before, after = branch.spelled(one.before), branch.spelled(one.after)
    return before if before == after else f"{before} > {after}"


def locus_lines(locus: Locus) -> list[tuple[str, str]]:
    """Lines (name, text) about a locus."""
    plan = locus.plan
    first, second = locus["parameter"], locus["second"]
    low, high = (end or "not followed further" for end in locus.ends)
    return [
        (
            "locus",
            f"{locus.case.name}: {locus.kind} {plan.label} in {plan.branch.keys[0]} and {plan.keys[0]}",
        ),
        ("points", str(len(locus))),
        ("from", _place(plan, first[0], second[0], low)),
        ("to", _place(plan, first[-1], second[-1], high)),
    ]


def _place(plan: LocusPlan, first: float, second: float, end: str) -> str:
    place = (
        f"{number(first, 8)} {plan.branch.unit}".rstrip()
        + f", {plan.keys[0]} = {number(second, 8)} {plan.unit}".rstrip()
    )
    return f"{place} ({end})"


def locus_facts(locus: Locus) -> dict[str, Any]:
    """A locus as plain data for JSON."""
    plan = locus.plan
    return {
        "case": locus.case.name,
        "kind": locus.kind,
        "label": plan.label,
        "keys": [plan.branch.keys[0], plan.keys[0]],
        "units": [plan.branch.unit, plan.unit],
        "periods": plan.branch.n,
        "ends": list(locus.ends),
        "points": [
            [float(one), float(other)] for one, other in zip(locus["parameter"], locus["second"], strict=True)
        ],
    }


def facts(branch: Branch) -> dict[str, Any]:
    """A branch as plain data for JSON."""
    return {
        "case": branch.case.name,
        "key": branch.key,
        "unit": branch.unit,
        "periods": branch.plan.n,
        "points": len(branch),
        "stable_points": int(branch["stable"].sum()),
        "closed": branch.closed,
        "ends": list(branch.ends),
        "parameter_from": reach(branch)[0],
        "parameter_to": reach(branch)[1],
        "unresolved": [one.parameter for one in branch.specials if one.kind == UNRESOLVED],
        "special_points": [special_facts(branch, one) for one in branch.specials],
    }


def special_facts(branch: Branch, one: SpecialPoint) -> dict[str, Any]:
    """A special point as plain data for JSON."""
    return {
        "label": one.label,
        "kind": one.kind,
        "parameter": branch.key,
        "value": one.parameter,
        "period": one.period,
        "word": branch.spelled(one.orbit.word),
        "before": branch.spelled(one.before),
        "after": branch.spelled(one.after),
        "jump": one.jump,
        "state": dict(zip(branch.names, one.orbit.state, strict=True)),
        "multipliers": [[mu.real, mu.imag] for mu in one.orbit.multipliers],
    }
