"""Which methods there are, what a run that fails says, and random runs with all that goes with them."""

import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from itertools import islice, pairwise

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings

from tests.engine.runs import opened, run
from tests.random_scenes import scenes
from tests.scenes import fixed_block, harmonic, paper, scene
from vibsim.engine.errors import EngineError
from vibsim.engine.tangent.tangent_space import dimension
from vibsim.engine.trajectory import flow_of, open_trajectory
from vibsim.physics.parts import EVENT_NAMES

METHODS = ("closed_form", "taylor")


def test_methods():
    assert flow_of(paper("I-A").as_parts()) == "closed_form"
    assert flow_of(paper("II-A").as_parts()) == "taylor"
    assert flow_of(paper("I-A", method="taylor").as_parts()) == "taylor"
    with pytest.raises(ValueError, match=r"closed_form .* motor"):
        flow_of(paper("II-A", method="closed_form").as_parts())
    with pytest.raises(ValueError, match="got 'euler'"):
        flow_of(paper("I-A", method="euler").as_parts())


def test_a_failing_run_says_what_when_where_and_what_to_do():
    wild = fixed_block(x1=1e308, v1=1e308, G=None, t_end=1.0)
    with pytest.raises(EngineError) as failure:
        list(opened(wild).blocks())
    message = str(failure.value)
    assert message.startswith("t = 0.0 s: the state is no longer finite")
    assert "x = 1e+308 m" in message
    assert message.endswith("check the parameters for values far outside each other's scale")
    assert "\n" not in message


@pytest.mark.parametrize("method", METHODS)
def test_a_run_that_overflows_fails(method):
    scene = fixed_block(k1=1e308, m1=1e-10, x1=1e10, t_end=0.1, method=method)
    with pytest.raises(EngineError, match="no longer finite"):
        run(scene)


@pytest.mark.parametrize("method", METHODS)
def test_a_run_that_ends_at_its_start(method):
    result = run(fixed_block(x1=0.02, rest_distance=0.01, stop_on_violation=True, method=method))
    assert [EVENT_NAMES[code] for code in result.events["kind"]] == ["start", "end"]
    assert result.events["t"].tolist() == [0.0, 0.0] and result.events["x1"].tolist() == [0.02, 0.02]
    assert result.totals["first_violation_time"] == 0.0


# Random scenes through every part of the engine; `make sanitize` runs a thousand under sanitizers.


COUNT = int(os.environ.get("VIBSIM_SCENES", "25"))
BLOCKS = 10  # a scene may run for ever


