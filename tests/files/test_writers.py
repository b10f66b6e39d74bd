"""Several who write one output: each file is that of one of them, whole, whatever HDF5 and the disk lock."""

import errno
import fcntl
import os
import socket
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest

import vibsim
from vibsim.results.file_contents import TEXT, Attribute, Column, Dataset
from vibsim.results.hdf5_reading import ResultFileError, opened, read_attributes, read_datasets
from vibsim.results.hdf5_writing import FOR_INDEX, write_hdf5
from vibsim.results.output_files import Lock, check_unlocked, lock_path, open_partial, output_file

DEAD = "4194304 "  # a number that Linux gives to no process (pid_max is at most 2^22)


def names(folder):
    return sorted(os.listdir(folder))


def test_two_who_write_at_once_publish_their_own(tmp_path):
    path = tmp_path / "a.csv"
    with output_file(path, force=True) as one:
        one.write(b"1" * 10)
        with output_file(path, force=True) as other:
            other.write(b"2" * 4)
        assert path.read_bytes() == b"2" * 4
    assert path.read_bytes() == b"1" * 10 and names(tmp_path) == ["a.csv"]


@pytest.mark.parametrize("force", [False, True])
def test_it_can_be_read_from_the_instant_in_which_it_has_its_name(tmp_path, monkeypatch, force):
    """By HDF5 too, which locks what it reads."""
    path, seen, sync = tmp_path / "a.h5", [], os.fsync
    write_hdf5(tmp_path / "b.h5", {"vibsim_kind": "sweep"}, [], {})

    def synced(descriptor):
        sync(descriptor)
        if path.exists():
            with h5py.File(path) as file:
                seen.append(file.attrs["vibsim_kind"])

    with output_file(path, force) as file:
        file.write((tmp_path / "b.h5").read_bytes())
        monkeypatch.setattr(os, "fsync", synced)
    assert seen == ["sweep"]


def test_what_came_meanwhile_is_kept(tmp_path):
    path = tmp_path / "a.csv"
    with pytest.raises(ResultFileError, match="appeared meanwhile; kept"), output_file(path) as file:
        file.write(b"late")
        path.write_bytes(b"early")
    assert path.read_bytes() == b"early" and names(tmp_path) == ["a.csv"]


@pytest.mark.parametrize("refused", [errno.EPERM, errno.EOPNOTSUPP])
def test_a_disk_without_links(tmp_path, monkeypatch, refused):
    def no_link(*_):
        raise OSError(refused, "no links here")

    monkeypatch.setattr(os, "link", no_link)
    with output_file(tmp_path / "a.csv") as file:
        file.write(b"whole")
    assert (tmp_path / "a.csv").read_bytes() == b"whole" and names(tmp_path) == ["a.csv"]
    with pytest.raises(ResultFileError, match="appeared meanwhile"), output_file(tmp_path / "b.csv") as file:
        (tmp_path / "b.csv").write_bytes(b"early")


def test_only_what_the_dead_have_left_is_removed(tmp_path):
    dead, alive = (tmp_path / f"a.csv.{token}.partial" for token in ("0123abcd", "00000000"))
    kept = ("a.csv.partial", "a.csv.0123abcd.partial.txt", "b.csv.0123abcd.partial")
    others = [tmp_path / name for name in kept]
    for path in (dead, alive, *others):
        path.write_text("half")
    with open(alive) as writing:
        fcntl.flock(writing, fcntl.LOCK_EX)
        with output_file(tmp_path / "a.csv") as file:
            file.write(b"whole")
    assert names(tmp_path) == sorted(["a.csv", alive.name, *kept])


def test_a_new_folder_that_another_takes_for_one_of_the_dead(tmp_path, monkeypatch):
    """It is removed before it could be locked: the next one is taken."""
    opened, removed = os.open, []

    def late(path, *flags):
        if not removed:
            os.rmdir(path)
            removed.append(path)
        return opened(path, *flags)

    monkeypatch.setattr(os, "open", late)
    descriptor, path = open_partial(tmp_path / "crate", folder=True)
    os.close(descriptor)
    assert removed and path != removed[0] and path.is_dir()
    with pytest.raises(FileNotFoundError):
        open_partial(tmp_path / "none" / "crate", folder=True)


