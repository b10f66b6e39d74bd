"""A file of every kind with any part of its structure damaged: one line that names the part, no traceback."""

import json
import os
import shutil
from pathlib import Path

import h5py
import numpy as np
import pytest

import vibsim
from tests.command_line.made import told
from tests.results.damages import OF_ATTRIBUTES, OF_DATASETS, damage_attribute, datasets
from tests.results.made import short_case
from vibsim.evidence.benchmark.bench_result import ATTRIBUTES as OF_BENCH
from vibsim.fitting import fit
from vibsim.fitting.fit_result import FitStore
from vibsim.fitting.plan import ATTRIBUTES as OF_FIT
from vibsim.orbits.branches.branch import BranchStore
from vibsim.orbits.branches.curve import ATTRIBUTES as OF_BRANCH
from vibsim.orbits.branches.curve import LOCUS_ATTRIBUTES as OF_LOCUS
from vibsim.orbits.branches.locus_result import LocusStore
from vibsim.results import ResultFileError
from vibsim.results.hdf5_reading import damage_named
from vibsim.results.trajectory_file import ATTRIBUTES as OF_TRAJECTORY
from vibsim.sweeps import sweep
from vibsim.sweeps.sweep_file import ATTRIBUTES as OF_SWEEP
from vibsim.sweeps.sweep_file import SweepStore

ATTRIBUTES = {
    **dict.fromkeys(("run", "digits", "orbit"), OF_TRAJECTORY),
    "sweep": OF_SWEEP,
    "bench": OF_BENCH,
    "fit": OF_FIT,
    "branch": OF_BRANCH,
    "locus": OF_LOCUS,
}
NOT_READ = {"digits": {"digits/events/event"}, "bench": {"row", "time", "kind"}, "sweep": {"section"}}

