"""How points are cut into batches: none twice, none left out, few in flight, short ones at the end."""

import os
import subprocess
import sys
import threading
from concurrent.futures import Future
from dataclasses import replace
from itertools import pairwise, zip_longest

import numpy as np
import pytest

import vibsim
from tests.sweeps.made import OMEGA0, assert_same_points, complete, in_memory, short_case, short_plan, swept
from vibsim.cases import load_case
from vibsim.cases.case import load_case_text
from vibsim.engine import _engine, c_engine
from vibsim.engine.errors import EngineError, State
from vibsim.engine.trajectory import advance_together, open_trajectory
from vibsim.results.simulation import open_result
from vibsim.sweeps import points, statistics
from vibsim.sweeps.axes import read_members
from vibsim.sweeps.points import BatchPiece, Measurement, SweepPoint, compute_batch, compute_point
from vibsim.sweeps.quantities import DONE, FAILED, NOT_REPRODUCIBLE, quantities_of
from vibsim.sweeps.statistics import MeasuredRun, sampled_for_statistics
from vibsim.sweeps.sweep_file import SweepStore
from vibsim.sweeps.sweeping import make_plan
from vibsim.sweeps.workers import ROUNDS, Backlog, Chain, run

CARRIED = {"carry_state": True, "direction": "both"}


class ImmediateWorkers:
    """Workers that say a point took `seconds`; they note the batches and how many are in flight."""

    batch_seconds = 1.0

    def __init__(self, plan, seconds, count=2):
        self.point_settings, self.seconds, self.count = plan.point_settings, seconds, count
        self.lengths, self.most_in_flight, self.waiting = [], 0, []

    def submit(self, pieces):
        self.lengths.append(sum(map(len, pieces)))
        future = Future()
        self.waiting.append((future, pieces))
        self.most_in_flight = max(self.most_in_flight, len(self.waiting))
        return future

    def result(self, future):
        return future.result()

    def compute_one(self):
        future, pieces = self.waiting.pop()  # the last first: the order of completion must not matter
        points = [invented(index, self.seconds) for piece in pieces for index, _ in piece.points]
        future.set_result(points)


def invented(index, seconds):
    """A point that was not computed; its end is the start of the next."""
    end = {f"end_{name}": float(sum(index)) for name in ("x1", "v1", "x2", "v2", "phi", "phidot")}
    return SweepPoint(index, DONE, "f" * 64, "", {"wall_time": seconds, **end})


def run_through(plan, workers):
    """Run a plan on such workers; the indices in the order in which they came back."""
    store, came = SweepStore(plan), []
    add = store.add
    store.add = lambda points: (came.extend(point.index for point in points), add(points))
    assert run(store, workers, lambda table: (workers.waiting and workers.compute_one()) or True)
    return came


@pytest.mark.parametrize("settings", [{}, CARRIED], ids=["fresh", "carried"])
@pytest.mark.parametrize("seconds", [1e-3, 0.05, 3.0])
def test_every_point_comes_once(settings, seconds):
    plan = short_plan({OMEGA0: "3:5:0.1 Hz", "c": "0:0.1/5"}, **settings)
    workers = ImmediateWorkers(plan, seconds)
    came = run_through(plan, workers)
    assert sorted(came) == sorted(index for chain in plan.chains() for index in chain)
    assert workers.most_in_flight <= 2 * workers.count
    for chain in plan.chains():
        assert [index for index in came if index in chain] == chain  # in the order of the chain


def test_a_batch_takes_its_time_and_the_last_are_short():
    plan = short_plan({"c": "0:0.2:0.0001"}, short_case("I-B"))  # 2001 points of 50 ms: 20 fill a second
    workers = ImmediateWorkers(plan, 0.05)
    run_through(plan, workers)
    assert max(workers.lengths) == 20
    assert workers.lengths[-1] == 1
    # as many as fill a second each; before the pace is known and towards the end, fewer
    assert len(workers.lengths) <= 2001 / 20 + 2 * workers.count + 6 * ROUNDS * workers.count


