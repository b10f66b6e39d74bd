"""Events that cross the section: the orbits go on, though the state on the section has a kink there."""

import numpy as np

from vibsim.branches import continue_branch
from vibsim.cases import load_case


def test_a_stick_that_comes_to_the_section():
    """PWSDDE-cont's friction demo, slowly driven: at 0.3439 rad/s a stick begins at phase 0 of the force, and
    from there on the velocity on the section is exactly 0.
    """
    case = load_case("gallery/friction-oscillator", {"drive.omega": "0.37 rad/s"})
    branch = continue_branch(case, "drive.omega", "0.33:0.37 rad/s")
    assert branch.ends == ("end of the range", "end of the range") and branch.specials == []
    at_rest = branch["v_mass"] == 0
    first = branch["parameter"][at_rest].max()
    assert at_rest.any() and np.all(branch["v_mass"][branch["parameter"] > first] > 0)
    assert 0.3438 < first < branch["parameter"][~at_rest].min() < 0.344
    assert set(branch["word"]) == {"susu"} and branch["residual"].max() < 1e-12