def test_one_writer_at_a_time_holds_the_lock(tmp_path):
    path = tmp_path / "a.h5"
    lock = Lock(path, "a.h5")
    ours = rf"^a.h5: another command is writing it \(process {os.getpid()} "
    with pytest.raises(ResultFileError, match=ours):
        Lock(path, "a.h5")
    check_unlocked(path, "a.h5")  # by others, that is
    lock.release()
    assert names(tmp_path) == []
    lock_path(path).write_text(f"{DEAD}somewhere")  # left by a writer that was killed
    check_unlocked(path, "a.h5")
    assert names(tmp_path) == []
    lock_path(path).write_text("")
    Lock(path, "a.h5").release()
    assert names(tmp_path) == []


@pytest.mark.parametrize("missing", [errno.ENOSYS, errno.ENOLCK, errno.EOPNOTSUPP])
def test_a_disk_without_locks(tmp_path, monkeypatch, missing):
    def no_flock(*_):
        raise OSError(missing, "no locks here")

    monkeypatch.setattr(fcntl, "flock", no_flock)
    path, machine = tmp_path / "a.h5", socket.gethostname()
    lock = Lock(path, "a.h5")
    with pytest.raises(ResultFileError, match=r"is writing it \(.*\); where it has ended, remove a.h5.lock"):
        Lock(path, "a.h5")
    lock.release()
    lock_path(path).write_text(f"{DEAD}{machine}")
    Lock(path, "a.h5").release()
    lock_path(path).write_text(f"{DEAD}{machine}.elsewhere")  # nobody here knows whether it lives
    with pytest.raises(ResultFileError, match=r"where it has ended, remove a\.h5\.lock"):
        Lock(path, "a.h5")
    with output_file(tmp_path / "a.csv") as file:
        file.write(b"whole")
    assert names(tmp_path) == ["a.csv", "a.h5.lock"]


def test_a_folder_in_which_nothing_can_be_made():
    with pytest.raises(ResultFileError, match=r"^x.h5: cannot write: "):
        Lock(Path("/proc/x.h5"), "x.h5")


AT_ONCE = """
import sys
from pathlib import Path
from tests.command_line.made import call
words = sys.argv[1:]
import vibsim.command_line.commands.export, vibsim.plots.picture
print("ready", flush=True)
for line in sys.stdin:
    done = call(*words, *line.split())
    print(done.exit_code, done.stderr.strip(), flush=True)
"""


def test_processes_that_export_at_once_publish_no_mixture(tmp_path):
    """Windows of a run, by two processes, into one file of each kind: it is that of one of them."""
    run = vibsim.simulate("II-B", trust=False, overrides={"run.t_end": "12 s"})
    spans = ("0:12", "4:6")
    for span in spans:
        run.save(tmp_path / f"{span[:2].strip(':')}.h5")
    children = [
        subprocess.Popen(
            [sys.executable, "-c", AT_ONCE, "export", f"{span[:2].strip(':')}.h5"], cwd=tmp_path, text=True,
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, env={**os.environ, "PYTHONPATH": os.getcwd()},
        )
        for span in spans
    ]  # fmt: skip

    def export(words, *children):
        """Each child exports at once with words of its own, and succeeds."""
        for child, own in zip(children, words, strict=True):
            child.stdin.write(f"{own} --force\n")
            child.stdin.flush()
        assert all(child.stdout.readline().startswith("0 ") for child in children)

    try:
        assert all(child.stdout.readline() == "ready\n" for child in children)
        for suffix in (".csv", ".parquet", ".mat"):
            alone = []
            for child, span in zip(children, spans, strict=True):
                export([f"--window {span} -o alone{suffix}"], child)
                alone.append((tmp_path / f"alone{suffix}").read_bytes())
            for _ in range(3):
                export([f"--window {span} -o both{suffix}" for span in spans], *children)
                written = (tmp_path / f"both{suffix}").read_bytes()
                # a MAT file begins with the time at which it was written
                assert written[128:] in [each[128:] for each in alone]
        export(["--ro-crate -o crate"] * 2, *children)
        assert len(names(tmp_path / "crate")) == 4
    finally:
        for child in children:
            child.stdin.close()
            child.stdout.close()
            child.wait()
    assert not [name for name in names(tmp_path) if "partial" in name]


# Files written whole: what is declared is what stands there, for us and for other readers of HDF5.


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
