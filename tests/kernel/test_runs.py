"""Which methods there are, what a run that fails says, and random runs with all that goes with them."""

import os
from itertools import islice, pairwise

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings

from tests.random_scenes import scenes
from tests.scenes import TABLE_1, fixed_block, paper
from tests.trajectories import opened, run
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


def test_table_1_amplitudes():
    assert [paper(name).A for name in TABLE_1] == [0.0725, 0.1140, 0.1350]
    # m3 e omega^2: 1.596, 3.941, 5.504 N
    assert [round(paper(f"{name}-eq211").A, 3) for name in TABLE_1] == [1.596, 3.941, 5.504]


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
