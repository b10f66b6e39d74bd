"""Either case in solve_ivp: with events and the mode automaton around it, or with sgn(v2) and no events."""

from math import cos, sin

import numpy as np
from scipy.integrate import solve_ivp


def run_with_events(scene, method, rtol):
    """State [x1, v1, x2, v2 (, phi, w)] at t_end, from rest; one call of solve_ivp per mode, atol 1e-3 rtol.

    Event functions are positive inside their mode and watched falling, so a zero just taken is not met again.
    """
    t, state, mode = 0.0, np.zeros(6 if scene.has_motor else 4), Mode(scene)
    while True:
        events = [mode.gap, mode.hold if mode.stuck else mode.slide]
        answer = solve_ivp(
            mode.motion, (t, scene.t_end), state, method, events=events, rtol=rtol, atol=1e-3 * rtol
        )
        if answer.status < 0:
            raise ArithmeticError(answer.message)
        t, state = answer.t[-1], answer.y[:, -1]
        if answer.status == 0:
            return state
        mode.switch(events[0 if answer.t_events[0].size else 1], state)


def run_with_sgn(scene, method, rtol):
    """State at t_end, contact and friction left to the right-hand side."""
    mode = Mode(scene)

    def motion(t, state):
        mode.side = -1.0 if state[0] - state[2] <= -scene.G else 1.0
        mode.sigma = np.sign(state[3])
        return mode.motion(t, state)

    mode.stuck = False
    start = np.zeros(6 if scene.has_motor else 4)
    return solve_ivp(motion, (0.0, scene.t_end), start, method, rtol=rtol, atol=1e-3 * rtol).y[:, -1]


class Mode:
    """Motion and event functions in one mode: side +1 free, -1 contact; sign of friction; stuck or not."""

    def __init__(self, scene):
        self.scene = scene
        self.side, self.sigma, self.stuck = 1.0, 1.0, True
        for function in (self.gap, self.slide, self.hold):
            function.__func__.terminal, function.__func__.direction = True, -1

    def force(self, state):
        """S [N], Eqs. (2.4)-(2.6)."""
        p, (x1, v1, x2, v2) = self.scene, state[:4]
        force = p.k1 * (x1 - x2) + p.c * (v1 - v2)
        return force + p.k2 * (x1 - x2 + p.G) if self.side < 0 else force

    def motion(self, t, state):
        """Eqs. (2.1)-(2.3) or (2.8)-(2.10)."""
        p, state = self.scene, state.tolist()
        force = self.force(state)
        a2 = 0.0 if self.stuck else (force - self.sigma * p.N) / p.m2
        if not p.has_motor:
            return state[1], (p.A * sin(p.omega * t) + p.F0 - force) / p.m1, state[3], a2
        phi, w = state[4:]
        unbalance, mass, inertia = p.m3 * p.e, p.m1 + p.m3, p.J + p.m3 * p.e * p.e
        coupling = unbalance * sin(phi)
        thrust, torque = unbalance * w * w * cos(phi) - force, p.M0 * (1.0 - w / p.Omega0)
        determinant = mass * inertia - coupling * coupling
        a1 = (thrust * inertia + coupling * torque) / determinant
        return state[1], a1, state[3], a2, w, (mass * torque + coupling * thrust) / determinant

    def gap(self, t, state):
        return self.side * (state[0] - state[2] + self.scene.G)

    def slide(self, t, state):
        return self.sigma * state[3]

    def hold(self, t, state):
        return self.scene.N - abs(self.force(state))

    def switch(self, function, state):
        """Enter the mode behind the zero of `function`; sets v2 to zero where block 2 begins to stick."""
        if function == self.gap:
            self.side = -self.side
            return
        force = self.force(state)
        self.stuck = function == self.slide and abs(force) < self.scene.N
        self.sigma = np.sign(force)
        if self.stuck:
            state[3] = 0.0
