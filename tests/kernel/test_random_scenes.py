"""Random scenes through every part of the C engine; `make sanitize` runs a thousand under sanitizers."""

import os
from itertools import islice, pairwise

import numpy as np
from hypothesis import HealthCheck, given, settings

from tests.random_scenes import scenes
from vibsim.engine.errors import EngineError
from vibsim.engine.tangent.tangent_space import dimension
from vibsim.engine.trajectory import open_trajectory, state_at

COUNT = int(os.environ.get("VIBSIM_SCENES", "25"))
BLOCKS = 10  # a scene may run for ever


@settings(max_examples=COUNT, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(scenes())
def test_a_scene_runs_with_all_that_goes_with_it(scene):
    scene = scene.as_parts()
    trajectory = open_trajectory(scene, "c", section=True, ledger=True, tangent=dimension(scene))
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
        states = state_at(scene, row, np.linspace(row["t"], following["t"], 3), "c")
        assert len(states["x1"]) == 3
