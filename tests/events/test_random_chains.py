"""Chains that begin at rest, drawn at random: events and motions by closed form, by Taylor series and, where
these differ, in 40 digits.
"""

import pytest

from tests.events.chains import chain
from tests.events.whole_runs import in_batches, judge, wrong_by_series


def test_chains_at_rest():
    judge(wrong_by_series, chain, range(100))


@pytest.mark.slow
@pytest.mark.timeout(3600)
@in_batches(range(3000), 250)
def test_many_chains_at_rest(seeds):
    judge(wrong_by_series, chain, seeds)
