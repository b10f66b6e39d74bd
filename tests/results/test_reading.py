"""What is not a result file of this vibsim is refused in one line that says why."""

import json
import re
import shutil
from dataclasses import dataclass, field
from fractions import Fraction
from typing import NamedTuple

import h5py
import numpy as np
import pytest

import vibsim
from tests.results.made import short_case, short_run
from vibsim.orbits.branches.correction import Pace
from vibsim.results import ResultFileError, is_result_file, kind_of
from vibsim.results.store import BESIDE, from_plain, plain_data, stored
from vibsim.sweeps.axes import Axis, Members, Spread, axis_from_plain


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


DOUBT = '{"time_s": 0.5, "events": ["contact at stop"], "reason": "rounding hides it"}'


def test_doubts_are_read_where_the_file_tells_of_them(copy):
    """An older version counted them only."""
    change(copy, uncertified=1, certified=0, first_uncertified_time=0.5)
    assert vibsim.open_result(copy).doubts == []
    (doubt,) = vibsim.open_result(change(copy, doubts_json=f"[{DOUBT}]")).doubts
    assert doubt == (0.5, ("contact at stop",), "rounding hides it")


@pytest.mark.parametrize(
    "text", ["", "{}7", "5", "[5]", "[" * 100000, f"[{DOUBT}]".replace("0.5", "NaN"), '[{"time_s": 0.5}]']
)
def test_doubts_that_are_none(copy, text):
    said = "damaged: the attribute doubts_json does not describe doubts"
    assert refusal(change(copy, doubts_json=text)) == said


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (None, "No such file or directory"),
        (b"", "is empty"),
        (b"name: II-B\n", "is not an HDF5 file"),
        (b"\x89HDF\r\n\x1a\n", "damaged|is truncated"),  # a signature alone
    ],
)
def test_what_is_no_file_of_ours(tmp_path, content, said):
    if content is not None:
        (tmp_path / "a.h5").write_bytes(content)
    assert re.match(said, refusal(tmp_path / "a.h5"))
    assert refusal(tmp_path) == "Is a directory"


def test_foreign_hdf5(tmp_path):
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["x1"] = np.zeros(3)
    assert refusal(tmp_path / "a.h5") == "is an HDF5 file, but not one that vibsim wrote"


@pytest.mark.parametrize("part", [0.02, 0.3, 0.9, 0.999])
def test_truncated(copy, part):
    with open(copy, "r+b") as file:
        file.truncate(int(part * copy.stat().st_size))
    assert refusal(copy) == "is truncated: it ends before the end that it names"


def test_of_a_newer_format(copy):
    change(copy, vibsim_format=2, vibsim_version="9.9")
    ours = f"this is vibsim {vibsim.__version__}, which reads up to 1"
    assert refusal(copy) == f"has format 2, written by vibsim 9.9; {ours}"


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


# The Python interface of a trajectory.


CASES = ["I-A", "I-B", "II-B"]


def test_columns_by_name():
    result = short_run("II-B")
    names = ["time", "x1", "v1", "x2", "v2", "phi", "phidot", "contact", "friction", "error_estimate"]
    assert result.keys() == names
    assert list(result) == result.keys()
    assert len(result) == 1001 == len(result.time)
    assert np.array_equal(result.time, np.arange(1001) * 5 / 1000)
    assert result["contact"].dtype == result["friction"].dtype == np.int8
    assert list(result.events)[:2] == ["t", "kind"]
    assert result.events["kind"][[0, -1]].tolist() == [0, 8]


def test_the_case_and_the_trust_horizon():
    result = short_run("II-B")
    assert result.case.sha256 == short_case("II-B").sha256
    assert result.trust_horizon == 5
    assert vibsim.simulate(short_case("II-B"), trust=False).trust_horizon is None
    assert "II-B: 0 to 5 s, 1001 samples" in repr(result)


@pytest.mark.parametrize("name", CASES)
def test_states_at_the_samples_are_the_samples(name):
    result = short_run(name)
    found = result.at(result.time)
    for column in found:
        assert found[column].tobytes() == result[column].tobytes()


@pytest.mark.parametrize("name", CASES)
def test_states_between_the_samples_are_those_of_a_run_with_more_samples(name):
    fine = short_run(name, run__every="1 ms")
    found = short_run(name).at(fine.time)
    for column in found:
        assert found[column].tobytes() == fine[column].tobytes()


def test_times_in_any_shape_and_order():
    result = short_run("II-B")
    times = np.array([[4.0, 0.0, 2.5], [5.0, 2.5, 1e-9]])
    found = result.at(times)
    assert found["x1"].shape == (2, 3)
    for place in np.ndindex(2, 3):
        one = result.at(times[place])
        assert one["x1"].shape == ()
        assert {name: one[name].item() for name in one} == {name: found[name][place] for name in found}
    assert result.at([])["x1"].shape == (0,)


@pytest.mark.parametrize("t", [-1e-9, 5.0001, np.nan, np.inf])
def test_times_outside_the_run(t):
    with pytest.raises(ValueError, match="between 0 and 5 s"):
        short_run().at([1.0, t])


def test_a_saved_result_answers_the_same(tmp_path):
    result = short_run("II-B")
    again = vibsim.open_result(result.save(tmp_path / "a.h5"))
    assert again.case.sha256 == result.case.sha256
    assert again.at(3.21) == result.at(3.21)
    assert again.attrs == result.attrs
    assert again.keys() == result.keys()
    assert list(again.events) == list(result.events)