def batch_lengths(plan, paces):
    """Points of the batches of a second that one worker is handed, whose points take so long [s]."""
    backlog = Backlog(plan, SweepStore(plan).table, seconds=1.0)
    for seconds in paces:
        handed = backlog.batch(1)
        points = [invented(index, seconds) for _, piece in handed for index, _ in piece.points]
        yield len(points)
        backlog.take(handed, points)


def test_the_pace_follows_the_points():
    plan = short_plan({"c": "0:0.2:0.0001"}, short_case("I-B"))
    lengths = list(batch_lengths(plan, (0.1, 0.1, 0.1, 0.5, 0.5, 0.5, 0.5, 0.5)))
    assert lengths[:3] == [1, 10, 10] and lengths[-1] == 2


@pytest.mark.skipif(not _engine.LANES, reason="needs a processor with lanes")
def test_runs_that_share_lanes_come_in_batches_that_fill_them():
    plan = short_plan({OMEGA0: "3:5:0.001 Hz"})
    assert list(batch_lengths(plan, (0.05, 0.3, 0.55, 2.0, 2.0))) == [1, 20, 16, 16, 6]
    few = short_plan({OMEGA0: "3:5:0.2 Hz"})  # 11 points: the last ones are shared out
    assert list(batch_lengths(few, (0.05, 0.05))) == [1, 10]


def test_a_carried_batch_is_the_points_one_by_one():
    plan = short_plan(case=short_case(t_end="2 s"), carry_state=True)
    indices = next(plan.chains())
    one_by_one = SweepStore(plan)
    backlog = Backlog(plan, one_by_one.table, seconds=0.0)
    while handed := backlog.batch(1):
        (_, piece), *_ = handed
        assert len(piece) == 1
        points = compute_batch(plan.point_settings, (piece,))
        one_by_one.add(points)
        backlog.take(handed, points)
    together = SweepStore(plan)
    piece = Chain(plan, together.table, indices).piece(len(indices))
    assert len(piece) == len(indices)
    together.add(compute_batch(plan.point_settings, (piece,)))
    assert_same_points(together.table, one_by_one.table)


def test_a_failed_point_is_retried_alone_when_those_behind_it_hold():
    """Behind a failed point a chain begins where that one began: if it fails again, all behind it count."""
    plan = short_plan(case=short_case(t_end="2 s"), carry_state=True)
    store, indices = SweepStore(plan), next(plan.chains())
    for index in indices:
        piece = Chain(plan, store.table, indices).piece(1)
        (point,) = compute_batch(plan.point_settings, (piece,))
        failing = replace(point, status=FAILED, error="so it is", values={}, arrays={})
        store.add([failing if index == (1, 0) else point])
        if index == (1, 0):
            break
    retried = Chain(plan, store.table, indices)
    assert [index for index, _ in retried.piece(10).points] == indices[1:]
    retried.take([store.table.point((1, 0))])  # it failed again
    rest = retried.piece(10)
    store.add(compute_batch(plan.point_settings, (rest,)))
    again = Chain(plan, store.table, indices)
    assert [index for index, _ in again.piece(10).points] == [(1, 0)]
    again.take([store.table.point((1, 0))])
    assert again.piece(10) is None


# A point does not depend on when, where and beside which others it is computed.


SETTINGS = {"fresh": {}, "up and down": CARRIED, "down": {**CARRIED, "direction": "down"}}


@pytest.mark.parametrize("settings", SETTINGS.values(), ids=SETTINGS)
@pytest.mark.parametrize("case", ["II-B", "I-B"])
def test_any_number_of_jobs_gives_the_same_bits(settings, case):
    axis = {OMEGA0 if case == "II-B" else "omega": "3:5:0.5 Hz", "c": "0.001, 0.03"}
    plan = short_plan(axis, short_case(case), **settings)
    one = swept(plan, jobs=1).table
    assert one.count(DONE) == plan.count == 5 * 2 * len(plan.directions)
    for jobs in (2, 5):
        assert_same_points(swept(plan, jobs=jobs).table, one)


