"""A fit on file: the same again, readable by others, resumed after any end, refused where it is another."""

import errno
import os
import shutil
import subprocess
import sys
import time

import h5py
import numpy as np
import pytest
import xarray

import vibsim
from tests.command_line.made import call
from tests.fitting.made import done, numbers_of, small_plan
from vibsim.fitting.fit_result import FitStore, run_fit
from vibsim.results import ResultFileError
from vibsim.results.simulation import open_result
from vibsim.results.store import journal_path


@pytest.fixture(scope="module")
def stored(tmp_path_factory):
    """A fit and its file, which is only read."""
    path = tmp_path_factory.mktemp("fit") / "fit.h5"
    return done(small_plan(), path), path


def test_a_fit_comes_back_as_it_was(stored):
    found, path = stored
    again = open_result(path)
    assert numbers_of(again) == numbers_of(found)
    assert again.plan.fingerprint == found.plan.fingerprint
    assert again.best == found.best
    assert [path.name for path in path.parent.iterdir()] == ["fit.h5"]


def test_a_fit_is_a_table_of_its_candidates(stored, tmp_path):
    fit, path = stored
    frame = open_result(path).to_dataframe()
    assert list(frame.index) == [one.number for one in fit.candidates]
    best = frame[frame["rank"] == 1]
    assert list(best.index) == [fit.best.candidate.number] and best["price"].iloc[0] == fit.best.price
    shares = fit.to_dataframe("statement")["share"]
    assert list(shares.loc[fit.best.candidate.number]) == [one.share for one in fit.best.results]
    with xarray.open_dataset(path, engine="h5netcdf") as data:
        assert set(fit.to_xarray().variables) == set(data.load().variables)
    heading, *lines = repr(fit).splitlines()
    assert heading.startswith("<FitResult ") and len(lines) == len(fit.statements) + 2
    assert call("export", str(path), "-o", str(tmp_path / "a.csv"), "-q").exit_code == 0
    assert len((tmp_path / "a.csv").read_text().splitlines()) == 1 + len(fit.candidates)


def test_a_fit_in_memory_can_be_saved(tmp_path):
    found = done(small_plan())
    assert numbers_of(open_result(found.save(tmp_path / "fit.h5"))) == numbers_of(found)
    with pytest.raises(ResultFileError, match="exists"):
        found.save(tmp_path / "fit.h5")


def test_the_file_tells_others_what_was_found(stored):
    found, path = stored
    with h5py.File(path) as file:
        assert file.attrs["vibsim_kind"] == "fit"
        ranks = file["rank"][...]
        best = int(np.flatnonzero(ranks == 1)[0])
        assert best == found.best.candidate.number
        assert file["price"][best] == found.best.price
        assert file["share"][best].tolist() == [each.share for each in found.best.results]
        assert file["statement_text"].asstr()[0] == "passes 3 Hz between 4 and 6 s"
        assert [dim[0].name for dim in file["value"].dims] == ["/candidate", "/statement", "/start"]
        values = file["value"][best, 0]
        assert np.array_equal(values, found.values(found.statements[0], found.best.candidate), equal_nan=True)
        assert np.isnan(file["value_J"][0])  # the printed values change nothing


def interrupted(plan, path, runs):
    """A fit that was stopped after so many looks."""
    looks = iter(range(runs))
    return run_fit(plan, path, 2, watch=lambda *_: next(looks, None) is not None)


@pytest.mark.parametrize("method", ["quasi-random", "evolution"])
def test_an_interrupted_fit_goes_on_to_the_same_bits(stored, tmp_path, method):
    plan, path = small_plan(method=method), tmp_path / "fit.h5"
    left, complete = interrupted(plan, path, 20)
    assert not complete and left.attrs["complete"] == 0
    half = open_result(path)
    assert 0 < len(half.runs) == len(left.runs)
    finished = done(plan, path)
    assert len(half.runs) < len(finished.runs)
    whole = stored[0] if method == "quasi-random" else done(plan)
    assert numbers_of(finished) == numbers_of(whole) == numbers_of(open_result(path))


