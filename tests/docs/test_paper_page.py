"""Every number of docs/paper.md is that of a whole report, or is given by the paper and the cases."""

from copy import deepcopy

import pytest

from tests.docs.paper_page import PAGE, PHRASES, numbers_left, pattern_of, rewritten, stored_numbers
from vibsim.cases import load_case
from vibsim.evidence.reports.measurements import PAPER_RUNS, measure_facts, measure_run, member_outcome
from vibsim.evidence.reports.paper import read_motion, true_motion

AGAIN = "make paper, then make paper-page"


@pytest.fixture(scope="module")
def page():
    return PAGE.read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def numbers():
    return stored_numbers()


def test_the_numbers_of_the_page_are_those_of_the_report(page, numbers):
    assert rewritten(page, numbers) == page, AGAIN


def test_every_number_of_the_page_is_held_or_given(page):
    assert numbers_left(page) == []


def test_a_number_that_is_not_held_is_noticed(page):
    left = numbers_left(page + "\nSome 7 of 9 do.")
    assert len(left) == 2 and all(words.endswith("of 9 do.") for words in left)


@pytest.mark.parametrize("phrase", range(len(PHRASES)), ids=[phrase for phrase, _ in PHRASES])
def test_a_stale_number_is_noticed(page, numbers, phrase):
    """With one of its numbers changed the page is no longer what the report gives."""
    match = pattern_of(PHRASES[phrase][0]).search(page)
    start, end = match.span(1)
    stale = page[:start] + "12345" + page[end:]
    assert rewritten(stale, numbers) == page


def test_a_wrong_row_of_the_table_is_noticed(page, numbers):
    moved = deepcopy(numbers)
    moved["search"]["readings"]["ranking"][0]["statements"][0]["count"] += 1
    assert rewritten(page, moved) != page


def test_the_numbers_stored_are_of_these_cases(numbers):
    for name in PAPER_RUNS:
        assert numbers["runs"][name]["case_sha256"] == load_case(name).sha256, AGAIN


def test_facts_are_measured_again(numbers):
    facts = measure_facts({name: load_case(name) for name in PAPER_RUNS})
    for key in ("free_hz_I", "free_hz_II", "bilinear_hz_I", "bilinear_hz_II"):
        assert numbers["facts"][key] == pytest.approx(facts[key], rel=1e-5), AGAIN
    for stored, fresh in zip(numbers["facts"]["amplitudes"], facts["amplitudes"], strict=True):
        assert stored == pytest.approx(fresh, rel=1e-5), AGAIN


def assert_same(stored, fresh):
    """A stored number, which has six digits, or None."""
    assert stored == (None if fresh is None else pytest.approx(fresh, rel=1e-5)), AGAIN


def test_motions_from_rest_are_measured_again(numbers):
    """What the page says of II-B and II-C from rest."""
    for name in ("II-B", "II-C"):
        case = load_case(name)
        fresh, stored = measure_run(true_motion(case, read_motion(case))), numbers["runs"][name]
        for key in ("impacts", "sticks", "rest_distance_needed", "overall"):
            assert stored[key] == pytest.approx(fresh[key], rel=1e-5), AGAIN
        for key in ("since", "until", "speed_hz", "final_speed_hz"):
            assert_same(stored["capture"][key], fresh["capture"][key])
        assert stored["peak"]["time"] == pytest.approx(fresh["peak"]["time"], rel=1e-5), AGAIN


def test_two_starts_of_the_ensembles_are_measured_again(numbers):
    for name, i in (("I-B", 30), ("II-B", 5)):
        ensemble = numbers["ensembles"][name]
        start = ensemble["starts"][i]
        fresh = member_outcome(load_case(name, {"initial.x1": f"{start:.4g} m"}))
        for key in ("overall", "impacts", "final_hz", "period"):
            if key in fresh:
                assert_same(ensemble["outcomes"][i][key], fresh[key])
