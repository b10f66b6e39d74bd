"""vibsim orbit: what it prints, stores and refuses."""

import errno
import json

import matplotlib
import numpy as np
import pytest

import vibsim
from tests.branches.made import RESONANT, orbit_of
from tests.command_line.made import call, refused, told
from tests.orbits.truths import TRUTHS

CAPTURED = ("-s", "c=0.03 N s/m", "-s", "Omega0=5Hz")


def facts(*words):
    return json.loads(told("orbit", *words, "--json"))


def test_json_has_the_truth():
    of = TRUTHS["II-B c=0.03 captured n=1 (2 impacts/turn)"]
    found = facts("II-B", *CAPTURED)
    assert found["period"] == pytest.approx(of.period, rel=1e-13) and found["n"] == 1
    assert {"x1", "x2", "v1", "v2", "phi", "phidot"} == set(found["state"])
    assert list(found["coordinates"].values()) == pytest.approx(of.unknowns.tolist(), rel=1e-11)
    multipliers = [complex(*pair) for pair in found["multipliers"]]
    assert all(min(abs(mu - other) for other in multipliers) < 1e-10 for mu in of.multipliers)
    assert found["events"] == of.word and found["stable"] is True and found["residual"] < 1e-13
    assert found["drift"] == found["drifts"]["2"] == pytest.approx(1.688e-4, rel=1e-3)
    assert found["impacts"] == 2 and found["reversals"] == 4 and found["certified"]
    assert [one["kind"] for one in found["near"]] == ["fold", "Neimark-Sacker"]


def test_what_is_printed():
    shown = told("orbit", "I-A")
    lines = {line[2:18].strip(): line[18:] for line in shown.splitlines()[1:] if line[2:3] != " "}
    assert lines["period"].startswith("1.42857142857 s, 0.7 Hz: 5 periods of the source, order 1/5")
    assert "3 impacts, 2 stick phases, 8 reversals" in lines["events"]
    assert "0.10140278 +- 0.79268517i (magnitude 0.79914473), 0" in lines["multipliers"]
    assert lines["stability"] == "stable" and "-inf 1/s" in lines["exponents"]
    assert set(lines) >= {"drift", "state", "margins", "energy", "residual", "certificate"}


def test_from_a_stored_orbit_to_a_neighbour(tmp_path):
    path = tmp_path / "orbit.h5"
    first = facts("II-B", *CAPTURED, "-o", path)
    assert first["file"] == str(path)
    beside = facts("II-B", *CAPTURED[:3], "Omega0=5.02Hz", "--from", path)
    assert beside["events"] == first["events"] and 0 < abs(beside["period"] - first["period"]) < 1e-3
    assert "orbit           1 turn, 0.2707740907 s, stable, events rbrerbre" in told("info", path)
    told("run", path, "--t-end", "2s", "-o", tmp_path / "run.h5")
    assert vibsim.open_result(tmp_path / "run.h5").orbit is None
    assert "exists; kept" in refused("orbit", "II-B", *CAPTURED, "-o", path, code=6)
    assert "run.h5" in refused("orbit", "II-B", "--from", tmp_path / "run.h5", code=6)
    said = refused("orbit", "gallery/bilinear-oscillator", "--from", path, code=6)
    needs = "to start from it, bilinear-oscillator also needs x_mass, v_mass"
    assert f"{path}: holds an orbit of II-B; {needs}" in said


def test_a_search_stores_each(tmp_path):
    words = ("gallery/bilinear-oscillator", "--search", 6, "--seed", 3, "-o", tmp_path / "all.h5")
    found = facts(*words)
    assert found["starts"] == 6 and {one["n"] for one in found["orbits"]} == {1, 2}
    for i, one in enumerate(found["orbits"]):
        assert one["file"] == str(tmp_path / f"all-{i + 1}.h5")
        assert vibsim.open_result(one["file"]).attrs["orbit_events"] == one["events"]
    refused("orbit", *words, code=6)
    listed = told("orbit", *words[:5]).splitlines()
    assert f"{len(found['orbits'])} from 6 starts" in listed[1] and len(listed) == 3 + len(found["orbits"])
    assert " found from one start, " in listed[-1]


