"""How much a small error grows over a run, from pairs of runs in doubles.

A run is cut at events into stretches. At the start of each a body is kicked a little and the engine
restarted; how far the two states are apart at its end tells by what factor errors grow on it. One stretch is
enough without chaos; with it stretches are halved until the difference stays small. The factors multiply up;
where motion contracts, an error never falls below fresh rounding. It is an estimate: every kick has to turn
into the direction of fastest growth anew.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from vibsim.engine.columns import state_columns, stop_column
from vibsim.engine.modes.status import RESTING, STICK
from vibsim.engine.resume import Row, rows_of_instant
from vibsim.engine.trajectory import open_trajectory
from vibsim.physics import elementary
from vibsim.physics.parts import Friction, RigidStop, Scene

KICK = 1e-12  # of the largest velocity: far above rounding, far below what bends the growth
LARGEST = 1e-4  # a difference up to here, relative to the motion, still grows in proportion

Table = Mapping[str, np.ndarray]
Scale = dict[str, float]  # by column


def error_growth(scene: Scene, along: Table | None = None) -> float:
    """Logarithm (base 10) of the factor by which errors have grown at the end of the run of `scene`.

    along: event table of the motion to follow, where it is not that in doubles: chaos takes the two apart.
    """
    scene = replace(scene, stop_on_violation=False)
    table = last_states(scene) if along is None else along
    scale = {name: float(np.abs(table[name]).max()) for name in state_columns(scene)}
    if not any(scale[body.columns[1]] for body in scene.bodies):
        return 0.0
    last = len(table["t"]) - 1
    grown, i = 0.0, 0
    while i < last:
        j = last
        factor = _stretch(scene, table, scale, i, j)
        while factor * KICK > LARGEST and j > i + 1:
            j = (i + j) // 2
            factor = _stretch(scene, table, scale, i, j)
        grown = max(grown + elementary.log10(max(factor, 1e-3)), 0.0)
        i = j
    return grown


def last_states(scene: Scene, resume: Sequence[Row] | None = None) -> Table:
    """The event table of a run without samples, from its start or from the event rows of one instant."""
    trajectory = open_trajectory(scene.without_samples(), resume)
    blocks = [block.events for block in trajectory.blocks()]
    return {name: np.concatenate([events[name] for events in blocks]) for name in blocks[0]}


def _stretch(scene: Scene, table: Table, scale: Scale, i: int, j: int) -> float:
    """Factor of growth from event i to event j."""
    rows = rows_of_instant(table, i)
    kick = _kick(scene, rows[-1], scale)
    kicked = last_states(replace(scene, t_end=float(table["t"][j])), [_moved(row, kick) for row in rows])
    apart = [abs(kicked[name][-1] - table[name][j]) / size for name, size in scale.items() if size]
    return float(max(apart)) / KICK


def _kick(scene: Scene, row: Row, scale: Scale) -> Scale:
    """Addition to states: a velocity of the first body that no friction or rigid stop holds, of rotors
    and states behind them, or a displacement of the first one where all are held.
    """
    holding: list[Friction | RigidStop] = [part for part in scene.frictions if row[part.name] == STICK]
    holding += [stop for _, stop in scene.rigid_stops if row[stop_column(stop.name)] == RESTING]
    held = {end for part in holding for end in (part.P, part.Q)}
    for i, body in enumerate(scene.bodies):
        _, v = body.columns
        if i not in held and scale[v]:
            return {v: KICK * scale[v]}
    places = [x for x, _ in (body.columns for body in scene.line) if x is not None]
    return {places[0]: KICK * max(scale[x] for x in places)}


def _moved(row: Row, kick: Scale) -> Row:
    return {**row} | {name: row[name] + size for name, size in kick.items()}
