"""Output never steers: cadence and end leave every bit of a trajectory alone; samples stand where asked."""

from dataclasses import replace

import numpy as np
import pytest

from tests.scenes import fixed_block, paper
from tests.trajectories import assert_same_columns, run

CASES = [("I-A", "closed_form"), ("I-A", "taylor"), ("II-B", "taylor")]


@pytest.mark.parametrize(("name", "method"), CASES)
def test_cadence_does_not_change_the_events(name, method):
    scene = paper(name, method=method, t_end=3.0)
    reference = run(scene)
    for every in ((7, 1000), (1, 10), (1, 3), (5, 1)):
        other = run(replace(scene, every_num=every[0], every_den=every[1]))
        assert_same_columns(other.events, reference.events)
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
    """Intervals whose numerators leave the integers that doubles hold: i numerator / denominator, each
    operation rounded once.
    """
    scene = fixed_block(x1=0.01, G=None, t_end=30.0, every_num=every[0], every_den=every[1])
    if scene.sample_count > 10**5:
        scene = replace(scene, t_end=0.2)
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
