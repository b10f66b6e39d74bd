"""A multiplier that is exactly 1 because orbits come in families: no fold is told of."""

import numpy as np

from vibsim.branches import continue_branch
from vibsim.cases import load_case

STUCK = """
name: family
bodies: {m: 1 kg, b: 1 kg}
links:
  spring: {between: [m, ground], k: 1 N/m, c: 0.1 N s/m}
  weak: {between: [b, ground], k: 0.5 N/m}
  tie: {between: [m, b], k: 0.1 N/m}
friction: {rub: {between: [b, ground], mu: 0.8}}
forces: {drive: {on: m, A: 1 N, omega: 1.3 rad/s}}
initial: {b: {x: 0.2 m}}
run: {t_end: 400 s, every: 0.5 s}
"""


def test_a_body_that_sticks_anywhere(tmp_path):
    """Body b sticks on its friction, anywhere within a band: at each amplitude orbits are a family."""
    (tmp_path / "family.yaml").write_text(STUCK)
    branch = continue_branch(load_case(str(tmp_path / "family.yaml")), "A", "0.5:2 N")
    assert branch.specials == [] and branch.ends == ("end of the range", "end of the range")
    assert np.abs(branch["multipliers"] - 1).min(axis=1).max() < 1e-12
    assert (branch["v_b"] == 0).all() and branch["residual"].max() < 1e-12
