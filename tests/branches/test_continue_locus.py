"""`vibsim.continue_locus`: a doubling in two parameters, against the branch at the end of the second one."""

import numpy as np
import pytest

import vibsim
from vibsim.orbits.branches.continuing import continue_branch
from vibsim.orbits.branches.curve import complete
from vibsim.orbits.branches.locus_result import LocusStore, locus_plan, read_locus
from vibsim.orbits.branches.plan import read_span


def branch_at(c):
    start = vibsim.orbit("I-C", {"omega": "4.2 Hz", "c": f"{c} N s/m"}, period=1)
    return vibsim.continue_branch(start, "omega", "4:4.3 Hz")


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
    second = {"c": ((0.001, 0.0015), "N s/m")}
    part = vibsim.continue_locus(stored, second, label="PD1", max_points=6, out=path)
    assert len(part) < len(locus)
    whole = vibsim.continue_locus(branch, {"coupling.c": (0.001, 0.0015)}, label="PD1", out=path)
    assert np.array_equal(whole["parameter"], read_locus(path)["parameter"])
    assert np.allclose(whole["parameter"], locus["parameter"], rtol=1e-11)
    with pytest.raises(vibsim.ResultFileError, match="holds another locus"):
        vibsim.continue_locus(branch, {"c": (0.001, 0.002)}, label="PD1", out=path)


# Folds beside the graze of a rigid stop, in two parameters, against a closed form.


def fold_of_one_impact(w, c=0.1, e=0.8):
    """Amplitude of the force at the fold of orbits with one impact on a rigid stop at 1 (m = k = 1).

    Behind the impact the free part of the motion is h = a v with the rate b v, v the impact speed: it comes
    back to a v with its rate larger by (1 + e) v. The forced part, of the amplitude A / sqrt((1 - w^2)^2 +
    (c w)^2), is there 1 - a v, its rate -(e + b) v: least where v = a / (a^2 + ((e + b) / w)^2).
    """
    T, wd = 2 * np.pi / w, np.sqrt(1 - c * c / 4)
    decay, sine, cosine = np.exp(-c * T / 2), np.sin(wd * T), np.cos(wd * T)
    flow = decay * np.array(
        [[cosine + c / (2 * wd) * sine, sine / wd], [-sine / wd, cosine - c / (2 * wd) * sine]]
    )
    a, b = np.linalg.solve(flow - np.eye(2), [0.0, 1 + e])
    other = (e + b) / w
    return np.sqrt(((1 - w * w) ** 2 + (c * w) ** 2) * other**2 / (a * a + other**2)), a


@pytest.mark.slow
def test_folds_beside_a_graze_are_followed():
    """From 3e-5 N beside the graze of a rigid stop to where the locus meets that of the graze: at the damped
    natural frequency, where a = 0. The test value changes by 0.2 over 1e-6, and differences told nothing.
    """
    branch = continue_branch("gallery/impact-oscillator-coco", "drive.A", "0.05:1.05 N")
    plan = locus_plan(branch, "F1", *read_span(branch.case, "drive.omega", "0.9:1.5 rad/s"))
    locus = complete(LocusStore(plan), 200)[0]
    exact = [fold_of_one_impact(w)[0] for w in locus["second"]]
    np.testing.assert_allclose(locus["parameter"], exact, rtol=1e-11)
    assert locus.ends == (
        "a rigid stop is grazed: here the locus meets that of the grazing",
        "end of the range",
    )
    assert 0 < locus["second"][0] - np.sqrt(1 - 0.1**2 / 4) < 1e-3 and len(locus) < 60
