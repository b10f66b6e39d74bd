"""Which events C can take by itself: what follows them is known before they happen, but for one comparison.

What follows other events Python decides, by the `Automaton`.
"""

from __future__ import annotations

from vibsim.engine.events.automaton import Automaton
from vibsim.engine.modes.rows import (
    CLEARANCE,
    CROSS,
    CROSS_IF_TIES_HOLD,
    DOMAIN,
    GAP,
    HOLD,
    PUSH,
    RIGID_IMPACT,
    SLIDE,
    STICK_OR_REVERSE,
    STRIKE,
    SWITCH,
    Event,
    EventKey,
    Joined,
    ModeRows,
    Rule,
)
from vibsim.engine.modes.status import CONTACT, LIFTED, OPEN, RESTING, STICK, Status
from vibsim.engine.modes.ties import TooManyCuts


class RuleMaker:
    """Makes the rules of a scene's events, as its automaton would decide."""

    def __init__(self, automaton: Automaton) -> None:
        self.automaton, self.scene, self.maker = automaton, automaton.scene, automaton.maker

    def rule(self, rows: ModeRows, event: Event) -> Rule | None:
        """The rule of an event, or None where Python decides."""
        try:
            rule = self._rule(rows, event)
        except TooManyCuts:  # of a mode that may never come
            return None
        return rule if rule is None or self.maker.is_watched(rule.target) else None

    def _rule(self, rows: ModeRows, event: Event) -> Rule | None:
        status, i, key = rows.status, event.part, event.key
        if event.kind in (SWITCH, DOMAIN):
            return self._turn_rule(status, event)
        if self.scene.has_courses and event.kind in (STRIKE, SLIDE, HOLD):
            return None
        if event.kind == STRIKE:
            return self._impact_rule(status, event)
        if event.kind == GAP:
            return self._contact_rule(status, event, key)
        if event.kind == PUSH:
            pulled = LIFTED if status.stops[i] == CONTACT else CONTACT
            kind = "contact_end" if pulled == LIFTED else "contact_begin"
            return self._cross(status.with_stop(i, pulled), kind, i, key, 1)
        if event.kind == CLEARANCE:
            turned = 1 - status.clearances[i]
            kind = "violation_begin" if turned else "violation_end"
            return self._cross(status.with_clearance(i, turned), kind, i, key, 1)
        if event.kind == SLIDE:
            return self._stand_rule(status, event, key)
        cut = rows.cuts[i]
        if len(cut.ties) > 1:
            return None
        tie, orientation = cut.ties[0]
        if tie >= len(status.frictions):
            i = tie - len(status.frictions)
            return self._cross(status.with_stop(i, OPEN), "rest_end", i, (STRIKE, i), 3)
        after = status.with_frictions({tie: orientation * event.direction})
        drops = self.scene.frictions[tie].drops(after.frictions[tie])
        if drops and after.tied:  # the drop may tear those too
            return self._cross(after, "stick_end", tie, (SLIDE, tie), 1, CROSS_IF_TIES_HOLD)
        return self._cross(after, "stick_end", tie, (SLIDE, tie), 1 if drops else 2)

    @staticmethod
    def _cross(
        status: Status, happened: str, part: int, key: EventKey, order: int, kind: int = CROSS
    ) -> Rule:
        return Rule(kind, status, None, -1, happened, part, key, order)

    def _turn_rule(self, status: Status, event: Event) -> Rule | None:
        """Of a switch whose sides are equal at its zero: a kink, of which nothing is told."""
        switches = self.automaton.departures.switches
        if event.kind != SWITCH or switches is None or not switches.rows.only_bends(event.part):
            return None
        return self._cross(switches.turned(status, event), "", -1, event.key, 1)

    def _impact_rule(self, status: Status, event: Event) -> Rule | None:
        """Of an impact on a stop, where no stop rests, where no friction sticks but those that it makes slip,
        and no damped stop at its ends lets go at zero force; without rotors on bodies, and switches of
        formulas, which it may turn.
        """
        i, scene, formulas = event.part, self.scene, self.maker.formulas
        if scene.rotors or (formulas is not None and formulas.switches):
            return None
        struck = {column for column in self.maker.ends(scene.stops[i]) if column < self.maker.n}
        lifting = [stop for _, stop in scene.elastic_stops if stop.lets_go]
        lasting: list[Joined] = [self.maker.tie(k) for k in status.tied]
        if RESTING in status.stops or any(struck & set(self.maker.ends(stop)) for stop in lifting):
            return None
        if any(not struck & set(self.maker.ends(tie)) for tie in lasting):
            return None
        return Rule(RIGID_IMPACT, status, None, -1, "impact", i, event.key, 1)

    def _contact_rule(self, status: Status, event: Event, key: EventKey) -> Rule | None:
        i = event.part
        stop, before = dict(self.scene.elastic_stops)[i], status.stops[i]
        behind = status.with_stop(i, CONTACT if before == OPEN else OPEN)
        told = "contact_begin" if before == OPEN else "contact_end", i
        if before == LIFTED:  # of which the end of its contact has been told
            told = "", -1
        if not stop.jumps or not status.tied:
            return self._cross(behind, *told, key, 1)
        self.maker.rows(behind)  # which may have too many cuts
        if not self.automaton.settling.possible(behind):
            return None
        return self._cross(behind, *told, key, 1, CROSS_IF_TIES_HOLD)

    def _stand_rule(self, status: Status, event: Event, key: EventKey) -> Rule | None:
        i = event.part
        standing = self.automaton.settling.standing(status, [i])
        stuck = status.with_frictions(dict.fromkeys(standing, STICK))
        rows = self.maker.rows(stuck)
        if set(standing) - {i} != set(status.tied) or not self.automaton.settling.possible(stuck):
            return None
        other, hold = None, -1
        before = status.frictions[i]
        for number, e in enumerate(rows.events):
            if e.kind == HOLD and [(i, -before * e.direction)] == list(rows.cuts[e.part].ties):
                other, hold = status.with_frictions({i: -before}), number
        return Rule(STICK_OR_REVERSE, stuck, other, hold, "stick_begin", i, key, 1)