def test_a_carried_point_begins_where_the_one_before_ended():
    result = swept(short_plan({OMEGA0: "3, 4 Hz"}, **CARRIED))
    order = [(0, 0), (1, 0), (1, 1), (0, 1)]  # up, then back down
    assert result.case_at(order[0]).number("initial.x1") == 0.0
    for before, after in pairwise(order):
        case = result.case_at(after)
        for name in ("x1", "v1", "x2", "v2", "phi", "phidot"):
            assert case.number(f"initial.{name}") == result[f"end_{name}"][before]
        assert case.sha256 == result["sha256"][after]


def test_a_carried_harmonic_force_has_no_jump():
    """4 s at 3.3 Hz end in a period; the state carried on is that at its last whole one, 13/3.3 s."""
    result = swept(short_plan({"omega": "3.3, 3.4 Hz"}, short_case("I-B"), carry_state=True))
    state = vibsim.simulate(result.case_at((0, 0))).at(13 / 3.3)
    for name in ("x1", "v1", "x2", "v2"):
        # an instant is rounded to 1e-16 of 4 s, and the state changes at up to 100 units per second
        assert result[f"end_{name}"][0, 0] == pytest.approx(float(state[name]), rel=1e-9, abs=1e-13)


def test_fresh_points_do_not_depend_on_the_direction():
    result = swept(short_plan(direction="both"))
    for name in ("mean_speed", "amplitude_x1", "end_x2"):
        assert (result[name][:, 0] == result[name][:, 1]).all()


# Points that fail: kept with their reason, tried again, and no harm to the others.


def test_a_failed_point_is_kept_with_its_reason_and_tried_again(tmp_path, monkeypatch):
    def failing(run):
        if abs(run.scene.motor.Omega0 / 2 / np.pi - 4) < 1e-9:
            raise EngineError("diverged", State(1.5, [1.5], [1.5], 1.5, 1.5, 1.5))
        return opened(run)

    opened = MeasuredRun._trajectory
    plan, path = short_plan({OMEGA0: "3, 4, 5 Hz"}, carry_state=True), tmp_path / "sweep.h5"
    monkeypatch.setattr(MeasuredRun, "_trajectory", failing)
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
    result = swept(short_plan({"t_end": "1, 100 s", "every": "1e-9, 1 s"}, short_case(run__every="1 s")))
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
    result = swept(short_plan({OMEGA0: "3, 4, 5 Hz"}))
    assert result["status"].ravel().tolist() == [DONE, FAILED, DONE]
    said = "a bug in vibsim, please report it: ZeroDivisionError: by nothing (test_"
    assert result["error"][1, 0].startswith(said)


def test_a_motion_too_fast_to_take_statistics_of_fails_alone():
    """10^300 turns a second over 2 s are no 10^10 samples; nor are 2 s in steps of 10^-30 s."""
    result = swept(short_plan({OMEGA0: "1e300, 4 Hz"}))
    assert result["status"].ravel().tolist() == [FAILED, DONE]
    assert "more than 1e10 samples" in result["error"][0, 0]
    result = swept(short_plan({OMEGA0: "4 Hz"}, every="1e-30 s"))
    assert "are more than 1e10 in this run" in result["error"][0, 0]


# A disk that fills up during a sweep: a clear message, and no point that was computed is lost.


SWEEP = """
import os, resource, sys
from vibsim.command_line.main import main
limit, section = int(sys.argv[1]), sys.argv[2]
resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))  # no file grows beyond that
sys.argv[1:] = "sweep II-B --omega0 3:5:0.1 --t-end 2s -j 2 -o s.h5 --section".split() + [section]
main()
"""
AXES = {"excitation.Omega0": "3:5:0.1 Hz"}


def size_without_points(plan, path):
    with SweepStore(plan, path):
        size = os.path.getsize(path)
    path.unlink()
    return size


