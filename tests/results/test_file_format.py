"""What a trajectory file looks like to other programs: h5py, xarray with both of its engines."""

import csv
import json
import subprocess
import sys

import h5py
import numpy as np
import pytest
from scipy.io import loadmat

import vibsim
from tests.results.made import short_case, short_run
from tests.sweeps.made import sweep_of_motors
from vibsim.physics.parts import EVENT_NAMES
from vibsim.results import ResultFileError, simulate_to_file
from vibsim.results import result as result_module
from vibsim.results.labelled import Tidy
from vibsim.results.recording import EVENT_CHUNK, SAMPLE_CHUNK
from vibsim.results.result import write_csv, write_mat

SAMPLES = {"time": "s", "x1": "m", "v1": "m s-1", "x2": "m", "v2": "m s-1", "phi": "rad", "phidot": "rad s-1"}
FLAGS = {"contact", "friction"}
ERROR = "error_estimate"


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return short_run("II-B").save(tmp_path_factory.mktemp("format") / "II-B.h5")


@pytest.fixture(scope="module")
def file(path):
    with h5py.File(path) as file:
        yield file


def columns(group):
    return {name: item for name, item in group.items() if isinstance(item, h5py.Dataset)}


def test_the_datasets_are_those_of_the_scene(file):
    assert set(columns(file)) == set(SAMPLES) | FLAGS | {ERROR}
    assert set(columns(file["events"])) == {"t", "kind", "part", "phase", *SAMPLES, *FLAGS} - {"time"}


def test_a_scene_without_motor_friction_and_stop_has_no_such_columns(tmp_path):
    text = "blocks: {m1: 1 kg, m2: fixed}\ncoupling: {k1: 1 N/m, c: 0}\nexcitation: {kind: none}\n"
    (tmp_path / "bare.yaml").write_text(text + "initial: {x1: 1 mm}\nrun: {t_end: 1 s}\n")
    saved = vibsim.simulate(vibsim.load_case(tmp_path / "bare.yaml")).save(tmp_path / "bare.h5")
    with h5py.File(saved) as file:
        assert set(columns(file)) == {"time", "x1", "v1", ERROR}
        assert set(columns(file["events"])) == {"t", "kind", "part", "x1", "v1"}


def test_units_and_meanings(file):
    for group in (file, file["events"]):
        for name, dataset in columns(group).items():
            assert dataset.attrs["long_name"]
            if dataset.dtype == "i1":
                values, meanings = dataset.attrs["flag_values"], dataset.attrs["flag_meanings"].split()
                assert values.dtype == "i1" and len(values) == len(meanings)
                assert set(np.unique(dataset[:])) <= set(values)
            else:
                assert dataset.dtype == "f8"
                assert dataset.attrs["units"] == {**SAMPLES, "t": "s", "phase": "rad", ERROR: "m"}[name]


def test_every_axis_has_its_scale(file):
    for group, scale in ((file, "time"), (file["events"], "t")):
        assert group[scale].is_scale
        for name, dataset in columns(group).items():
            if name != scale:
                assert dataset.dims[0].keys() == [scale]
                assert dataset.dims[0][0] == group[scale]


def test_filters_and_chunks(file):
    for group, chunk in ((file, SAMPLE_CHUNK), (file["events"], EVENT_CHUNK)):
        for dataset in columns(group).values():
            assert (dataset.compression, dataset.compression_opts) == ("gzip", 1)
            assert dataset.shuffle and dataset.fletcher32
            assert dataset.chunks == (chunk,) and dataset.maxshape == (None,)


def test_root_attributes(file):
    attrs, case = dict(file.attrs), short_case("II-B")
    assert attrs["Conventions"].startswith("CF-1.")
    assert (attrs["vibsim_format"], attrs["vibsim_kind"], attrs["complete"]) == (1, "trajectory", 1)
    assert attrs["vibsim_version"] == vibsim.__version__
    assert (attrs["case_name"], attrs["title"]) == (case.name, case.title)
    assert (attrs["case_yaml"], attrs["case_sha256"]) == (case.text, case.sha256)
    assert json.loads(attrs["case_resolved_json"])["run"]["t_end"] == "5 s"
    assert (attrs["method"], attrs["taylor_order"], attrs["taylor_tolerance"]) == ("taylor", 20, 2.0**-53)
    assert attrs["engine"] == "c"
    assert attrs["impacts"] == np.count_nonzero(file["events/kind"][:] == 1)
    assert attrs["events"] == len(file["events/t"]) - 2
    assert attrs["t_reached_s"] == 5.0
    assert attrs["wall_time_s"] > 0
    assert {"date_created", "platform", "python_version", "numpy_version"} <= set(attrs)


