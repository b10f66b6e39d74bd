"""How much work a point of a branch takes: counted, not timed."""

from collections import Counter

import pytest

from tests.branches.made import KEYS, RESONANT, orbit_of
from vibsim.orbits.branches.continuing import continue_branch
from vibsim.orbits.branches.family import Family, FamilyPoint


@pytest.mark.parametrize("span", ["6.2:8 Hz", "5:8 Hz"])
def test_a_point_over_the_frequency_takes_few_motions_and_scenes(span, monkeypatch):
    """Newton's method begins with a derivative by the parameter that the points before tell, and asks for one
    of its own a point, which is the tangent's too: 3.5 motions with their derivative, 1.1 quotients and 3.8
    scenes. They were 3.9, 2.3 and 5.2.
    """
    counts = Counter()

    def counted(of, name):
        plain = getattr(of, name)

        def call(*arguments):
            counts[name] += 1
            return plain(*arguments)

        monkeypatch.setattr(of, name, call)

    counted(FamilyPoint, "__init__")
    counted(FamilyPoint, "_one_sided")
    counted(Family, "_new_map")
    branch = continue_branch(orbit_of(RESONANT), KEYS["I"], span)
    assert len(branch) > 400
    assert counts["__init__"] < 3.8 * len(branch)
    assert counts["_one_sided"] < 1.3 * len(branch)
    assert counts["_new_map"] < 4.2 * len(branch)
