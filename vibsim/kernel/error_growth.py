"""How much a small error grows over a run, from pairs of runs in doubles.

A run is cut at events into stretches. At the start of each the velocity of block 1 is kicked a little and the
engine restarted; how far the two states are apart at its end tells by what factor errors grow on it. One
stretch is enough without chaos; with it stretches are halved until the difference stays small. The factors
multiply up; where motion contracts, an error never falls below fresh rounding. It is an estimate: every kick
has to turn into the direction of fastest growth anew.
"""

from collections.abc import Mapping
from dataclasses import replace
from math import log10

import numpy as np

from vibsim.kernel import open_trajectory
from vibsim.kernel.block import EVENT_STATE
from vibsim.physics.scene import Scene

KICK = 1e-12  # of the largest velocity: far above rounding, far below what bends the growth
LARGEST = 1e-4  # a difference up to here, relative to the motion, still grows in proportion

Table = Mapping[str, np.ndarray]


def error_growth(scene: Scene, engine: str = "auto", along: Table | None = None) -> float:
    """Logarithm (base 10) of the factor by which errors have grown at the end of the run of `scene`.

    along: event table of the motion to follow, where it is not that in doubles: chaos takes the two apart.
    """
    scene = replace(scene, stop_on_violation=False)
    table = last_states(scene, engine) if along is None else along
    scale = {name: float(np.abs(table[name]).max()) for name in EVENT_STATE if name in table}
    if scale["v1"] == 0.0:
        return 0.0
    last = len(table["t"]) - 1
    grown, i = 0.0, 0
    while i < last:
        j = last
        factor = _stretch(scene, engine, table, scale, i, j)
        while factor * KICK > LARGEST and j > i + 1:
            j = (i + j) // 2
            factor = _stretch(scene, engine, table, scale, i, j)
        grown = max(grown + log10(max(factor, 1e-3)), 0.0)
        i = j
    return grown


def last_states(scene: Scene, engine: str = "auto", resume: Mapping[str, float] | None = None) -> Table:
    """The event table of a run without samples, from its start or from an event row."""
    numerator, denominator = float(scene.t_end).as_integer_ratio()
    sparse = replace(scene, every_num=max(numerator, 1), every_den=denominator)
    blocks = [block.events for block in open_trajectory(sparse, engine, resume).blocks()]
    return {name: np.concatenate([events[name] for events in blocks]) for name in blocks[0]}


def _stretch(scene, engine, table: Table, scale, i, j):
    """Factor of growth from event i to event j."""
    row = {name: column[i].item() for name, column in table.items()}
    row["v1"] += KICK * scale["v1"]
    kicked = last_states(replace(scene, t_end=float(table["t"][j])), engine, row)
    apart = [abs(kicked[name][-1] - table[name][j]) / size for name, size in scale.items() if size]
    return max(apart) / KICK
