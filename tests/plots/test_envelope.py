"""No extreme is lost: the envelope keeps the first, least, greatest and last sample of every pixel column."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vibsim.plots.samples import Envelope

COLUMNS = 37


def enveloped(t, values, blocks=1, columns=COLUMNS):
    envelope = Envelope(t[0], t[-1], columns)
    for part in np.array_split(np.arange(len(t)), blocks):
        envelope.add(t[part], values[part])
    return envelope.points()


def column_of(t, start, stop, columns=COLUMNS):
    return np.minimum((t - start) / (stop - start) * columns, columns - 1).astype(int)


@given(st.integers(0, 2**32 - 1), st.integers(2, 3000), st.integers(1, 7))
def test_every_column_keeps_its_extremes_and_ends(seed, count, blocks):
    rng = np.random.default_rng(seed)
    t = np.cumsum(rng.uniform(0.1, 1.0, count))
    values = rng.normal(size=count)
    kept_t, kept = enveloped(t, values, min(blocks, count))
    all_columns, kept_columns = column_of(t, t[0], t[-1]), column_of(kept_t, t[0], t[-1])
    assert set(all_columns) == set(kept_columns)
    for column in set(all_columns):
        whole, part = values[all_columns == column], kept[kept_columns == column]
        assert (part.min(), part.max(), part[0], part[-1]) == (whole.min(), whole.max(), whole[0], whole[-1])


def test_kept_points_are_samples_in_order():
    t = np.linspace(0, 1, 5000)
    values = np.sin(900 * t)
    kept_t, kept = enveloped(t, values)
    assert len(kept_t) <= 4 * COLUMNS
    assert np.all(np.diff(kept_t) > 0)
    np.testing.assert_array_equal(kept, values[np.searchsorted(t, kept_t)])


@pytest.mark.parametrize("row", [0, 777, 4999])
def test_a_single_spike_survives(row):
    t, values = np.arange(5000.0), np.zeros(5000)
    values[row] = -3.0
    kept_t, kept = enveloped(t, values, blocks=3)
    assert kept.min() == -3.0
    assert kept_t[kept.argmin()] == row


def test_blocks_do_not_matter():
    t = np.linspace(0, 1, 4321)
    values = np.cumsum(np.random.default_rng(1).normal(size=t.size))
    for once, often in zip(enveloped(t, values), enveloped(t, values, blocks=11), strict=True):
        np.testing.assert_array_equal(once, often)
