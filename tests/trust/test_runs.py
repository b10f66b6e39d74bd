"""The trust horizon in runs, files and commands."""

import gc
import json
from weakref import ref

import h5py
import numpy as np
import pytest

import vibsim
from tests.command_line.made import call
from tests.results.made import short_case
from vibsim.engine.blocks_ahead import Thinning, instants_per_sample, sampled_finer
from vibsim.physics.rates import longest_period
from vibsim.results import recording, simulate, simulate_to_file, trust_horizon
from vibsim.results.parallel_runs import LastSamples, RunPiece
from vibsim.sweeps import sweep


def chaotic():
    return short_case("II-B", "60 s", run__trust_tolerance="1e-12 m")


def test_the_motion_is_the_same_with_and_without():
    case = short_case("II-B", "20 s")
    judged, plain = simulate(case), simulate(case, trust=False)
    assert [name for name in judged if name not in plain] == ["error_estimate"]
    for name in plain:
        assert judged[name].tobytes() == plain[name].tobytes()
    assert plain.trust_horizon is plain.error_estimate is None
    assert not [name for name in plain.attrs if "trust" in name or "error_estimate" in name]


def test_the_file_says_what_the_result_says(tmp_path):
    result = simulate(chaotic())
    written = simulate_to_file(chaotic(), tmp_path / "a.h5")
    read = vibsim.open_result(tmp_path / "a.h5")
    assert 10 < result.trust_horizon < 60
    assert result.trust_horizon == written.trust_horizon == read.trust_horizon
    assert result.error_estimate.tobytes() == read.error_estimate.tobytes()
    with h5py.File(tmp_path / "a.h5") as file:
        assert file["error_estimate"].attrs["units"] == "m"
        assert file["error_estimate"].dims[0][0] == file["time"]
        assert file.attrs["trust_tolerance_m"] == 1e-12
        assert file.attrs["trust_horizon_s"] == result.trust_horizon
        assert "order 25" in file.attrs["trust_method"]
        assert file.attrs["error_estimate_max"] == result.error_estimate.max()


def test_the_tolerance_moves_the_horizon_and_not_the_fingerprint():
    fine, coarse = chaotic(), short_case("II-B", "60 s")
    assert fine.sha256 == coarse.sha256
    assert simulate(coarse).trust_horizon == 60 == simulate(coarse).t_reached


def test_truncation_is_seen():
    """Steps of order 8 and tolerance 1e-7, against the closed form."""
    case = short_case("I-B", "10 s", run__method="taylor", run__order="8", run__tol="1e-7")
    rough, true = simulate(case), simulate(short_case("I-B", "10 s"))
    error = np.maximum(np.abs(rough["x1"] - true["x1"]), np.abs(rough["x2"] - true["x2"]))
    assert error.max() > 1e-11
    ratio = rough.error_estimate[200:].max() / error[200:].max()
    assert 1 <= ratio < 30


def test_sparse_samples_are_judged_as_dense_ones():
    dense, sparse = simulate(chaotic()), simulate(short_case("II-B", "60 s", run__every="1 s"))
    np.testing.assert_array_less(sparse.error_estimate, 2 * dense.error_estimate[::200] + 1e-300)


@pytest.mark.parametrize("every", ["0.3 s", "60 s", "500 s"])
def test_the_horizon_belongs_to_the_run_whatever_its_samples(every):
    """II-B parts from the truth by 1e-6 m at 81.5 s; one sample a minute shows nothing of it."""
    dense, sparse = simulate(short_case("II-B", "119 s")), short_case("II-B", "119 s", run__every=every)
    found = simulate(sparse)
    assert 79 < found.trust_horizon < 81
    assert found.trust_horizon == pytest.approx(dense.trust_horizon, abs=0.05)
    plain = simulate(sparse, trust=False)
    assert all(found[name].tobytes() == plain[name].tobytes() for name in plain)
    assert all(found.events[name].tobytes() == plain.events[name].tobytes() for name in plain.events)