def test_what_is_not_known_is_absent(file):
    assert "first_violation_time" not in file.attrs
    for value in file.attrs.values():
        assert not (isinstance(value, float) and np.isnan(value))


def test_a_case_of_a_megabyte_fits_into_an_attribute(tmp_path):
    result = short_run()
    long_text = "# " + "x" * 900_000 + "\n" + result.attrs["case_yaml"]
    copy = vibsim.Result({**result.attrs, "case_yaml": long_text}, dict(result._samples), result.events)
    assert vibsim.open_result(copy.save(tmp_path / "long.h5")).attrs["case_yaml"] == long_text


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    """The file of a sweep, and its result."""
    return sweep_of_motors(tmp_path_factory.mktemp("sweep") / "sweep.h5")


READ = """
import sys, warnings
warnings.simplefilter("error")
import numpy, xarray
run, sweep, engine = sys.argv[1:]
for group, scale in ((None, "time"), ("events", "t")):
    with xarray.open_dataset(run, engine=engine, group=group) as data:
        data.load()
        print(*data.sizes.items(), sorted(data.variables), data[scale].dtype, data["x1"].dims, end=" ")
        print(float(data["x1"].sum()))
with xarray.open_dataset(sweep, engine=engine) as data:
    data.load()
    print(dict(data.sizes), data["mean_speed"].dims, data["section_speed"].dims)
    print(data["sha256"].values[1, 0, 0], data["error"].values[0, 0, 0] == "", int(data["status"].sum()))
    print(repr(float(data["mean_speed"].sel(omega0=3.5, G=2, direction=-1))))
"""


@pytest.mark.parametrize("engine", ["h5netcdf", "netcdf4"])
def test_xarray_opens_it_without_warnings_and_phony_dimensions(path, file, swept, engine):
    """A run and a sweep; one process per engine: h5py and netCDF4 bring an HDF5 library each."""
    sweep, result = swept
    command = [sys.executable, "-c", READ, str(path), str(sweep), engine]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    *runs, dims, texts, speed = done.stdout.splitlines()
    assert "'omega0': 3" in dims and "'G': 2" in dims and "'section': 7" in dims and "phony" not in dims
    assert "('omega0', 'G', 'direction') ('omega0', 'G', 'direction', 'section')" in dims
    assert texts.split() == [result["sha256"][1, 0, 0], "True", "12"]
    assert float(speed) == result["mean_speed"][1, 1, 1]
    tables = (file, "time"), (file["events"], "t")
    for told, (table, scale) in zip(runs, tables, strict=True):
        assert told.split(" [")[0] == f"('{scale}', {len(table[scale])})"
        assert str(sorted(columns(table))) in told and f"float64 ('{scale}',)" in told
        total = float(np.sum(table["x1"][:]))
        assert float(told.split()[-1]) == pytest.approx(total, rel=1e-12, abs=1e-12)


def test_a_run_and_a_saved_result_are_the_same_file(tmp_path):
    simulate_to_file(short_case(), tmp_path / "run.h5")
    short_run().save(tmp_path / "saved.h5")
    run, saved = vibsim.open_result(tmp_path / "run.h5"), vibsim.open_result(tmp_path / "saved.h5")
    assert list(run.attrs) == list(saved.attrs)
    for name in run:
        assert run[name].tobytes() == saved[name].tobytes()
    for name in run.events:
        assert run.events[name].tobytes() == saved.events[name].tobytes()


def test_many_chunks_hold_what_memory_holds(tmp_path):
    values = {"t_end": "20 s", "run__every": "0.2 ms"}
    assert len(short_run(**values)) == 100_001 > 6 * SAMPLE_CHUNK
    simulate_to_file(short_case(**values), tmp_path / "long.h5")
    run = vibsim.open_result(tmp_path / "long.h5")
    for name in run:
        assert run[name].tobytes() == short_run(**values)[name].tobytes()


# CSV and MAT files hold the same bits as the trajectory.


EVERYTHING = (0.0, np.inf)


