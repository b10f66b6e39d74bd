"""Points of branches are orbits to rounding, beside a graze too."""

import pytest

from vibsim.orbits.branches.continuing import continue_branch


@pytest.mark.parametrize(
    ("case", "key", "span"),
    [
        ("gallery/impact-oscillator-coco", "drive.omega", "0.3:3 rad/s"),
        ("gallery/energy-sink", "drive.A", "0.2:5 N"),
    ],
)
def test_up_to_the_graze_of_a_rigid_stop(case, key, span):
    """Newton's method went to and fro across the graze, and left residuals of 3e-9 and 8e-9 behind."""
    branch = continue_branch(case, key, span)
    assert "grazing" in {one.kind for one in branch.specials}
    assert branch["residual"].max() < 1e-12


def test_beside_the_graze_of_an_elastic_stop():
    """Newton's method was ended where its steps grew no shorter, to and fro across the graze, and left 5e-8.
    Multipliers are up to 7,000: the residual of a point is by the largest one larger than its error.
    """
    branch = continue_branch("gallery/impact-damper", "drive.A", "0.2:1.185 N")
    assert {one.kind for one in branch.specials} >= {"grazing", "branch point", "fold", "neimark-sacker"}
    wrong = branch["residual"] / abs(branch["multipliers"]).max(axis=1).clip(1.0)
    assert branch["residual"].max() < 1e-9 and wrong.max() < 1e-11
