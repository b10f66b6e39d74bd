import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from vibsim.plots.sheet import spread


@given(st.lists(st.floats(0, 1), min_size=1, max_size=12), st.floats(0.001, 0.2))
def test_labels_keep_their_distance_and_order(heights, gap):
    places = spread(np.sort(heights), gap)
    assert len(places) == len(heights)
    assert np.all(np.diff(places) >= gap * (1 - 1e-9))


def test_labels_with_room_stay_where_they_are():
    heights = np.array([0.1, 0.5, 0.9])
    np.testing.assert_array_equal(spread(heights, 0.2), heights)


def test_a_crowd_is_centred_on_its_levels():
    np.testing.assert_allclose(spread(np.array([0.5, 0.5, 0.5]), 0.1), [0.4, 0.5, 0.6])
