"""A check: a named piece of the verification that computes its rows afresh."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from vibsim.evidence.verification.row import Row


@dataclass(frozen=True)
class Check:
    """One check.

    name : such as V3/closed_form or hard/stiff-stop/taylor; title : one line on what it shows
    rows : given the engine ("c" or "python"), runs it and yields its rows
    long : takes the Python engine minutes
    """

    name: str
    title: str
    rows: Callable[[str], Iterator[Row]]
    long: bool = False
