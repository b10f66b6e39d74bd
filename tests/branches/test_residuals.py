"""Points of branches are orbits to rounding, beside a graze too."""

import pytest

from vibsim.branches import continue_branch


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
