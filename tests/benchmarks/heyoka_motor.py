"""Case II in heyoka.py: an adaptive Taylor integrator, the mode automaton in its event callbacks.

The peer of the C engine, as good as heyoka allows: constants compiled in, modes as run-time parameters, back
to Python at events only. Every event function is positive inside its mode and watched falling, so a zero just
taken is not met again. Needs heyoka.
"""

import heyoka as hy
import numpy as np

from vibsim.physics.modes import EVENT_KINDS

# run-time parameters: +1 free, -1 contact; sign of the friction force; 1 while block 2 sticks
SIDE, SIGMA, STUCK = range(3)
HELD = 1.0 - 1e-10  # share of the limit friction below which block 2 sticks: at a release |S| = N to rounding
# heyoka deduces a cooldown by dividing by the slope: 1.9e9 s at the zero of order 2 of a stick release, and
# every later reversal missed (II-C from 8.3 s on)
COOLDOWN = 1e-9  # s
FAR = 1.0  # keeps the event function of another friction mode away from zero

hy.llvm_state.set_diskcache_enabled(False)  # so that the JIT time is one


class HeyokaMotor:
    """The scene of a motor at rest, compiled at once; `run` lists its `events` as (time [s], kind code)."""

    def __init__(self, scene):
        self.scene, self.events = scene, []
        system, gap, slide, hold = expressions(scene)
        functions = ((gap, self._gap), (slide, self._slide), (hold, self._hold))
        options = {"direction": hy.event_direction.negative, "cooldown": COOLDOWN}
        events = [hy.t_event(function, callback=shared(taken), **options) for function, taken in functions]
        self.integrator = hy.taylor_adaptive(system, [0.0] * 6, pars=[0.0] * 3, t_events=events)

    def run(self, times):
        """States [x1, v1, x2, v2, phi, w] at the ascending `times` [s], the first of them 0."""
        integrator = self.integrator
        self.events = []
        integrator.time = 0.0
        integrator.state[:] = 0.0
        integrator.pars[:] = (1.0, 1.0, 1.0)
        integrator.reset_cooldowns()
        return integrator.propagate_grid(times)[-1]

    def _gap(self, integrator):
        integrator.pars[SIDE] = -integrator.pars[SIDE]
        return self._happened(integrator, "contact_begin" if integrator.pars[SIDE] < 0 else "contact_end")

    def _slide(self, integrator):
        force = self._force(integrator)
        if abs(force) < HELD * self.scene.N:
            integrator.state[3] = 0.0
            integrator.pars[STUCK] = 1.0
            return self._happened(integrator, "stick_begin")
        if np.sign(force) == integrator.pars[SIGMA]:  # rounding at a stick release
            return True
        integrator.pars[SIGMA] = np.sign(force)
        return self._happened(integrator, "reversal")

    def _hold(self, integrator):
        integrator.pars[STUCK], integrator.pars[SIGMA] = 0.0, np.sign(self._force(integrator))
        return self._happened(integrator, "stick_end")

    def _happened(self, integrator, kind):
        self.events.append((integrator.time, EVENT_KINDS[kind]))
        return True

    def _force(self, integrator):
        """S [N], Eqs. (2.4)-(2.6)."""
        p, (x1, v1, x2, v2) = self.scene, integrator.state[:4]
        y = x1 - x2
        force = p.k1 * y + p.c * (v1 - v2)
        return force + p.k2 * (y + p.G) if integrator.pars[SIDE] < 0 else force


def shared(taken):
    """`taken` as a callback that heyoka, which deep-copies what it is given, cannot part from its object."""
    return lambda integrator, sign: taken(integrator)


def expressions(scene):
    """Eqs. (2.8)-(2.10) with the modes as parameters; event functions of contact, sliding and sticking."""
    p = scene
    x1, v1, x2, v2, phi, w = hy.make_vars("x1", "v1", "x2", "v2", "phi", "w")
    side, sigma, stuck = (hy.par[i] for i in (SIDE, SIGMA, STUCK))
    y = x1 - x2
    force = p.k1 * y + p.c * (v1 - v2) + (0.5 - 0.5 * side) * p.k2 * (y + p.G)
    unbalance, mass, inertia = p.m3 * p.e, p.m1 + p.m3, p.J + p.m3 * p.e**2
    coupling = unbalance * hy.sin(phi)
    thrust = unbalance * w**2 * hy.cos(phi) - force
    torque = p.M0 - p.M0 / p.Omega0 * w
    determinant = mass * inertia - coupling**2
    a1 = (thrust * inertia + coupling * torque) / determinant
    dw = (mass * torque + coupling * thrust) / determinant
    a2 = (1.0 - stuck) * (force - sigma * p.N) / p.m2
    system = [(x1, v1), (v1, a1), (x2, v2), (v2, a2), (phi, w), (w, dw)]
    return system, side * (y + p.G), sigma * v2 + FAR * stuck, p.N**2 - force**2 + 1e6 * FAR * (1.0 - stuck)