SHARE = 4  # of the names each damage is done to one; `make fuzz` draws from all


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A file of every kind."""
    folder = tmp_path_factory.mktemp("whole")
    vibsim.simulate(short_case("II-B", "1 s")).save(folder / "run.h5")
    vibsim.simulate(short_case("I-A", "0.1 s"), digits=20).save(folder / "digits.h5")
    sweep(short_case("II-B", "1 s"), {"Omega0": "3, 4, 5 Hz"}, section=3, jobs=1, out=folder / "sweep.h5")
    statements = ["impacts at most 0", "mean speed at least 1 Hz"]
    search = {"ensemble": 1, "candidates": 4, "confirm": 1, "fresh": 1, "jobs": 1, "out": folder / "fit.h5"}
    fit([short_case("II-B", "1 s")], {"J": "1:2 g m^2"}, statements, readings=["c=0.01 N s/m"], **search)
    captured = vibsim.orbit("II-B", {"c": "0.03 N s/m", "Omega0": "5.7 Hz"})
    captured.save(folder / "orbit.h5")
    omega0 = vibsim.continue_branch(captured, "excitation.Omega0", "5.6:5.8 Hz", out=folder / "branch.h5")
    vibsim.continue_locus(omega0, {"c": "0.028:0.032"}, label="F1", max_points=3, out=folder / "locus.h5")
    told("bench", "I-A", "--t-end", "0.5s", "--methods", "taylor", "-o", folder / "bench.h5")
    return {name: folder / f"{name}.h5" for name in ATTRIBUTES}


def read(path):
    """Everything that is in a file."""
    result = vibsim.open_result(path)
    for name in result.keys():  # noqa: SIM118 - a bench has keys and is no mapping
        result[name]
    for name in getattr(result, "events", ()):
        result.events[name]
    if getattr(result, "digits", None):
        for table in (result.digits, result.digits.events):
            for name in table:
                table[name]
    return result


def refusal(path):
    with pytest.raises(ResultFileError) as caught:
        read(path)
    line = str(caught.value)
    assert line.startswith(f"{path}: damaged: ") and "\n" not in line
    return line.removeprefix(f"{path}: damaged: ")


@pytest.mark.parametrize("kind", ATTRIBUTES)
@pytest.mark.parametrize("damage", OF_DATASETS, ids=lambda damage: damage.__name__)
def test_damaged_datasets(whole, tmp_path, kind, damage):
    names = [name for name in datasets(whole[kind]) if name not in NOT_READ.get(kind, ())]
    for name in names[OF_DATASETS.index(damage) % SHARE :: SHARE]:
        path = shutil.copy(whole[kind], tmp_path / "copy.h5")
        with h5py.File(path, "r+") as file:
            same = damage.__name__ == "text" and h5py.check_string_dtype(file[name].dtype)
            if not same:
                damage(file, name)
        if not same:
            assert name.rpartition("/")[2] in refusal(path) or damage.__name__ == "one_too_few", name


@pytest.mark.parametrize("kind", ATTRIBUTES)
@pytest.mark.parametrize("damage", OF_ATTRIBUTES)
def test_damaged_attributes(whole, tmp_path, kind, damage):
    with h5py.File(whole[kind]) as file:
        needed = [each.name for each in ATTRIBUTES[kind] if not each.optional]
        there = [each.name for each in ATTRIBUTES[kind] if each.name in file.attrs]
    names = needed if damage == "gone" else there
    for name in names[list(OF_ATTRIBUTES).index(damage) % SHARE :: SHARE]:
        path = shutil.copy(whole[kind], tmp_path / "copy.h5")
        with h5py.File(path, "r+") as file:
            damage_attribute(file, name, OF_ATTRIBUTES[damage])
        assert name in refusal(path)


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [("x1", np.nan, "x1 has the value nan"), ("v2", np.inf, "v2 has the value inf"), ("time", 0.5, None),
     ("time", -1.0, "time has the value -1"), ("contact", 100, "contact has the value 100; allowed: 0, 1"),
     ("friction", -128, "friction has the value -128; allowed: -1, 0, 1"),
     ("events/t", -1e300, "events/t has the value -1e+300"), ("events/t", 2.0, "events/t has the value 2"),
     ("events/kind", 99, "events/kind has the value 99; allowed: 0, 1, 2, 3, 4, 5, 6, 7, 8"),
     ("events/contact", 100, "events/contact has the value 100; allowed: 0, 1"),
     ("events/phase", np.nan, "events/phase has the value nan")],
)  # fmt: skip
def test_numbers_that_cannot_be_right(whole, tmp_path, name, value, said):
    path = shutil.copy(whole["run"], tmp_path / "copy.h5")
    with h5py.File(path, "r+") as file:
        file[name][:] = value
    if said is None:
        read(path)
    else:
        assert refusal(path) == said


@pytest.mark.parametrize("kind", [kind for kind in ATTRIBUTES if kind != "bench"])
def test_an_engine_that_there_is_not(whole, tmp_path, kind):
    path = shutil.copy(whole[kind], tmp_path / "copy.h5")
    with h5py.File(path, "r+") as file:
        file.attrs["engine"] = "steam"
    with pytest.raises(ResultFileError, match="the attribute engine is steam; allowed: c, python"):
        vibsim.open_result(path)


def test_times_that_go_back(whole, tmp_path):
    path = shutil.copy(whole["run"], tmp_path / "copy.h5")
    with h5py.File(path, "r+") as file:
        file["time"][:] = file["time"][:][::-1]
    assert refusal(path) == "time does not ascend"


def test_digits_that_are_none(whole, tmp_path):
    path = shutil.copy(whole["digits"], tmp_path / "copy.h5")
    with h5py.File(path, "r+") as file:
        file["digits/x1"][0] = "\u00e9".encode()
    assert refusal(path) == "digits/x1 has a text that is no number"


SETTINGS = {
    "sweep": [
        {"axes": []}, {"axes": {"key": "excitation.Omega0"}}, {"section": 10**15}, {"section": -1},
        {"axes": [{"key": "excitation.Omega0", "unit": "Hz", "from": "3", "step": "1", "count": 10**15}]},
        {"axes": [{"key": "nothing", "unit": "Hz", "values": ["3", "4", "5"]}]},
        {"axes": [{"key": "excitation.Omega0", "unit": "mm", "values": ["3", "4", "5"]}]},
        {"axes": [{"key": "excitation.Omega0", "unit": "Hz", "values": ["3", "4", "1e999999999"]}]},
        {"axes": [{"key": "excitation.Omega0", "unit": "Hz", "values": ["3", "4", "6"]}]},
        {"direction": ["sideways"]}, {"every": "soon"}, {"compute": ["nothing"]}, {"discard": 7},
    ],
    "fit": [
        {"free": []}, {"free": [{"key": "nothing"}]}, {"statements": []}, {"statements": ["II-B: flies"]},
        {"readings": [{"nothing": "3"}]}, {"starts": None}, {"starts": {"count": 10**12}},
        {"search": {"method": "by luck"}}, {"search": None}, {"fitting": -1},
    ],
}  # fmt: skip


@pytest.mark.parametrize(("kind", "change"), [(kind, each) for kind in SETTINGS for each in SETTINGS[kind]])
def test_settings_that_are_damaged(whole, tmp_path, kind, change):
    path, name = shutil.copy(whole[kind], tmp_path / "copy.h5"), f"{kind}_settings_json"
    with h5py.File(path, "r+") as file:
        file.attrs[name] = json.dumps(json.loads(file.attrs[name]) | change)
    assert kind == "sweep" or refusal(path).startswith(f"the attribute {name}")
    assert refusal(path)


@pytest.mark.parametrize(
    "text", ["", "null", '{"a": "b"}', '{"coupling.c": "-3 N s/m"}', '{"coupling.c": null}']
)
def test_a_fit_whose_changes_are_damaged(whole, tmp_path, text):
    path = shutil.copy(whole["fit"], tmp_path / "copy.h5")
    with h5py.File(path, "r+") as file:
        file["changes"][1] = text
    assert refusal(path) == "changes has values that its cases do not take"


@pytest.mark.parametrize("kind", ATTRIBUTES)
@pytest.mark.parametrize("value", ["", "{}", "[" * 100_000, '{"vibsim_case": 1, "blocks": 3}'])
def test_a_case_that_is_none(whole, tmp_path, kind, value):
    if len(value) > 60_000:
        value = value[:60_000]  # attributes hold no more
    path = shutil.copy(whole[kind], tmp_path / "copy.h5")
    with h5py.File(path, "r+") as file:
        file.attrs["case_resolved_json"] = value
    assert refusal(path).startswith("the attribute case_resolved_json")


def test_a_pipe_is_no_result_file(tmp_path):
    os.mkfifo(tmp_path / "pipe.h5")
    with pytest.raises(ResultFileError, match="is not a regular file"):
        vibsim.open_result(tmp_path / "pipe.h5")


STORES = {"sweep": SweepStore, "fit": FitStore, "branch": BranchStore, "locus": LocusStore}


@pytest.mark.parametrize("kind", STORES)
def test_what_cannot_be_gone_on_from_is_named_as_it_was_typed(whole, here, kind):
    Path("a.h5").write_bytes(whole[kind].read_bytes()[:-100])
    plan = vibsim.open_result(whole[kind]).plan
    with pytest.raises(ResultFileError, match=r"^a\.h5: is truncated"):
        STORES[kind](plan, "a.h5")
    shutil.copy(whole[kind], "a.h5")
    with h5py.File("a.h5", "r+") as file:
        file.attrs["vibsim_format"] = 1000
    with pytest.raises(ResultFileError, match=r"^a\.h5: has format 1000, written by vibsim"):
        STORES[kind](plan, "a.h5")
    assert [each.name for each in Path().iterdir()] == ["a.h5"]


def test_words_of_hdf5_stand_without_quotes():
    with pytest.raises(ResultFileError) as caught, damage_named(Path("a.h5")):
        raise KeyError("bad object header")
    assert str(caught.value) == "a.h5: damaged: bad object header"


TEXT_TYPE = b"\x19\x01\x01\x00\x10\x00\x00\x00"  # of variable length, in UTF-8: class and version, kind, size


@pytest.mark.parametrize("name", ["run", "sweep", "branch"])
@pytest.mark.parametrize("kind", [0x00, 0x2B])
def test_a_text_whose_type_has_lost_a_byte_is_not_read(whole, tmp_path, name, kind):
    """As a list of unknown things of unknown length, of which HDF5 takes any bytes for addresses."""
    data, path = whole[name].read_bytes(), tmp_path / "damaged.h5"
    for attribute in ("case_yaml", "platform"):
        at = data.index(TEXT_TYPE, data.index(attribute.encode() + b"\0"))
        path.write_bytes(data[: at + 1] + bytes([kind]) + data[at + 2 :])
        with pytest.raises(ResultFileError, match=f"damaged: the attribute {attribute} is missing"):
            vibsim.open_result(path)
