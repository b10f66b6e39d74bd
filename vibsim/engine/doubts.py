"""Doubts of the certificate in words: when, about which events, for which reason.

C counts every doubt and describes the first few by the numbers of event functions in the mode of then; the
automaton, which is in Python, describes its own. Both become the names that the case has for its parts.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from vibsim.engine.modes.rows import (
    CLEARANCE,
    DOMAIN,
    GAP,
    HOLD,
    PUSH,
    SLIDE,
    STRIKE,
    SWITCH,
    Event,
    ModeRows,
)
from vibsim.physics.parts import Clearance, Friction, RigidStop, Scene, Stop

if TYPE_CHECKING:
    from vibsim.engine.modes.row_maker import RowMaker

MOST_NAMED = 3  # events of one doubt


class Doubt(NamedTuple):
    """A point that a run could not prove.

    time : near which it is [s]; events : by the names of the parts, empty where no event is singled out;
    reason : in words
    """

    time: float
    events: tuple[str, ...]
    reason: str


# Reasons of C, in the order of its codes; the first stands for those of the automaton.
REASONS_OF_C = (
    "",
    "in one instant, in an order that is not known",
    "a touch so near that it cannot be distinguished from a miss",
    "not excluded: steps are as short as times are rounded",
    "so near where a stretch begins that its side is not known",
    "at zero with all derivatives that are taken: it may rest there",
)

# Reasons of the automaton.
LEAVES = "rounding hides whether it begins or not"
CROSSES = "rounding hides whether it goes on or turns back"
LOADED = "the load is within rounding of its limit"
SIGN = "rounding hides whether the force pushes"
HOLDS = "rounding hides which of them hold"
SLOW = "the speed is within rounding and taken for zero"
ORDER = "in one instant, and their order would change the motion"
ENDLESS = "in one instant without end, and taken without restitution"
TOUCHED = "rounding hides whether it touches in the instant of an impact"
START = "rounding hides on which side it starts"
SIDE = "rounding hides on which side it goes on"
START_AT_REST = "rounding hides whether it starts at rest"


def name_of_event(maker: RowMaker[Any], rows: ModeRows[Any], event: Event[Any]) -> str:
    """An event of a mode by the names of its parts, as "impact at stop wall"."""
    part, scene = event.part, maker.scene
    if event.kind == HOLD:
        return f"release at {' with '.join(name_of_tie(scene, k) for k, _ in rows.cuts[part].ties)}"
    if event.kind == SWITCH:
        return name_of_switch(maker, part)
    if event.kind == DOMAIN and rows.tape is not None:
        return f"zero under a root in the formula of {rows.tape.texts[part]}"
    return name_of(scene, event.kind, part)


def name_of_switch(maker: RowMaker[Any], i: int) -> str:
    """The turn of switch number i of the formulas of a scene."""
    assert maker.formulas is not None
    return f"switch in the formula of {maker.formulas.owners[i]}"


def name_of(scene: Scene[Any], kind: int, part: int) -> str:
    """An event of one part, by its kind and the number of the part in its section."""
    if kind == SLIDE:
        return f"end of sliding at {called('friction', scene.frictions[part])}"
    if kind == CLEARANCE:
        return f"limit of {called('clearance', scene.clearances[part])}"
    what = {GAP: "contact", PUSH: "zero force", STRIKE: "impact"}[kind]
    return f"{what} at {called('stop', scene.stops[part])}"


def called(word: str, part: Friction[Any] | Stop[Any] | RigidStop[Any] | Clearance[Any]) -> str:
    """A part by what it is and its name; those of two blocks are called by what they are."""
    return word if part.name == word else f"{word} {part.name}"


def name_of_stop(scene: Scene[Any], i: int) -> str:
    """The event of a stop whose ends meet."""
    return name_of(scene, STRIKE if isinstance(scene.stops[i], RigidStop) else GAP, i)


def name_of_tie(scene: Scene[Any], k: int) -> str:
    """A tie by its number: frictions, then stops."""
    count = len(scene.frictions)
    return called("friction", scene.frictions[k]) if k < count else called("stop", scene.stops[k - count])


def few_of(names: Iterable[str]) -> tuple[str, ...]:
    """The first few of many names, and how many more there are."""
    every: Sequence[str] = list(dict.fromkeys(names))
    more = len(every) - MOST_NAMED
    return (*every[:MOST_NAMED], f"{more} more") if more > 0 else tuple(every)
