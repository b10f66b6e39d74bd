"""Stored truths belong to their cases, and are what a fresh computation gives."""

import json
from decimal import Decimal
from math import inf
from random import Random
from statistics import median

import pytest

import vibsim
from vibsim.cases import hard_case_names, load_case
from vibsim.engine.c_engine import CRun
from vibsim.evidence.verification.catalogue import judged_case
from vibsim.evidence.verification.checks import (
    NUMBERS,
    SCENE_UNITS,
    START,
    STATE_UNITS,
    UNIT,
    TruthError,
    kicked_scene,
    match_events,
    outside,
    reach,
    read_truth,
    run,
    truth_path,
    truths_folder,
    write_truth,
)
from vibsim.evidence.verification.hard_cases import REPORTED, hard_state_points, judged_names
from vibsim.evidence.verification.truth_making import (
    TruthPlan,
    confirm,
    form_of,
    make_truth,
    run_digits,
    states_apart,
    stored_names,
    undecided_spans,
)
from vibsim.evidence.verification.truth_making import TruthRun as DigitsRun
from vibsim.physics.precision import number_kit

ZERO = Decimal("1e-39")  # what rounding may leave of a zero among 40 digits


def case_of(name):
    return load_case(name) if name.startswith("hard/") else judged_case(name)


@pytest.mark.parametrize("name", stored_names())
def test_each_truth_is_that_of_its_case(name):
    truth = read_truth(name, case_of(name).sha256)
    assert truth.case == name
    assert truth.provenance["digits"] == 40
    assert len(truth.time) >= 11 and all(len(column) == len(truth.time) for column in truth.states.values())
    for flow, stray in truth.stray.items():
        assert set(stray) == set(truth.states)
        assert len(truth.event_stray[flow]) == len(truth.events)
    assert [t for _, t in truth.events] == sorted(t for _, t in truth.events)


def test_no_truth_is_left_over():
    stems = {truth_path(name).stem for name in stored_names()}
    assert {path.stem for path in truths_folder().glob("*.json")} == stems


def test_every_hard_case_has_a_truth_or_a_closed_form():
    closed = {"hard/a-million-seconds-linear", "hard/tiny-amplitude", "hard/conservative"}
    assert set(hard_case_names()) == set(judged_names()) | closed | {"hard/a-million-seconds", *REPORTED}


def test_a_case_that_has_changed_and_one_that_is_missing_have_no_truth():
    changed = load_case("hard/stiff-stop", {"stop.k2": "1.000001e9 N/m"})
    with pytest.raises(TruthError, match="hard/stiff-stop: the case has changed"):
        read_truth("hard/stiff-stop", changed.sha256)
    with pytest.raises(TruthError, match="hard/nothing: no truth is stored"):
        read_truth("hard/nothing", "0")


def test_a_truth_is_read_as_it_was_written(tmp_path):
    truth = read_truth("hard/release-at-the-peak", load_case("hard/release-at-the-peak").sha256)
    write_truth(truth, tmp_path / "truth.json")
    text = (tmp_path / "truth.json").read_text(encoding="utf-8")
    assert text == truth_path("hard/release-at-the-peak").read_text(encoding="utf-8")
    assert json.loads(text)["case"] == "hard/release-at-the-peak"


def run_with(*events):
    return DigitsRun([0.0], {"x1": [Decimal(1)]}, [(kind, Decimal(t)) for kind, t in events])


def test_touches_that_only_some_runs_have_are_undecided():
    touching = run_with(("stick_end", "1.0"), ("stick_begin", "1.1"), ("contact_begin", "5"))
    clear = run_with(("contact_begin", "5"))
    assert undecided_spans(touching.events, [touching]) == []
    ((low, high),) = undecided_spans(touching.events, [touching, clear])
    assert float(low) == pytest.approx(0.6) and float(high) == pytest.approx(1.5)
    assert undecided_spans(clear.events, [touching]) == [(low, high)]