def test_a_finished_fit_computes_nothing_again(stored, tmp_path):
    plan, path = small_plan(), shutil.copy(stored[1], tmp_path / "fit.h5")
    before = path.stat().st_mtime_ns, path.read_bytes()
    steps = []
    run_fit(plan, path, 1, watch=lambda step, ready, total: steps.append(ready == total) or True)
    assert all(steps)
    assert (path.stat().st_mtime_ns, path.read_bytes()) == before


def test_a_fit_that_cannot_be_written_goes_on_from_its_journal(tmp_path, monkeypatch):
    def full(*_):
        raise OSError(errno.ENOSPC, "full")

    plan, path = small_plan(), tmp_path / "fit.h5"
    with monkeypatch.context() as patched, pytest.raises(ResultFileError) as caught:
        patched.setattr(os, "fsync", full)
        done(plan, path)
    kept = "what was computed is kept in fit.h5.journal, and the same command resumes it"
    assert str(caught.value) == f"{path}: cannot write: disk full; {kept}"
    steps = []
    run_fit(plan, path, 1, watch=lambda step, ready, total: steps.append(ready == total) or True)
    assert all(steps) and open_result(path).attrs["complete"] == 1


def start(path, *more):
    """The command as a process of its own."""
    command = [
        sys.executable, "-m", "vibsim", "-q", "fit", "II-B", "--free", "J=0.2:5g.m^2", "--want",
        "mean speed at least 2 Hz",
        "--candidates", "24", "--ensemble", "2", "--t-end", "8s", "-j", "2", "-o", str(path), *more,
    ]  # fmt: skip
    return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def test_what_was_run_survives_kill_9(tmp_path):
    """Killed twice: nothing is lost, and the end is that of a fit that was never killed."""
    path, size = tmp_path / "fit.h5", 0
    for more in (300, 3000):
        process, journal, deadline = start(path), journal_path(path), time.monotonic() + 60
        while process.poll() is None and time.monotonic() < deadline:
            if journal.exists() and journal.stat().st_size > size + more:
                break
            time.sleep(0.001)
        process.kill()
        process.wait()
        if not journal.exists():
            break  # done before it could be killed
        assert journal.stat().st_size >= size
        size = journal.stat().st_size
    with open(journal_path(path), "ab") as file:
        file.write(b'{"index": [9, 0, 0], "sta')  # as if cut off in the middle of a line
    assert start(path).wait() == 0
    assert start(tmp_path / "whole.h5").wait() == 0
    assert numbers_of(open_result(path)) == numbers_of(open_result(tmp_path / "whole.h5"))
    assert sorted(each.name for each in tmp_path.iterdir()) == ["fit.h5", "whole.h5"]


def test_another_fit_is_refused(stored, tmp_path):
    path = shutil.copy(stored[1], tmp_path / "fit.h5")
    before = path.read_bytes()
    with pytest.raises(ResultFileError, match="holds another fit, of other starts and search settings; kept"):
        run_fit(small_plan(seed=1), path)
    assert path.read_bytes() == before and not journal_path(path).exists()
    done(small_plan(seed=1), path, force=True)
    assert open_result(path).plan.search.seed == 1


def test_a_second_process_is_refused(tmp_path):
    path = tmp_path / "fit.h5"
    store = FitStore(small_plan(), path)
    with pytest.raises(ResultFileError, match="another command is writing it"):
        FitStore(small_plan(), path)
    store._journal.close(remove=True)


def test_a_trajectory_is_not_overwritten(tmp_path):
    path = vibsim.simulate(vibsim.load_case("II-A", {"run.t_end": "1 s"})).save(tmp_path / "run.h5")
    before = path.read_bytes()
    with pytest.raises(ResultFileError, match="holds a trajectory, not a fit"):
        run_fit(small_plan(), path)
    assert path.read_bytes() == before
    assert [each.name for each in tmp_path.iterdir()] == ["run.h5"]


def test_a_fit_that_was_stopped_before_its_first_run_is_on_file(tmp_path):
    left, complete = run_fit(small_plan(), tmp_path / "fit.h5", 1, watch=lambda *_: False)
    stored = open_result(tmp_path / "fit.h5")
    assert not complete and stored.attrs["complete"] == 0
    assert len(stored.runs) == len(left.runs)  # 0 as a rule
