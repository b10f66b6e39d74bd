"""Branches that close: orbits of the paper's machine that no other branch leads to."""

import numpy as np

from vibsim.cases import load_case
from vibsim.orbits.branches.continuing import continue_branch
from vibsim.orbits.branches.walk import landed
from vibsim.orbits.search import orbit


def test_the_plateau_at_three_quarters_is_an_isola():
    """II-B at c = 0.001 N s/m: three turns, four impacts. Once round, the orbits begin a turn later."""
    start = orbit(load_case("II-B"), {"c": "0.001", "excitation.Omega0": "5.9 Hz"})
    assert start.n == 3 and start.spelled.count("b") == 4
    branch = continue_branch(start, "excitation.Omega0", "5:9 Hz", max_points=400)
    assert branch.closed and branch.ends == ("closed", "closed")
    assert abs(branch["parameter"][-1] - 5.9) < 1e-8
    assert abs(branch["period"][-1] / branch["period"][0] - 1) < 1e-9
    once = branch.plan.family().map(branch["parameter"][0]).of(1)
    X, images = np.array(branch.points[0].orbit.state), []
    for _ in range(3):
        images.append(X)
        X = landed(once, X).image
    last = np.array(branch.points[-1].orbit.state)
    assert min(np.abs(last - image).max() for image in images) < 1e-6
    assert 5.9423 < branch["parameter"].max() < 5.9424 and 5.2298 < branch["parameter"].min() < 5.2299
