"""Points that fail: kept with their reason, tried again, and no harm to the others."""

import numpy as np

from tests.sweeps.made import (
    OMEGA0,
    assert_same_points,
    complete,
    in_memory,
    run_stored,
    short_case,
    short_plan,
)
from vibsim.sweeps.quantities import DONE, FAILED
from vibsim.sweeps.sweep_file import SweepStore


def test_a_failed_point_is_kept_with_its_reason_and_tried_again(tmp_path, monkeypatch):
    from vibsim.engine.errors import EngineError, State
    from vibsim.engine.trajectory import open_trajectory
    from vibsim.sweeps import statistics

    def failing(scene, *arguments, **options):
        if abs(scene.motor.Omega0 / 2 / np.pi - 4) < 1e-9:
            raise EngineError("diverged", State(1.5, [1.5], [1.5], 1.5, 1.5, 1.5))
        return open_trajectory(scene, *arguments, **options)

    plan, path = short_plan({OMEGA0: "3, 4, 5 Hz"}, carry_state=True), tmp_path / "sweep.h5"
    monkeypatch.setattr(statistics, "open_trajectory", failing)
    result, _ = complete(plan, path)
    assert result["status"].ravel().tolist() == [DONE, FAILED, DONE]
    assert "t = 1.5 s: the state is no longer finite" in result["error"][1, 0]
    assert np.isnan(result["mean_speed"][1, 0]) and result.complete
    assert result.case_at((2, 0)).number("initial.x1") == result["end_x1"][0, 0]  # passes over the failed one
    monkeypatch.undo()
    again, _ = complete(plan, path)
    assert_same_points(again.table, in_memory(plan))


def test_a_point_whose_case_is_not_allowed_fails_alone():
    """Each value alone is allowed; together t_end and every make too many samples."""
    plan = short_plan({"t_end": "1, 100 s", "every": "1e-9, 1 s"}, short_case(run__every="1 s"))
    result, _ = run_stored(SweepStore(plan), 1)
    assert result["status"][:, :, 0].tolist() == [[DONE, DONE], [FAILED, DONE]]
    assert "samples" in result["error"][1, 0, 0]


def test_a_bug_at_one_point_does_not_stop_the_others(monkeypatch):
    from vibsim.sweeps import points

    class Faulty(points.Statistics):
        def update(self, block):
            if abs(self.scene.motor.Omega0 / 2 / np.pi - 4) < 1e-9:
                raise ZeroDivisionError("by nothing")
            super().update(block)

    monkeypatch.setattr(points, "Statistics", Faulty)
    result, _ = run_stored(SweepStore(short_plan({OMEGA0: "3, 4, 5 Hz"})), 2)
    assert result["status"].ravel().tolist() == [DONE, FAILED, DONE]
    assert result["error"][1, 0].startswith(
        "a bug in vibsim, please report it: ZeroDivisionError: by nothing (test_"
    )


def test_a_motion_too_fast_to_take_statistics_of_fails_alone():
    """10^300 turns a second over 2 s are no 10^10 samples; nor are 2 s in steps of 10^-30 s."""
    result, _ = run_stored(SweepStore(short_plan({OMEGA0: "1e300, 4 Hz"})), 1)
    assert result["status"].ravel().tolist() == [FAILED, DONE]
    assert "more than 1e10 samples" in result["error"][0, 0]
    result, _ = run_stored(SweepStore(short_plan({OMEGA0: "4 Hz"}, every="1e-30 s")), 1)
    assert "more than 1e10 samples" in result["error"][0, 0]
