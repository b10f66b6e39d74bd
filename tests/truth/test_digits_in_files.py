"""The digits of a run: in memory, in its file, and for programs that read the file."""

from decimal import Decimal

import h5py
import numpy as np
import pytest
import xarray

import vibsim
from tests.command_line.made import call
from tests.truth.made import case


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    """The file of a run of 40 digits by `vibsim run`."""
    path = tmp_path_factory.mktemp("truth") / "II-B.h5"
    done = call("run", "II-B", "--digits", 40, "--t-end", "3 s", "-o", path)
    assert done.exit_code == 0
    assert "digits          40 carried, 3" in done.stdout
    return path


def test_doubles_are_the_digits_rounded(path):
    result = vibsim.open_result(path)
    assert list(result.digits) == ["x1", "v1", "x2", "v2", "phi", "phidot"]
    assert list(result.digits.events) == ["t", *result.digits]
    for name, texts in result.digits.items():
        assert np.array_equal(result[name], [float(text) for text in texts])
    for name, texts in result.digits.events.items():
        assert np.array_equal(result.events[name], [float(text) for text in texts])
    with pytest.raises(KeyError, match="no digits of time"):
        result.digits["time"]


def test_texts_have_all_digits(path):
    texts = vibsim.open_result(path).digits["x1"]
    assert len(texts) == 601
    assert {len(Decimal(str(text)).as_tuple().digits) for text in texts[1:]} == {40}


def test_attributes_say_how_it_was_computed(path):
    attrs = vibsim.open_result(path).attrs
    assert (attrs["digits"], attrs["engine"], attrs["number_type"]) == (40, "c", "192-bit")
    assert (attrs["precision_bits"], attrs["method"], attrs["complete"]) == (133, "taylor", 1)
    assert attrs["taylor_order"] == 47 and "taylor_tolerance" not in attrs
    assert attrs["number_library"].startswith("python-flint ")
    assert "digits          40 carried" in call("info", path).stdout


@pytest.mark.parametrize("engine", ["h5netcdf", "netcdf4"])
def test_xarray_reads_them(path, engine):
    for group, dimension, count in (("digits", "time", 601), ("digits/events", "event", None)):
        with xarray.open_dataset(path, engine=engine, group=group) as table:
            assert list(table.sizes) == [dimension]
            assert count is None or table.sizes[dimension] == count
            assert float(table["x1"].values[-1]) == vibsim.open_result(path)["x1"][-1]
            assert table["x1"].attrs["units"] == "m"


def test_every_axis_has_its_scale(path):
    with h5py.File(path) as file:
        assert file["digits/x1"].dims[0][0] == file["time"]
        assert file["digits/events/t"].dims[0][0] == file["digits/events/event"]
        assert file["digits/x1"].dtype.kind == "S"


def test_saving_keeps_them(tmp_path):
    result = vibsim.simulate(case("I-A", "1 s", every="10 ms"), digits=25)
    again = vibsim.open_result(result.save(tmp_path / "again.h5"))
    for name, texts in result.digits.items():
        assert np.array_equal(again.digits[name], texts)
    assert np.array_equal(again.digits.events["t"], result.digits.events["t"])
    assert vibsim.simulate(case("I-A", "1 s")).digits is None


def test_an_interrupted_run_keeps_its_digits(tmp_path):
    from vibsim.results import simulate_to_file

    short = case("I-A", "20 s", every="10 ms")
    result = simulate_to_file(short, tmp_path / "cut.h5", digits=30, watch=lambda t: t < 2)
    assert not result.complete and "digits_right" not in result.attrs
    assert 2 <= result.t_reached < 20
    assert len(result.digits["x1"]) == len(result["x1"]) > 0
