"""No call of an engine does unbounded work, however long the stretch that it is in."""

from dataclasses import replace
from itertools import islice

import numpy as np
import pytest
from vibsim.kernel import _kernel, open_trajectory, state_at
from vibsim.kernel.c_engine import CTrajectory

from tests.scenes import fixed_block, harmonic, paper, scene

WORK_AT_ONCE = 100_000  # evaluations of the motion, as kernel.h has it
# one stretch without events of 1e10 quadrature pieces, or tangent pieces
FAST_SOURCE = fixed_block(harmonic(1e9, 1.0), x1=1e-3, k1=1.0, G=None, t_end=100.0, every_num=1, every_den=1)
OVERDAMPED = fixed_block(m1=1e-3, k1=1.0, c=1e6, x1=1e-3, G=None, t_end=100.0, every_num=1, every_den=1)


@pytest.mark.parametrize("engine", ("c", "python"))
def test_the_ledger_of_one_long_stretch_is_kept_in_many_calls(engine):
    trajectory = open_trajectory(FAST_SOURCE, engine, ledger=True)
    evaluations, worked_to = 0, 0.0
    for block in islice(trajectory.blocks(), 1, 5):
        totals = trajectory.totals
        assert totals["evaluations"] - evaluations < 1.2 * WORK_AT_ONCE
        assert block.worked_to > worked_to
        assert block.t_reached == 0.0
        # what is told belongs to whole stretches
        assert totals["work_source"] == totals["energy_residual"] == 0.0
        evaluations, worked_to = totals["evaluations"], block.worked_to


@pytest.mark.parametrize("method", ("closed_form", "taylor"))
@pytest.mark.parametrize("engine", ("c", "python"))
def test_the_tangents_of_one_long_stretch_are_carried_in_many_calls(engine, method):
    trajectory = open_trajectory(replace(OVERDAMPED, method=method), engine, tangent=2)
    pieces, worked_to = 0, 0.0
    for block in islice(trajectory.blocks(), 1, 5):
        totals = trajectory.totals
        assert totals["tangent_pieces"] - pieces < WORK_AT_ONCE
        assert block.worked_to > worked_to
        pieces, worked_to = totals["tangent_pieces"], block.worked_to
    assert worked_to < 100.0


def test_a_stretch_of_many_calls_adds_up_as_one():
    """Bit for bit: the Python engine takes it in pieces of other lengths."""
    source = harmonic(150.0, 1.0)
    long = fixed_block(source, x1=1e-3, k1=1.0, c=1e-3, G=None, t_end=30.0, every_num=10, every_den=1)
    calls, totals = {}, {}
    for engine in ("c", "python"):
        trajectory = open_trajectory(long, engine, ledger=True)
        calls[engine] = len(list(trajectory.blocks()))
        totals[engine] = {name: float(value).hex() for name, value in trajectory.totals.items()}
    assert calls["c"] > 2 and calls["python"] > calls["c"]
    assert totals["c"] == totals["python"]


@pytest.mark.parametrize("engine", ("c", "python"))
def test_samples_of_one_long_stretch_come_in_blocks(engine):
    many = fixed_block(x1=0.01, G=None, t_end=1e5, every_num=1, every_den=1000)
    for block in islice(open_trajectory(many, engine).blocks(), 4):
        assert len(block.samples["time"]) <= 20_000


def test_a_state_far_from_its_event_takes_many_calls():
    quiet = scene(harmonic(3.5, 1e-9), N=None, G=1.0, t_end=1e9, every_num=10**8)
    row = dict.fromkeys(("t", "kind", "x1", "v1", "x2", "v2", "contact"), 0.0)
    trajectory = CTrajectory(quiet, "closed_form", row)
    assert _kernel.state_at(trajectory.run, 1e8) is None
    near = trajectory.state_at([1e5])  # ten calls
    there = open_trajectory(replace(quiet, t_end=1e5, every_num=10**5), "c").blocks()
    assert near["x1"][0] == np.concatenate([block.samples["x1"] for block in there])[-1]


@pytest.mark.parametrize("engine", ("c", "python"))
@pytest.mark.parametrize("t", (-1e300, np.nan, np.inf, -1.0))
def test_no_run_goes_on_from_a_time_that_there_is_not(engine, t):
    row = dict.fromkeys(("kind", "x1", "v1", "x2", "v2", "phi", "phidot", "phase", "contact"), 0.0)
    with pytest.raises(ValueError, match="event row"):
        state_at(paper("II-B"), {**row, "friction": 1, "t": t}, np.array([1.0]), engine)
