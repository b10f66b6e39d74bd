"""A start that the case's decimals put exactly at the stop is there for doubles and for any digits alike."""

from dataclasses import replace

import pytest

import vibsim
from tests.engine.runs import run as run_parts
from tests.trajectories import ENGINES, run
from vibsim.engine.truth import open_truth
from vibsim.physics.parts import EVENT_NAMES

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


def case_at(place, v1, acts, tmp_path):
    x1, x2, G = PLACES[place]
    if acts == "extension":
        x1, x2 = x2, x1
    rest = G if acts == "compression" else "1"
    path = tmp_path / "at-stop.yaml"
    path.write_text(CASE.format(G=G, acts=acts, rest=rest, x1=x1, x2=x2, v1=v1))
    return vibsim.load_case(path)


def test_the_places_lie_on_both_sides():
    below, above, at = ([float(number) for number in PLACES[name]] for name in ("below", "above", "at"))
    assert below[0] - below[1] < below[2] and above[0] - above[1] > above[2] and at[0] - at[1] == at[2]


@everywhere
@both_ways
@mirrored
def test_doubles_and_digits_start_in_one_mode(place, v1, acts, tmp_path):
    case = case_at(place, v1, acts, tmp_path)
    touches = (v1 > 0) == (acts == "compression")
    *_, block = open_truth(case.exact_scene, 40).blocks()
    truth = [EVENT_NAMES[kind] for kind in block.events["kind"]]
    assert truth == ["start", "end"]
    assert block.events["contact"].tolist() == [touches] * 2
    for engine in ENGINES:
        for method in ("closed_form", "taylor"):
            doubles = run(replace(case.two_blocks(), method=method), engine)
            assert doubles.kinds == []
            assert doubles.events["contact"].tolist() == [touches] * 2
            assert doubles.totals["uncertified"] == 0
            assert doubles.totals["violations"] == 0
        parts = run_parts(case.scene(), engine)
        assert parts.events["kind"].tolist() == block.events["kind"].tolist()
        contact = parts.samples["contact"]
        assert contact.tolist() == [touches] * len(contact)
        assert parts.totals["uncertified"] == 0


def test_what_is_moved_from_the_stop_is_not_there(tmp_path):
    """A sweep that starts elsewhere from a scene made for the stop is judged by its numbers."""
    scene = replace(case_at("below", 0.1, "compression", tmp_path).two_blocks(), x1=0.25)
    for engine in ENGINES:
        assert run(scene, engine).events["contact"][0] == 0
