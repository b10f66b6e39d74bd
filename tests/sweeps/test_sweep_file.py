"""What a sweep file looks like to other programs: h5py, xarray with both of its engines."""

import subprocess
import sys

import h5py
import numpy as np
import pytest

from tests.sweeps.made import OMEGA0, assert_same_points, run_stored, short_case, short_plan
from vibsim.results import ResultFileError
from vibsim.results.simulation import open_result
from vibsim.sweeps import describe, sweep
from vibsim.sweeps.quantities import DEFINITIONS, always, quantities_of, section
from vibsim.sweeps.sweep_file import SweepStore

SECTIONS = 7


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A grid of motor constants and gaps, carried up and down, one point missing."""
    path = tmp_path_factory.mktemp("sweep") / "sweep.h5"
    plan = short_plan(
        {OMEGA0: "3:4:0.5 Hz", "G": "1, 2 mm"}, carry_state=True, direction="both", section=SECTIONS
    )
    result, _ = run_stored(SweepStore(plan, path), 2)
    return path, result


@pytest.fixture(scope="module")
def file(made):
    with h5py.File(made[0]) as file:
        yield file


def test_the_scales(file):
    assert file["omega0"][:].tolist() == [3.0, 3.5, 4.0] and file["omega0"].attrs["units"] == "Hz"
    assert file["G"][:].tolist() == [1.0, 2.0] and file["G"].attrs["units"] == "mm"
    assert file["omega0"].attrs["key"] == OMEGA0
    assert file["direction"][:].tolist() == [1, -1]
    assert file["direction"].attrs["flag_meanings"].split() == ["up", "down"]
    assert file["section"][:].tolist() == list(range(1 - SECTIONS, 1))


def test_every_dataset_lies_on_the_scales(file):
    scales = ["omega0", "G", "direction", "section"]
    of_sections = section(quantities_of(short_case()))
    for name, dataset in file.items():
        if name not in scales:
            expected = scales if name in of_sections else scales[:3]
            assert [dataset.dims[i].keys() for i in range(dataset.ndim)] == [[scale] for scale in expected]
            assert dataset.attrs["long_name"]


def test_units_and_filters(file):
    for name, column in always(quantities_of(short_case())).items():
        assert file[name].attrs["units"] == column.units
        assert (file[name].compression, file[name].fletcher32) == ("gzip", True)
    assert file["status"].attrs["flag_meanings"].split() == ["missing", "done", "failed"]
    assert file["status"].attrs["flag_values"].dtype == "i1"


def test_root_attributes(file):
    attrs = dict(file.attrs)
    assert (attrs["vibsim_kind"], attrs["vibsim_format"], attrs["complete"]) == ("sweep", 1, 1)
    assert (attrs["points"], attrs["points_done"], attrs["points_failed"]) == (12, 12, 0)
    assert attrs["definitions"] == DEFINITIONS and attrs["case_sha256"] == short_case().sha256
    assert (attrs["method"], attrs["taylor_order"]) == ("taylor", 20)
    assert {"case_yaml", "case_resolved_json", "sweep_sha256", "platform", "date_created"} <= set(attrs)


def test_reading_back_gives_the_same(made):
    path, result = made
    read = open_result(path)
    assert_same_points(read.table, result.table)
    assert read.plan.fingerprint == result.plan.fingerprint and read.plan.settings == result.plan.settings
    assert read.attrs == result.attrs
    assert read.case_at((1, 1, 1)).sha256 == result["sha256"][1, 1, 1]


def test_sections_are_filled_from_the_front(made):
    """2 s at 3 Hz from rest hold fewer than 7 turns: NaN first, then the turns."""
    _, result = made
    section = result["section_speed"][0, 0, 0]
    count = int(result["periods"][0, 0, 0]) + 1
    assert 2 <= count < SECTIONS
    assert np.isnan(section[: SECTIONS - count]).all() and np.isfinite(section[SECTIONS - count :]).all()


def test_a_sweep_without_motor_or_block_2_has_no_such_columns(tmp_path):
    text = "blocks: {m1: 1 kg, m2: fixed}\ncoupling: {k1: 9 N/m, c: 1}\nrun: {t_end: 9 s}\n"
    (tmp_path / "bare.yaml").write_text(text + "excitation: {kind: harmonic, A: 1 N, omega: 1 Hz}\n")
    result = sweep(tmp_path / "bare.yaml", {"omega": "1, 2 Hz"}, out=tmp_path / "bare.h5", section=0)
    with h5py.File(tmp_path / "bare.h5") as file:
        absent = {
            "mean_speed",
            "amplitude_x2",
            "drift_rate",
            "impacts",
            "sticks_per_period",
            "end_phi",
            "section",
        }
        assert not absent & set(file)
        assert file["amplitude_x1"][:].tolist() == result["amplitude_x1"].tolist()


READ = """
import sys, warnings
warnings.simplefilter("error")
import numpy, xarray
path, engine = sys.argv[1:]
with xarray.open_dataset(path, engine=engine) as data:
    data.load()
    print(dict(data.sizes), data["mean_speed"].dims, data["section_speed"].dims)
    print(data["sha256"].values[1, 0, 0], data["error"].values[0, 0, 0] == "", int(data["status"].sum()))
    print(repr(float(data["mean_speed"].sel(omega0=3.5, G=2, direction=-1))))
"""


@pytest.mark.parametrize("engine", ["h5netcdf", "netcdf4"])
def test_xarray_opens_it_without_warnings_and_phony_dimensions(made, engine):
    path, result = made
    command = [sys.executable, "-c", READ, str(path), engine]  # h5py and netCDF4 bring an HDF5 library each
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    dims, texts, speed = done.stdout.splitlines()
    assert "'omega0': 3" in dims and "'G': 2" in dims and "'section': 7" in dims and "phony" not in dims
    assert "('omega0', 'G', 'direction') ('omega0', 'G', 'direction', 'section')" in dims
    assert texts.split() == [result["sha256"][1, 0, 0], "True", "12"]
    assert float(speed) == result["mean_speed"][1, 1, 1]


def test_describe(made):
    lines, facts = describe(made[0])
    labelled = dict(lines)
    assert (
        labelled["omega0"] == "3 to 4 Hz in steps of 0.5, 3 values" and labelled["G"] == "1, 2 mm, 2 values"
    )
    assert labelled["points"] == "12 of 12 done"
    assert "up and back down" in labelled["start"]
    assert facts["points"] == 12 and facts["sweep"]["carry_state"] is True and facts["failed"] == []


@pytest.mark.parametrize("damage", ["truncated", "no datasets"])
def test_damaged_files_say_so(made, tmp_path, damage):
    path = tmp_path / "damaged.h5"
    path.write_bytes(made[0].read_bytes()[:20_000] if damage == "truncated" else made[0].read_bytes())
    if damage == "no datasets":
        with h5py.File(path, "r+") as file:
            del file["status"]
    with pytest.raises(ResultFileError, match=r"damaged\.h5: (is truncated|damaged)"):
        open_result(path).table.count(1)