def test_a_case_read_back_from_a_file_runs_bit_for_bit_the_same(tmp_path):
    result = short_run("II-B", excitation__Omega0="6.5 Hz")
    case = vibsim.open_result(result.save(tmp_path / "a.h5")).case
    again = vibsim.simulate(case)
    for name in result:
        assert again[name].tobytes() == result[name].tobytes()


def test_violations_are_counted_and_may_stop_the_run():
    limits = {"rest_distance__value": "1 mm"}
    warned = short_run(t_end="20 s", rest_distance__on_violation="warn", **limits)
    assert warned.attrs["violations"] > 0
    assert warned.t_reached == 20
    first = warned.attrs["first_violation_time"]
    assert first == warned.events["t"][warned.events["kind"] == 6][0]
    stopped = short_run(t_end="20 s", rest_distance__on_violation="stop", **limits)
    assert stopped.complete
    assert stopped.t_reached == first
    assert stopped.attrs["rest_distance_needed"] == pytest.approx(1e-3, rel=1e-6)
    assert warned.attrs["rest_distance_needed"] > 1e-3


# Plans and records as plain data: through JSON and back, every type that there is, by names of files.


class Pair(NamedTuple):
    first: float
    second: int


@dataclass(frozen=True)
class Inner:
    case: str = field(metadata=BESIDE)
    word: tuple[tuple[str, int], ...]
    pairs: tuple[complex, ...] = ()


def _spelled(ways):
    return "".join(map(str, ways))


def _ways(text):
    return tuple(map(int, text))


@dataclass(frozen=True)
class Outer:
    number: int
    inner: "Inner"
    share: Fraction | None
    pace: Pair
    texts: dict[str, str] = field(default_factory=dict)
    arrays: dict[str, np.ndarray] = field(default_factory=dict)
    span: tuple[float, float] = field(default=(0.0, 1.0), metadata=stored("range"))
    ways: tuple[int, ...] = field(default=(1,), metadata=stored("directions", _spelled, _ways))


INNER = Inner("here", (("impact", 0), ("reversal", 1)), (1 + 2j, -0.5j))
ARRAYS = {"x": np.array([1.5, -0.0, np.inf])}
WHOLE = Outer(3, INNER, Fraction(1, 3), Pair(0.1, 2), {"a": "b"}, ARRAYS, (2.0, float("inf")), (1, 2))
PLAIN = {
    "number": 3,
    "inner": {"word": [["impact", 0], ["reversal", 1]], "pairs": [[1.0, 2.0], [-0.0, -0.5]]},
    "share": "1/3",
    "pace": [0.1, 2],
    "texts": {"a": "b"},
    "arrays": {"x": "000000000000f83f0000000000000080000000000000f07f"},
    "range": [2.0, float("inf")],
    "directions": "12",
}


def test_every_type_has_its_plain_form():
    assert plain_data(WHOLE) == PLAIN and list(plain_data(WHOLE)) == list(PLAIN)


def test_what_is_read_back_is_the_same_to_the_bit():
    read = from_plain(Outer, json.loads(json.dumps(plain_data(WHOLE))), case="here")
    assert read.arrays["x"].tobytes() == WHOLE.arrays["x"].tobytes()
    assert plain_data(read) == plain_data(WHOLE) and read.inner == WHOLE.inner and read.share == WHOLE.share
    assert isinstance(read.pace, Pair) and read.span == WHOLE.span and read.ways == WHOLE.ways


def test_a_field_without_data_has_its_default():
    read = from_plain(Outer, {name: PLAIN[name] for name in ("number", "inner", "share", "pace")}, case="")
    assert (read.texts, read.span, read.ways) == ({}, (0.0, 1.0), (1,))


@pytest.mark.parametrize(
    "change",
    [{"number": "three"}, {"number": None}, {"inner": {"word": [["impact"]]}}, {"inner": {"word": [[0, 1]]}},
     {"inner": []}, {"share": "1/0"}, {"pace": [0.1]}, {"pace": [0.1, 2, 3]}, {"range": [2.0]},
     {"range": 2.0}, {"arrays": {"x": "xyz"}}],
)  # fmt: skip
def test_data_of_another_kind_are_refused(change):
    with pytest.raises((AttributeError, LookupError, TypeError, ValueError)):
        from_plain(Outer, PLAIN | change, case="here")


def test_axes_of_sweeps_are_told_apart():
    axis = Axis("excitation.Omega0", "Hz", (Fraction(3), Fraction(7, 2)), ("c",))
    spread = Spread("initial.x1", "mm", "uniform", Fraction(0), Fraction(1, 10))
    for each in (axis, Members(5, 2, (spread,), first=3)):
        data = each.plain() if isinstance(each, Axis) else plain_data(each)
        assert axis_from_plain(json.loads(json.dumps(data))) == each
    spreads = [{"key": "initial.x1", "unit": "mm", "shape": "uniform", "centre": "0", "width": "0.1"}]
    assert data == {"key": "member", "count": 5, "first": 3, "seed": 2, "spread": spreads}


def test_the_bounds_of_the_step_are_a_list():
    @dataclass(frozen=True)
    class Plan:
        pace: Pace

    assert plain_data(Plan(Pace(1e-2, 1e-9, 0.5))) == {"pace": [1e-2, 1e-9, 0.5]}
    assert from_plain(Plan, {"pace": [1e-2, 1e-9, 0.5]}).pace == Pace(1e-2, 1e-9, 0.5)


# The lines that tell of a run.


def test_one_is_no_plural():
    result = vibsim.simulate("II-B", overrides={"Omega0": "6.5 Hz", "run.t_end": "20 s"})
    assert result.attrs["sticks"] == 1
    assert dict(result.lines())["motion"] == f"{result.attrs['impacts']} impacts, 1 stick phase"