def test_half_a_touch_is_no_touch():
    with pytest.raises(ValueError, match="without its counterpart"):
        undecided_spans(run_with(("contact_begin", "5")).events, [run_with()])


def test_two_runs_that_differ_make_no_truth():
    truth, other = run_with(), DigitsRun([0.0], {"x1": [Decimal("1.0000001")]}, [])
    stray = {"taylor": {"x1": [1.0]}}
    confirm("case", truth, other, stray, ([], {"taylor": []}))
    with pytest.raises(ValueError, match="case: x1: 1 is known to 1e-07 only"):
        confirm("case", truth, other, {"taylor": {"x1": [1e-14]}}, ([], {"taylor": []}))


@pytest.mark.parametrize(
    "name",
    ["hard/a-million-seconds", "hard/contact-lost-as-it-sticks", "hard/release-at-the-peak",
     "hard/separatrix-capture", "hard/stiff-stop-motor", "hard/critical-damping", "I-B-eq211"],
)  # fmt: skip
def test_a_fresh_computation_gives_the_same_truth(name):
    """State and event times to the digits stored; strays are of their size, though other signs are drawn."""
    stored, fresh = read_truth(name, case_of(name).sha256), make_truth(name)
    for column, values in stored.states.items():
        for value, again in zip(values, fresh.states[column], strict=True):
            assert abs(value - again) <= max(abs(value) * Decimal("1e-23"), ZERO), column
    for (kind, t), (kind_again, again) in zip(stored.events, fresh.events, strict=True):
        assert kind == kind_again and abs(t - again) <= t * Decimal("1e-23")
    assert len(stored.undecided) == len(fresh.undecided)
    for flow, strays in stored.stray.items():
        pairs = [zip(fresh.stray[flow][column], values, strict=True) for column, values in strays.items()]
        ratios = [one / other for of_column in pairs for one, other in of_column if other > 1e-25]
        assert 0.5 < median(ratios) < 2, flow


@pytest.mark.parametrize("name", judged_names())
def test_hard_cases_are_compared_to_their_end(name):
    """No instant is left out for chaos."""
    truth = read_truth(name, case_of(name).sha256)
    for flow in truth.stray:
        points = list(hard_state_points(truth, run(case_of(name), flow), flow))
        assert len(points) == len(truth.states) * len(truth.time)


# Kicks have the size of the rounding that they stand for, and spare what is exact.


@pytest.fixture
def kit():
    return number_kit(30)


def relative(kit, kicked, value):
    """Size of a kick in units of round-off, with its sign."""
    return float((kicked - value) / (value * kit.number(UNIT)))


@pytest.mark.parametrize("name", ["I-A", "II-B", "hard/contact-lost-as-it-sticks"])
def test_every_number_of_a_scene_is_kicked(kit, name):
    scene = vibsim.load_case(name).exact_two_blocks(kit.number, kit.pi)
    kicked = kicked_scene(scene, kit, Random(1))
    signs = []
    for field in NUMBERS + START:
        value, moved = getattr(scene, field), getattr(kicked, field)
        if value is None or value == 0:
            assert moved is None or moved == 0
        else:
            signs.append(relative(kit, moved, value))
            assert abs(signs[-1]) == pytest.approx(SCENE_UNITS, rel=1e-9)
    assert min(signs) < 0 < max(signs)
    assert (kicked.cycles, kicked.t_end) == (scene.cycles, scene.t_end)


