"""Runs with few samples are not drawn as if there were nothing between them."""

import numpy as np
import pytest

from tests.plots.artists import lines, points
from vibsim.cases import load_case
from vibsim.plots.subject import Subject, View
from vibsim.plots.time_histories import displacement_picture
from vibsim.plots.traces import samples_are_sparse
from vibsim.results import simulate


@pytest.fixture(scope="module")
def sparse():
    """A run with one sample per second, of a source with 6.5 periods per second."""
    case = load_case("I-C", {"run.t_end": "20 s", "run.every": "1 s"})
    return Subject("sparse", "sparse", "trajectory", case, simulate(case))


def test_which_samples_are_sparse(sparse):
    assert samples_are_sparse(sparse.scene)
    assert not samples_are_sparse(load_case("I-C").scene())


def test_vibrations_between_samples_are_drawn_and_the_interval_is_stated(sparse):
    figure = displacement_picture([sparse], View(width="column"))
    t, x1 = points(lines(figure, "x1")[0])
    assert len(t) > 16 * 6.5 * 20
    assert np.ptp(x1) > 1.5 * 1000 * np.ptp(sparse.result["x1"])
    assert "samples every 1 s" in figure.axes[0].get_title(loc="right")


def test_an_interrupted_run_says_so(sparse):
    sparse.result.attrs["complete"] = 0
    assert "incomplete run" in displacement_picture([sparse], View(width="column")).axes[0].get_title(
        loc="right"
    )
