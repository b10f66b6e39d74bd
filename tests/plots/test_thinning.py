"""One sample per pixel: nothing invented, nothing farther than a pixel from what is kept."""

import numpy as np

from vibsim.plots.traces import one_per_pixel

PIXELS = (60, 40)


def test_samples_are_kept_and_none_is_far():
    rng = np.random.default_rng(3)
    x, y = rng.normal(size=5000), rng.uniform(size=5000)
    kept_x, kept_y = one_per_pixel(
        lambda: zip(np.array_split(x, 7), np.array_split(y, 7), strict=True), PIXELS
    )
    assert len(kept_x) < len(x)
    assert set(zip(kept_x, kept_y, strict=True)) <= set(zip(x, y, strict=True))
    dx = np.abs(x[:, None] - kept_x) / np.ptp(x) * PIXELS[0]
    dy = np.abs(y[:, None] - kept_y) / np.ptp(y) * PIXELS[1]
    assert np.maximum(dx, dy).min(axis=1).max() <= 1 + 1e-12


def test_pixels_are_not_kept_twice():
    x = np.array([0.0, 1.0, 0.0, 1.0])
    kept_x, _ = one_per_pixel(lambda: [(x, x), (x, x)], PIXELS)
    assert sorted(kept_x) == [0.0, 1.0]


def test_a_point_at_rest_is_one_point():
    x = np.full(100, 2.0)
    assert one_per_pixel(lambda: [(x, x)], PIXELS)[0].tolist() == [2.0]