@pytest.mark.skipif(sys.platform == "win32", reason="needs limits of a process")
@pytest.mark.parametrize(
    ("section", "further", "left"),
    [
        (100, 500, ["s.h5", "s.h5.journal"]),  # room for the journal, none for the file that takes it up
        (1500, 600_000, ["s.h5"]),  # room for the file, none for the journal of all points
    ],
)
def test_nothing_computed_is_lost(tmp_path, section, further, left):
    plan, path = short_plan(AXES, short_case(t_end="2 s"), section=section), tmp_path / "s.h5"
    limit = size_without_points(plan, path) + further
    command = [sys.executable, "-c", SWEEP, str(limit), str(section)]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 6
    assert "disk full; " in done.stderr and "and the same command resumes it" in done.stderr
    assert done.stderr.count("\n") == 1
    assert sorted(os.listdir(tmp_path)) == left
    open_result(path)
    store = SweepStore(plan, path)
    kept = store.table.count(DONE)
    store._journal.close(remove=False)
    assert kept > 0
    result, computed = complete(plan, path)
    assert len(computed) == plan.count - kept
    assert_same_points(result.table, in_memory(plan))
    assert os.listdir(tmp_path) == ["s.h5"]


# Points that begin a kept run anew have the bits of points that are run alone.


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


NUMBERS = [  # case, key, values; of the last some make other modes
    ("II-B", "Omega0", "4:7:1 Hz"),
    ("II-B", "G", "1, 2, 3, 4 mm"),  # from which the smallest gaps are
    ("I-A-eq211", "omega", "3:6:1 Hz"),
    ("I-B", "mu", "1e-3, 0.1, 2e-3, 3e-3"),  # from the second on it sticks at first
    ("gallery/chattering-oscillator", "wall.e", "0.6:0.75:0.05"),
    ("gallery/belt-oscillator", "spring.k", "1:1.3:0.1 N/m"),
    ("gallery/belt-oscillator", "belt.belt", "1.2:1.8:0.2 m/s"),  # the block begins with 1.5 m/s
    ("gallery/energy-harvester", "run.t_end", "2:8:2 s"),
    ("I-B", "mu", "1e-3, 0, 2e-3, 0.1"),
    ("two-forces", "g.omega", "2, 2.1234567891234, 3, 4 Hz"),  # the second has no common period
    ("two-forces", "g.omega", "2.1234567891234, 2, 3, 4.1234567891234 Hz"),
]

TWO_FORCES = """
name: two-forces
title: A body under two forces
bodies: {a: 1 kg}
links: {spring: {between: [a, ground], k: 40 N/m, c: 0.5 N s/m}}
forces:
  f: {on: a, A: 1 N, omega: 1 Hz}
  g: {on: a, A: 1 N, omega: 2 Hz}
run: {t_end: 12 s, every: 10 ms}
"""


@pytest.mark.parametrize("name", STARTS)
def test_points_do_not_depend_on_starts_before(name):
    case = load_case(name, {"run.t_end": "12 s"})
    check_apart(make_plan(case, [], ensemble=(read_members(case, 4, 0, STARTS[name]),), section=5))


@pytest.mark.parametrize(("name", "key", "values"), NUMBERS)
def test_points_do_not_depend_on_numbers_before(name, key, values):
    changes = {"run.t_end": "12 s"} | ({"x1": "0.2 mm"} if name == "I-B" else {})
    case = load_case_text(TWO_FORCES) if name == "two-forces" else load_case(name, changes)
    check_apart(make_plan(case, [(key, values)], section=5, compute="all"))


def test_modes_of_another_form_are_told_to_a_new_run(monkeypatch):
    def refused(*_):
        raise ValueError("the packed numbers are none of that mode")

    monkeypatch.setattr(c_engine.CRun, "retune", refused)
    check_apart(make_plan(load_case("II-B", {"run.t_end": "3 s"}), [("Omega0", "4:7:1 Hz")], section=5))


def check_apart(plan):
    """Four points, computed one after another, have the bits of each alone."""
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

    case = load_case("gallery/belt-oscillator", {"run.t_end": "12 s"})
    spreads = STARTS["gallery/belt-oscillator"]
    plan = make_plan(case, [], ensemble=(read_members(case, 3, 0, spreads),), section=5)
    piece = BatchPiece(tuple(((member, 0), plan.changes((member, 0))) for member in range(3)))
    compute_batch(plan.point_settings, (piece,))  # behind which C knows what follows each event
    monkeypatch.setattr(c_engine, "FEW", few)
    monkeypatch.setattr(MeasuredRun, "hold", noting("run", MeasuredRun.hold))
    monkeypatch.setattr(Measurement, "steps", noting("measured", Measurement.steps))
    assert all(point.done for point in compute_batch(plan.point_settings, (piece,)))
    assert noted == order
    asked = iter([True, True, False])  # after each run
    assert len(compute_batch(plan.point_settings, (piece,), lambda: next(asked))) == 2


