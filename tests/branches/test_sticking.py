"""Branches along which a motion begins to stick."""

from vibsim.branches import continue_branch
from vibsim.branches.family import Family
from vibsim.cases import load_case
from vibsim.orbits.seeking import orbit


def test_a_motion_that_begins_to_stick_on_both_sides_at_once_is_followed_fast(monkeypatch):
    """Its own mirror image sticks at both reversals at one frequency: two changes that no halving parts.

    Each is bisected once, from a step's length to 4e-15, in some 45 motions and as many Newton steps.
    """
    counts, call = [0], Family.__call__

    def counted(self, z):
        counts[0] += 1
        return call(self, z)

    start = orbit(
        load_case("gallery/friction-oscillator", {"floor.static": "1.1", "drive.omega": "0.76 rad/s"})
    )
    monkeypatch.setattr(Family, "__call__", counted)
    branch = continue_branch(start, "drive.omega", "0.74:0.77 rad/s")
    assert [one.kind for one in branch.specials] == ["sticking", "sticking"]
    one, other = (one.parameter for one in branch.specials)
    assert abs(one - other) < 1e-12 and counts[0] < 400
