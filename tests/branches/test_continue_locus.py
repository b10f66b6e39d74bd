"""`vibsim.continue_locus`: a doubling in two parameters, against the branch at the end of the second one."""

import numpy as np
import pytest

import vibsim
from vibsim.orbits.branches.locus_result import read_locus

AT = {"omega": "4.2 Hz"}


def branch_at(c):
    return vibsim.continue_branch(
        vibsim.orbit("I-C", {**AT, "c": f"{c} N s/m"}, period=1), "omega", "4:4.3 Hz"
    )


@pytest.fixture(scope="module")
def branch():
    return branch_at(0.001)


@pytest.fixture(scope="module")
def locus(branch):
    return vibsim.continue_locus(branch, {"c": "0.001:0.0015 N s/m"}, label="PD1")


def test_it_ends_at_the_doubling_of_another_branch(branch, locus):
    assert isinstance(locus, vibsim.Locus) and locus.ends == ("end of the range",) * 2
    assert locus["second"][[0, -1]].tolist() == [0.001, 0.0015]
    for at, end in ((branch, 0), (branch_at(0.0015), -1)):
        assert locus["parameter"][end] == pytest.approx(at.special("PD1").parameter, rel=1e-11)


def test_into_a_file_and_gone_on_with(branch, locus, tmp_path):
    path, stored = tmp_path / "locus.h5", branch.save(tmp_path / "branch.h5")
    part = vibsim.continue_locus(
        stored, {"c": ((0.001, 0.0015), "N s/m")}, label="PD1", max_points=6, out=path
    )
    assert len(part) < len(locus)
    whole = vibsim.continue_locus(branch, {"coupling.c": (0.001, 0.0015)}, label="PD1", out=path)
    assert np.array_equal(whole["parameter"], read_locus(path)["parameter"])
    assert np.allclose(whole["parameter"], locus["parameter"], rtol=1e-11)
    with pytest.raises(vibsim.ResultFileError, match="holds another locus"):
        vibsim.continue_locus(branch, {"c": (0.001, 0.002)}, label="PD1", out=path)
