"""Quadrature against the integrals of powers, and what its last place may be off by."""

import math

import pytest

from vibsim.physics.elementary import EIGHT, TWELVE


@pytest.mark.parametrize("rule", [EIGHT, TWELVE], ids=["eight", "twelve"])
def test_polynomials_are_integrated_exactly_up_to_twice_the_nodes(rule):
    count = len(rule.nodes)

    def miss(power):
        terms = [weight * node**power for node, weight in zip(*rule, strict=True)]
        return 1 / (power + 1) - math.fsum(terms)

    assert all(abs(miss(power)) < 2e-16 for power in range(2 * count))
    # the first that is missed, by (n!)^4 / ((2 n + 1) ((2 n)!)^2) of it
    first = math.factorial(count) ** 4 / ((2 * count + 1) * math.factorial(2 * count) ** 2)
    assert miss(2 * count) == pytest.approx(first, abs=2e-16)
    assert first > 3e-16 or count == 12


def test_eight_nodes_take_the_power_of_a_step_to_rounding():
    """(1 - cos 2 w t) / 2 over a step of 1.32 rad, the longest of order 20 at full tolerance."""
    angle = 1.32
    assert angle**20 / math.factorial(20) == pytest.approx(2.0**-53, rel=0.1)
    for phase in (0.0, 0.4, 1.1, 2.5):
        exact = angle / 2 - (math.sin(2 * (angle + phase)) - math.sin(2 * phase)) / 4
        powers = (math.sin(node * angle + phase) ** 2 for node in EIGHT.nodes)
        found = angle * math.fsum(w * power for w, power in zip(EIGHT.weights, powers, strict=True))
        assert found == pytest.approx(exact, abs=3e-16)
