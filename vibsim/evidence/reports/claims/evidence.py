"""What the claims rest on, from the table of numbers: holds, ensembles, readings, in words."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from itertools import product
from statistics import median

from vibsim.evidence.reports.claims.claim import Numbers
from vibsim.evidence.reports.wording import hz, mm, of_all, seconds, typeset

MOST = 0.8  # share of an ensemble that makes a property of the system: four in five

True_of = Callable[[Numbers], bool]


def members(numbers: Numbers, name: str) -> list[Numbers]:
    """What came of the perturbed starts of a case."""
    outcomes: list[Numbers] = numbers["ensembles"][name]["outcomes"]
    return outcomes


def how_many(numbers: Numbers, name: str, true_of: True_of) -> tuple[int, int]:
    """For how many members of an ensemble something is true, and of how many."""
    outcomes = members(numbers, name)
    return sum(true_of(outcome) for outcome in outcomes), len(outcomes)


def mostly(numbers: Numbers, name: str, true_of: True_of) -> bool:
    """Whether it is true of four members in five."""
    count, total = how_many(numbers, name, true_of)
    return count >= MOST * total


def count_of(numbers: Numbers, name: str, true_of: True_of) -> str:
    """The count in words."""
    return of_all(*how_many(numbers, name, true_of))


def magnitudes(numbers: Numbers, name: str, key: str) -> list[float]:
    """Magnitudes of a number of every member that has it."""
    return [abs(each[key]) for each in members(numbers, name) if each.get(key) is not None]


def middle(numbers: Numbers, name: str, key: str) -> float:
    """Median of those magnitudes; 0 without any."""
    values = magnitudes(numbers, name, key)
    return median(values) if values else 0.0


def share_above(numbers: Numbers, one: str, other: str, key: str) -> float:
    """Share of the pairs of starts, one of each case, in which the first has the greater magnitude."""
    pairs = list(product(*(magnitudes(numbers, name, key) for name in (one, other))))
    return sum(ours > theirs for ours, theirs in pairs) / len(pairs) if pairs else 0.0


def rest_value(numbers: Numbers, name: str, key: str) -> float:
    """Magnitude from rest of what `magnitudes` has of the starts; 0 where undecided."""
    run = numbers["runs"][name]
    value = run["drift"]["rate"] if key == "drift" else run[key]
    return abs(value) if value is not None else 0.0


def commonest_regime(numbers: Numbers, name: str) -> str | None:
    """The regime of most perturbed starts."""
    regimes = Counter(str(each["regime"]) for each in members(numbers, name) if "regime" in each)
    return regimes.most_common(1)[0][0] if regimes else None


def capture_line(numbers: Numbers, name: str) -> str:
    """Verdict, hold, how far the vibration has grown at its end, and final speed, from rest."""
    run = numbers["runs"][name]
    capture, held = run["capture"], ""
    if capture["since"] is not None:
        until = "the end" if capture["until"] is None else seconds(capture["until"])
        held = f", held at {hz(capture['speed_hz'])} from {seconds(capture['since'])} to {until}{_reach(run)}"
    return f"{name} from rest: {capture['verdict']}{held}; final speed {hz(capture['final_speed_hz'])}"


def _reach(run: Numbers) -> str:
    reach = run["held"]["reach"]
    if reach["last"] is None or reach["before"] is None:
        return ""
    growth = 100 * (reach["last"] / reach["before"] - 1)
    return f", when x1 − x2 reaches {mm(reach['last'])} ({growth:+.1f} % in 50 s)"


def in_reading(numbers: Numbers, name: str) -> str:
    """The numbers that a reading changes, in words."""
    changes = numbers["runs"][name]["changes"]
    return typeset(
        " and ".join(f"{key} = {now} (printed: {printed})" for key, (now, printed) in changes.items())
    )
