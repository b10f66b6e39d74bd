"""How many digits are right: what a run says of itself, judged by a run of many more."""

import re
from decimal import Decimal

import pytest

import vibsim
from tests.truth.made import case, true_end
from vibsim.results.many_digits import DOUBLE_DIGITS, DigitsPlan, agreement


def test_agreement_is_that_of_the_worst_quantity():
    first = {"x1": Decimal("1.2345"), "x2": Decimal("-2")}
    assert agreement(first, first) == float("inf")
    assert agreement(first, {"x1": Decimal("1.2346"), "x2": Decimal("-2.1")}) == pytest.approx(
        1.322, abs=1e-3
    )
    assert agreement(first, {"x1": Decimal("1.2345"), "x2": Decimal(0)}) == 0


@pytest.mark.parametrize(("name", "digits"), [("I-A", 40), ("I-C", 30), ("II-B", 25)])
def test_digits_said_to_be_right_are(name, digits):
    result = vibsim.simulate(case(name, "4 s"), digits=digits)
    _, end = true_end(name, "4 s", digits + 20)
    found = agreement({key: Decimal(str(column[-1])) for key, column in result.digits.events.items()}, end)
    # a run carries guard bits beyond its digits: it may be right to a few digits more than it says
    assert result.attrs["digits_right"] - 1 <= found <= result.attrs["digits_right"] + 6
    assert result.attrs["digits_right_from"] == "agreement with a run in doubles"


def test_a_regular_case_costs_one_run():
    result = vibsim.simulate(case("I-A", "20 s"), digits="auto")
    assert result.attrs["digits"] == 30
    assert 20 < result.attrs["digits_right"] <= 30
    assert result.attrs["digits_right_from"] == "agreement with a run in doubles"


def chaos(t_end="45 s"):
    """A chaotic run that loses every digit of a double: some 16 digits in 45 s."""
    return case("I-B-eq211", t_end)


@pytest.mark.slow
def test_a_chaotic_case_gets_what_it_needs():
    result = vibsim.simulate(chaos(), digits="auto")
    right, carried = result.attrs["digits_right"], result.attrs["digits"]
    assert right >= 10 and carried > 30
    assert re.fullmatch(r"agreement with a run of \d+ digits", result.attrs["digits_right_from"])
    _, end = true_end("I-B-eq211", "45 s", carried + 20)
    found = agreement({key: Decimal(str(column[-1])) for key, column in result.digits.events.items()}, end)
    assert found >= right - 1 >= 9


def test_too_few_digits_are_raised():
    plan = DigitsPlan(chaos("15 s"), "auto")
    plan.coarse_digits, plan.digits = DOUBLE_DIGITS, 20
    _, end = true_end("I-B-eq211", "15 s", 60)
    plan.coarse = {key: value * 2 for key, value in end.items()}  # a run that shares nothing with it
    assert plan.verdict(end, {})["digits_right"] == 0
    assert not plan.enough and plan.digits > 20 and plan.coarse is end


def test_a_coarser_run_tells_what_doubles_do_not():
    plan = DigitsPlan(chaos("15 s"), "auto")
    _, end = true_end("I-B-eq211", "15 s", 60)
    plan.coarse_digits, plan.digits = DOUBLE_DIGITS, 40
    plan.coarse = {key: value * 2 for key, value in end.items()}  # as doubles of a longer run
    told = plan.verdict(end, {})
    assert plan.enough and re.fullmatch(r"agreement with a run of 2\d digits", told["digits_right_from"])
    assert 40 > told["digits_right"] > 30  # some 5 digits are lost in 15 s


def test_fixed_digits_of_a_chaotic_case_are_estimated():
    result = vibsim.simulate(chaos(), digits=60)
    assert result.attrs["digits_right_from"] == "growth of small kicks, estimated"
    assert 0 < result.attrs["digits_right"] < 60
