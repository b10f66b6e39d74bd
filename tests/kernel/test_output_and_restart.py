"""Output never steers: cadence, restart and resumption leave every bit of a trajectory alone."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings

from tests.random_scenes import scenes
from tests.scenes import fixed_block, paper
from tests.trajectories import assert_same_columns, bits, run
from vibsim.engine.trajectory import state_at

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


@settings(max_examples=50)
@given(scenes())
def test_random_runs_end_at_their_end(scene):
    scene = replace(scene, stop_on_violation=False)
    result = run(scene)
    assert result.events["t"][-1] == scene.t_end
    assert np.all(np.diff(result.events["t"]) >= 0)
    assert len(result.samples["time"]) == scene.sample_count


def states_between(scene, result, i):
    """Samples strictly between event rows i and i + 1, as the run gave them and as state_at gives them."""
    t = result.samples["time"]
    inside = (t >= result.events["t"][i]) & (t < result.events["t"][i + 1])
    stored = {name: column[inside] for name, column in result.samples.items()}
    return stored, state_at(scene.as_parts(), result.row(i), t[inside])


@pytest.mark.parametrize("name", ("I-A", "I-B", "I-C-eq211"))
def test_closed_form_restarts_bit_for_bit(name):
    scene = paper(name, t_end=8.0, every_den=1000)
    result = run(scene)
    for i in range(len(result.times)):
        stored, again = states_between(scene, result, i)
        assert_same_columns(again, stored)


@pytest.mark.parametrize("name", ("I-A", "II-B"))
def test_taylor_restarts_bit_for_bit(name):
    """From a stored row the same steps follow, so even later steps are the same; turns of the rotor apart."""
    scene = paper(name, t_end=8.0, method="taylor", every_den=1000)
    result = run(scene)
    for i in range(len(result.times)):
        stored, again = states_between(scene, result, i)
        assert_same_columns(again, stored)


def assert_resumes(scene, result, i):
    rest = run(scene, resume=result.row(i))
    for name, column in rest.events.items():
        if name not in ("kind", "part"):
            np.testing.assert_array_equal(bits(column), bits(result.events[name][i:]), err_msg=name)
    np.testing.assert_array_equal(rest.events["kind"][1:], result.events["kind"][i + 1 :])
    late = result.samples["time"] >= result.events["t"][i]
    assert_same_columns(rest.samples, {name: column[late] for name, column in result.samples.items()})


@pytest.mark.parametrize(
    ("name", "method"), [*CASES, ("I-B", "closed_form"), ("I-C", "taylor"), ("II-C", "taylor")]
)
def test_resumed_runs_go_on_bit_for_bit(name, method):
    scene = paper(name, method=method, t_end=8.0, every_den=100)
    result = run(scene)
    for i in range(len(result.times) + 1):
        assert_resumes(scene, result, i)


@settings(max_examples=50)
@given(scenes())
def test_random_scenes_resume_bit_for_bit(scene):
    result = run(scene)
    times = result.events["t"]
    for i in range(1, min(len(times) - 1, 12)):
        alone = (
            times[i - 1] < times[i] < times[i + 1]
        )  # of two events at one instant the row of one tells half
        if alone:
            assert_resumes(scene, result, i)


def test_a_resumed_run_samples_from_its_row_on():
    scene = paper("I-A", t_end=3.0)
    result = run(scene)
    row = result.row(len(result.times) // 2)
    rest = run(scene, resume=row)
    assert rest.samples["time"][0] >= row["t"] > rest.samples["time"][0] - 0.005