def test_what_cannot_be_stored_is_printed(here, monkeypatch):
    """It may have taken hours; a search ends there."""

    def full(descriptor, start, count):
        raise OSError(errno.ENOSPC, "full")

    monkeypatch.setattr("vibsim.results.hdf5_reading._extend", full)
    done = call("orbit", "I-C", "--digits", 25, "-o", "a.h5")
    assert done.exit_code == 6 and "1.53846153846153846153846" in done.stdout
    assert done.stderr == "Error: a.h5: disk full\n"
    done = call("orbit", "I-C", "--search", 3, "-o", "a.h5", "--json")
    printed = json.loads(done.stdout)
    assert done.exit_code == 6 and printed["starts"] == 1 and len(printed["orbits"]) == 2
    error = {"message": "a-1.h5: disk full", "exit_code": 6}
    assert printed["error"] == error and not any("file" in one for one in printed["orbits"])
    assert not list(here.iterdir())


def test_digits(tmp_path):
    found = facts("I-C", "--digits", 25, "-o", tmp_path / "orbit.h5")
    assert found["period_digits"].startswith("1.53846153846153846153846")
    stored = vibsim.open_result(tmp_path / "orbit.h5")
    assert stored.attrs["orbit_digits"] == 25
    kept = [text.decode() for text in stored.orbit["digits_start"]]
    assert kept == list(found["coordinates_digits"].values())
    assert float(kept[0]) == pytest.approx(found["state"]["x1"], rel=1e-12)


@pytest.mark.parametrize(
    ("words", "code", "message"),
    [
        (["I-A", "--at-start", "--search", "3"], 2, "leave --search out"),
        (["I-A", "--at-start", "--from", "x.h5"], 2, "leave --from out"),
        (["I-C", "--seed", "3"], 2, "--seed draws the starts of --search"),
        (["I-C", "--search", "3", "--from", "x.h5"], 2, "leave --from out"),
        (["I-C", "--digits", "auto"], 2, "'auto' is for runs"),
        (["I-C", "-o", "orbit.csv"], 2, "suffix .csv"),
        (["I-C", "--period", "0"], 2, "0 is not in the range"),
        (["nosuchcase"], 3, "nosuchcase"),
        (["I-C", "-s", "k9=3"], 3, "k9"),
    ],
)
def test_what_is_refused(words, code, message):
    assert message in refused("orbit", *words, code=code)


def test_at_start_looks_near_the_initial_state():
    """Beside the orbit that the run goes to, without impacts; a motor is followed to phi = 0."""
    assert facts("I-A")["n"] == 5
    smooth = facts("I-A", "--at-start")
    assert smooth["n"] == 1 and smooth["impacts"] == 0 and smooth["residual"] < 1e-13
    same = vibsim.orbit("I-A", start=[0.0, 0.0, 0.0, 0.0])
    assert list(same.state) == list(vibsim.orbit("I-A", start="initial").state)
    first = facts("II-B", *CAPTURED)
    units = {"x1": "m", "v1": "m/s", "x2": "m", "v2": "m/s", "phidot": "rad/s"}
    there = [word for key, unit in units.items() for word in ("-s", f"{key}={first['state'][key]!r} {unit}")]
    again = facts("II-B", *CAPTURED, *there, "-s", "phi=-0.1 rad", "--at-start")
    assert again["period"] == pytest.approx(first["period"], rel=1e-12)


# An orbit as a table, and as a picture.


matplotlib.use("agg")


@pytest.fixture(scope="module")
def orbit():
    return orbit_of(RESONANT)


def test_a_frame_is_one_period_on_it(orbit):
    frame = orbit.to_dataframe()
    assert frame.index.name == "time" and frame.index[-1] <= orbit.period
    assert orbit.run.t_reached == pytest.approx(orbit.period, rel=1e-15)
    assert frame["x1"].to_numpy().tobytes() == orbit.run["x1"].tobytes()
    assert orbit.to_xarray()["v1"].attrs["units"] == "m s-1"
    assert len(vibsim.analyse(orbit.run).regime.multipliers) == len(orbit.multipliers)
    end, start = orbit.run.at(orbit.period), orbit.run.at(0.0)
    assert abs(end["v1"] - start["v1"]) < 1e-9 * np.ptp(orbit.run["v1"])


def test_it_shows_itself(orbit):
    text = repr(orbit)
    assert text.startswith("<Orbit of I-C: period 0.15384") and "stable" in text and "multipliers" in text
    assert "multipliers" in orbit._repr_html_()


def test_a_picture_of_it(orbit):
    import matplotlib.pyplot as pyplot

    _, axes = pyplot.subplots()
    assert orbit.plot("relative", ax=axes) is axes and axes.lines
    assert vibsim.plot([orbit, orbit.run], "relative", ax=axes) is axes
    assert len(orbit.plot()) == 2 and orbit.plot()[1].get_xlabel() == "Real part of the multipliers"
    pyplot.close("all")
