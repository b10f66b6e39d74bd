"""Scenes of kinds that random numbers hardly make: events and motions by closed form, by Taylor series and,
where these differ, in 40 digits.
"""

import pytest

from tests.events.oddities import oddity
from tests.events.whole_runs import in_batches, judge, wrong_by_digits, wrong_by_series


def test_oddities_by_two_methods():
    judge(wrong_by_series, oddity, range(459, 509))


def test_oddities_in_many_digits():
    judge(wrong_by_digits, oddity, range(2001, 2005))


@pytest.mark.slow
@pytest.mark.timeout(3600)
@in_batches(range(800), 100)
def test_many_oddities_by_two_methods(seeds):
    judge(wrong_by_series, oddity, seeds)


@pytest.mark.slow
@pytest.mark.timeout(3600)
def test_many_oddities_in_many_digits():
    judge(wrong_by_digits, oddity, range(2000, 2080))
