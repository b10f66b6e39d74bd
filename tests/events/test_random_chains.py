"""Chains that begin at rest, drawn at random: events and motions by closed form, by Taylor series and, where
these differ, in 40 digits.
"""

import pytest

from tests.events.chains import chain
from tests.events.whole_runs import judge, wrong_by_series

pytest.importorskip("flint")


def test_chains_at_rest():
    judge(wrong_by_series, chain, range(100))


@pytest.mark.slow
@pytest.mark.timeout(3600)
def test_many_chains_at_rest():
    judge(wrong_by_series, chain, range(3000))
