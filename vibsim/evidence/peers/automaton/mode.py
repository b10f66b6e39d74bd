"""The mode automaton around a solver that finds events: which state each stop and friction is in."""

from vibsim.evidence.peers.automaton.consistent_states import SLACK, consistent_states
from vibsim.evidence.peers.automaton.instant import Instant
from vibsim.evidence.peers.automaton.strike import NEVER, Shortest, strike
from vibsim.evidence.peers.equations.compiled import Compiled
from vibsim.evidence.peers.equations.switches import (
    BACKWARD,
    CONTACT,
    FORWARD,
    FREE,
    LIFTED,
    OPEN,
    REST,
    STICK,
    TIES,
)
from vibsim.physics.parts import AT_FORCE, Friction, RigidStop

KINDS = {
    (FREE, CONTACT): "contact_begin",
    (CONTACT, FREE): "contact_end",
    (CONTACT, LIFTED): "contact_end",
    (LIFTED, CONTACT): "contact_begin",
    (FORWARD, BACKWARD): "reversal",
    (BACKWARD, FORWARD): "reversal",
    (FORWARD, STICK): "stick_begin",
    (BACKWARD, STICK): "stick_begin",
    (STICK, FORWARD): "stick_end",
    (STICK, BACKWARD): "stick_end",
    (OPEN, REST): "rest_begin",
    (REST, OPEN): "rest_end",
}

STILL = 1e-12  # of the fastest velocity: at rest but for rounding

Events = list[str]  # kinds


class Mode:
    """The mode of the motion: `begin` with the state at t = 0, then `switch` at every event.

    states : of the parts; parameters : what the equations take; hop_ends : until the shortest hop ends that
    has just begun [s], LATER where that is not in sight, NEVER where none began
    """

    def __init__(self, compiled: Compiled, shortest: Shortest):
        self.compiled, self.switches, self.shortest = compiled, compiled.switches, shortest
        self.states = [switch.states[0] for switch in self.switches]
        self.parameters: list[float] = []
        self.hop_ends = NEVER
        self._damped = [i for i, switch in enumerate(self.switches) if LIFTED in switch.states]
        self._without_jump = {
            i
            for i, switch in enumerate(self.switches)
            if switch.states == (FREE, CONTACT) and not switch.part.c
        }

    def begin(self, state: list[float]) -> Events:
        """Take the mode of the state at t = 0, in which a blow may fall; kinds of the events."""
        at = Instant(self.compiled, 0.0, state)
        undecided, striking = [], []
        for i, switch in enumerate(self.switches):
            if isinstance(switch.part, Friction):
                self.states[i] = FORWARD if at.rate(i) > 0 else BACKWARD
                undecided += [i] * (at.rate(i) == 0)
            elif isinstance(switch.part, RigidStop):
                touches = switch.part.at_start or at.depth(i) == 0
                self.states[i] = OPEN
                undecided += [i] * (touches and at.rate(i) == 0)
                striking += [i] * (touches and at.rate(i) > 0)
            else:
                self.states[i] = _elastic_at_start(at, i)
        events: Events = []
        if striking:
            events, undecided = self._strike(at, striking, undecided)
        self._settle(at, undecided)
        return events

    def switch(self, i: int, t: float, state: list[float]) -> Events:
        """Enter the mode behind the zero of an event function of part i; kinds of the events.

        Sets the velocities in `state` to those behind it. No kind where nothing changes, as rounding makes
        zeros beside a release. Raises ArithmeticError where no mode is consistent.
        """
        before = list(self.states)
        impacts: Events = []
        self.hop_ends = NEVER
        if i in self._without_jump:  # of any force: nothing else changes
            self.states[i] = CONTACT if before[i] == FREE else FREE
            self.parameters = self.compiled.parameters(self.states)
            return [KINDS[before[i], self.states[i]]]
        at = Instant(self.compiled, t, state)
        undecided = [j for j, each in enumerate(before) if each in TIES and j != i]
        match before[i]:
            case "open":
                impacts, undecided = self._strike(at, [i], undecided)
            case "rest":
                self.states[i] = OPEN
            case "stick":
                self.states[i] = self._torn(at, i)
            case "forward" | "backward":
                undecided += [i, *self._still(at, i)]
            case _:
                self.states[i] = _elastic_behind(at, i, before[i])
        self._settle(at, undecided, i)
        steps = zip(before, self.states, strict=True)
        return impacts + [KINDS[step] for step in steps if step in KINDS]

    def _strike(self, at: Instant, striking: list[int], undecided: list[int]) -> tuple[Events, list[int]]:
        struck = strike(at, self.states, striking, undecided, self.shortest)
        self.hop_ends = struck.hop_ends
        return ["impact"] * struck.impacts, struck.undecided

    def _still(self, at: Instant, i: int) -> list[int]:
        """Frictions that slide, and come to rest at the same instant as friction i."""
        fastest = max(map(abs, at.state[1 : 2 * len(self.compiled.masses) : 2]))
        slides = (j for j, each in enumerate(self.states) if each in (FORWARD, BACKWARD) and j != i)
        return [j for j in slides if abs(at.rate(j)) <= STILL * fastest]

    def _torn(self, at: Instant, i: int) -> str:
        """The way a stick that ends begins to slip."""
        forwards, backwards = self.switches[i].part.limits
        force = at.tie_force(i, at.balance(self.states))
        return FORWARD if forwards + force < backwards - force else BACKWARD

    def _settle(self, at: Instant, undecided: list[int], last: int | None = None) -> None:
        """Choose the states of the parts `undecided`; where that cannot be done, of part `last` too."""
        self._mend_lifts(at)
        states = consistent_states(at, self.states, undecided)
        if states is None and last is not None and self.switches[last].tie:
            undecided = [*undecided, last]
            states = consistent_states(at, self.states, undecided)
        if states is None:
            raise ArithmeticError(f"no mode is consistent at {at.t:.9g} s")
        self.states, self.parameters = states, self.compiled.parameters(states)
        tied = [i for i in dict.fromkeys(undecided) if states[i] in TIES]
        if tied:
            at.halt(tied)

    def _mend_lifts(self, at: Instant) -> None:
        """Where a blow has turned the force of a damped stop round, it lets go, or takes hold again."""
        for i in self._damped:
            if self.states[i] != FREE and at.depth(i) > self.shortest.height:
                force = at.contact_force(i)
                if abs(force) > SLACK * self.switches[i].part.k * at.depth(i):
                    self.states[i] = CONTACT if force > 0 else LIFTED


def _elastic_at_start(at: Instant, i: int) -> str:
    """The state of an elastic stop at t = 0: deep, or touching on its way in."""
    part = at.switches[i].part
    depth = 0.0 if part.at_start else at.depth(i)
    if depth < 0 or (depth == 0 and at.rate(i) < 0):
        return FREE
    return LIFTED if part.release == AT_FORCE and at.contact_force(i) < 0 else CONTACT


def _elastic_behind(at: Instant, i: int, state: str) -> str:
    """The state of an elastic stop behind the end of one."""
    part, depth = at.switches[i].part, at.depth(i)
    if state == FREE:
        return CONTACT
    if state == CONTACT:
        return LIFTED if part.release == AT_FORCE and part.c and depth > 0 else FREE
    return FREE if part.k * depth < abs(at.contact_force(i)) else CONTACT
