"""Runs of scenes made of parts, in doubles.

trajectory = open_trajectory(scene)
for block in trajectory.blocks(): ...
trajectory.totals
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from vibsim.engine.blocks import Block, ColumnMaker, by_name
from vibsim.engine.doubts import Doubt
from vibsim.engine.errors import State
from vibsim.engine.ledger import ledger_totals, rigid_totals, totals_of
from vibsim.engine.modes.ties import Edge
from vibsim.engine.resume import Row, resume_point
from vibsim.engine.tangent.tangent_space import dimension
from vibsim.physics.parts import Scene

if TYPE_CHECKING:
    from vibsim.engine.c_engine import CRun, Filled


def open_trajectory(
    scene: Scene,
    resume: Row | Sequence[Row] | None = None,
    section: bool = False,
    ledger: bool = False,
    momentum: bool = False,
    tangent: int = 0,
    tangent_from: float = 0.0,
    extremes: tuple[Sequence[Edge], float] | None = None,
    early: bool = False,
    dither: int = 0,
    record_from: tuple[float, float] = (0.0, 0.0),
) -> Trajectory:
    """A run of `scene` (a `vibsim.physics.parts.Scene`) from its start, not yet computed.

    Parameters
    ----------
    scene : Scene
    resume : one stored event row (t, kind, part, states, phase, part states, sides of switches by name) to go
        on from, all rows of one instant in their order, or None
    section : whether the blocks carry the stroboscopic section, the state at the end of every period of what
        drives the scene
    ledger : whether the totals carry the energy ledger
    momentum : whether they carry the momentum ledger, and with it that of energy
    tangent : number of disturbances to carry along, for as many Lyapunov exponents in the totals
    tangent_from : time [s] from which their growth counts
    extremes : (pairs of ends P, Q as of a part, time [s] from which on), or None. Least and greatest
        x_P - x_Q of each pair, then of the rotor's speed, exact to rounding: by period in the blocks, where
        they carry the section, and of all in `extremes` of the object returned, with the smallest gap at a
        turn without contact of each stop between the ends of a pair
    early : whether infinite sequences of impacts end at least one whole hop before they do without it: what
        the one run leaves out, the difference of two shows
    dither : k > 0: events are taken one unit in the last place of the time later or earlier than they are
        rounded, with signs of their own for every k up to 31
    record_from : times [s] before which samples, and the section, are left out; the state at the former is
        `at_begin` of the object returned

    Raises ValueError for another method, a row that no run has or more disturbances than the scene has
    directions.
    """
    check_method(scene)
    if tangent and not 0 <= tangent <= dimension(scene):
        raise ValueError(f"tangent must be 0 to {dimension(scene)} for this scene, got {tangent}")
    from vibsim.engine.c_engine import CRun

    return Trajectory(
        CRun(
            scene,
            None if resume is None else resume_point(scene, resume),
            section=section,
            ledger=ledger,
            momentum=momentum,
            tangent=(tangent, tangent_from),
            extremes=extremes,
            early=early,
            dither=dither,
            record_from=record_from,
        )
    )


RUNS_AT_ONCE = 8  # lanes, as in `lanes.h`


def suits_lanes(scene: Scene) -> bool:
    """Whether several runs of scenes like this one take their steps side by side on this machine: those of
    one body or two with a motor, whose motion no formula or moving base makes.
    """
    import vibsim.engine._engine as _engine

    small = scene.has_motor and len(scene.bodies) <= 2
    return small and not scene.has_formulas and not scene.base_moves and _engine.LANES > 0


def advance_together(trajectories: Sequence[Trajectory]) -> None:
    """Make the next call of C of runs whose `blocks_beside` have yielded None: their steps side by side where
    they suit lanes, with the numbers of each run by itself. Runs that are not `advanced` afterwards wait for
    the next call of this function.
    """
    import vibsim.engine._engine as _engine

    advanced = _engine.advance_together(tuple(one.run.run for one in trajectories))
    for trajectory, progress in zip(trajectories, advanced, strict=True):
        trajectory.run.advanced = progress


class Trajectory:
    """A run on the C engine, whose rows of numbers become columns by name; see `open_trajectory`."""

    def __init__(self, run: CRun) -> None:
        scene = run.scene
        self.scene, self.run, self.columns = scene, run, ColumnMaker(scene, run.switches)

    @property
    def advanced(self) -> bool:
        """Whether `advance_together` has made the call of C that the blocks wait for."""
        return self.run.advanced is not None

    def blocks(self) -> Iterator[Block]:
        """Yield `Block`s until the run ends; raises EngineError when it fails."""
        return filter(None, self.blocks_beside())

    def blocks_beside(self) -> Iterator[Block | None]:
        """The same, with None before each call of C: `advance_together` may make that call, else the run."""
        for rows in self.run.blocks_beside():
            yield self.columns.block(*rows) if rows else None

    def whole(self) -> Filled | None:
        """The rows of a short run, computed from its start, that `columns.block` takes even when the run has
        begun anew. None of a longer one, which `blocks` then goes on with.
        """
        self.run.advanced = self.run.run.advance()
        return self.run.whole(self.run.advanced)

    def stop(self) -> None:
        """Have `blocks` end with what is computed, from any thread; at once where it decides what follows."""
        self.run.stopped.set()

    def restart(self, scene: Scene) -> bool:
        """Begin anew from the start of a scene that differs from that of the run at most in its start and in
        numbers of its modes. Whether that was possible: if not, this run must not be used again.

        What the blocks before have shown holds no longer.
        """
        self.scene, self.run.advanced = scene, None
        return self.run.begin_anew(scene)

    def pause_at(self, time: float) -> None:
        """Have the block end with which the run reaches a time [s]; the next one where there is no other."""
        self.run.run.pause_at(time)

    @property
    def at_begin(self) -> dict[str, np.ndarray]:
        """Time and state from which samples are recorded, as columns of one."""
        row = self.run.form.empty(3 + 2 * self.run.n, 1)
        self.run.run.at_begin(row)
        return by_name(self.columns.timed_states, row)

    @property
    def extremes(self) -> tuple[list[float], list[float], list[float]]:
        """Least and greatest of every pair so far, and the smallest gap of every stop that is watched."""
        return self.run.run.extremes()

    @property
    def left_out(self) -> list[tuple[float, float]]:
        """(time [s], distance [m] that ends of infinite sequences of impacts have left out from then on)."""
        return self.run.automaton.rigid.chatter.cut_off.ends if self.scene.rigid_stops else []

    @property
    def doubts(self) -> list[Doubt]:
        """The first doubts of the certificate, described; the totals count all."""
        return self.run.doubts

    @property
    def totals(self) -> dict[str, Any]:
        """Counts and margins so far, and the ledgers and exponents where they are kept, as doubles."""
        run, tally, rounded = self.run, self.run.run.tally(), self.run.kit.rounded
        uncertified, *margins = tally["certificate"]
        certificate = uncertified, *rounded(margins)
        totals = totals_of(tally, certificate)
        if run.integrals:
            now = run.left_at or State(*tally["state"]), run.statuses[tally["mode"]]
            entries, where = tally["entries"], (run.first, now)
            ledger = ledger_totals(self.scene, run.kit, run.integrals.names, entries, *where)
            totals |= dict(zip(ledger, rounded(ledger.values()), strict=True))
        if self.scene.rigid_stops:
            cut = run.automaton.rigid.chatter.cut_off
            left_out = rounded([cut.time, cut.speed, cut.distance])
            totals |= rigid_totals(tally["counts"], left_out)
        if run.moving:
            from vibsim.engine.tangent.tangencies import tangent_totals

            totals |= tangent_totals(self.scene, run.kit, run.disturbances, *certificate[2:])
        return totals

    def state_at(self, times: Iterable[float]) -> dict[str, np.ndarray]:
        """States at ascending times [s] as columns; events on the way are taken."""
        states, codes = self.run.states_at(list(times))
        return self.columns.samples(states, codes)


# By which flow a scene is run.


METHODS = ("auto", "closed_form", "taylor")


def check_method(scene: Scene) -> None:
    """Raises ValueError for a method that there is not, and for closed_form with a motor, which has none."""
    if scene.method not in METHODS:
        raise ValueError(f"method must be one of {', '.join(METHODS)}, got {scene.method!r}")
    if scene.method == "closed_form" and scene.has_motor:
        raise ValueError("method closed_form needs an ideal source; with a motor use taylor or auto")


def flow_of(scene: Scene) -> str:
    """The flow of a run: "closed_form" or "taylor" where all modes take it, "auto" where each is asked.

    Raises ValueError as `check_method` does.
    """
    check_method(scene)
    if scene.has_motor or scene.rotors or scene.base_formula is not None or scene.method == "taylor":
        return "taylor"
    if scene.has_formulas:  # closed in the modes that read none, such as a flight between stops
        acts = any(force.formula is not None for force in scene.forces) or any(
            link.force is not None for link in scene.links
        )
        return "taylor" if acts else "auto"
    return "closed_form" if _always_closed(scene) else "auto"


def _always_closed(scene: Scene) -> bool:
    """Whether every mode has a closed form: one body, or two that links and stops join to each other only,
    without belts, which may stretch springs for ever, and without rigid stops, on which they hop.
    """
    if any(friction.belt for friction in scene.frictions) or scene.rigid_stops:
        return False
    joined = [{part.P, part.Q} for part in scene.links] + [{part.P, part.Q} for part in scene.stops]
    return len(scene.bodies) == 1 or (len(scene.bodies) == 2 and all(ends == {0, 1} for ends in joined))
