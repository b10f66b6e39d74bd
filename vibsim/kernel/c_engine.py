"""The C engine as a trajectory: packs the scene, hands buffers to the kernel, cuts blocks from them."""

from math import log2, nan

import numpy as np

from vibsim.events.watch import CLEARANCE
from vibsim.kernel import _kernel
from vibsim.kernel.block import select
from vibsim.kernel.errors import KernelError
from vibsim.kernel.resume import resume_point
from vibsim.kernel.tangent_totals import tangent_totals
from vibsim.kernel.totals import totals_of
from vibsim.physics.numbers import TWO_PI
from vibsim.physics.state import State

# the order of the kernel's struct
PACKED: tuple[str, ...] = ("m1", "m2", "k1", "c", "k2", "G", "stop_sign", "N", "A", "F0", "omega", "cycles")
PACKED += ("cycles_lo", "m3", "e", "J", "M0", "Omega0", "x1", "v1", "x2", "v2", "phi", "phidot")
PACKED += ("rest_distance", "t_end", "every_num", "every_den")
SAMPLE_ROOM, EVENT_ROOM, SECTION_ROOM = 16384, 4096, 1024
SAMPLE_ROWS = ("time", "x1", "v1", "x2", "v2", "phi", "phidot")
EVENT_ROWS = ("t", "x1", "v1", "x2", "v2", "phi", "phidot", "phase")
REASONS = {1: "accumulation", 2: "diverged"}


def pack(scene, method, ledger=False, tangent=(0, 0.0)):
    """The scene as the kernel's struct of doubles; what it has not got is zero and flagged."""
    values = [getattr(scene, name) for name in PACKED]
    values += [log2(scene.tol), scene.order, scene.has_block2, scene.has_stop, scene.has_friction]
    values += [scene.has_motor, scene.source == "harmonic", scene.rest_distance is not None]
    values += [scene.stop_on_violation, scene.at_stop, scene.at_rest_distance]
    values += [method == "closed_form", ledger, *tangent]
    return np.array([0.0 if value is None else float(value) for value in values])


def pack_resume(scene, row):
    """A stored event row as the kernel's doubles: state, mode, known zeros."""
    state, mode, known = resume_point(scene, row)
    orders = [known.get(function, 0) for function in range(CLEARANCE + 1)]
    return np.array([*vars(state).values(), mode.contact, mode.friction, mode.violated, *orders], dtype="f8")


class CTrajectory:
    """A run on the C engine; see `vibsim.kernel.open_trajectory`."""

    engine = "c"

    def __init__(self, scene, method, resume=None, section=False, ledger=False, tangent=(0, 0.0)):
        self.scene, self.method, self.ledger, self.tangent = scene, method, ledger, tangent
        self.samples = np.empty((len(SAMPLE_ROWS), SAMPLE_ROOM))
        self.sample_modes = np.empty((2, SAMPLE_ROOM), dtype="i1")
        self.events = np.empty((len(EVENT_ROWS), EVENT_ROOM))
        self.event_codes = np.empty((3, EVENT_ROOM), dtype="i1")
        wanted = section and scene.source != "none"
        self.section = np.empty((len(SAMPLE_ROWS), SECTION_ROOM if wanted else 0))
        row = None if resume is None else pack_resume(scene, resume)
        packed = pack(scene, method, ledger, tangent)
        self.run, count, happened = _kernel.start(packed, row, *self._buffers())
        self.filled = count, happened

    def _buffers(self):
        return self.samples, self.sample_modes, self.events, self.event_codes, self.section

    def blocks(self):
        """Yield `Block`s until the run ends; raises KernelError when it fails."""
        finished, status = 0, 0
        yield self._block(*self.filled, 0)
        while not finished:
            *filled, finished, status = _kernel.advance(self.run, *self._buffers())
            yield self._block(*filled)
            if status:
                raise KernelError(REASONS[status], State(*_kernel.tally(self.run)["state"]))

    def _block(self, count, happened, passed):
        samples = {name: self.samples[i, :count].copy() for i, name in enumerate(SAMPLE_ROWS)}
        events = {name: self.events[i, :happened].copy() for i, name in enumerate(EVENT_ROWS)}
        section = {name: self.section[i, :passed].copy() for i, name in enumerate(SAMPLE_ROWS)}
        events["kind"] = self.event_codes[0, :happened].copy()
        for i, name in enumerate(("contact", "friction")):
            samples[name] = self.sample_modes[i, :count].copy()
            events[name] = self.event_codes[i + 1, :happened].copy()
        tally = _kernel.tally(self.run)
        return select(self.scene, samples, events, section, tally["state"][0], tally["worked_to"])

    @property
    def totals(self):
        """Counts and margins so far."""
        tally = _kernel.tally(self.run)
        return totals_of(
            tally["counts"],
            (int(tally["steps"]), int(tally["evaluations"])),
            tally["certificate"],
            tally["first_violation"] if tally["violated_once"] else nan,
            tally["ledger"] if self.ledger else None,
            self._tangent_totals(*tally["certificate"][2:]) if self.tangent[0] else None,
        )

    def _tangent_totals(self, margin, margin_time):
        return tangent_totals(self.scene, _kernel.growth(self.run), margin, margin_time)

    def state_at(self, times):
        """States at ascending times before the next event, as columns."""
        rows = np.array([self._state_at(t) for t in times]).reshape(-1, 8)
        t, x1, v1, x2, v2, phase, turns, w = rows.T
        columns = {"time": t, "x1": x1, "v1": v1, "x2": x2, "v2": v2, "phidot": w}
        columns["phi"] = phase + turns * TWO_PI
        mode = _kernel.tally(self.run)["mode"]
        for i, name in enumerate(("contact", "friction")):
            columns[name] = np.full(len(rows), mode[i], dtype="i1")
        return {name: columns[name] for name in self.scene.columns()}

    def _state_at(self, t):
        while (state := _kernel.state_at(self.run, t)) is None:
            pass  # here a signal is heard
        return state