@pytest.mark.parametrize("every", ["5 ms", "0.1 s", "1/3 s", "7 s", "1e9 s", "123456789/1000003 s"])
def test_judged_instants_lie_at_every_sample_and_close_together(every):
    scene = short_case("I-B", "100 s", run__every=every).scene()
    count = instants_per_sample(scene)
    finer = sampled_finer(scene, count)
    assert finer.every_num / finer.every_den <= longest_period(scene) / 8 * (1 + 1e-15)
    assert [finer.sample_time(i * count) for i in range(20)] == [scene.sample_time(i) for i in range(20)]
    assert count == 1 or count < scene.every_num / scene.every_den * 8 / longest_period(scene) + 1


def test_every_so_many_rows_are_picked_across_blocks():
    rows = np.arange(100)
    thinning = Thinning(7)
    parts = np.split(rows, [1, 1, 6, 7, 9, 30, 31, 90])
    picked = [thinning.thinned({"time": part})["time"] for part in parts]
    np.testing.assert_array_equal(np.concatenate(picked), rows[::7])


def test_a_scene_without_block_2():
    case = vibsim.load_case("I-A", {"blocks.m2": "fixed", "friction": "none", "run.t_end": "5 s"})
    result = simulate(case)
    assert result.error_estimate.max() < 1e-12
    assert result.trust_horizon == 5


def test_an_interrupted_run_is_judged_as_far_as_it_went(tmp_path):
    result = simulate_to_file(short_case("I-B", "3000 s"), tmp_path / "a.h5", watch=lambda t: t < 20)
    assert not result.complete
    assert 20 <= result.t_reached < 3000
    assert result.trust_horizon == result.t_reached
    assert len(result.error_estimate) == len(result)


def test_a_run_goes_on_while_a_third_run_is_waited_for(monkeypatch):
    """Whether it waits at once or goes on for four blocks, all comes out the same."""
    case = short_case("II-B", "119 s")
    monkeypatch.setattr(trust_horizon, "HELD", 0)
    waiting = simulate(case)
    monkeypatch.setattr(trust_horizon, "HELD", 4)
    going_on = simulate(case)
    assert waiting.trust_horizon == going_on.trust_horizon < 100
    assert all(waiting[name].tobytes() == going_on[name].tobytes() for name in waiting)


def test_a_run_tells_how_far_it_is_before_its_companion_has_begun(monkeypatch, tmp_path):
    monkeypatch.setattr(trust_horizon.Trust, "t_reached", 0.0)
    told = []
    simulate_to_file(short_case("II-B", "119 s"), tmp_path / "a.h5", watch=lambda t: told.append(t) is None)
    assert told and 0 < told[0] <= told[-1] < 119


def test_a_run_that_is_stopped_before_a_third_run_has_ended_is_not_trusted_beyond(monkeypatch, tmp_path):
    monkeypatch.setattr(LastSamples, "told", lambda *_: None)
    monkeypatch.setattr(trust_horizon, "GRACE", 0.05)
    result = simulate_to_file(short_case("II-B", "300 s"), tmp_path / "a.h5", watch=lambda t: t < 90)
    assert not result.complete and result.t_reached > 80
    assert len(result.error_estimate) == len(result) > 0.99 * result.t_reached / 5e-3
    assert 30 < result.trust_horizon < 70  # the third run is asked at 37 s, where errors have grown 1e4 times


def test_sweeps_do_without(monkeypatch):
    def refuse(*_):
        raise AssertionError("a sweep pays for a second run")

    monkeypatch.setattr("vibsim.results.trust_horizon.Trust.__init__", refuse)
    monkeypatch.setattr("vibsim.results.parallel_runs.Companion.__init__", refuse)
    done = sweep(short_case("II-B", "2 s"), {"excitation.Omega0": "3:4:0.5 Hz"}, jobs=1)
    assert done.complete
    with pytest.raises(AssertionError, match="pays"):
        simulate(short_case("II-B", "2 s"))


