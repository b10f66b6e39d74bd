"""The mode automaton around a solver that finds events: {free, contact} x {slip +, slip -, stick}.

Every event function is positive inside its mode and watched falling, so that a zero just taken is not met
again; all have simple zeros.
"""

from collections.abc import Callable, Sequence
from math import copysign

from vibsim.evidence.peers.equations import Equations, State

HELD = 1.0 - 1e-10  # share of the limit friction below which block 2 sticks: at a release |S| = N to rounding


def falling(function):
    """Mark an event function for solve_ivp: it ends the call, and only where it falls through zero."""
    function.terminal, function.direction = True, -1
    return function


class Mode:
    """The mode of the motion, from that of `state` on.

    contact : whether the stop acts; stuck : whether block 2 rests; sigma : sgn(v2) while it slides
    """

    def __init__(self, equations: Equations, state: State):
        self.equations, scene = equations, equations.scene
        self.rubs, self.has_stop = scene.has_friction, scene.has_stop
        gap = equations.gap(state) if scene.has_stop else -1.0
        self.contact = gap > 0 or (gap == 0 and equations.gap_rate(state) > 0)
        self.sigma, self.stuck = 1.0, equations.fixed
        if self.rubs:
            force = equations.force(state, self.contact)
            self.sigma = copysign(1.0, state[3] or force)
            self.stuck = state[3] == 0 and abs(force) <= scene.N

    def motion(self, t: float, state: Sequence[float]) -> tuple[float, ...]:
        """d state/dt in this mode."""
        equations = self.equations
        S = equations.force(state, self.contact)
        a2 = 0.0 if self.stuck else (S - self.sigma * equations.N) / equations.scene.m2
        return equations.rates(t, state, S, a2)

    def event_functions(self) -> list[Callable[..., float]]:
        """What ends this mode."""
        functions: list[Callable[..., float]] = [self.gap] if self.has_stop else []
        if self.rubs:
            functions.append(self.hold if self.stuck else self.slide)
        return functions

    @falling
    def gap(self, t, state):
        """Minus g while free, g in contact [m]."""
        gap = self.equations.gap(state)
        return gap if self.contact else -gap

    @falling
    def slide(self, t, state):
        """sigma v2 [m/s]."""
        return self.sigma * state[3]

    @falling
    def hold(self, t, state):
        """N - |S| [N]."""
        return self.equations.N - abs(self.equations.force(state, self.contact))

    def switch(self, function: Callable[..., float], state: list[float]) -> str | None:
        """Enter the mode behind the zero of `function` at `state`; the kind of the event.

        Sets v2 to zero where block 2 begins to stick. None for a zero that changes nothing, as rounding
        makes them beside a release.
        """
        if function == self.gap:
            self.contact = not self.contact
            return "contact_begin" if self.contact else "contact_end"
        force = self.equations.force(state, self.contact)
        before, self.sigma = self.sigma, copysign(1.0, force)
        if function == self.hold:
            self.stuck = False
            return "stick_end"
        if abs(force) < HELD * self.equations.N:
            self.stuck, state[3] = True, 0.0
            return "stick_begin"
        return "reversal" if self.sigma != before else None
