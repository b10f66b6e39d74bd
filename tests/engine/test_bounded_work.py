"""No call of an engine does unbounded work, however long the stretch that it is in."""

from dataclasses import replace
from itertools import islice
from math import pi

import numpy as np
import pytest

from vibsim.cases import load_case
from vibsim.engine.c_engine import CRun
from vibsim.engine.number_forms import DOUBLES
from vibsim.engine.resume import resume_point
from vibsim.engine.trajectory import open_trajectory
from vibsim.physics.parts import COMPRESSION, GROUND, Body, Force, Friction, Harmonic, Link, Scene, Stop

WORK_AT_ONCE = 100_000  # evaluations of the motion, as engine.h has it


def one_body(frequency=0.0, c=0.0, amplitude=1.0, **parts):
    """A body on a spring, under a force of so many hertz."""
    harmonic = Harmonic(amplitude, 2 * pi * frequency, frequency, 0.0, 0.0)
    forces = (Force("F", 0, 0.0, (harmonic,)),) if frequency else ()
    link = Link("l", 0, GROUND, 1.0, c)
    parts = {"every_num": 1, "every_den": 1, **parts}
    return Scene((Body("m", 1.0, 1e-3, 0.0),), (link,), forces=forces, **parts)


# one stretch without events of 1e10 pieces
FAST = one_body(1e9, t_end=100.0)


@pytest.mark.parametrize("engine", ("c", "python"))
def test_the_ledger_of_one_long_stretch_is_kept_in_many_calls(engine):
    trajectory = open_trajectory(FAST, engine, ledger=True, momentum=True)
    evaluations, worked_to = 0, 0.0
    for block in islice(trajectory.blocks(), 4):
        totals = trajectory.totals
        assert totals["evaluations"] - evaluations < 1.2 * WORK_AT_ONCE
        assert block.worked_to > worked_to
        assert block.t_reached == 0.0
        # what is told belongs to whole stretches
        assert totals["work_source"] == totals["energy_residual"] == totals["momentum_residual"] == 0.0
        evaluations, worked_to = totals["evaluations"], block.worked_to


@pytest.mark.parametrize("method", ("auto", "taylor"))
@pytest.mark.parametrize("engine", ("c", "python"))
def test_the_disturbances_of_one_long_stretch_are_carried_in_many_calls(engine, method):
    """A damper that wants 1e9 pieces."""
    overdamped = replace(one_body(c=1e8, t_end=100.0), method=method)
    trajectory = open_trajectory(overdamped, engine, tangent=2)
    pieces, worked_to = 0, 0.0
    for block in islice(trajectory.blocks(), 4):
        totals = trajectory.totals
        assert totals["tangent_pieces"] - pieces < WORK_AT_ONCE
        assert block.worked_to > worked_to
        pieces, worked_to = totals["tangent_pieces"], block.worked_to
    assert 0 < worked_to < 100.0


def test_the_disturbances_of_many_calls_add_up_as_in_one():
    long = one_body(150.0, c=2e4, t_end=16.0, every_num=10)
    pieces, totals = {}, {}
    for engine in ("c", "python"):
        trajectory = open_trajectory(long, engine, tangent=2)
        pieces[engine] = len(list(trajectory.blocks()))
        totals[engine] = {name: np.asarray(value).tolist() for name, value in trajectory.totals.items()}
    assert pieces["c"] > 1 and pieces["python"] > 2
    assert str(totals["c"]) == str(totals["python"])


def test_a_stretch_of_many_calls_adds_up_as_one():
    """Bit for bit: the Python engine takes it in pieces of other lengths."""
    scene = one_body(150.0, c=1e-3, t_end=20.0, every_num=10)
    calls, totals = {}, {}
    for engine in ("c", "python"):
        trajectory = open_trajectory(scene, engine, ledger=True)
        calls[engine] = len(list(trajectory.blocks()))
        totals[engine] = {name: float(value).hex() for name, value in trajectory.totals.items()}
    assert calls["c"] > 1 and calls["python"] > calls["c"]
    assert totals["c"] == totals["python"]


@pytest.mark.parametrize("method", ("auto", "taylor"))
@pytest.mark.parametrize("engine", ("c", "python"))
def test_samples_of_one_long_stretch_come_in_blocks(engine, method):
    many = replace(one_body(t_end=1e5, every_den=1000), method=method)
    for block in islice(open_trajectory(many, engine).blocks(), 4):
        assert len(block.samples["time"]) <= 65_536


@pytest.mark.parametrize("engine", ("c", "python"))
def test_section_points_of_one_long_stretch_come_in_blocks(engine):
    for block in islice(open_trajectory(FAST, engine, section=True).blocks(), 4):
        assert len(block.section["time"]) <= 65_536


def test_steps_of_a_run_without_events_come_in_many_calls():
    """A chain of twenty bodies whose stops are never reached; a call does a part of the work."""
    stops = tuple(Stop(f"s{i}", i, i + 1, 1.0, COMPRESSION, 1.0, 0.0) for i in range(19))
    bodies = tuple(Body(f"b{i}", 1.0, 1e-3 * i, 0.0) for i in range(20))
    links = tuple(Link(f"l{i}", i, i + 1, 1.0, 0.0) for i in range(19))
    chain = Scene(
        bodies, links, stops, (Friction("f", 0, GROUND, 1.0, 1.0, 0.0),), t_end=1e9, every_num=10**8
    )
    trajectory, steps = open_trajectory(chain, "c"), 0
    for _ in islice(trajectory.blocks(), 3):
        assert trajectory.totals["steps"] - steps < WORK_AT_ONCE / 2
        steps = trajectory.totals["steps"]


def test_a_state_far_from_its_event_takes_many_calls():
    stop = Stop("s", 0, GROUND, 1.0, COMPRESSION, 1.0, 0.0)
    quiet = one_body(3.5, amplitude=1e-9, t_end=1e9, every_num=10**8, stops=(stop,))
    row = {name: values[0] for name, values in next(open_trajectory(quiet, "c").blocks()).events.items()}
    far = CRun(quiet, resume_point(quiet, row))
    codes = np.empty((1, 1), dtype="i1")
    assert far.run.states_at(DOUBLES.packed([1e8]), DOUBLES.empty(5, 1), codes, 0) == (0, 0)
    near = open_trajectory(quiet, "c", resume=row).state_at([1e5])
    there = open_trajectory(replace(quiet, t_end=1e5, every_num=10**5), "c").blocks()
    assert near["x_m"][0] == np.concatenate([block.samples["x_m"] for block in there])[-1]


@pytest.mark.parametrize("engine", ("c", "python"))
@pytest.mark.parametrize("gap", ("1e-300 m", "1e-40 m"))
def test_a_gap_that_opens_by_the_fourth_power_of_time_takes_few_steps(engine, gap):
    """A motor that sets off from rest parts the blocks in proportion to t^4. Bounds that hold for a whole
    Taylor step would allow steps of the root of the gap, and 1e9 of them or more.
    """
    case = load_case("II-B", {"x1": gap, "G": "0 m", "run.t_end": "0.05 s"})
    trajectory = open_trajectory(case.scene(), engine)
    samples = [block.samples["x1"] for block in islice(trajectory.blocks(), 40)]
    assert len(np.concatenate(samples)) == 11
    assert trajectory.totals["steps"] < 20
