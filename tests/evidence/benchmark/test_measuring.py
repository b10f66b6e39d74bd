import math

import numpy as np
import pytest

from tests.evidence.benchmark.made import plan, truth
from vibsim.engine.choice import compiled
from vibsim.evidence.benchmark import running
from vibsim.evidence.benchmark.bench_result import DONE, FAILED, SLOWER
from vibsim.evidence.benchmark.plan import OwnEngine, SolverFamily, family_of
from vibsim.evidence.benchmark.running import MOST_RUNS, measure
from vibsim.evidence.peers.solvers import EVERY_KIND, TimeLimit
from vibsim.physics.parts import EVENT_KINDS


class Failing:
    def __init__(self, scene):
        pass

    def run(self, times, limit):
        raise ArithmeticError("the step is too small\nand more")


FAILS = SolverFamily(
    "failing", "failing", "failing", "tests.evidence.benchmark.test_measuring:Failing", {}, [("as it is", {})]
)


def row(method, setting, limit=20.0, going_on=lambda: True, name="II-B"):
    scene = plan(name).case.scene()
    return measure(family_of(method), setting, scene, truth(name), limit, going_on)


def test_a_peer_is_timed_counted_and_judged():
    found = row("dop853", "rtol 1e-9")
    assert (found.status, found.problem, found.t_reached, found.faithful_time) == (DONE, "", 2.0, 2.0)
    assert found.wall_time > 0 and found.cpu_time > 0 and 1 <= found.runs <= MOST_RUNS
    assert found.evaluations > 5 * found.steps > 0
    assert 0 < found.error[-1] < 1e-9 and len(found.error) == 401
    true = np.isin(truth().events["kind"], [EVENT_KINDS[name] for name in EVERY_KIND])
    count = found.counted()
    assert (count.found, count.missed, count.spurious) == (np.count_nonzero(true), 0, 0)


def test_the_least_of_several_runs_counts(monkeypatch):
    """Runs that other processes disturb move no number: neither the first nor most of them."""
    clocks = iter([(1.0, 1.0), (0.2, 0.1), (0.02, 0.01), (0.15, 0.14), (0.2, 0.19)])  # setup, then runs [s]
    monkeypatch.setattr(running, "ENOUGH", 0.5)
    monkeypatch.setattr(running, "_timed", lambda call: (next(clocks), call()))
    found = row("dop853", "rtol 1e-9")
    assert (found.runs, found.wall_time, found.cpu_time) == (4, 0.02, 0.01)
    assert found.time_per_second == 0.01 / 2.0


def test_what_is_slow_is_stopped_and_judged_so_far():
    looks = iter(range(100))
    found = row("rk4", "step 0.5 ms", going_on=lambda: next(looks) < 60)
    assert found.status == SLOWER and 0 < found.t_reached < 2.0
    assert np.isfinite(found.error[0]) and math.isnan(found.error[-1])
    assert math.isnan(found.error_until(truth().samples["time"], 2.0))


def test_what_fails_says_so():
    found = measure(FAILS, "as it is", plan().case.scene(), truth(), 1.0, lambda: True)
    assert (found.status, found.problem) == (FAILED, "the step is too small")
    assert found.runs == 0 and np.isnan(found.error).all() and found.counted() is None


@pytest.mark.skipif(not compiled(), reason="needs the C engine")
def test_vibsim_is_measured_like_its_peers():
    found = row("closed-form", "C engine", name="I-A")
    assert found.status == DONE and found.error[-1] < 1e-15 and found.evaluations == -1
    assert found.counted().missed == found.counted().spurious == 0


def test_states_are_those_of_the_bodies():
    from tests.scenes import fixed_block

    scene = fixed_block(x1=1e-3, t_end=1.0).as_parts()
    attempt = OwnEngine(scene, "python", "auto").run(np.array([0.0]), TimeLimit())
    assert attempt.states.shape == (201, 2) and abs(attempt.states[:, 1]).max() > 0.01
