"""Stored truths belong to their cases, and are what a fresh computation gives."""

import json
from decimal import Decimal

import pytest

from vibsim.cases import hard_case_names, load_case
from vibsim.evidence.verification.catalogue import judged_case
from vibsim.evidence.verification.checks import (
    TruthError,
    read_truth,
    run,
    truth_path,
    truths_folder,
    write_truth,
)
from vibsim.evidence.verification.hard_cases import REPORTED, hard_state_points, judged_names
from vibsim.evidence.verification.truth_making import TruthRun as DigitsRun
from vibsim.evidence.verification.truth_making import confirm, make_truth, stored_names, undecided_spans

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
    assert {path.stem for path in truths_folder().glob("*.json")} == {
        truth_path(name).stem for name in stored_names()
    }


def test_every_hard_case_has_a_truth_or_a_closed_form():
    closed = {"hard/a-million-seconds-linear", "hard/tiny-amplitude", "hard/conservative"}
    assert set(hard_case_names()) == set(judged_names()) | closed | {"hard/a-million-seconds", *REPORTED}


def test_a_case_that_has_changed_has_no_truth():
    changed = load_case("hard/stiff-stop", {"stop.k2": "1.000001e9 N/m"})
    with pytest.raises(TruthError, match="hard/stiff-stop: the case has changed"):
        read_truth("hard/stiff-stop", changed.sha256)


def test_a_truth_that_is_missing_is_named():
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


@pytest.mark.slow
@pytest.mark.timeout(600)
@pytest.mark.parametrize(
    "name",
    [
        "hard/a-million-seconds",
        "hard/contact-lost-as-it-sticks",
        "hard/release-at-the-peak",
        "hard/separatrix-capture",
        "hard/stiff-stop-motor",
        "hard/critical-damping",
        "I-B-eq211",
    ],
)
def test_a_fresh_computation_gives_the_same_truth(name):
    """State and event times to the digits stored; strays too: kicks are seeded."""
    stored, fresh = read_truth(name, case_of(name).sha256), make_truth(name)
    for column, values in stored.states.items():
        for value, again in zip(values, fresh.states[column], strict=True):
            assert abs(value - again) <= max(abs(value) * Decimal("1e-23"), ZERO), column
    assert [kind for kind, _ in stored.events] == [kind for kind, _ in fresh.events]
    assert all(
        abs(t - again) <= t * Decimal("1e-23")
        for (_, t), (_, again) in zip(stored.events, fresh.events, strict=True)
    )
    assert len(stored.undecided) == len(fresh.undecided)
    for flow, strays in stored.stray.items():
        for column, values in strays.items():
            assert fresh.stray[flow][column] == pytest.approx(values, rel=0.2, abs=1e-25), (flow, column)


@pytest.mark.parametrize("name", judged_names())
def test_hard_cases_are_compared_to_their_end(name):
    """No instant is left out for chaos."""
    truth = read_truth(name, case_of(name).sha256)
    for flow in truth.stray:
        points = list(hard_state_points(truth, run(case_of(name), "c", flow), flow))
        assert len(points) == len(truth.states) * len(truth.time)
