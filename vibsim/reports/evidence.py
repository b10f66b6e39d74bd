"""What the claims on the motors rest on, from the table of numbers: holds, ensembles, readings, in words."""

from __future__ import annotations

from collections.abc import Callable

from vibsim.reports.claim import Numbers
from vibsim.reports.wording import hz, mm, of_all, seconds

MOST = 0.8  # share of an ensemble that makes a property of the system
SOME = 0.1  # share up from which something is among what chance may bring

True_of = Callable[[Numbers], bool]


def how_many(numbers: Numbers, name: str, true_of: True_of) -> tuple[int, int]:
    """For how many members of an ensemble something is true, and of how many."""
    outcomes = numbers["ensembles"][name]["outcomes"]
    return sum(true_of(outcome) for outcome in outcomes), len(outcomes)


def mostly(numbers: Numbers, name: str, true_of: True_of) -> bool:
    """Whether it is true of most members."""
    count, total = how_many(numbers, name, true_of)
    return count >= MOST * total


def at_times(numbers: Numbers, name: str, true_of: True_of) -> bool:
    """Whether it is true of some members: what a single run may well show."""
    count, total = how_many(numbers, name, true_of)
    return count >= SOME * total


def count_of(numbers: Numbers, name: str, true_of: True_of) -> str:
    """The count in words."""
    return of_all(*how_many(numbers, name, true_of))


def capture_line(numbers: Numbers, name: str, wanted: str) -> str:
    """Verdict, hold, how far the vibration has grown at its end, final speed, and the ensemble."""
    run = numbers["runs"][name]
    capture, held = run["capture"], ""
    if capture["since"] is not None:
        until = "the end" if capture["until"] is None else seconds(capture["until"])
        held = f", held at {hz(capture['speed_hz'])} from {seconds(capture['since'])} to {until}{_reach(run)}"
    count = count_of(numbers, name, lambda outcome: outcome.get("verdict") == wanted)
    final = f"final speed {hz(capture['final_speed_hz'])}"
    return f"{name}: {capture['verdict']}{held}; {final}; perturbed starts: {wanted} in {count}"


def _reach(run: Numbers) -> str:
    reach = run["held"]["reach"]
    if reach["last"] is None or reach["before"] is None:
        return ""
    growth = 100 * (reach["last"] / reach["before"] - 1)
    return f", when x1 − x2 reaches {mm(reach['last'])} ({growth:+.1f} % in 50 s)"


def in_reading(numbers: Numbers, name: str) -> str:
    """The numbers that a reading changes, in words."""
    changes = numbers["runs"][name]["changes"]
    return " and ".join(f"{key} is {now} (printed: {printed})" for key, (now, printed) in changes.items())
