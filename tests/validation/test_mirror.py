"""V8: any scene mirrored gives the mirrored trajectory, bit for bit."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings

from tests.random_scenes import scenes
from tests.scenes import CASE_NAMES, paper
from tests.trajectories import ENGINES, run

ODD = ("x1", "v1", "x2", "v2", "friction")  # change sign; all else stays: time, phi, phidot, contact, kinds


def mirrored(scene):
    """The scene seen in a mirror: signs of state and of A, F0 or e, and the stop on the other side."""
    names = ("A", "F0", "e", "x1", "v1", "x2", "v2")
    flipped = {name: -getattr(scene, name) for name in names if getattr(scene, name) is not None}
    return replace(scene, stop_sign=-scene.stop_sign, **flipped)


def assert_mirror_image(scene, engine):
    one, other = run(scene, engine), run(mirrored(scene), engine)
    for table, image in ((one.samples, other.samples), (one.events, other.events)):
        for name, column in table.items():
            # without friction the flag means nothing and is absent; -0.0 == 0.0 holds
            np.testing.assert_array_equal(-image[name] if name in ODD else image[name], column, err_msg=name)
    assert one.totals == pytest.approx(other.totals, rel=0, abs=0, nan_ok=True)
    return one


@pytest.mark.parametrize("name", CASE_NAMES)
def test_papers_cases_mirrored(name):
    result = assert_mirror_image(paper(name, t_end=60.0), "c")
    assert result.totals["impacts"] > 10


@pytest.mark.parametrize("name", ("I-A", "II-B"))
@pytest.mark.parametrize("engine", ENGINES)
def test_both_engines_mirrored(name, engine):
    assert_mirror_image(paper(name, t_end=5.0), engine)


@settings(max_examples=150)
@given(scenes(features=False))
def test_random_scenes_mirrored(scene):
    assert_mirror_image(scene, "c")


@settings(max_examples=100)
@given(scenes(sources=("none", "harmonic"), features=False))
def test_random_scenes_mirrored_by_taylor(scene):
    assert_mirror_image(replace(scene, method="taylor"), "c")
