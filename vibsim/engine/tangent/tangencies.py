"""Events that are crossed almost tangentially: there a disturbance is small only as long as it is tiny.

Where an event function h is crossed at the rate h', the motion goes beyond by about h'^2 / (2 |h''|) before
it can turn. A disturbance larger than that misses the event, and first order (the tangent flow) says nothing
of it. Crossings are judged by the square of their rate over that of the whole motion, about their share of
the depth of the deepest one. A share below CLOSE counts as a tangency. An impact on a rigid stop counts
where the acceleration in front of it parts the ends; where it drives them together, as in chatter, no motion
turns before the stop. Below GRAZING rounding decides whether it comes up to the stop at all, and there is no
derivative; nor at other events whose saltation is undefined. There its share is that of the motion since the
stop was struck before: hops of a sequence of impacts shrink, and their approaches are no slower than they.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from math import inf, nan
from typing import Any, Generic

import numpy as np

from vibsim.engine.errors import State
from vibsim.engine.events.impacts.simultaneous import SimultaneousImpacts
from vibsim.engine.flows.base_motion import base_motion
from vibsim.engine.flows.expansion import Expansion
from vibsim.engine.modes.rows import FORMULA, GAP, HOLD, SLIDE, STRIKE, SWITCH, Event, Joined, ModeRows, Rule
from vibsim.engine.modes.status import STICK, Status
from vibsim.engine.tangent.impact_saltation import JOINED, UNDEFINED, ImpactSaltation, NoMatrix
from vibsim.engine.tangent.saltation import EventCrossing, Jump, ModeChange, gradient
from vibsim.engine.tangent.tangent_space import natural_rate
from vibsim.physics.numbers import Kit, N, abs
from vibsim.physics.parts import Scene

CLOSE = 1e-6  # a rate of 1/1000 of the largest
GRAZING = 2.0**-40  # a depth of some thousand roundings
SAME, MOVED, JOIN = range(3)  # what an event does to disturbances, as in tangent.h


class Jumps(Generic[N]):
    """Effect of the events of a scene on disturbances that a run in C carries, where C leaves it to Python.

    run : that run, an `_engine.Run`; rows : the rows of a mode, by its status
    """

    def __init__(
        self, scene: Scene[N], run: Any, rows: Callable[[Status], ModeRows[N]], expansion: Expansion[N]
    ) -> None:
        self.scene, self.run, self.rows = scene, run, rows
        self.expansion, self.form, self.kit = expansion, expansion.form, expansion.kit
        self.rate = natural_rate(scene, self.kit)

    def in_c(
        self,
        before: ModeRows[N],
        after: ModeRows[N],
        event: Event[N],
        touch: SimultaneousImpacts[N] | None = None,
    ) -> bool:
        """Whether C knows what `event` does to disturbances between the modes of two rows: saltation.c and
        tangencies.c, against `saltation.py` and `tangencies.py`. touch : what rigid stops did
        """
        if event.kind == STRIKE or touch is not None:
            return False
        change = ModeChange(self.scene, before, after, event)
        if before.tape is not None and (change.turns_forces if event.kind == SWITCH else change.by_formulas):
            return False
        return event.kind != HOLD or not change.released

    def of_rule_in_c(self, rows: ModeRows[N], rule: Rule, event: Event[N]) -> bool:
        """The same for all that a rule may lead to."""
        behind = [rule.target] if rule.other is None or rule.hold < 0 else [rule.target, rule.other]
        return all(self.in_c(rows, self.rows(status), event) for status in behind)

    def hand(
        self,
        event: Event[N],
        state: State[N],
        before: ModeRows[N],
        after: ModeRows[N],
        touch: SimultaneousImpacts[N] | None,
    ) -> None:
        """Take disturbances from C through `event`, judge it, and give them back.

        touch : what rigid stops did
        """
        entries, form = self.run.disturbances(), self.form
        vectors = entries["vectors"]
        at = EventCrossing(self.scene, before, after, event, self.expansion, state, touch)
        jump = at.saltation()
        closest, undefined = self._judged(at, jump, entries["fastest"], entries["since"])
        kind = JOIN if jump is JOINED else SAME
        determinant = self.kit.number(1)
        if not isinstance(jump, NoMatrix | None):
            kind, vectors = MOVED, map(jump.applied, vectors)
            determinant = jump.determinant if before.leader == after.leader else determinant
        moved = form.packed([value for one in vectors for value in one])
        self.run.hand_jump(kind, determinant, int(closest < CLOSE), closest, undefined, moved)

    def _judged(
        self, at: EventCrossing[N], jump: Jump[N] | NoMatrix | None, fastest: Sequence[N], since: Sequence[N]
    ) -> tuple[N, bool]:
        """(Square of the rate of an event over that of the whole motion, at most 1, and 1 where it is not
        judged; whether it has no derivative).

        fastest : by stop, the largest |v_P - v_Q| + rate |x_P - x_Q| at an event or the end of a step [m/s]
        since : by stop, the same since it was struck last, with x_P - x_Q counted from where that was [m/s]
        """
        event, before, after, one = at.event, at.before, at.after, self.kit.number(1)
        i, grazes = event.part, False
        if jump is UNDEFINED:
            return one, True
        if event.kind == GAP and fastest[i] > 0 and before.status.stops[i] != after.status.stops[i]:
            share = self._parting_rate(self.scene.stops[i], at.state, before) / fastest[i]
        elif isinstance(jump, ImpactSaltation) and fastest[i] > 0 and jump.drive <= 0:
            share = jump.approach / fastest[i]
            grazes = bool(jump.approach * jump.approach < GRAZING * (since[i] * since[i]))
        elif event.kind == SLIDE and after.status.frictions[i] == STICK:
            share = self._stopping_share(at)
        elif event.kind == HOLD and at.tied and at.released:
            share = self._tearing_share(at)
        else:
            return one, False
        share = share * share
        return share if share < one else one, grazes

    def _parting_rate(self, stop: Joined, state: State[N], rows: ModeRows[N]) -> N:
        """v_P - v_Q [m/s]."""
        zero = self.kit.number(0)
        v = (*state.v, base_motion(self.scene, self.kit, state.t, rows)[1], zero)  # BASE is -2, GROUND -1
        return v[stop.P] - v[stop.Q]

    def _tearing_share(self, at: EventCrossing[N]) -> N:
        """How fast the force of ties comes to a limit at which it drops, over a sweep through all that they
        can hold at the natural rate [-]. Where it does not drop nothing depends on the instant.
        """
        cut, held = at.before.cuts[at.event.part], self.kit.number(0)
        for limit in (cut.above, cut.below):  # a rigid stop at rest holds any force one way
            held = held if limit is None else held + limit
        rate = at.tie_rate
        for term in at.event.terms:
            if term.kind == FORMULA and term.coefficient == 1:
                held = held + 2 * abs(at.expansion.formulas()[term.P])
        return -rate / (held * self.rate)

    def _stopping_share(self, at: EventCrossing[N]) -> N:
        """Deceleration of a sliding that ends, over the largest with which it can end in sticking [-]: with
        the friction turned round it would be 0 at least.

        It is 0 where the motion just touches v_rel = 0, which a disturbed one may miss; 1 where ground and
        base hold both ends, so that no force decides.
        """
        scene, kit, i, sliding = self.scene, self.kit, at.event.part, at.before.status
        n = len(scene.bodies)
        maker: Any = at.expansion.table.maker
        turned = maker.rows(sliding.with_frictions({i: -sliding.frictions[i]}))
        gained, _ = replace(at, after=turned).jump()
        largest = gradient(kit, at.event, [kit.number(0)] * n + gained[:n], n)
        return -at.rate / largest if largest != 0 else kit.number(1)


# What the disturbances of a run came to, by name.


def tangent_totals(
    scene: Scene[N], kit: Kit[N], entries: dict[str, Any], margin: float, margin_time: float
) -> dict[str, Any]:
    """Totals of the disturbances that a run in C has carried, from what `CRun.disturbances` reads.

    margin, margin_time: smallest gap at a turn without contact [m] (inf without any) and when [s].

    Their names are those of `vibsim.engine.tangent.lyapunov.LyapunovExponents`. Directions that ties held at
    the start of the span count as lost.
    """
    columns, lost = entries["columns"], np.array(entries["lost"])
    table = np.array(entries["rows"], dtype="f8").reshape(-1, 1 + len(columns))
    growth = np.ascontiguousarray(table[:, [0, *(1 + column for column in columns)]])
    growth[1:, 1:][:, lost] = -inf
    known = len(growth) > 1
    count, undefined_time = entries["undefined"]
    if count:
        growth[growth[:, 0] > undefined_time, 1:] = nan
    exponents = growth[-1, 1:] / (growth[-1, 0] - growth[0, 0]) if known else np.full(len(columns), nan)
    return {
        "exponents": exponents,
        "undefined_time": float(undefined_time) if count else nan,
        "growth": growth,
        "rank_losses": int(entries["losses"]),
        "tangent_pieces": int(entries["pieces"]),
        "volume_residual": float(entries["residual"]) if entries["complete"] and not count else nan,
        **_tangencies(scene, kit, entries["near"], growth[0, 0] if known else inf, margin, margin_time),
    }


def _tangencies(
    scene: Scene[N],
    kit: Kit[N],
    near: tuple[int, float, float, float],
    begin: float,
    margin: float,
    margin_time: float,
) -> dict[str, Any]:
    """Crossings and the closest turn. A turn as far from contact as the deepest crossing at the natural rate
    counts 1, as that crossing does.
    """
    count, closest, time, fastest = near
    if begin <= margin_time and margin < inf and fastest > 0:
        share = 2 * margin * float(natural_rate(scene, kit)) / fastest
        count += share < CLOSE
        closest, time = min((closest, time), (share, margin_time))
    return {
        "tangencies": int(count),
        "closest_tangency": float(closest),
        "closest_tangency_time": float(time) if closest < 1 else nan,
    }