def test_run_and_info_print_it(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    settings = ("--t-end", "60s", "-s", "trust_tolerance=1e-12 m")
    found = call("run", "II-B", *settings)
    [line] = [line for line in found.stdout.splitlines() if "trust horizon" in line]
    horizon = vibsim.open_result("II-B.h5").trust_horizon
    assert line.split(maxsplit=2)[2] == f"right to 1e-12 m until {horizon:.4g} s"
    assert line in call("info", "II-B.h5").stdout.splitlines()
    assert json.loads(call("info", "II-B.h5", "--json").stdout)["trust_horizon_s"] == horizon
    found = call("run", "I-A", "--t-end", "5s", "--json")
    assert json.loads(found.stdout)["trust_horizon_s"] == 5
    assert "right to 1e-6 m over the whole run; estimated error up to " in call("info", "I-A.h5").stdout


def test_run_can_do_without(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    found = call("run", "I-A", "--t-end", "5s", "--no-trust")
    assert "trust" not in found.stdout
    assert "error_estimate" not in vibsim.open_result("I-A.h5")


def test_a_run_from_a_file_keeps_its_tolerance(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    call("run", "II-B", "--t-end", "60s", "-s", "trust_tolerance=1e-12 m", "-o", "a.h5")
    call("run", "a.h5", "-o", "b.h5")
    first, again = vibsim.open_result("a.h5"), vibsim.open_result("b.h5")
    assert first.trust_horizon == again.trust_horizon < 60
    assert first.error_estimate.tobytes() == again.error_estimate.tobytes()


@pytest.mark.parametrize("value", ["0 m", "-1 m", "1 s", "none"])
def test_tolerances_that_are_none(value):
    found = call("run", "I-A", "-s", f"trust_tolerance={value}", "--dry-run")
    assert found.exit_code == 3
    assert "run.trust_tolerance" in found.stderr


def test_what_judges_a_run_is_freed_with_it(monkeypatch):
    """Without the garbage collector, which commands seldom call: else every run leaves its blocks behind."""
    judges = []

    class Watched(recording.Trust):
        def __init__(self, *of):
            super().__init__(*of)
            judges.append(ref(self))

    monkeypatch.setattr(recording, "Trust", Watched)
    gc.disable()
    try:
        assert simulate(chaotic()).trust_horizon > 0
        assert [judge() for judge in judges] == [None]
    finally:
        gc.enable()


@pytest.mark.parametrize("who", ["companion", "third run"])
def test_a_run_beside_that_takes_too_many_events_is_given_up(who, monkeypatch, tmp_path):
    """Nothing is known from there on; the file and what is printed say so, and the motion is all there."""
    case = short_case("II-B", "119 s", run__trust_tolerance="100 m")
    plain = simulate(case)
    assert plain.trust_horizon == 119 and "trust_known_to_s" not in plain.attrs
    most = {"companion": lambda taken: np.minimum(taken, 300), "third run": lambda taken: taken + 1000}[who]
    monkeypatch.setattr(trust_horizon, "most_events", most)
    if who == "third run":
        monkeypatch.setattr(LastSamples, "_piece", lambda self, block: RunPiece(np.empty((2, 0)), [], 10**6))
    written = simulate_to_file(case, tmp_path / "a.h5")
    read = vibsim.open_result(tmp_path / "a.h5")
    known_to = read.attrs["trust_known_to_s"]
    assert written.trust_horizon == read.trust_horizon == known_to and 10 < known_to < 110
    if who == "companion":
        taken = np.searchsorted(plain.events["t"], plain.time, side="right")
        assert abs(known_to - plain.time[np.argmax(taken > 300)]) < 0.5
    assert f"{who} took more than 2 times the events of the run" in read.attrs["trust_unknown_why"]
    assert read.complete and read["x1"].tobytes() == plain["x1"].tobytes()
    shown = call("info", tmp_path / "a.h5").output
    assert f"nothing is known behind {known_to:.4g} s" in " ".join(shown.split())
    assert "took more than 2 times" in str(read)
