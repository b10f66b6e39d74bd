"""A point does not depend on when, where and beside which others it is computed."""

from itertools import pairwise

import pytest

from tests.sweeps.made import OMEGA0, assert_same_points, run_stored, short_case, short_plan
from vibsim.sweeps.quantities import DONE
from vibsim.sweeps.sweep_file import SweepStore

SETTINGS = {
    "fresh": {},
    "carried up and down": {"carry_state": True, "direction": "both"},
    "carried down": {"carry_state": True, "direction": "down"},
}


def table(plan, jobs, engine="auto"):
    result, finished = run_stored(SweepStore(plan, engine=engine), jobs, engine)
    assert finished and result.complete
    return result.table


@pytest.mark.parametrize("settings", SETTINGS.values(), ids=SETTINGS)
@pytest.mark.parametrize("case", ["II-B", "I-B"])
def test_any_number_of_jobs_gives_the_same_bits(settings, case):
    axis = {OMEGA0 if case == "II-B" else "omega": "3:5:0.5 Hz", "c": "0.001, 0.03"}
    plan = short_plan(axis, short_case(case), **settings)
    one = table(plan, 1)
    assert one.count(DONE) == plan.count == 5 * 2 * len(plan.directions)
    for jobs in (2, 5):
        assert_same_points(table(plan, jobs), one)


def test_processes_over_the_python_engine_give_the_same_bits():
    plan = short_plan({OMEGA0: "3:5:1 Hz"}, short_case(t_end="1 s"), discard="0.2")
    assert_same_points(table(plan, 2, "python"), table(plan, 1, "c"))


def test_a_carried_point_begins_where_the_one_before_ended():
    plan = short_plan({OMEGA0: "3, 4 Hz"}, carry_state=True, direction="both")
    result, _ = run_stored(SweepStore(plan), 1)
    order = [(0, 0), (1, 0), (1, 1), (0, 1)]  # up, then back down
    assert result.case_at(order[0]).number("initial.x1") == 0.0
    for before, after in pairwise(order):
        case = result.case_at(after)
        for name in ("x1", "v1", "x2", "v2", "phi", "phidot"):
            assert case.number(f"initial.{name}") == result[f"end_{name}"][before]
        assert case.sha256 == result["sha256"][after]


def test_a_carried_harmonic_force_has_no_jump():
    """4 s at 3.3 Hz end in a period; the state carried on is that at its last whole one, 13/3.3 s."""
    plan = short_plan({"omega": "3.3, 3.4 Hz"}, short_case("I-B"), carry_state=True)
    result, _ = run_stored(SweepStore(plan), 1)
    import vibsim

    state = vibsim.simulate(result.case_at((0, 0))).at(13 / 3.3)
    for name in ("x1", "v1", "x2", "v2"):
        # an instant is rounded to 1e-16 of 4 s, and the state changes at up to 100 units per second
        assert result[f"end_{name}"][0, 0] == pytest.approx(float(state[name]), rel=1e-9, abs=1e-13)


def test_fresh_points_do_not_depend_on_the_direction():
    result, _ = run_stored(SweepStore(short_plan(direction="both")), 2)
    for name in ("mean_speed", "amplitude_x1", "end_x2"):
        assert (result[name][:, 0] == result[name][:, 1]).all()
