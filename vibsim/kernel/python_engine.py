"""The Python engine as a trajectory: the driver's rows gathered into blocks of arrays."""

from math import nan
from typing import Any

import numpy as np

from vibsim.events.watch import NOTHING
from vibsim.flows.closed_form import ClosedForm
from vibsim.flows.taylor import Taylor
from vibsim.kernel.block import select
from vibsim.kernel.driver import Driver
from vibsim.kernel.resume import resume_point
from vibsim.kernel.tangent_totals import tangent_totals
from vibsim.kernel.totals import totals_of
from vibsim.physics.numbers import Doubles

SAMPLES, EVENTS, PIECES = 2048, 1024, 4096
SECONDS = 0.1  # between two blocks: Ctrl-C is heard there
FLOWS: dict[str, Any] = {"closed_form": ClosedForm, "taylor": Taylor}


class PythonTrajectory:
    """A run on the Python engine; see `vibsim.kernel.open_trajectory`."""

    engine = "python"

    def __init__(self, scene, method, resume=None, section=False, ledger=False, tangent=(0, 0.0)):
        self.scene, self.method = scene, method
        self.kit = Doubles
        self.flow = FLOWS[method](scene, Doubles)
        point = resume and resume_point(scene, resume)
        self.driver = Driver(scene, Doubles, self.flow, point, section, ledger, tangent)

    def blocks(self):
        """Yield `Block`s until the run ends."""
        while True:
            self.driver.run(SAMPLES, EVENTS, PIECES, SECONDS)
            yield self._block()
            if self.driver.finished:
                return

    def _block(self):
        samples, events, section = self.driver.take()
        rows = sample_columns(self.kit, [row[0] for row in samples], [row[1] for row in samples])
        table = sample_columns(self.kit, [row[1] for row in events], [row[2] for row in events])
        table["t"], table["kind"] = table["time"], np.array([row[0] for row in events], dtype="i1")
        table["phase"] = np.array([row[1].phase for row in events], dtype="f8")
        points = sample_columns(self.kit, section, [self.driver.mode] * len(section))
        return select(self.scene, rows, table, points, self.driver.state.t, self.driver.worked_to)

    @property
    def totals(self):
        """Counts and margins so far."""
        driver, flow, kept = self.driver, self.flow, self.flow.certificate
        violated = driver.first_violation
        return totals_of(
            driver.counts,
            (flow.steps, flow.evaluations),
            (kept.uncertified, kept.first_doubt, kept.margin, kept.margin_time),
            nan if violated is None else violated,
            driver.ledger.entries(),
            tangent_totals(self.scene, driver.tangent.entries(), kept.margin, kept.margin_time),
        )

    def state_at(self, times):
        """States at ascending times before the next event, as columns."""
        states = []
        for t in times:
            end = self.flow.t0
            while True:
                end, function = self.flow.advance(self.scene.t_end)
                if function != NOTHING or end >= t or end >= self.scene.t_end:
                    break
                state = self.flow.state_at(end)
                if not self.kit.finite(state.x1 + state.v1 + state.x2 + state.v2 + state.w):
                    break
                self.flow.carry_on(state)
            states.append(self.flow.state_at(t))
        columns = sample_columns(self.kit, states, [self.driver.mode] * len(states))
        return {name: columns[name] for name in self.scene.columns()}


def sample_columns(kit, states, modes):
    """Columns of states and modes, under their file names."""
    columns = {"time": [s.t for s in states], "phi": [kit.unwind(s.phase, s.turns) for s in states]}
    columns.update({name: [getattr(s, name) for s in states] for name in ("x1", "v1", "x2", "v2")})
    columns["phidot"] = [s.w for s in states]
    arrays = {name: np.array(values, dtype="f8") for name, values in columns.items()}
    arrays["contact"] = np.array([m.contact for m in modes], dtype="i1")
    arrays["friction"] = np.array([m.friction for m in modes], dtype="i1")
    return arrays
