"""Plans of benchmarks, and verdicts on their rows."""

import json
import math
import warnings

import numpy as np
import pytest

from tests.evidence.benchmark.made import METHODS, plan, planted, truth
from vibsim.cases import CaseError, load_case
from vibsim.evidence.benchmark import open_bench, run_bench
from vibsim.evidence.benchmark.bench_result import (
    DONE,
    FAILED,
    ROW,
    SLOWER,
    BenchResult,
    BenchRow,
    beside_reference,
    error_at,
    facts,
    faster,
    fastest,
    impacts_per_second,
    most_accurate,
    reference,
)
from vibsim.evidence.benchmark.plan import FAMILIES, BenchError, family_of, make_plan
from vibsim.evidence.benchmark.running import truth_at_hand, truth_from
from vibsim.results import ResultFileError, kind_of, simulate
from vibsim.results.simulation import open_result


@pytest.mark.parametrize(
    ("t_end", "samples", "last"), [(None, 2001, 100.0), ("2 s", 401, 2.0), ("30 s", 2001, 30.0)]
)
def test_about_2000_instants_of_the_case(t_end, samples, last):
    times = plan(t_end=t_end).times
    assert len(times) == samples and times[-1] == last
    whole = load_case("II-B").two_blocks()
    assert set(times.tolist()) <= {whole.sample_time(i) for i in range(whole.sample_count)}


def test_errors_are_told_at_four_instants():
    assert plan(t_end="100 s").check_times == [10.0, 20.0, 50.0, 100.0]


def test_a_short_case_is_run_to_its_own_end():
    assert make_plan(load_case("II-B", {"run.t_end": "7 s"})).times[-1] == 7.0


def test_methods_are_taken_in_the_order_of_the_table():
    names = [family.name for family in plan(methods=["rk4", "taylor"]).families]
    assert names == ["taylor", "rk4"]
    assert len(plan(methods=()).families) == len(FAMILIES)


def test_an_unknown_method_gets_a_hint():
    with pytest.raises(BenchError, match=r"unknown method 'DOP_853': did you mean dop853\? The methods are "):
        plan(methods=["DOP_853"])


def test_a_span_of_a_few_samples_is_refused():
    with pytest.raises(BenchError, match=r"0\.02 s is too short: a bench needs 10 samples, one every 5 ms"):
        plan(t_end="0.02 s")
    with pytest.raises(CaseError):
        plan(t_end="-1 s")


def test_the_fingerprint_knows_what_the_truth_depends_on():
    print_of = plan().fingerprint
    assert plan(methods=()).fingerprint == print_of == plan(limit=1.0).fingerprint
    assert plan(run__method="taylor", run__order=12, run__tol="1e-9").fingerprint == print_of
    assert plan(coupling__c="0.01").fingerprint != print_of
    assert plan(t_end="3 s").fingerprint != print_of


def methods(name, t_end="2 s"):
    return {family.name for family, _ in plan(name, t_end, methods=()).rows()}


def test_the_closed_form_needs_an_ideal_source():
    assert "closed-form" in methods("I-A") and "closed-form" not in methods("II-B")


def test_methods_without_events_cannot_take_rigid_stops():
    chain, ball = (methods(f"gallery/{name}", "1 s") for name in ("chain-with-gaps", "bouncing-ball"))
    assert chain - ball == {"rk45", "tanh", "rk4"}
    refusal = family_of("rk4").refusal(load_case("hard/zeno-ball").scene())
    assert "rigid stops, which need located events" in refusal


def test_a_clearance_and_a_rest_distance_stop_no_run():
    clearance = plan("gallery/chain-with-gaps", "1 s", run__on_violation="stop")
    rest = plan(rest_distance__value="1 mm", rest_distance__on_violation="stop")
    assert not clearance.case.scene().stop_on_violation and not rest.case.scene().stop_on_violation


def test_what_is_not_installed_is_left_out(monkeypatch):
    monkeypatch.setattr("vibsim.evidence.benchmark.plan.find_spec", lambda name: None)
    found = plan(methods=())
    assert [family.name for family in found.absent()] == ["heyoka"]
    assert "heyoka" not in {family.name for family, _ in found.rows()}
    assert family_of("heyoka").remedy == "not installed: pip install 'vibsim[bench]'"


@pytest.mark.parametrize("family", FAMILIES, ids=lambda family: family.name)
def test_settings_of_a_family_are_told_apart(family):
    names = [setting for setting, _ in family.ladder]
    assert len(set(names)) == len(names)


