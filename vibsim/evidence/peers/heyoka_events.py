"""heyoka.py: an adaptive Taylor integrator compiled at run time, the mode automaton in its event callbacks.

The peer as good as heyoka allows: constants compiled in, modes as run-time parameters, back to Python at
events only. An impact changes the velocities in the callback too: stopping at it and calling heyoka anew
takes longer. Every event function is positive inside its mode and watched falling, so a zero just taken is
not met again. Needs heyoka.
"""

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import heyoka as hy
import numpy as np

from vibsim.evidence.peers.automaton import Mode, Shortest
from vibsim.evidence.peers.equations import (
    Compiled,
    ModeEquations,
    parameter_count,
    start_of,
    state_count,
    sum_of,
)
from vibsim.evidence.peers.solvers import SHARE, Attempt, OutOfTime, SolverProgress, TimeLimit, kinds_of
from vibsim.physics.parts import EVENT_KINDS, Scene

# heyoka deduces a cooldown by dividing by the slope: 1.9e9 s at the zero of order 2 of a stick release, and
# every later reversal missed (II-C from 8.3 s on)
COOLDOWN = 1e-9  # s
SHORTEST_HOP = 10 * COOLDOWN  # s: the end of a shorter one lies in the cooldown
PIECE = 100  # samples between two looks at the clock
SKIN = 1e-12  # m: no power of a depth but a whole one has a series at 0, so such contacts begin and end here


def _choose(flag: Any, yes: Any, no: Any) -> Any:
    """flag yes + (1 - flag) no."""
    terms = [(flag, yes), (1.0 - flag, no)]
    return sum_of(share * value for share, value in terms if not (isinstance(value, float) and value == 0.0))


KIT = SimpleNamespace(
    sin=hy.sin, cos=hy.cos, exp=hy.exp, call=lambda name, a: getattr(hy, name)(a),
    power=lambda a, p: hy.sqrt(a) if p == 0.5 else a**p, choose=_choose, skin=SKIN,
)  # fmt: skip


class HeyokaEvents:
    """A scene compiled to the tolerance `tol` (relative)."""

    def __init__(self, scene: Scene, tol: float):
        hy.llvm_state.set_diskcache_enabled(False)  # so that compiling is compiling
        hy.set_logger_level_error()  # it warns of zeros that it loses on the output: here they are counted
        self.scene, self.tol = scene, tol
        self.compiled = Compiled(scene, SKIN)
        system, functions = expressions(scene)
        options = {"direction": hy.event_direction.negative, "cooldown": COOLDOWN}
        events = [
            hy.t_event(function, callback=self._callback(*place), **options) for place, function in functions
        ]
        self.integrator = hy.taylor_adaptive(system, start_of(scene), t_events=events, tol=tol)
        self.restart()

    def run(self, times: np.ndarray, limit: TimeLimit) -> Attempt:
        """States at the ascending `times` [s], from 0 to the end. Raises ArithmeticError where it fails."""
        self.restart()
        pieces, steps, stopped, first = [np.array([start_of(self.scene)])], 0, False, 0
        try:
            while first < len(times) - 1:
                ahead = times[first : first + PIECE + 1].copy()
                ahead[0] = self.integrator.time
                outcome, _, _, taken, _, states = self.integrator.propagate_grid(ahead)
                steps += taken
                if self.problem is not None:
                    raise self.problem
                if outcome == hy.taylor_outcome.err_nf_state:
                    raise ArithmeticError(
                        "no longer finite, as a power whose base comes to 0 has no Taylor series"
                    )
                if outcome != hy.taylor_outcome.time_limit:
                    raise ArithmeticError(f"heyoka: {outcome} at {self.integrator.time:g} s")
                pieces.append(states[1:])
                first += len(ahead) - 1
                limit.check()
        except OutOfTime:
            stopped = True
        states, kinds = np.concatenate(pieces), kinds_of(self.scene)
        return Attempt(states, float(times[first]), steps, None, self.events, kinds, stopped)

    def restart(self) -> None:
        """Go back to t = 0."""
        self.mode = Mode(self.compiled, Shortest(SHARE * self.tol, SHORTEST_HOP))
        self.progress = SolverProgress()
        self.problem: ArithmeticError | None = None
        state = start_of(self.scene)
        self.events = [(0.0, EVENT_KINDS[kind]) for kind in self.mode.begin(state)]
        self.integrator.time = 0.0
        self.integrator.state[:] = state
        self._set_parameters(self.integrator)
        if self.integrator.with_events:
            self.integrator.reset_cooldowns()
        # where an event function is exactly 0, heyoka misses its next zero in the same step: so a short one
        self.integrator.step(SHORTEST_HOP)

    def _set_parameters(self, integrator: Any) -> None:
        integrator.pars[:] = self.mode.parameters[: len(integrator.pars)]  # the last may be in no equation

    def _callback(self, i: int, place: int) -> Callable[[Any, int], bool]:
        """Function that heyoka calls at a zero of an event function of part i at its place; a plain function,
        for heyoka deep-copies what it is given. An error cannot pass through heyoka: it is kept, and the run
        ended.
        """

        def taken(integrator: Any, _sign: int) -> bool:
            state = integrator.state.tolist()
            before = list(state)
            try:
                kinds = self.mode.switch(i, place, integrator.time, state)
                self.progress.event(integrator.time)
            except ArithmeticError as error:
                self.problem = error
                return False
            if state != before:
                integrator.state[:] = state
            self._set_parameters(integrator)
            self.events += [(integrator.time, EVENT_KINDS[kind]) for kind in kinds]
            return True

        return taken


def expressions(scene: Scene) -> tuple[list[tuple[Any, Any]], list[tuple[tuple[int, int], Any]]]:
    """The equations of motion with the modes as parameters; ((part, place), event function) of all parts."""
    names = [f"s{i}" for i in range(state_count(scene))]
    states = hy.make_vars(*names)
    parameters = [hy.par[i] for i in range(parameter_count(scene))]
    equations = ModeEquations(scene, KIT, hy.time, states, parameters)
    system = [(state, _expression(rate)) for state, rate in zip(states, equations.rates, strict=True)]
    parts = range(len(equations.switches) + len(equations.turning))
    ends = [
        ((i, place), _expression(end))
        for i in parts
        for place, end in enumerate(equations.ends_in_any_state(i))
    ]
    return system, ends


def _expression(value: Any) -> Any:
    """A value of heyoka's: a plain number, such as the rate of a body without forces, becomes one."""
    return hy.expression(value) if isinstance(value, float) else value
