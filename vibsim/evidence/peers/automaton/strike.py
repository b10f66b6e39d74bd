"""What happens at a rigid stop that is struck: blows until none closes, then rest or a hop."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf

from vibsim.evidence.peers.automaton.blow import blow
from vibsim.evidence.peers.automaton.consistent_states import States
from vibsim.evidence.peers.automaton.instant import Instant
from vibsim.evidence.peers.equations.switches import BACKWARD, FORWARD, OPEN, REST, STICK
from vibsim.physics.parts import Friction, RigidStop

ZERO = 1e-13  # of the fastest approach: at rest but for rounding
MOST_BLOWS = 100  # at one instant
LATER, NEVER = 1e300, inf  # s, until a hop ends


@dataclass(frozen=True)
class Shortest:
    """Hops of no more than `height` [m], or `time` [s], are none."""

    height: float
    time: float = 0.0

    def holds(self, speed: float, press: float) -> bool:
        """Whether a hop that begins with `speed` [m/s] against `press` [m/s^2] is none."""
        return press > 0 and (speed**2 <= 2 * press * self.height or 2 * speed <= press * self.time)


@dataclass
class Struck:
    """impacts : stops that were struck while they closed; undecided : parts at rest behind the blows;
    hop_ends : until the shortest hop ends [s], LATER where that is not in sight
    """

    impacts: int
    undecided: list[int]
    hop_ends: float


def strike(
    at: Instant, states: States, striking: Sequence[int], undecided: Sequence[int], shortest: Shortest
) -> Struck:
    """Blows of the stops `striking` and of those that touch; changes velocities of `at`, and `states` of the
    parts that they set in motion. undecided : other parts at rest. Raises ArithmeticError as `blow`.
    """
    touching = [i for i in _rigid(at) if _touches(at, i, states, {*striking, *undecided}, shortest)]
    frictions = [i for i, switch in enumerate(at.switches) if isinstance(switch.part, Friction)]
    slips = {i: at.rate(i) for i in frictions}
    first, struck = max(at.rate(i) for i in touching), set()
    for _ in range(MOST_BLOWS):
        rates = [at.rate(i) for i in touching]
        if not max(rates) > ZERO * first >= 0:
            break
        impulses = blow(at, touching, rates)
        struck |= {i for i, L, rate in zip(touching, impulses, rates, strict=True) if L > 0 and rate > 0}
    else:
        raise ArithmeticError(f"blows without end at {at.t:g} s")
    torn = [i for i in frictions if at.rate(i) != slips[i]]
    for i in torn:
        states[i] = FORWARD if at.rate(i) > 0 else BACKWARD
    short, hop_ends = _let_go(at, states, touching, first, shortest)
    still = [i for i in frictions if i not in torn and (i in undecided or states[i] == STICK)]
    return Struck(len(struck), [*short, *still], hop_ends)


def _rigid(at: Instant) -> list[int]:
    return [i for i, switch in enumerate(at.switches) if isinstance(switch.part, RigidStop)]


def _touches(at: Instant, i: int, states: States, there: set[int], shortest: Shortest) -> bool:
    return i in there or states[i] == REST or abs(at.depth(i)) <= shortest.height


def _let_go(
    at: Instant, states: States, touching: Sequence[int], first: float, shortest: Shortest
) -> tuple[list[int], float]:
    """Open the stops that separate behind a blow; those at rest, or with a hop that is none, and until the
    shortest of the other hops ends.
    """
    for i in touching:
        states[i] = OPEN
    values = at.balance(states)
    short, hop_ends = [], LATER
    for i in touching:
        speed, press = max(-at.rate(i), 0.0), at.second_rate(i, values)
        if speed <= ZERO * first or shortest.holds(speed, press):
            short.append(i)
        elif press > 0:
            hop_ends = min(hop_ends, 2 * speed / press)
    if short:
        at.halt(short)
    return short, hop_ends
