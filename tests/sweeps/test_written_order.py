"""Order is meaning: a falling range runs down, a list as it is written, on axes, in files and in pictures."""

from itertools import pairwise

import numpy as np
import pytest

from tests.command_line.made import call
from tests.sweeps.made import OMEGA0, assert_same_points, run_stored, short_plan
from vibsim.plots.subject import open_subjects
from vibsim.plots.sweep_axes import plane_of
from vibsim.plots.sweep_curves import curves
from vibsim.results.simulation import open_result
from vibsim.sweeps import join
from vibsim.sweeps.sweep_file import SweepStore
from vibsim.sweeps.sweep_plan import DOWN, UP, PlanError, shard

CARRIED = {"carry_state": True}


def swept(plan):
    return run_stored(SweepStore(plan), 1)[0]


def test_a_falling_range_runs_down():
    """As the rising one does with --direction down, from the other end."""
    falling, rising = short_plan({OMEGA0: "5:3:1 Hz"}, **CARRIED), short_plan({OMEGA0: "3:5:1 Hz"}, **CARRIED)
    down = short_plan({OMEGA0: "3:5:1 Hz"}, direction="down", **CARRIED)
    assert (falling.directions, rising.directions) == ((DOWN,), (UP,))
    result = swept(falling)
    assert result["omega0"].tolist() == [5.0, 4.0, 3.0]
    assert result.case_at((0, 0)).number("initial.x1") == 0.0
    assert result["end_x1"].tolist() == swept(down)["end_x1"][::-1].tolist()
    assert result["end_x1"].tolist() != swept(rising)["end_x1"][::-1].tolist()


def test_a_list_runs_as_it_is_written_and_back():
    plan = short_plan({OMEGA0: "4, 3, 5 Hz"}, direction="both", **CARRIED)
    result = swept(plan)
    assert result["omega0"].tolist() == [4.0, 3.0, 5.0]
    order = [(0, 0), (1, 0), (2, 0), (2, 1), (1, 1), (0, 1)]
    for before, after in pairwise(order):
        assert result.case_at(after).number("initial.x1") == result["end_x1"][before]
    for word in ("up", "down"):
        with pytest.raises(
            PlanError, match="a direction needs values that rise or fall: sort those of omega0"
        ):
            short_plan({OMEGA0: "4, 3, 5 Hz"}, direction=word, **CARRIED)


@pytest.mark.parametrize(
    ("text", "word", "directions"),
    [
        ("3:5:1 Hz", None, (UP,)),
        ("3:5:1 Hz", "down", (DOWN,)),
        ("3:5:1 Hz", "both", (UP, DOWN)),
        ("5:3:1 Hz", "up", (UP,)),
        ("5:3:1 Hz", "both", (DOWN, UP)),
        ("4 Hz", None, (UP,)),
        ("4, 3, 5 Hz", None, (UP,)),
    ],
)
def test_the_directions(text, word, directions):
    plan = short_plan({OMEGA0: text}, direction=word, **CARRIED)
    assert plan.directions == directions
    assert open_settings(plan) == directions


def open_settings(plan):
    return tuple({"up": UP, "down": DOWN}[word] for word in plan.settings["direction"])


def test_points_that_start_fresh_have_no_direction():
    assert short_plan({OMEGA0: "5:3:1 Hz"}).directions == (UP,)


def test_a_file_keeps_the_order_and_is_completed_in_it(tmp_path):
    plan = short_plan({OMEGA0: "5:3:1 Hz"}, direction="both", **CARRIED)
    whole = run_stored(SweepStore(plan, tmp_path / "a.h5"), 1)[0]
    read = open_result(tmp_path / "a.h5")
    assert read.plan.fingerprint == plan.fingerprint
    assert read.directions == (DOWN, UP)
    assert read["omega0"].tolist() == [5.0, 4.0, 3.0]
    assert_same_points(read.table, whole.table)


@pytest.mark.parametrize("text", ["0.05:0.01/5", "0.01:0.05/5"])
def test_parts_of_a_range_join_in_its_order_whatever_theirs(tmp_path, text):
    plan = short_plan({"c": text})
    for number in (1, 2):
        run_stored(SweepStore(shard(plan, number, 2), tmp_path / f"{number}.h5"), 1)
    for order in ((1, 2), (2, 1)):
        joined = join([tmp_path / f"{number}.h5" for number in order])
        assert joined.plan.fingerprint == plan.fingerprint
        assert joined["c"].tolist() == [float(value) for value in plan.axes[0].values]


def test_pictures_run_from_left_to_right(tmp_path):
    axes = [{OMEGA0: "5, 3, 4 Hz", "c": "0.03:0.01/3"}, {OMEGA0: "3, 4, 5 Hz", "c": "0.01:0.03/3"}]
    for name, ranges in zip("ab", axes, strict=True):
        run_stored(SweepStore(short_plan(ranges), tmp_path / f"{name}.h5"), 1)
    (a,), (b,) = (open_subjects([str(tmp_path / f"{name}.h5")]) for name in "ab")
    drawn = {curve.label: (curve.x, curve.values("mean_speed")) for curve in curves([a])}
    assert len(drawn) == 3
    for curve in curves([b]):
        x, values = drawn[curve.label]
        np.testing.assert_array_equal(x, curve.x)
        np.testing.assert_array_equal(values, curve.values("mean_speed"))
    planes = plane_of(a), plane_of(b)
    for mine, others in zip(planes[0].spans(), planes[1].spans(), strict=True):
        np.testing.assert_array_equal(mine, others)
    cells = [plane.grid(s.result["mean_speed"]) for plane, s in zip(planes, (a, b), strict=True)]
    np.testing.assert_array_equal(*cells)


@pytest.mark.parametrize(
    ("command", "said"),
    [
        (["sweep", "--omega0", "3:4:1", "--omega0", "5:6:1"], "--omega0 is given twice"),
        (["sweep", "--omega0", "3:4:1", "--carry-state", "--fresh"], "--carry-state is given twice"),
        (["sweep", "--ensemble", "2", "--spread", "x1=1mm", "--spread", "x1=2mm"], "x1 is given twice"),
        (["run", "II-B", "--t-end", "1s", "--t-end", "2s"], "--t-end is given twice"),
        (["run", "II-B", "-s", "mu=1", "-s", "mu=2"], "mu is given twice"),
        (["run", "II-B", "-s", "mu=1", "-s", "friction.mu=2"], "friction.mu: is given twice"),
        (["run", "II-B", "-s", "t_end=1 s", "--t-end", "2s"], "--t-end and --set t_end say the same"),
        (["--color", "never", "--color", "always", "cases"], "--color is given twice"),
    ],
)
def test_what_is_given_twice_is_an_error(command, said, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    found = call(*command)
    assert found.exit_code in (2, 3)
    assert said in found.stderr
    assert not list(tmp_path.iterdir())