@settings(max_examples=COUNT, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(scenes())
def test_a_scene_runs_with_all_that_goes_with_it(scene):
    scene = scene.as_parts()
    trajectory = open_trajectory(scene, section=True, ledger=True, tangent=dimension(scene))
    t, rows = 0.0, []
    try:
        for block in islice(trajectory.blocks(), BLOCKS):
            assert t <= block.t_reached <= scene.t_end
            t = block.t_reached
            rows += [
                dict(zip(block.events, row, strict=True)) for row in zip(*block.events.values(), strict=True)
            ]
    except EngineError:
        pass
    for row, following in list(pairwise(rows))[:5]:
        states = open_trajectory(scene, resume=row).state_at(np.linspace(row["t"], following["t"], 3))
        assert len(states["x1"]) == 3


# Output never steers: cadence and end leave every bit of a trajectory alone; samples stand where asked.


CASES = [("I-A", "closed_form"), ("I-A", "taylor"), ("II-B", "taylor")]


@pytest.mark.parametrize(("name", "method"), CASES)
def test_cadence_does_not_change_the_events(name, method):
    scene = paper(name, method=method, t_end=3.0)
    reference = run(scene)
    for every in ((7, 1000), (1, 10), (1, 3), (5, 1)):
        other = run(replace(scene, every_num=every[0], every_den=every[1]))
        assert all(
            column.tobytes() == reference.events[name].tobytes() for name, column in other.events.items()
        )
        assert other.totals["steps"] == reference.totals["steps"]
        assert len(other.samples["time"]) == scene.t_end * every[1] // every[0] + 1


def test_sample_times_are_correctly_rounded():
    result = run(paper("I-A", t_end=3.0, every_num=7, every_den=1000))
    assert result.samples["time"].tolist() == [7 * i / 1000 for i in range(429)]
    assert result.samples["time"][3] == 0.021


@pytest.mark.parametrize(
    "every", ((123456789012347, 10**15), (987654321098765432109, 10**22), (1, 3 * 10**5))
)
def test_samples_at_intervals_of_many_digits(every):
    """Numerators beyond the integers that doubles hold: i numerator / denominator, each rounded once; over
    one block or several.
    """
    scene = fixed_block(x1=0.01, G=None, t_end=30.0, every_num=every[0], every_den=every[1])
    if scene.sample_count > 10**5:
        scene = replace(scene, t_end=0.5)
    times = run(scene).samples["time"].tolist()
    assert times == [(float(i) * float(every[0])) / float(every[1]) for i in range(len(times))]
    assert len(times) == scene.sample_count and times[-1] <= scene.t_end < times[-1] + every[0] / every[1]


@pytest.mark.parametrize("method", ("closed_form", "taylor"))
@pytest.mark.parametrize("before", (1e-3, 1e-6, 1e-12))
def test_nothing_happens_after_the_end(method, before):
    """The run ends shortly before a contact: that contact is not part of it."""
    w = np.sqrt(200 / 0.297)
    contact = float(np.arcsin(0.001 * w / 0.1) / w)
    scene = fixed_block(
        k2=12400.0, G=0.001, c=0.0, v1=-0.1, t_end=contact - before, every_den=10**6, method=method
    )
    result = run(scene)
    assert result.kinds == []
    assert result.events["t"].tolist() == [0.0, scene.t_end]
    assert result.samples["time"][-1] <= scene.t_end
    assert len(result.samples["time"]) == scene.sample_count


# A run is served in small blocks, whatever it does: Ctrl-C never waits long and memory never grows.


QUIET = scene(harmonic(3.5, 1e-9), N=None, G=1.0, t_end=1e9, every_num=10**8)
BUSY = fixed_block(k2=1e9, G=0.0, c=0.0, v1=-1.0, t_end=1e9, every_num=10**8)
SAMPLED = fixed_block(x1=0.01, G=None, t_end=1e6, every_num=1, every_den=1000)


@pytest.mark.parametrize("method", ("closed_form", "taylor"))
@pytest.mark.parametrize("scene", (QUIET, BUSY, SAMPLED), ids=("quiet", "busy", "sampled"))
def test_work_between_two_blocks_is_bounded(scene, method):
    trajectory = opened(replace(scene, method=method))
    steps = 0
    for block in islice(trajectory.blocks(), 4):
        # a step costs a microsecond or so, a sample less: 0.2 s would be 2e5 of them
        assert trajectory.totals["steps"] - steps <= 120_000
        assert len(block.samples["time"]) <= 65_536
        assert len(block.events["t"]) <= 20_000
        steps = trajectory.totals["steps"]
    assert block.t_reached < scene.t_end


PROGRAM = """
from tests.kernel.test_runs import {name}
from tests.engine.runs import opened
print("ready", flush=True)
for block in opened({name}).blocks():
    pass
"""


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no SIGINT for one child")
@pytest.mark.parametrize("name", ("QUIET", "BUSY", "SAMPLED"))
def test_interrupt_stops_a_long_run(name):
    command = [sys.executable, "-c", PROGRAM.format(name=name)]
    child = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        assert child.stdout.readline() == "ready\n"
        time.sleep(0.2)
        assert child.poll() is None
        child.send_signal(signal.SIGINT)
        _, errors = child.communicate(timeout=100)  # 0.1 s where nothing else runs
    finally:
        child.kill()
    assert "KeyboardInterrupt" in errors