@pytest.fixture(params=["memory", "file"])
def result(request, tmp_path):
    run = short_run("II-B")
    return run if request.param == "memory" else vibsim.open_result(run.save(tmp_path / "run.h5"))


def read_csv(path):
    with open(path, newline="") as file:
        header, *rows = csv.reader(file)
    return header, dict(zip(header, zip(*rows, strict=True), strict=True))


def test_csv_reads_back_to_the_same_bits(result, tmp_path, monkeypatch):
    monkeypatch.setattr(result_module, "PIECE", 300)  # several pieces, the last one short
    write_csv(result, tmp_path / "a.csv", EVERYTHING)
    header, columns = read_csv(tmp_path / "a.csv")
    assert header == result.keys()
    for name in set(header) - {"contact", "friction"}:
        assert np.array(columns[name], "f8").tobytes() == result[name].astype("f8").tobytes()


@pytest.mark.parametrize("events", [False, True])
def test_csv_writes_all_codes_as_the_words_that_tables_have(result, tmp_path, events):
    write_csv(result, tmp_path / "a.csv", EVERYTHING, events=events)
    columns = read_csv(tmp_path / "a.csv")[1]
    table = Tidy((result.events if events else result).arrays())
    for name in ["contact", "friction", *(["kind", "part"] if events else [])]:
        assert list(columns[name]) == list(table.told(name))
    assert {"free", "contact"} == set(columns["contact"])


def test_csv_lines_end_as_rfc_4180_says(result, tmp_path):
    write_csv(result, tmp_path / "a.csv", EVERYTHING)
    raw = (tmp_path / "a.csv").read_bytes()
    assert raw.count(b"\r\n") == raw.count(b"\n") == 1 + len(result)
    assert raw.endswith(b"\r\n")


def test_csv_of_the_events_names_their_kinds(result, tmp_path):
    write_csv(result, tmp_path / "a.csv", EVERYTHING, events=True)
    header, columns = read_csv(tmp_path / "a.csv")
    assert header == list(result.events)
    assert list(columns["kind"]) == [EVENT_NAMES[code] for code in result.events["kind"].tolist()]
    assert np.array_equal(np.array(columns["t"], "f8"), result.events["t"])


def test_a_window_has_both_of_its_ends(result, tmp_path):
    write_csv(result, tmp_path / "a.csv", (1.0, 1.5))
    times = np.array(read_csv(tmp_path / "a.csv")[1]["time"], "f8")
    assert (times[0], times[-1], len(times)) == (1.0, 1.5, 101)


def test_mat_holds_samples_events_and_where_they_come_from(result, tmp_path):
    write_mat(result, tmp_path / "a.mat", EVERYTHING)
    found = loadmat(tmp_path / "a.mat", squeeze_me=True)
    for name in result:
        assert found[name].dtype == result[name].dtype
        assert found[name].tobytes() == result[name].tobytes()
    for name in result.events:
        assert found["events"][name].item().tobytes() == result.events[name].tobytes()
    assert found["info"]["case_sha256"].item() == result.case.sha256
    assert found["info"]["impacts"].item() == result.attrs["impacts"]


def test_mat_of_a_window(result, tmp_path):
    write_mat(result, tmp_path / "a.mat", (1.0, 1.5))
    found = loadmat(tmp_path / "a.mat", squeeze_me=True)
    assert len(found["time"]) == 101
    times = np.atleast_1d(found["events"]["t"].item())
    assert len(times) > 0 and np.all((times >= 1.0) & (times <= 1.5))


def test_mat_beyond_its_limit_is_refused(result, tmp_path, monkeypatch):
    monkeypatch.setattr(result_module, "LARGEST", 1000)
    with pytest.raises(ResultFileError, match="a MAT file takes 2 GB; export a window, or as CSV"):
        write_mat(result, tmp_path / "a.mat", EVERYTHING)
    assert not (tmp_path / "a.mat").exists()


@pytest.mark.parametrize("write", [write_csv, write_mat])
def test_an_existing_export_is_kept(result, tmp_path, write):
    (tmp_path / "a.out").write_text("precious")
    with pytest.raises(ResultFileError, match="exists; kept"):
        write(result, tmp_path / "a.out", EVERYTHING)
    assert (tmp_path / "a.out").read_text() == "precious"
    write(result, tmp_path / "a.out", EVERYTHING, force=True)
    assert (tmp_path / "a.out").stat().st_size > 1000
