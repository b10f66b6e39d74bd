"""The Python engine as a trajectory: the driver's rows gathered into blocks of arrays."""

from math import inf, nan

import numpy as np

from vibsim.flows.closed_form import ClosedForm
from vibsim.flows.taylor import Taylor
from vibsim.kernel.block import Block, select
from vibsim.kernel.driver import Driver, mode_of
from vibsim.physics.modes import EVENT_KINDS
from vibsim.physics.numbers import Doubles
from vibsim.physics.state import State

SAMPLES, EVENTS, STRETCHES = 2048, 1024, 512


class PythonTrajectory:
    """A run on the Python engine; see `vibsim.kernel.open_trajectory`."""

    engine = "python"

    def __init__(self, scene, method, resume=None):
        self.scene, self.method = scene, method
        self.kit = Doubles
        self.flow = {"closed_form": ClosedForm, "taylor": Taylor}[method](scene, Doubles)
        self.driver = Driver(scene, Doubles, self.flow, resume)

    def blocks(self):
        """Yield `Block`s until the run ends."""
        while True:
            self.driver.run(SAMPLES, EVENTS, STRETCHES)
            yield self._block()
            if self.driver.finished:
                return

    def _block(self):
        samples, events = self.driver.take()
        rows = sample_columns(self.kit, [row[0] for row in samples], [row[1] for row in samples])
        table = sample_columns(self.kit, [row[1] for row in events], [row[2] for row in events])
        table["t"], table["kind"] = table["time"], np.array([row[0] for row in events], dtype="i1")
        table["phase"] = np.array([row[1].phase for row in events], dtype="f8")
        return select(self.scene, rows, table, self.driver.state.t)

    @property
    def totals(self):
        """Counts and margins so far."""
        driver, flow = self.driver, self.flow
        counts = dict(zip(EVENT_KINDS, driver.counts, strict=True))
        found = flow.margin != inf
        return {
            "impacts": counts["contact_begin"],
            "sticks": counts["stick_begin"],
            "reversals": counts["reversal"],
            "events": sum(driver.counts) - counts["start"] - counts["end"],
            "steps": flow.steps,
            "evaluations": flow.evaluations,
            "uncertified": flow.uncertified,
            "grazing_margin": flow.margin if found else nan,
            "grazing_time": flow.margin_time if found else nan,
            "violations": counts["violation_begin"],
            "first_violation_time": nan if driver.first_violation is None else driver.first_violation,
        }

    def state_at(self, times):
        """States at ascending times before the next event, as columns."""
        states = []
        for t in times:
            end = self.flow.t0
            while True:
                end, function = self.flow.advance(self.scene.t_end)
                if function != -1 or end >= t or end >= self.scene.t_end:
                    break
                self.flow.carry_on(self.flow.state_at(end))
            states.append(self.flow.state_at(t))
        return sample_columns(self.kit, states, [self.driver.mode] * len(states))


def sample_columns(kit, states, modes):
    """Columns of states and modes, under their file names."""
    columns = {"time": [s.t for s in states], "phi": [kit.unwind(s.phase, s.turns) for s in states]}
    columns.update({name: [getattr(s, name) for s in states] for name in ("x1", "v1", "x2", "v2")})
    columns["phidot"] = [s.w for s in states]
    arrays = {name: np.array(values, dtype="f8") for name, values in columns.items()}
    arrays["contact"] = np.array([m.contact for m in modes], dtype="i1")
    arrays["friction"] = np.array([m.friction for m in modes], dtype="i1")
    return arrays


__all__ = ["Block", "PythonTrajectory", "State", "mode_of"]
