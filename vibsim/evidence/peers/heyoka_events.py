"""heyoka.py: an adaptive Taylor integrator compiled at run time, the mode automaton in its event callbacks.

The peer as good as heyoka allows: constants compiled in, modes as run-time parameters, back to Python at
events only. Every event function is positive inside its mode and watched falling, so a zero just taken is not
met again. Needs heyoka.
"""

import heyoka as hy
import numpy as np

from vibsim.evidence.peers.attempt import EVERY_KIND, Attempt
from vibsim.evidence.peers.equations import Equations
from vibsim.evidence.peers.mode import Mode
from vibsim.evidence.peers.time_limit import OutOfTime, TimeLimit
from vibsim.physics.modes import EVENT_KINDS
from vibsim.physics.two_blocks import TwoBlocks

# run-time parameters: 1 in contact; sign of the friction force; 1 while block 2 sticks
CONTACT, SIGMA, STUCK = range(3)
# heyoka deduces a cooldown by dividing by the slope: 1.9e9 s at the zero of order 2 of a stick release, and
# every later reversal missed (II-C from 8.3 s on)
COOLDOWN = 1e-9  # s
FAR = 1.0  # keeps the event function of another friction mode away from zero
PIECE = 100  # samples between two looks at the clock


class HeyokaEvents:
    """A scene compiled to the tolerance `tol` (relative)."""

    def __init__(self, scene: TwoBlocks, tol: float):
        hy.llvm_state.set_diskcache_enabled(False)  # so that compiling is compiling
        self.equations = Equations(scene)
        self.start = self.equations.start()
        self.mode = Mode(self.equations, self.start)
        system, functions = expressions(scene)
        options = {"direction": hy.event_direction.negative, "cooldown": COOLDOWN}
        events = [
            hy.t_event(function, callback=self._callback(name), **options)
            for name, function in functions.items()
        ]
        self.integrator = hy.taylor_adaptive(system, self.start, t_events=events, tol=tol)
        self.events: list[tuple[float, int]] = []

    def run(self, times: np.ndarray, limit: TimeLimit) -> Attempt:
        """States at the ascending `times` [s], from 0 to the end. Raises ArithmeticError where it fails."""
        self._restart()
        pieces, steps, stopped, first = [np.array([self.start])], 0, False, 0
        try:
            while first < len(times) - 1:
                ahead = times[first : first + PIECE + 1]
                outcome, _, _, taken, _, states = self.integrator.propagate_grid(ahead)
                steps += taken
                if outcome != hy.taylor_outcome.time_limit:
                    raise ArithmeticError(f"heyoka: {outcome} at {self.integrator.time:g} s")
                pieces.append(states[1:])
                first += len(ahead) - 1
                limit.check()
        except OutOfTime:
            stopped = True
        return Attempt(
            np.concatenate(pieces), float(times[first]), steps, None, self.events, EVERY_KIND, stopped
        )

    def _restart(self):
        self.integrator.time = 0.0
        self.integrator.state[:] = self.start
        self.mode = Mode(self.equations, self.start)
        self._set_parameters(self.integrator)
        if self.integrator.with_events:
            self.integrator.reset_cooldowns()
        self.events = []

    def _set_parameters(self, integrator):
        parameters = (self.mode.contact, self.mode.sigma, self.mode.stuck)
        integrator.pars[:] = parameters[: len(integrator.pars)]  # what no equation uses is not there

    def _callback(self, name):
        """What heyoka calls at a zero of event function `name`; a plain function, for heyoka deep-copies what
        it is given.
        """

        def taken(integrator, _sign):
            state = integrator.state.tolist()
            kind = self.mode.switch(getattr(self.mode, name), state)
            integrator.state[3] = state[3]
            self._set_parameters(integrator)
            if kind is not None:
                self.events.append((integrator.time, EVENT_KINDS[kind]))
            return True

        return taken


def expressions(scene: TwoBlocks):
    """Eqs. (2.1)-(2.3) or (2.8)-(2.10) with the modes as parameters, and the event functions by the names of
    those of `Mode`.
    """
    p = scene
    x1, v1, x2, v2 = hy.make_vars("x1", "v1", "x2", "v2")
    contact, sigma, stuck = (hy.par[i] for i in (CONTACT, SIGMA, STUCK))
    force = p.k1 * (x1 - x2) + p.c * (v1 - v2)
    functions = {}
    if p.has_stop:
        force = force + contact * p.k2 * (x1 - x2 + p.stop_sign * p.G)
        functions["gap"] = (2.0 * contact - 1.0) * (p.stop_sign * (x2 - x1) - p.G)
    if p.has_friction:
        functions["slide"] = sigma * v2 + FAR * stuck
        functions["hold"] = p.N**2 - force**2 + 1e6 * FAR * (1.0 - stuck)
    a2 = hy.expression(0.0)
    if p.has_block2:
        a2 = (1.0 - stuck) * (force - sigma * (p.N if p.has_friction else 0.0)) / p.m2
    if p.has_motor:
        a1, rotor = motor_accelerations(p, force)
    else:
        load = p.A * hy.sin(p.omega * hy.time) + p.F0 if p.source == "harmonic" else 0.0
        a1, rotor = (load - force) / p.m1, []
    return [(x1, v1), (v1, a1), (x2, v2), (v2, a2), *rotor], functions


def motor_accelerations(p, force):
    """Eqs. (2.8), (2.10) solved for a1, and the equations of the rotor."""
    phi, w = hy.make_vars("phi", "w")
    unbalance, mass, inertia = p.m3 * p.e, p.m1 + p.m3, p.J + p.m3 * p.e**2
    coupling = unbalance * hy.sin(phi)
    thrust = unbalance * w**2 * hy.cos(phi) - force
    torque = p.M0 - p.M0 / p.Omega0 * w
    determinant = mass * inertia - coupling**2
    a1 = (thrust * inertia + coupling * torque) / determinant
    dw = (mass * torque + coupling * thrust) / determinant
    return a1, [(phi, w), (w, dw)]