def test_states_are_kicked_by_the_size_of_the_motion():
    """Displacements by the size of the largest, velocities likewise, the phase by that of a radian; what is
    exactly 0 stays. The first sample is of the state that the flow begins with.
    """
    start = {"x1": "3 m", "x2": "2 m", "v1": "-4 m/s", "phi": "0.5 rad", "phidot": "9 rad/s"}
    case = vibsim.load_case("II-B", {f"initial.{name}": value for name, value in start.items()})
    form, firsts = form_of(30), []
    parts = case.exact_two_blocks(form.kit.number, form.kit.pi).as_parts()
    for seed in (0, *range(1, 9)):
        samples, *_ = next(CRun(parts, form=form, kick=seed).blocks())
        firsts.append(list(form.all_taken(samples[1:, 0])))
    plain, *kicked = firsts
    for i, size in enumerate((3, 4, 3, 0, 1, 9)):  # x1, v1, x2, v2, phi, phidot
        kicks = [float(one[i] - plain[i]) / (STATE_UNITS * UNIT) for one in kicked]
        assert all(abs(kick) == pytest.approx(size, rel=1e-9) for kick in kicks)
        assert not size or min(kicks) < 0 < max(kicks)
    assert len(set(map(str, kicked))) > 4


def test_stray_is_what_conditioning_says(kit):
    """A block that slides and stops: x2 at rest is v0^2 / (2 mu g), so it strays by 5 numbers of 4 units each
    at most, and by the 16 of the state twice over.
    """
    alone = {"stop": "none", "excitation": "none", "k1": "0 N/m", "c": "0 N s/m"}
    case = vibsim.load_case("I-A", {**alone, "v2": "0.05 m/s", "run.t_end": "10 s", "run.every": "1 s"})
    how = TruthPlan(case, 1)
    truth = run_digits(how, "closed_form", 40)
    way = 0.05**2 / (2 * 0.001 * 9.81)
    assert float(truth.states["x2"][-1]) == pytest.approx(way, rel=1e-15)
    strays = [
        states_apart(truth, [run_digits(how, "closed_form", 30, seed)])["x2"][-1] / (way * UNIT)
        for seed in range(6)
    ]
    assert max(strays) <= 5 * SCENE_UNITS + 3 * STATE_UNITS
    assert sum(stray > 1 for stray in strays) >= 5  # of 6: all may cancel in one
    assert len(set(strays)) > 1


# Missed and spurious events are told from those that are only late.


WITHIN = 0.1


def events(text):
    """ "a1 b2.5" -> [("a", 1), ("b", 2.5)]."""
    return [(word[0], Decimal(word[1:])) for word in text.split()]


@pytest.mark.parametrize(
    ("truth", "run", "pairs", "missed", "spurious"),
    [
        ("a1 b2 a3", "a1.05 b1.95 a3", [(0, 0), (1, 1), (2, 2)], [], []),
        ("a1 a2 a3", "a1 a3", [(0, 0), (2, 1)], [1], []),
        ("a1 a3", "a1 a2 a3", [(0, 0), (1, 2)], [], [1]),
        ("a1 a2", "a1 a2.2", [(0, 0)], [1], [1]),  # one too late
        ("a1", "b1", [], [0], [0]),  # another kind at the same time
        ("a1 b1", "b1.01 a1.02", [(0, 1), (1, 0)], [], []),  # two at one instant have no order
        (
            "a1 a2 a3 a4 a5",
            "a2 a3 a4 a5 a6",
            [(1, 0), (2, 1), (3, 2), (4, 3)],
            [0],
            [4],
        ),  # a miss shifts none
    ],
)
def test_missed_and_spurious_events(truth, run, pairs, missed, spurious):
    truth = events(truth)
    matching = match_events(truth, [WITHIN] * len(truth), events(run))
    assert (matching.pairs, matching.missed, matching.spurious) == (pairs, missed, spurious)


def test_reach_is_half_way_to_the_next_of_a_kind():
    assert reach(events("a1 b2 a5 a6 b9")) == [2.0, 3.5, 0.5, 0.5, 3.5]
    assert reach(events("a1 b2")) == [inf, inf]


def test_what_is_undecided_is_left_out():
    windows = [(Decimal("1.5"), Decimal("2.5"))]
    assert outside(events("a1 a2 b2.5 a3"), windows) == events("a1 a3")
