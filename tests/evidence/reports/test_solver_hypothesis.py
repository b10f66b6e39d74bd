"""Solvers without events: told apart by what they make of II-B, and stopped when nobody waits."""

import pytest

from vibsim.cases import load_case
from vibsim.evidence.reports.measurements import MeasurementInterrupted
from vibsim.evidence.reports.readings import PATIENCE, measure_solvers, solved


def test_a_solver_follows_the_run_up():
    """The first 30 s of II-B, not chaotic yet: RK4 with 2 ms passes as the engine does."""
    found = solved("RK4, step 2 ms", load_case("II-B", {"run.t_end": "30 s"}))
    assert found["steps"] == 15_000
    assert 3.7 < found["final_hz"] < 4.6


def test_a_coarse_step_acts_like_damping():
    """After 60 s the motor of II-B is away with steps of 2 ms, and held with steps of 4 ms."""
    case = load_case("II-B", {"run.t_end": "60 s"})
    fine, coarse = (solved(f"RK4, step {step} ms", case) for step in (2, 4))
    assert fine["final_hz"] > 4.8
    assert coarse["final_hz"] == pytest.approx(3.69, abs=0.03)


def test_work_is_given_up_at_once():
    """Work for minutes, stopped at the first look: the time limit of a test is shorter."""
    case = load_case("II-B", {"run.t_end": "100000 s"})
    assert PATIENCE >= 120
    with pytest.raises(MeasurementInterrupted):
        measure_solvers([case], lambda done, total: False)
