"""Ends of runs, as columns of a sweep: rest or vibration, attractors; and the starts followed first.

How a run is labelled with its attractor stands in `vibsim.sweeps.attractor_labels`, which is loaded where
attractors are asked for.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import prod
from typing import TYPE_CHECKING, Any

import numpy as np

from vibsim.engine.blocks import Block
from vibsim.physics.parts import EVENT_KINDS, IMPACTS, Scene, columns_of
from vibsim.results.file_contents import Column
from vibsim.sweeps.contact_computations import Task
from vibsim.sweeps.quantities import Columns, Quantities
from vibsim.sweeps.statistics import MeasuredRun

if TYPE_CHECKING:
    from vibsim.sweeps.axes import Axis, Members

# What a motion without a source that changes comes to: rest, or vibration that goes on.
#
# Judged on the time after the transient, in two halves. Where stops or frictions go on to change their states
# in the second half, the motion is a vibration (stick-slip, impacts): events are exact, so no threshold
# decides. Where they do not, it is smooth, and rests if its kinetic energy falls from one half to the other.


END_STATE_TITLE = "rest or vibration, without a source that changes"
END_STATE = "end_state"
VERDICTS = {"undecided": 0, "rest": 1, "vibration": 2}
OF_FRICTION = ("reversal", "stick_begin", "stick_end")
CHANGES = (*OF_FRICTION, *IMPACTS, "contact_end", "rest_begin", "rest_end")
FALLS = 0.99  # of the greatest kinetic energy in the first half: samples meet its peaks to a hundredth


def end_state_columns(of: Quantities) -> Columns:
    """The verdict; none with a source, whose motions have a regime."""
    return {} if of.has_source else {END_STATE: Column("1", "what the motion comes to", flags=VERDICTS)}


class EndState:
    """End state of one run. Memory grows with its samples and events after the transient."""

    def __init__(self, task: Task):
        self._begin, bodies = task.begin, task.scene.line
        self._half_masses = {columns_of(body.name)[1]: float(body.m) / 2 for body in bodies}
        self._codes = [EVENT_KINDS[kind] for kind in CHANGES]
        self._changes: list[np.ndarray] = []
        self._times: list[np.ndarray] = []
        self._energies: list[np.ndarray] = []

    def update(self, block: Block) -> None:
        """Take the next block."""
        events, samples = block.events, block.samples
        self._changes.append(events["t"][np.isin(events["kind"], self._codes)])
        self._times.append(samples["time"])
        energy = np.zeros(len(samples["time"]))
        for v, half in self._half_masses.items():
            energy = energy + half * samples[v] ** 2
        self._energies.append(energy)

    def values(
        self, window: tuple[float, float], run: MeasuredRun, measured: dict[str, Any]
    ) -> dict[str, float]:
        """The verdict on the window."""
        middle = (window[0] + window[1]) / 2
        times, energies = np.concatenate(self._times), np.concatenate(self._energies)
        late, early = times >= middle, (times >= window[0]) & (times < middle)
        if any(np.any(changes >= middle) for changes in self._changes):
            return {END_STATE: float(VERDICTS["vibration"])}
        known = late.any() and early.any()
        falls = known and energies[late].max() <= FALLS * energies[early].max()
        return {END_STATE: float(VERDICTS["rest" if falls else "undecided"])}


# The attractor that a run ends on, as it is stored.


KINDS = {
    "undecided": 0,
    "rest": 1,
    "periodic": 2,
    "quasi-periodic": 3,
    "chaotic": 4,
    "running away": 5,
    "turning": 6,  # for ever, with nothing that drives it
}
REASONS = {  # why a run is undecided
    "decided": 0,
    "no section": 1,
    "too few cycles": 2,
    "still on its way": 3,
    "no stable orbit": 4,
    "tests disagree": 5,
}
NONE = -1  # the number of no attractor, as of an undecided run
ATTRACTOR_TITLE = "attractor that the run ends on: rest, orbit, quasi-periodic or chaotic set"
NAME = "attractor"
INITIAL = "initial."  # begins the keys of what a run starts from


def attractor_columns(of: Quantities) -> Columns:
    """Columns stored of each point; `vibsim.sweeps.attractors` makes numbers of attractors of them."""
    unknowns, observed = "unknown", "observable"
    return {
        "attractor_kind": Column("1", "what the run ends on", flags=KINDS),
        "attractor_reason": Column("1", "why it is undecided", flags=REASONS),
        "attractor_period": Column("1", "returns to the section that its orbit takes; NaN of other kinds"),
        "attractor_multiplier": Column("1", "greatest modulus of the multipliers of its orbit"),
        "attractor_time": Column("s", "when it was sure to end there; NaN: at the end of the run"),
        "attractor_state": Column("1", "state on the section of its orbit or rest, SI", dimension=unknowns),
        "attractor_means": Column("1", "means over its section, of sets, SI", dimension=observed),
        "attractor_errors": Column("1", "standard errors of these, SI", dimension=observed),
    }


def unknowns(scene: Scene) -> int:
    """How many unknowns the orbits of a scene have; 0 without a section."""
    from vibsim.orbits.coordinates import OrbitError, coordinates_of_rest

    try:
        return coordinates_of_rest(scene).count
    except OrbitError:
        return 0


def observed(scene: Scene) -> int:
    """How many observables tell sets apart, see `vibsim.analysis.attractor.observables`."""
    return 3 * unknowns(scene)


# Starts that are followed first: what they end on is known to all points of their scene.


FEWEST_STARTS = 32  # of one scene, below which it does not pay
STARTS_PER_PROBE = 8
MOST_PROBES = 24
PLASTIC = 1.32471795724474602596  # x^3 = x + 1: points of two axes spread as evenly as those of one by gold


def probe_starts(axes: Sequence[Axis | Members], compute: Sequence[str], carry: bool) -> tuple[Any, ...]:
    """Changes of the initial values for each probe of a sweep; none where they do not pay.

    Positions k = 1, 2, ... along the i-th axis of starts are the fractions of k / a^i, a the plastic number
    (M. Roberts, The unreasonable effectiveness of quasirandom sequences, 2018).
    """
    starts = [axis for axis in axes if is_of_starts(axis)]
    count = prod(map(len, starts))
    if NAME not in compute or carry or not starts or count < FEWEST_STARTS:
        return ()
    probes = []
    for k in range(1, min(MOST_PROBES, count // STARTS_PER_PROBE) + 1):
        changes: dict[str, str] = {}
        for i, axis in enumerate(starts, 1):
            share = (0.5 + k * PLASTIC**-i) % 1.0
            changes |= axis.changes(int(share * len(axis)))
        probes.append(changes)
    return tuple(probes)


def is_of_starts(axis: Axis | Members) -> bool:
    """Whether an axis varies initial values alone."""
    return all(key.startswith(INITIAL) for key in axis.keys)
