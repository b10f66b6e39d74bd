"""The states of the parts behind an event, found by trying.

Of all combinations of states of the parts that are undecided at an instant, the first whose accelerations and
forces are consistent; those with most ties are tried first, so friction sticks whenever it can.
"""

from collections.abc import Iterator, Sequence
from itertools import product
from math import prod

from vibsim.evidence.peers.automaton.instant import Instant
from vibsim.evidence.peers.equations.switches import BACKWARD, FORWARD, OPEN, REST, STICK, TIES
from vibsim.physics.parts import Friction

HELD = 1.0 - 1e-10  # of the limit friction, below which ends stick: at a release the force equals it
SLACK = 1e-9  # of the largest force: beside a release that of slip is zero to HELD
MOST = 3**9  # combinations that are tried: those of nine frictions
ZERO = 1e-13  # of the largest force: zero but for rounding

States = list[str]


def consistent_states(at: Instant, states: States, undecided: Sequence[int]) -> States | None:
    """`states` with those of the parts `undecided` chosen; None where no combination is consistent.

    Raises ArithmeticError where one may be whose forces are not unique: its consistency cannot be told; and
    for more combinations than MOST.
    """
    if not undecided:
        return states
    if len(undecided) == 1 and isinstance(at.switches[undecided[0]].part, Friction):
        return _of_one_friction(at, states, undecided[0])
    trials = _combinations(at, states, undecided)
    return next((trial for trial in trials if _is_consistent(at, trial, undecided)), None)


def _of_one_friction(at: Instant, states: States, i: int) -> States:
    """It sticks if it holds, else it slips the way it is pulled."""
    chosen = list(states)
    chosen[i] = STICK
    force, (forwards, backwards) = at.tie_force(i, at.balance(chosen)), at.switches[i].part.limits
    if force < -HELD * forwards:
        chosen[i] = FORWARD
    elif force > HELD * backwards:
        chosen[i] = BACKWARD
    return chosen


def _combinations(at: Instant, states: States, undecided: Sequence[int]) -> Iterator[States]:
    count = prod(len(at.switches[i].states) for i in undecided)
    if count > MOST:
        raise ArithmeticError(f"{count} combinations of the parts at rest, of which {MOST} can be tried")
    choices = product(*(at.switches[i].states for i in undecided))
    for choice in sorted(choices, key=lambda choice: -sum(state in TIES for state in choice)):
        trial = list(states)
        for i, state in zip(undecided, choice, strict=True):
            trial[i] = state
        yield trial


def _is_consistent(at: Instant, states: States, undecided: Sequence[int]) -> bool:
    values = at.balance(states)
    scale = max((abs(at.tie_force(i, values)) for i in at.compiled.ties), default=0.0)
    for body, mass in enumerate(at.compiled.masses):
        scale = max(scale, abs(mass * values[2 * body + 1]))
    return all(_agrees(at, i, states[i], values, scale) for i in undecided)


def _agrees(at: Instant, i: int, state: str, values: Sequence[float], scale: float) -> bool:
    """Whether the state of part i agrees with its force, or with its acceleration. scale : forces [N]"""
    if state == REST:
        return at.tie_force(i, values) >= -ZERO * scale
    if state == STICK:
        forwards, backwards = at.switches[i].part.limits
        return bool(-HELD * forwards <= at.tie_force(i, values) <= HELD * backwards)
    force = min(at.compiled.masses) * at.second_rate(i, values)
    if state == OPEN:
        return bool(force <= ZERO * scale)
    return bool((force if state == FORWARD else -force) >= -SLACK * scale)
