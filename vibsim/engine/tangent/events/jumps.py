"""Jumps of disturbances at events, where the C engine leaves them to Python."""

from __future__ import annotations

from array import array
from collections.abc import Callable
from typing import Any

from vibsim.engine.events.impacts.touch import Touch
from vibsim.engine.modes.rows import HOLD, STRIKE, Event, ModeRows
from vibsim.engine.modes.rule import Rule
from vibsim.engine.modes.status import Status
from vibsim.engine.state import State
from vibsim.engine.tangent.events.impact_saltation import Undefined
from vibsim.engine.tangent.events.saltation import released_frictions, saltation
from vibsim.engine.tangent.events.tangencies import Tangencies
from vibsim.physics.arithmetic.numbers import Doubles
from vibsim.physics.parts import Scene


class Jumps:
    """What events of a scene do to disturbances that a run in C carries.

    run : that run, an `_engine.Run`; rows : the rows of a mode, by its status
    """

    def __init__(self, scene: Scene, run: Any, rows: Callable[[Status], ModeRows]) -> None:
        self.scene, self.run, self.rows = scene, run, rows
        self.tangencies = Tangencies(scene, Doubles)

    def in_c(self, before: ModeRows, after: ModeRows, event: Event) -> bool:
        """Whether C knows what `event` does to disturbances between the modes of two rows: saltation.c and
        tangencies.c, against `saltation.py` and `tangencies.py`.
        """
        if event.kind == STRIKE:
            return False
        return event.kind != HOLD or not released_frictions(self.scene, before, after)

    def of_rule_in_c(self, rows: ModeRows, rule: Rule, event: Event) -> bool:
        """The same for all that a rule may lead to."""
        behind = [rule.target] if rule.other is None or rule.hold < 0 else [rule.target, rule.other]
        return all(self.in_c(rows, self.rows(status), event) for status in behind)

    def hand(
        self, event: Event, state: State, before: ModeRows, after: ModeRows, touch: Touch | None
    ) -> None:
        """Take disturbances from C through `event`, as `TangentBundle.cross` does, and give them back.

        touch : what rigid stops did
        """
        entries, near = self.run.disturbances(), self.tangencies
        vectors = entries["vectors"]
        near.forget()
        near.fastest = entries["fastest"]
        jump = saltation(self.scene, Doubles, state, before, after, event, touch)
        near.judge(event, state, before, after, jump)
        jump = None if isinstance(jump, Undefined) else jump
        determinant = jump.determinant if jump and before.leader == after.leader else 1.0
        moved = array("d", (value for one in vectors for value in (jump.applied(one) if jump else one)))
        lost = near.undefined > 0
        self.run.hand_jump(jump is not None, determinant, near.count, near.closest, lost, moved.tobytes())