TIMES = np.array([0.0, 1.0, 2.0])


def row(method, setting, cpu_time, errors, status=DONE, t_reached=2.0):
    return BenchRow(method, setting, status, cpu_time=cpu_time, t_reached=t_reached, error=np.array(errors))


ROWS = [
    row("taylor", "tol 1e-3", 2e-3, [0, 1e-4, 1e-2]),
    row("taylor", "tol 1.1e-16", 4e-3, [0, 1e-13, 1e-2]),
    row("orders", "order 8", 9e-3, [0, 1e-14, 1e-2]),
    row("dop853", "rtol 1e-3", 1.0, [0, 1e-3, 1e-2]),
    row("dop853", "rtol 1e-9", 4.0, [0, 1e-9, 1e-2]),
    row("rk45", "rtol 1e-9", 1e-4, [0, math.nan, math.nan], SLOWER, 0.5),
    BenchRow("rk4", "step 2 ms", FAILED, "why", error=np.full(3, math.nan)),
]
TEXT = load_case("II-B").resolved_json()


def bench(rows=ROWS, events=()):
    attrs = {"check_times_s": [1.0, 2.0], "case_yaml": "", "case_resolved_json": TEXT}
    truth = planted(TIMES, [0, 0, 0], events)
    return BenchResult({**attrs, "methods": "[]", "not_installed": "[]"}, truth, rows)


def test_errors_are_compared_before_chaos_parts_everybody():
    assert bench().telling_time == 1.0
    assert bench([row("rk4", "", 1.0, [0, 1e-3, 1e-2])]).telling_time == 1.0
    assert bench([row("rk4", "", 1.0, [0, 1e-9, 1e-8])]).telling_time == 2.0


def test_impacts_per_second_are_true_ones_until_the_time_reached():
    events = [(0.3, 1), (0.4, 2), (0.6, 9), (1.5, 1)]  # contacts begin, end; an impact
    assert impacts_per_second(bench(events=events), ROWS[0]) == pytest.approx(3 / 2e-3)
    assert impacts_per_second(bench(events=events), ROWS[5]) == pytest.approx(1 / 1e-4)
    assert impacts_per_second(bench(), ROWS[0]) is None and impacts_per_second(bench(), ROWS[6]) is None


def test_who_is_left_out_is_told():
    attrs = {**bench().attrs, "methods": '["closed-form", "taylor"]'}
    left_out = facts(BenchResult(attrs, bench().truth, ROWS))["left_out"]
    assert left_out == {"closed-form": "left out: it needs an ideal source, and the case has a motor"}


def test_the_best():
    assert fastest(bench()) is ROWS[0]
    assert fastest(bench([row("rk4", "", 1e-6, [0, 2e-3, 0]), *ROWS])) is ROWS[0]  # fast, and wrong
    assert most_accurate(bench()) is ROWS[2]
    assert most_accurate(bench(), "dop853") is ROWS[4] and most_accurate(bench(), "rk4") is None


def test_the_reference_is_vibsim_as_it_runs_by_default():
    assert reference(bench()) is ROWS[1]
    assert reference(bench(ROWS[3:])) is None and beside_reference(bench(ROWS[3:])) == []


def test_peers_beside_it():
    (found,) = beside_reference(bench())
    assert found.row is ROWS[4]
    assert found.times == pytest.approx(1000) and found.errors == pytest.approx(1e4)


def test_how_much_faster_at_no_larger_error():
    assert faster(bench(), ROWS[3]) == pytest.approx(500)  # beside the one of error 1e-4
    assert faster(bench(), ROWS[4]) == pytest.approx(1000)
    assert faster(bench(), row("heyoka", "", 1.0, [0, 1e-15, 0])) is None


def test_no_error_is_below_what_doubles_tell():
    assert error_at(bench(), row("rk4", "", 1.0, [0, 0, 0])) == 2.0**-60


def test_facts_are_plain():
    found = facts(bench())
    assert found["telling_time_s"] == 1.0 and found["case"]["name"] == "II-B" and len(found["rows"]) == 7
    assert found["rows"][5]["errors_m"] == [None, None] and found["rows"][5]["status"] == "slower"
    assert found["rows"][6]["problem"] == "why" and found["rows"][6]["cpu_time"] is None
    assert found["rows"][0]["evaluations"] is None


