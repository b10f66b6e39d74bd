"""Points that begin a kept run anew have the bits of points that are run alone."""

import threading

import numpy as np
import pytest

from vibsim.cases import load_case
from vibsim.engine import c_engine
from vibsim.engine.trajectory import open_trajectory
from vibsim.sweeps import statistics
from vibsim.sweeps.axes import read_members
from vibsim.sweeps.points import BatchPiece, Measurement, compute_batch
from vibsim.sweeps.quantities import NOT_REPRODUCIBLE, quantities_of
from vibsim.sweeps.statistics import MeasuredRun, sampled_for_statistics
from vibsim.sweeps.sweeping import make_plan

STARTS = {  # case -> spreads
    "II-B": {"phi": "0:1 turn", "x1": "2 mm"},
    "gallery/belt-oscillator": {"block.x": "-2:2 m", "block.v": "0:2 m/s"},
    "gallery/chattering-oscillator": {"mass.x": "1e-4 m"},
    "gallery/two-exciters": {"left.phi": "0:1 turn"},
}


def alone(function):
    """What a function gives in a thread of its own, in which no run is kept."""
    got = []
    thread = threading.Thread(target=lambda: got.append(function()))
    thread.start()
    thread.join()
    return got[0]


def numbers(point):
    """All bits of a point that can be reproduced."""
    values = {name: value.hex() for name, value in point.values.items() if name not in NOT_REPRODUCIBLE}
    return point.error, point.sha256, values, {name: one.tobytes() for name, one in point.arrays.items()}


@pytest.mark.parametrize("name", STARTS)
def test_points_do_not_depend_on_those_before(name):
    case = load_case(name, {"run.t_end": "12 s"})
    plan = make_plan(case, [], ensemble=(read_members(case, 4, 0, STARTS[name]),), section=5)
    indices = [(member, 0) for member in (0, 1, 2, 3, 1)]  # one twice, other motions between
    piece = BatchPiece(tuple((index, plan.changes(index)) for index in indices))
    together = alone(lambda: compute_batch(plan.point_settings, (piece,)))
    for index, point in zip(indices, together, strict=True):
        one = BatchPiece(((index, plan.changes(index)),))
        [apart] = alone(lambda one=one: compute_batch(plan.point_settings, (one,)))
        assert numbers(point) == numbers(apart)


@pytest.mark.parametrize(
    ("few", "order"), [(c_engine.FEW, ["run"] * 3 + ["measured"] * 3), (0, ["run", "measured"] * 3)]
)
def test_short_runs_of_a_batch_end_before_one_is_measured(monkeypatch, few, order):
    noted = []

    def noting(name, function):
        def noted_first(self):
            noted.append(name)
            return function(self)

        return noted_first

    monkeypatch.setattr(c_engine, "FEW", few)
    monkeypatch.setattr(MeasuredRun, "hold", noting("run", MeasuredRun.hold))
    monkeypatch.setattr(Measurement, "values", noting("measured", Measurement.values))
    case = load_case("gallery/belt-oscillator", {"run.t_end": "12 s"})
    spreads = STARTS["gallery/belt-oscillator"]
    plan = make_plan(case, [], ensemble=(read_members(case, 3, 0, spreads),), section=5)
    piece = BatchPiece(tuple(((member, 0), plan.changes((member, 0))) for member in range(3)))
    assert all(point.done for point in compute_batch(plan.point_settings, (piece,)))
    assert noted == order
    asked = iter([True, True, False])  # after each run
    assert len(compute_batch(plan.point_settings, (piece,), lambda: next(asked))) == 2


def test_a_run_is_begun_anew_where_the_start_alone_differs(monkeypatch):
    opened = []

    def noted(scene, **wishes):
        opened.append(scene)
        return open_trajectory(scene, **wishes)

    monkeypatch.setattr(statistics, "open_trajectory", noted)
    case = load_case("gallery/belt-oscillator", {"run.t_end": "4 s"})
    scenes = [case.with_start({"initial.block.x": x}).scene() for x in ("0.1 m", "0.2 m")]
    others = [case.with_values({"belt.mu_s": "1.1"}).scene(), case.scene().but(t_end=5.0)]
    for scene in (*scenes, others[0], *scenes, others[1], *scenes):
        list(MeasuredRun(scene, quantities_of(case), 2.0).blocks())
    assert opened == [scenes[0], others[0], scenes[0], others[1], scenes[0]]


def test_a_held_run_leaves_nothing_to_the_next():
    case = load_case("gallery/belt-oscillator", {"run.t_end": "12 s"})
    scenes = [case.with_start({"initial.block.x": x}).scene() for x in ("0.1 m", "0.2 m")]

    def ends(scene, held):
        run = MeasuredRun(scene, quantities_of(case), 2.0)
        assert not held or run.hold()
        return lambda: [block.events["t"].tobytes() for block in run.blocks()]

    first, second = ends(scenes[0], True), ends(scenes[1], False)
    assert [second(), first()] == [alone(ends(scene, False)) for scene in reversed(scenes)]


def since(begin, blocks, table, clock):
    """Bits of a table from a time on, by column."""
    parts = [getattr(block, table) for block in blocks]
    late = [part[clock] >= begin for part in parts]
    return {
        name: np.concatenate([part[name][rows] for part, rows in zip(parts, late, strict=True)]).tobytes()
        for name in parts[0]
    }


@pytest.mark.parametrize("name", ["II-B", "gallery/belt-oscillator", "gallery/chattering-oscillator"])
def test_a_run_recorded_from_a_time_is_the_whole_run_from_there(name):
    case = load_case(name, {"run.t_end": "12 s"})
    scene, begin = sampled_for_statistics(case.scene()), 6.1
    whole = list(open_trajectory(scene, section=True).blocks())
    run = MeasuredRun(scene, quantities_of(case), begin)
    shown = list(run.blocks())
    for table, clock in (("samples", "time"), ("events", "t"), ("section", "time")):
        of_whole, of_late = (since(begin, blocks, table, clock) for blocks in (whole, shown))
        assert of_whole == of_late
    first = {name: column[0] for name, column in shown[0].events.items()}
    assert first["t"] <= begin and first["kind"] == 0 and run.rows[-1]["t"] == first["t"]
    again = open_trajectory(scene, resume=run.rows).state_at([begin])
    for column, values in run.ends().items():
        assert values[0] == again[column][0]
