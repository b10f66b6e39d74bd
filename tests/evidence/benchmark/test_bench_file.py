"""A bench on file: everything comes back, foreign readers open it, and rows are kept as they come."""

import json
import warnings

import numpy as np
import pytest

from tests.evidence.benchmark.made import METHODS, plan, truth
from vibsim.evidence.benchmark import open_bench, run_bench
from vibsim.evidence.benchmark.bench_result import ROW, BenchRow
from vibsim.evidence.benchmark.plan import BenchError
from vibsim.evidence.benchmark.running import truth_at_hand, truth_from
from vibsim.results import ResultFileError, kind_of, simulate
from vibsim.results.simulation import open_result


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
    with pytest.raises(
        BenchError, match=r"it differs in coupling\.c \(0\.001 N s/m there, 0\.01 N s/m here\)"
    ):
        truth_from(other, made[1])
    assert truth_at_hand(other, made[1]) is None and truth_at_hand(plan(), tmp_path / "no.h5") is None


def test_a_trajectory_is_no_bench(tmp_path):
    path = simulate(plan().case, trust=False).save(tmp_path / "run.h5")
    with pytest.raises(ResultFileError, match="holds a trajectory, not a bench"):
        open_bench(path)
    assert truth_at_hand(plan(), path) is None
