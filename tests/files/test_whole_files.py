"""Files written whole: what is declared is what stands there, for us and for other readers of HDF5."""

import h5py
import numpy as np
import pytest

from vibsim.results.file_contents import TEXT, Attribute, Column, Dataset
from vibsim.results.hdf5_reading import ResultFileError, opened, read_attributes, read_datasets
from vibsim.results.hdf5_writing import FOR_INDEX, write_hdf5

FLAGS = {"not run": 0, "done": 1}
DECLARED = [
    Dataset("load", Column("N", "load", besides={"key": "forces.F"}), ("run", "t"), gaps=True),
    Dataset("t", Column("s", "instant compared"), ("t",)),
    Dataset("run", Column("1", "number of the run", dtype="i4"), ("run",)),
    Dataset("status", Column(None, "what came of it", dtype="i1", flags=FLAGS), ("run",)),
    Dataset("steps", Column("1", "steps", dtype="i8", missing=-1), ("run",)),
    Dataset("why", Column(None, "why it failed", dtype="text"), ("run",)),
    Dataset("late/t", Column("s", "time"), ("t",), ascending=True, span=(0.0, 9.0)),
    Dataset("late/x", Column("m", "displacement"), ("t",)),
]
VALUES = {
    "run": [0, 1],
    "t": [1.0, 2.0, 3.0],
    "load": [1.0, np.nan, 3.0, 4.0, 5.0, 6.0],  # run by run: the scales tell the shape
    "status": [0, 1],
    "steps": [-1, 7],
    "why": ["grüße", ""],
    "late/t": [0.5, 0.5, 2.0],
    "late/x": [0.0, 1.0, 2.0],
}
ATTRS = {"vibsim_format": 1, "vibsim_kind": "sweep", "title": "two runs", "left_out": None}


@pytest.fixture
def written(tmp_path):
    write_hdf5(tmp_path / "a.h5", ATTRS, DECLARED, VALUES)
    return tmp_path / "a.h5"


def changed(path, name, value):
    with h5py.File(path, "r+") as file:
        file[name][...] = value


def read(path, kind="sweep"):
    with opened(path, kind) as file:
        return read_datasets(path, file, DECLARED, {"run": 2})


def test_what_was_written_is_read(written):
    values = read(written)
    for name, expected in VALUES.items():
        np.testing.assert_array_equal(np.ravel(values[name]), expected)
    assert values["load"].shape == (2, 3)
    with opened(written, "sweep") as file:
        assert read_attributes(written, file, [Attribute("title", TEXT)])["title"] == "two runs"
        assert "left_out" not in file.attrs


def test_other_readers_find_units_meanings_and_scales(written):
    with h5py.File(written) as file:
        assert file["load"].attrs["units"] == "N" and file["load"].attrs["key"] == "forces.F"
        assert file["status"].attrs["flag_meanings"] == "not_run done" and "units" not in file["status"].attrs
        assert file["status"].attrs["flag_values"].tolist() == [0, 1]
        assert file["steps"].attrs["missing_value"] == -1
        assert [dim[0].name for dim in file["load"].dims] == ["/run", "/t"]
        assert file["late/x"].dims[0][0].name == "/late/t"  # the scale of its own group
        assert file["late/x"].compression == "gzip" and file["late/x"].fletcher32


@pytest.mark.parametrize("count", [FOR_INDEX // 8, FOR_INDEX // 8 + 1])
def test_a_scale_is_compressed_where_that_makes_it_smaller(tmp_path, count):
    write_hdf5(tmp_path / "t.h5", ATTRS, [DECLARED[1]], {"t": np.arange(count)})
    with h5py.File(tmp_path / "t.h5") as file:
        assert (file["t"].compression is None) == (8 * count <= FOR_INDEX)


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("status", 5, "status has the value 5; allowed: 0, 1"),
        ("late/t", [2.0, 1.0, 3.0], "late/t does not ascend"),
        ("late/t", 9.5, "late/t has the value 9.5"),
        ("late/x", np.inf, "late/x has the value inf"),
    ],
)
def test_values_that_cannot_be_right(written, name, value, message):
    changed(written, name, value)
    with pytest.raises(ResultFileError, match=f"a.h5: damaged: {message}"):
        read(written)


def test_another_kind_of_file(written):
    with pytest.raises(ResultFileError, match="holds a sweep, not a bench"):
        read(written, "bench")


def test_values_that_do_not_fit_the_scales(tmp_path):
    with pytest.raises(ValueError, match="reshape"):
        write_hdf5(tmp_path / "a.h5", ATTRS, DECLARED, {**VALUES, "load": [1.0]})
    assert not list(tmp_path.iterdir())


def test_an_attribute_whose_name_is_no_text_is_left_out(written):
    """h5py gives a name that is no UTF-8 as bytes."""
    with h5py.File(written, "r+") as file:
        h5py.h5a.create(file.id, b"\xff\xfe", h5py.h5t.NATIVE_INT64, h5py.h5s.create(h5py.h5s.SCALAR))
    with opened(written, "sweep") as file:
        assert read_attributes(written, file, [Attribute("title", TEXT)])["title"] == "two runs"
