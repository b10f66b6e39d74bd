"""What is not a result file of this vibsim is refused in one line that says why."""

import shutil

import h5py
import numpy as np
import pytest

import vibsim
from tests.results.made import short_run
from vibsim.results import ResultFileError, is_result_file, kind_of


@pytest.fixture(scope="module")
def saved(tmp_path_factory):
    return short_run("II-B").save(tmp_path_factory.mktemp("reading") / "II-B.h5")


@pytest.fixture
def copy(saved, tmp_path):
    return shutil.copy(saved, tmp_path / "copy.h5")


def refusal(path):
    with pytest.raises(ResultFileError) as caught:
        result = vibsim.open_result(path)
        for name in result:
            assert result[name] is not None
    text = str(caught.value)
    assert "\n" not in text
    assert text.startswith(f"{path}: ")
    return text.removeprefix(f"{path}: ")


def change(path, **attrs):
    with h5py.File(path, "r+") as file:
        file.attrs.update(attrs)
    return path


def test_missing(tmp_path):
    assert refusal(tmp_path / "none.h5") == "No such file or directory"


def test_a_folder(tmp_path):
    assert refusal(tmp_path) == "Is a directory"


def test_empty(tmp_path):
    (tmp_path / "a.h5").touch()
    assert refusal(tmp_path / "a.h5") == "is empty"


def test_not_hdf5(tmp_path):
    (tmp_path / "a.h5").write_text("name: II-B\n")
    assert refusal(tmp_path / "a.h5") == "is not an HDF5 file"


def test_foreign_hdf5(tmp_path):
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["x1"] = np.zeros(3)
    assert refusal(tmp_path / "a.h5") == "is an HDF5 file, but not one that vibsim wrote"


@pytest.mark.parametrize("part", [0.02, 0.3, 0.9, 0.999])
def test_truncated(copy, part):
    with open(copy, "r+b") as file:
        file.truncate(int(part * copy.stat().st_size))
    assert refusal(copy) == "is truncated: it ends before the end that it names"


def test_only_a_signature(tmp_path):
    (tmp_path / "a.h5").write_bytes(b"\x89HDF\r\n\x1a\n")
    assert refusal(tmp_path / "a.h5").startswith(("damaged", "is truncated"))


def test_of_a_newer_format(copy):
    change(copy, vibsim_format=2, vibsim_version="9.9")
    expected = (
        f"has format 2, written by vibsim 9.9; this is vibsim {vibsim.__version__}, which reads up to 1"
    )
    assert refusal(copy) == expected


def test_of_an_unknown_kind(copy):
    assert refusal(change(copy, vibsim_kind="opera")).startswith("holds a 'opera'")


def test_without_permission(tmp_path):
    # a file that even root may not read: a process's memory map of nobody's; so the error is made instead
    (tmp_path / "a.h5").write_text("x")

    def refuse(*args, **kwargs):
        raise PermissionError(13, "Permission denied")

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("builtins.open", refuse)
        assert refusal(tmp_path / "a.h5") == "Permission denied"


def test_a_flipped_bit_in_the_data_is_noticed(copy):
    with h5py.File(copy) as file:
        chunk = file["x1"].id.get_chunk_info(0)
    with open(copy, "r+b") as file:
        file.seek(chunk.byte_offset + chunk.size // 2)
        byte = file.read(1)[0]
        file.seek(-1, 1)
        file.write(bytes([byte ^ 1]))
    assert refusal(copy).startswith("damaged")
    assert len(vibsim.open_result(copy)["x2"])  # the other columns are whole


def test_without_events(copy):
    with h5py.File(copy, "r+") as file:
        del file["events"]
    assert refusal(copy).startswith("damaged")


@pytest.mark.parametrize("value", ["one", [1, 2], -1.5e300, 0])
def test_a_format_that_is_no_number(copy, value):
    change(copy, vibsim_format=value)
    assert refusal(copy) == "damaged: the attribute vibsim_format is not a whole number from 1 on"


def test_kinds_and_signatures(saved, tmp_path):
    (tmp_path / "a.yaml").write_text("name: a\n")
    assert kind_of(saved) == "trajectory"
    assert is_result_file(saved)
    assert not is_result_file(tmp_path / "a.yaml")
    assert not is_result_file(tmp_path / "none.h5")


def test_columns_are_read_when_asked_for(saved, monkeypatch):
    read = []
    original = h5py.Dataset.__getitem__
    monkeypatch.setattr(
        h5py.Dataset, "__getitem__", lambda self, rows: read.append(self.name) or original(self, rows)
    )
    result = vibsim.open_result(saved)
    assert read == []
    assert len(result) == len(result["x1"])
    first, again = result["x1"], result["x1"]
    assert first is again
    assert read == ["/x1"]
    assert result.column("v1")[10:13].tolist() == short_run("II-B")["v1"][10:13].tolist()
    assert "x3" not in result
    with pytest.raises(KeyError, match="no column x3; this trajectory has time, x1"):
        result["x3"]
