"""vibsim info and vibsim export."""

import csv
import json
from pathlib import Path

import h5py
import pytest
from scipy.io import loadmat

import vibsim
import vibsim.sweeps
from tests.command_line.made import call, refused, told
from tests.results.made import short_run


@pytest.fixture(autouse=True)
def folder(here):
    """Every test runs in a folder with one result, II-B.h5."""
    short_run("II-B").save("II-B.h5")
    return here


def test_info_says_what_run_said_and_more():
    text = call("info", "II-B.h5").stdout
    attrs = vibsim.open_result("II-B.h5").attrs
    assert text.startswith("II-B  Non-ideal source")
    assert f"{attrs['impacts']} impacts" in text
    assert "1001 x time, x1, v1, x2, v2, phi, phidot, contact, friction" in text
    assert f"{attrs['events'] + 2} x t, kind, part, x1" in text
    for part in (attrs["case_sha256"], attrs["date_created"], attrs["numpy_version"], attrs["platform"]):
        assert part in text


def test_info_as_json():
    done = call("info", "II-B.h5", "II-B.h5", "--json")
    first, second = map(json.loads, done.stdout.splitlines())
    assert first == second
    assert first["case"]["name"] == "II-B"
    assert first["t_reached_s"] == 5.0


def test_info_prints_the_case_as_it_was_given():
    assert call("info", "II-B.h5", "--case").stdout == vibsim.load_case("II-B").text


def test_info_of_a_sweep_asks_the_sweeps(monkeypatch):
    with h5py.File("sweep.h5", "w") as file:
        file.attrs.update(vibsim_format=1, vibsim_kind="sweep")
    described = [("points", "81")], {"points": 81}
    monkeypatch.setattr(vibsim.sweeps, "describe", lambda path: described, raising=False)
    assert call("info", "sweep.h5").stdout == "  points          81\n"
    assert json.loads(call("info", "sweep.h5", "--json").stdout) == {"file": "sweep.h5", "points": 81}


@pytest.mark.parametrize("command", [["info"], ["export", "-o", "a.csv"]])
def test_what_is_no_result_file(command):
    assert refused(*command, "none.h5", code=6) == "Error: none.h5: No such file or directory\n"


def test_info_of_a_file_without_its_end():
    Path("II-B.h5").rename("II-B.h5.partial")
    with h5py.File("II-B.h5.partial", "r+") as file:  # as a killed run leaves it
        gone = "t_reached_s wall_time_s impacts sticks events certified grazing_margin grazing_time"
        for name in gone.split():
            del file.attrs[name]
        file.attrs["complete"] = 0
    text = call("info", "II-B.h5.partial").stdout
    assert "samples end at 5 s" in text
    assert "motion" not in text
    assert json.loads(call("info", "II-B.h5.partial", "--json").stdout)["complete"] == 0


def test_export_csv():
    assert told("export", "II-B.h5", "-o", "a.csv", "--window", "1:2") == ""
    rows = list(csv.reader(Path("a.csv").read_text().splitlines()))
    assert rows[0] == vibsim.open_result("II-B.h5").keys()
    assert (rows[1][0], rows[-1][0], len(rows)) == ("1.0", "2.0", 202)


def test_export_events_from_the_start_and_to_the_end():
    call("export", "II-B.h5", "-o", "a.csv", "--events", "--window", ":2", "-q")
    call("export", "II-B.h5", "-o", "b.csv", "--events", "--window", "2:")
    first, second = (Path(name).read_text().splitlines() for name in ("a.csv", "b.csv"))
    assert first[1].startswith("0.0,start,")
    assert second[-1].startswith("5.0,end,")
    assert len(first) + len(second) - 2 == len(vibsim.open_result("II-B.h5").events["t"])


def test_export_mat():
    assert call("export", "II-B.h5", "-o", "a.MAT").exit_code == 0
    assert loadmat("a.MAT")["x1"].shape == (1001, 1)


def test_an_existing_export_is_kept_unless_forced():
    Path("a.csv").write_text("precious")
    done = call("export", "II-B.h5", "-o", "a.csv")
    assert (done.exit_code, done.stderr) == (6, "Error: a.csv: exists; kept (--force replaces it)\n")
    assert call("export", "II-B.h5", "-o", "a.csv", "--force").exit_code == 0
    assert len(Path("a.csv").read_text().splitlines()) == 1002


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["-o", "a.xlsx"], "the suffix must be .csv, .parquet or .mat"),
        (["-o", "a.mat", "--events"], "--events is for CSV and Parquet"),
        (["-o", "a.csv", "--window", "3"], "'3' is not A:B with A < B"),
        (["-o", "a.csv", "--window", "3:1"], "is not A:B"),
        (["-o", "a.csv", "--window", "a:b"], "is not A:B"),
        ([], "Missing option '-o'"),
    ],
)
def test_misuse_of_export(words, message):
    assert message in refused("export", "II-B.h5", *words)
    assert not Path("a.csv").exists()
