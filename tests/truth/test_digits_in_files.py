"""The digits of a run: in memory, in its file, and for programs that read the file."""

from dataclasses import replace
from decimal import Decimal
from fractions import Fraction

import h5py
import numpy as np
import pytest
import xarray

import vibsim
from tests.command_line.made import call, told
from tests.engine.runs import run
from tests.truth.made import case
from vibsim.command_line.commands import run as command
from vibsim.engine.truth import open_truth
from vibsim.physics import precision
from vibsim.physics.parts import EVENT_NAMES
from vibsim.results import simulate_to_file


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    """The file of a run of 40 digits by `vibsim run`."""
    path = tmp_path_factory.mktemp("truth") / "II-B.h5"
    shown = told("run", "II-B", "--digits", 40, "--t-end", "3 s", "-o", path)
    assert "digits          40 carried, 3" in shown
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
    assert attrs["number_library"].startswith("vibsim ")
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
    short = case("I-A", "20 s", every="10 ms")
    result = simulate_to_file(short, tmp_path / "cut.h5", digits=30, watch=lambda t: t < 2)
    assert not result.complete and "digits_right" not in result.attrs
    assert 2 <= result.t_reached < 20
    assert len(result.digits["x1"]) == len(result["x1"]) > 0


# --digits on the command line: what it refuses, and how.


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--digits", "0"], "0 is not in the range 20 to 1000"),
        (["--digits", "-5"], "-5 is not in the range 20 to 1000"),
        (["--digits", "5000"], "5000 is not in the range 20 to 1000"),
        (["--digits", "many"], "must be a whole number or auto, got 'many'"),
    ],
)
def test_wrong_usage(words, message, tmp_path):
    done = call("run", "I-A", "-o", tmp_path / "out.h5", *words)
    assert done.exit_code == 2
    assert message in done.stderr
    assert not list(tmp_path.iterdir())


def test_a_missing_engine_is_named(monkeypatch, tmp_path):
    for module in (precision, command):
        monkeypatch.setattr(module, "is_built", lambda words: False)
    done = call("run", "I-A", "--digits", "60", "-o", tmp_path / "out.h5")
    assert done.exit_code == 2
    assert "which was not built here" in done.stderr
    with pytest.raises(ImportError, match="not built here"):
        vibsim.simulate(case("I-A", "1 s"), digits=30)


def test_simulate_refuses_too():
    with pytest.raises(ValueError, match="20 to 1000"):
        vibsim.simulate(case("I-A", "1 s"), digits=10)


def test_method_taylor_is_obeyed(tmp_path):
    path = tmp_path / "out.h5"
    words = ["run", "I-A", "--digits", "30", "--method", "taylor", "--t-end", "0.5 s", "-o", path]
    shown = told(*words)
    assert "C on 128-bit numbers, taylor series of order 36" in shown
    assert vibsim.open_result(path).attrs["method"] == "taylor"


# A start that the case's decimals put exactly at the stop is there for doubles and for any digits alike.


CASE = """
name: at-stop
blocks: {{m1: 1 kg, m2: 2 kg}}
coupling: {{k1: 10 N/m}}
stop: {{k2: 1000 N/m, G: {G} m, acts: {acts}}}
rest_distance: {{value: {rest} m}}
initial: {{x1: {x1} m, v1: {v1} m/s, x2: {x2} m}}
run: {{t_end: 10 ms, every: 1 ms}}
"""
# the doubles of these lie below, above and at the stop
PLACES = {"below": ("0.3", "0.2", "0.1"), "above": ("0.8", "0.7", "0.1"), "at": ("0.5", "0.25", "0.25")}
everywhere = pytest.mark.parametrize("place", PLACES)
both_ways = pytest.mark.parametrize("v1", [0.1, -0.1])
mirrored = pytest.mark.parametrize("acts", ["compression", "extension"])


def case_at(place, v1, acts):
    x1, x2, G = PLACES[place]
    if acts == "extension":
        x1, x2 = x2, x1
    rest = G if acts == "compression" else "1"
    return vibsim.load_case(CASE.format(G=G, acts=acts, rest=rest, x1=x1, x2=x2, v1=v1))


def test_the_places_lie_on_both_sides():
    below, above, at = ([float(number) for number in PLACES[name]] for name in ("below", "above", "at"))
    assert below[0] - below[1] < below[2] and above[0] - above[1] > above[2] and at[0] - at[1] == at[2]


@everywhere
@both_ways
@mirrored
def test_doubles_and_digits_start_in_one_mode(place, v1, acts):
    case = case_at(place, v1, acts)
    touches = (v1 > 0) == (acts == "compression")
    *_, block = open_truth(case.exact_scene, 40).blocks()
    truth = [EVENT_NAMES[kind] for kind in block.events["kind"]]
    assert truth == ["start", "end"]
    assert block.events["contact"].tolist() == [touches] * 2
    for method in ("closed_form", "taylor"):
        doubles = run(replace(case.two_blocks(), method=method))
        assert doubles.kinds == []
        assert doubles.events["contact"].tolist() == [touches] * 2
        assert doubles.totals["uncertified"] == 0
        assert doubles.totals["violations"] == 0
    parts = run(case.scene())
    assert parts.events["kind"].tolist() == block.events["kind"].tolist()
    contact = parts.samples["contact"]
    assert contact.tolist() == [touches] * len(contact)
    assert parts.totals["uncertified"] == 0


def test_what_is_moved_from_the_stop_is_not_there():
    """A sweep that starts elsewhere from a scene made for the stop is judged by its numbers."""
    scene = replace(case_at("below", 0.1, "compression").two_blocks(), x1=0.25)
    assert run(scene).events["contact"][0] == 0


# The span of a run with digits is the decimal that the case says; its samples are those of doubles.


@pytest.mark.parametrize(
    ("t_end", "every", "exact"),
    [
        ("0.1 s", "0.1 s", Fraction(1, 10)),  # the nearest double lies above
        ("0.3 s", "0.1 s", Fraction(3, 10)),  # and below
        ("0.7 s", "0.1 s", Fraction(7, 10)),
        ("1.1 s", "10 ms", Fraction(11, 10)),
    ],
)
def test_the_end_is_the_decimal(t_end, every, exact):
    case = vibsim.load_case("I-A", {"run.t_end": t_end, "run.every": every})
    run, doubles = vibsim.simulate(case, digits=40), vibsim.simulate(case)
    end = Fraction(run.digits.events["t"][-1])
    assert abs(end - exact) < Fraction(1, 10**39)
    assert run.t_reached == float(exact) == doubles.t_reached == doubles.events["t"][-1]
    np.testing.assert_array_equal(run.time, doubles.time)
    np.testing.assert_allclose(run["x1"], doubles["x1"], rtol=0, atol=1e-16)
