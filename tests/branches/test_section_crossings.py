"""Events that cross the section: the orbits go on, though the state on the section has a kink there."""

import numpy as np
import pytest

from vibsim.cases import load_case
from vibsim.orbits.branches.continuing import continue_branch


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


def test_contacts_with_damped_stops_pass_the_section():
    """The velocity has a kink where a contact begins, which Newton's method did not get across: the branch of
    the impact damper ended where one came to the section, at 0.97005 and at 1.32668 Hz.
    """
    branch = continue_branch("gallery/impact-damper", "drive.omega", "0.95:1.35 Hz")
    assert branch["parameter"].min() == pytest.approx(0.95, rel=1e-14)
    fold = next(one for one in branch.specials if one.kind == "fold")
    assert fold.parameter > 1.327
    changes = np.diff(branch["index"])
    for special in branch.specials:
        changes[special.between[0]] -= special.jump
    assert not changes.any()
