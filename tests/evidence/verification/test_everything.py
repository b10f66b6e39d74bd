"""The whole verification: every number within its bound."""

import pytest

from vibsim.evidence.verification import verify
from vibsim.evidence.verification.catalogue import all_checks


@pytest.mark.parametrize("name", [check.name for check in all_checks()])
def test_all_numbers_are_within_their_bounds(name):
    rows = list(verify([name], "c"))
    assert rows
    assert [(row.name, row.obtained, row.error, row.bound) for row in rows if not row.passed] == []