MANY = ("capture", "certificate", "power", "impact-velocity", "attractor")


@pytest.mark.parametrize("compute", [(), MANY, ("attractor",)])
def test_points_whose_runs_share_lanes_are_those_of_each_alone(monkeypatch, compute):
    plan = short_plan({OMEGA0: "3:5:0.1 Hz"}, short_case(t_end="12 s"), section=5, compute=compute)
    piece = BatchPiece(tuple(((i, 0), plan.changes((i, 0))) for i in range(19)))
    beside = []

    def noted(runs):
        beside.append(len(runs))
        advance_together(runs)

    monkeypatch.setattr(points, "advance_together", noted)
    together = compute_batch(plan.point_settings, (piece,))
    assert max(beside, default=0) >= 8 or not _engine.LANES
    assert [point.index for point in together] == [index for index, _ in piece.points]
    for point, (index, changes) in zip(together, piece.points, strict=True):
        other = compute_point(plan.point_settings, index, changes, None)
        assert (point.status, point.sha256, point.error) == (other.status, other.sha256, other.error)
        assert repr(reproducible(point.values)) == repr(reproducible(other.values))
        assert {name: array.tobytes() for name, array in point.arrays.items()} == {
            name: array.tobytes() for name, array in other.arrays.items()
        }


def reproducible(values):
    """Values of a point without those that are another each time."""
    return {name: value for name, value in values.items() if name not in NOT_REPRODUCIBLE}


@pytest.mark.skipif(not _engine.LANES, reason="needs a processor with lanes")
def test_points_that_are_done_beside_others_that_are_given_up_are_kept(monkeypatch):
    calls = []

    def short_ones_first(runs):
        calls.append(len(runs))
        for one in runs:
            if len(calls) > 1 or one.scene.t_end < 2:
                one.run.advanced = one.run.run.advance()

    monkeypatch.setattr(points, "advance_together", short_ones_first)
    plan = short_plan({OMEGA0: "3:5:0.5 Hz"}, short_case(t_end="60 s"))
    ends = ("60 s", "1 s", "60 s", "1 s", "60 s")
    changes = [{**plan.changes((i, 0)), "run.t_end": end} for i, end in enumerate(ends)]
    piece = BatchPiece(tuple(((i, 0), change) for i, change in enumerate(changes)))
    done = compute_batch(plan.point_settings, (piece,), lambda: len(calls) < 2)
    assert calls == [5, 3] and [point.index for point in done] == [(1, 0), (3, 0)]


def test_a_run_is_begun_anew_where_numbers_alone_differ(monkeypatch):
    opened = []

    def noted(scene, **wishes):
        opened.append(scene)
        return open_trajectory(scene, **wishes)

    monkeypatch.setattr(statistics, "open_trajectory", noted)
    case = load_case("gallery/belt-oscillator", {"run.t_end": "4 s"})
    scenes = [case.with_values({"initial.block.x": x}).scene() for x in ("0.1 m", "0.2 m")]
    others = [case.with_values(one).scene() for one in ({"spring.k": "1.1 N/m"}, {"run.t_end": "5 s"})]
    undamped = case.with_values({"spring.c": "0 N s/m"}).scene()  # whose rows have another form

    def run_all():
        for together in ([scenes[0]], [scenes[1]], *zip(others), [undamped], scenes, scenes):
            runs = [MeasuredRun(scene, quantities_of(case), 2.0).blocks() for scene in together]
            list(zip_longest(*runs))  # by turns

    alone(run_all)
    assert opened == [scenes[0], undamped, *scenes]


def test_a_held_run_leaves_nothing_to_the_next():
    case = load_case("gallery/belt-oscillator", {"run.t_end": "12 s"})
    scenes = [case.with_values({"initial.block.x": x}).scene() for x in ("0.1 m", "0.2 m")]

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
