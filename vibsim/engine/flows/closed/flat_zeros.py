"""Zeros too flat for the closed form, of event functions with more zero derivatives than that takes.

At the end of a chain whose other end is driven every body between makes two more derivatives zero. In Taylor
series they are exactly zero; in modal coordinates rounding stands in for them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from vibsim.engine.flows.closed.closed_form_search import FLAT_ORDER
from vibsim.engine.modes.rows import ACCELERATION, COUPLING, DIFFERENCE, Coupling, Event, Known, ModeRows
from vibsim.engine.state import State
from vibsim.physics.arithmetic.numbers import N
from vibsim.physics.parts import Scene

if TYPE_CHECKING:
    from vibsim.engine.flows.closed.closed_form import ClosedForm


def leaves_flat(closed: ClosedForm[N], state: State[N], rows: ModeRows[N], known: Known) -> bool:
    """Whether an event function may leave zero with more zero derivatives than the closed form takes."""
    if closed.dimension(rows) <= FLAT_ORDER:
        return False
    return any(
        known.get(event.key, 0) >= FLAT_ORDER or _rests_at_zero(event, rows, state, closed.scene)
        for event in rows.events
    )


def _rests_at_zero(event: Event[N], rows: ModeRows[N], state: State[N], scene: Scene[N]) -> bool:
    """Whether an event function is zero because all that it is made of stands still."""
    total = state.t - state.t
    for term in event.terms:
        value: N | None = None
        if term.kind == COUPLING:
            value = _still_force(rows.couplings[term.P], state)
        elif term.kind == DIFFERENCE:
            value = _still_distance(state, term.P, term.Q)
        elif term.kind == ACCELERATION and _is_left_alone(rows, rows.leader[term.P], state, scene):
            continue
        if value is None:
            return False
        total = total + term.coefficient * value
    return bool(event.terms) and total + event.constant == 0


def _is_left_alone(rows: ModeRows[N], leader: int, state: State[N], scene: Scene[N]) -> bool:
    """Whether no force acts on a group, nor begins to."""
    leaders, n = rows.leader, len(state.x)
    if leader >= n:
        return leader == n
    if any(leaders[force.on] == leader for force in scene.forces):
        return False
    if any(leaders[column] == leader for column, _ in rows.constants):
        return False
    return all(
        _still_force(one, state) == 0 for one in rows.couplings if leader in (leaders[one.P], leaders[one.Q])
    )


def _still_force(one: Coupling[N], state: State[N]) -> N | None:
    """The force of a coupling whose ends move alike; None of others."""
    apart = _still_distance(state, one.P, one.Q)
    return None if apart is None else one.k * apart + one.offset


def _still_distance(state: State[N], P: int, Q: int) -> N | None:
    """x_P - x_Q of two columns that move alike; None of others, and of the base."""
    n = len(state.x)
    if n < P or n < Q:
        return None
    zero = state.t - state.t
    (xP, vP), (xQ, vQ) = ((state.x[c], state.v[c]) if c < n else (zero, zero) for c in (P, Q))
    return xP - xQ if vP == vQ else None
