"""How the packed numbers of a mode follow from some numbers of its scene: recorded once, repeated for others.

A branch over a damping or a gap changes numbers of the same few modes from value to value. Making their rows
takes some 0.1 ms each; what of them depends on the parameter is a handful of operations.
"""

from __future__ import annotations

from array import array
from collections.abc import Sequence
from typing import Any, NamedTuple

from vibsim.engine.flows.closed.modal import pitches
from vibsim.engine.flows.closed.modal_maker import modal_of
from vibsim.engine.modes.packing import Packed, packed_mode
from vibsim.engine.modes.row_maker import RowMaker
from vibsim.engine.modes.rows import EventKey
from vibsim.engine.modes.same_structure import Place, with_number
from vibsim.engine.modes.status import Status
from vibsim.physics.parts import Scene
from vibsim.physics.traced_numbers import NotRecorded, Record, Recorded, RecordedNumbers


class ParametricRows(NamedTuple):
    """The packed numbers of a mode at first, and how those that change follow from the numbers of the scene.

    changing : by place among the doubles, the place in the record
    """

    ints: bytes
    doubles: array[float]
    changing: tuple[tuple[int, int], ...]
    record: Record

    def packed(self, numbers: Sequence[float]) -> Packed | None:
        """The mode as bytes of ints and of doubles for other numbers; None where it takes another form."""
        values = self.record.repeated(numbers)
        if values is None:
            return None
        doubles = self.doubles[:]
        for place, number in self.changing:
            doubles[place] = values[number]
        return self.ints, doubles.tobytes()


def recipe_of(
    scene: Scene, places: Sequence[Place], status: Status, keys: dict[EventKey, int]
) -> ParametricRows | None:
    """The recipe of a mode for the numbers of a scene in `places`; None where it cannot be recorded, as that
    of a mode with formulas.

    keys : {event key: number}, which grows
    """
    if scene.has_formulas:
        return None
    kit: Any = RecordedNumbers
    record = Record([_number(scene, place) for place in places])
    recorded: Any = scene
    for place, number in zip(places, record.inputs, strict=True):
        recorded = with_number(recorded, place, number)
    try:
        rows = RowMaker(recorded, kit).rows(status)
        if scene.method != "taylor":
            rows.modal = modal_of(recorded, kit, rows, pitches(recorded))  # type: ignore[assignment]
        pack = packed_mode(rows, keys)
    except NotRecorded:
        return None
    numbers: list[Any] = [*pack.doubles]
    changing = tuple((i, number.place) for i, number in enumerate(numbers) if isinstance(number, Recorded))
    doubles = array("d", (n.value if isinstance(n, Recorded) else n for n in numbers))
    return ParametricRows(array("i", pack.ints).tobytes(), doubles, changing, record)


def _number(scene: Any, place: Place) -> float:
    """The number of a scene in a place."""
    for step in place:
        scene = scene[step] if isinstance(step, int) else getattr(scene, step)
    return float(scene)