# A bench on file: everything comes back, foreign readers open it, and rows are kept as they come.


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A bench of three methods, in memory and on file."""
    path = tmp_path_factory.mktemp("bench") / "II-B-bench.h5"
    return run_bench(plan(), path, truth()), path


def assert_same_row(got: BenchRow, expected: BenchRow):
    np.testing.assert_array_equal(got.error, expected.error)
    for name in ("method", "setting", "status", "problem", "events", *ROW):
        assert getattr(got, name) == getattr(expected, name), name


def test_what_was_written_comes_back(made):
    bench, path = made
    found = open_bench(path)
    assert kind_of(path) == "bench" and found.complete and len(found.rows) == 15
    for got, expected in zip(found.rows, bench.rows, strict=True):
        assert_same_row(got, expected)
    assert found.truth.fingerprint == truth().fingerprint == plan().fingerprint
    for name, column in truth().samples.items():
        np.testing.assert_array_equal(found.truth.samples[name], column)
    assert found.truth.attrs == bench.truth.attrs
    assert found.case.sha256 == plan().case.sha256 and found.check_times == [0.2, 0.4, 1.0, 2.0]


def test_open_result_knows_it(made):
    found = open_result(made[1])
    assert found["error"].shape == (15, 401) and set(found["method"]) == set(METHODS)
    assert "15 rows, 2 s" in repr(found)
    with pytest.raises(KeyError, match="a bench has time, method"):
        found["x1"]


def test_the_attributes_say_where_it_comes_from(made):
    attrs = open_bench(made[1]).attrs
    assert attrs["vibsim_kind"] == "bench" and attrs["case_name"] == "II-B" and attrs["t_end_s"] == 2.0
    assert json.loads(attrs["methods"]) == list(METHODS)
    assert attrs["processor"] and attrs["scipy_version"] and attrs["cores"] >= 1
    assert "engine" not in attrs and "method" not in attrs


def test_xarray_reads_it(made):
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("h5netcdf")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with xarray.open_dataset(made[1], engine="h5netcdf") as data:
            assert data["error"].dims == ("row", "time") and data["found"].dims == ("row", "kind")
            assert data["wall_time"].attrs["units"] == "s" and not [d for d in data.dims if "phony" in str(d)]
            assert set(data["method"].values) == set(METHODS)
            assert np.isnan(data["evaluations"].values[0])  # vibsim evaluates no right-hand sides
        with xarray.open_dataset(made[1], engine="h5netcdf", group="truth") as data:
            assert data["x1"].dims == ("time",)


@pytest.mark.parametrize("rows", [0, 2])
def test_rows_are_kept_as_they_come(tmp_path, rows):
    path, seen = tmp_path / "b.h5", []

    def watch(what, share):
        if what not in seen:
            seen.append(what)
        return len(seen) <= rows

    bench = run_bench(plan(), path, truth(), watch=watch)
    found = open_bench(path)
    assert not bench.complete and not found.complete
    assert len(found.rows) == rows == len(bench.rows)
    assert len(found.truth.samples["time"]) == 401


def test_the_file_is_whole_after_every_row(tmp_path):
    path, counts = tmp_path / "b.h5", []

    def watch(what, share):
        counts.append(len(open_bench(path).rows))
        return True

    run_bench(plan(methods=["taylor"]), path, truth(), watch=watch)
    assert sorted(set(counts)) == [0, 1, 2, 3, 4] and len(open_bench(path).rows) == 5


def test_an_existing_file_is_not_replaced(made):
    before = made[1].read_bytes()
    with pytest.raises(ResultFileError, match="exists; kept"):
        run_bench(plan(), made[1], truth())
    assert made[1].read_bytes() == before


def test_the_truth_is_taken_over_where_it_fits(made, tmp_path):
    assert truth_from(plan(methods=["rk4"]), made[1]).fingerprint == plan().fingerprint
    other = plan(coupling__c="0.01")
    message = r"it differs in coupling\.c \(0\.001 N s/m there, 0\.01 N s/m here\)"
    with pytest.raises(BenchError, match=message):
        truth_from(other, made[1])
    assert truth_at_hand(other, made[1]) is None and truth_at_hand(plan(), tmp_path / "no.h5") is None


def test_a_trajectory_is_no_bench(tmp_path):
    path = simulate(plan().case, trust=False).save(tmp_path / "run.h5")
    with pytest.raises(ResultFileError, match="holds a trajectory, not a bench"):
        open_bench(path)
    assert truth_at_hand(plan(), path) is None
