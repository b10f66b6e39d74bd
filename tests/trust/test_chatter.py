"""What a completed chatter leaves out counts as error: the companion leaves it out too."""

import pytest

from vibsim import simulate


@pytest.mark.parametrize("name", ("drifting-oscillator", "pile-driver"))
def test_the_estimate_covers_what_chatter_leaves_out(name):
    result = simulate(f"gallery/{name}")
    left_out = result.attrs["chatter_distance"]
    assert result.attrs["chatters"] > 0 and left_out > 1e-14
    assert result.error_estimate[-1] >= left_out
