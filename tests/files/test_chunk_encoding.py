"""Chunks encoded here are read back by HDF5's own filters, which check every checksum."""

import zlib

import h5py
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vibsim.results import hdf5_writing
from vibsim.results.hdf5_writing import encoded, fletcher32

CHUNK = 4096


def through_hdf5(values, path, chunk=CHUNK):
    with h5py.File(path, "w") as file:
        filters = {"compression": "gzip", "shuffle": True, "fletcher32": True}
        dataset = file.create_dataset("x", values.shape, values.dtype, chunks=(chunk,), **filters)
        dataset.id.write_direct_chunk((0,), encoded(values))
    with h5py.File(path) as file:
        return file["x"][:]


NOISE = np.random.default_rng(1)
CHUNKS = {
    "zeros": np.zeros(CHUNK),
    "ones": np.ones(CHUNK),
    "all bits set": np.full(CHUNK, -1, "<i8").view("<f8"),
    "times": np.arange(CHUNK) / 200,
    "smooth": np.sin(np.arange(CHUNK) / 50),
    "noise": NOISE.integers(0, 256, 8 * CHUNK, dtype="u1").view("<f8"),
    "noise between flat bytes": np.ones(CHUNK) + 1e-9 * NOISE.random(CHUNK),
    "at rest, then moving": np.where(np.arange(CHUNK) < 3000, 0.0, np.sin(np.arange(CHUNK))),
    "flags": NOISE.integers(-1, 2, CHUNK).astype("i1"),
}


@pytest.mark.parametrize("name", CHUNKS)
def test_hdf5_reads_the_same_bits(name, tmp_path):
    values = CHUNKS[name]
    assert through_hdf5(values, tmp_path / "x.h5").tobytes() == values.tobytes()


@given(st.binary(min_size=8, max_size=800).map(lambda raw: np.frombuffer(raw[: len(raw) // 8 * 8], "<f8")))
def test_any_bits_survive(tmp_path_factory, values):
    path = tmp_path_factory.getbasetemp() / "any.h5"
    assert through_hdf5(values, path, len(values)).tobytes() == values.tobytes()


def test_noise_is_stored_and_the_rest_is_compressed():
    smooth, noise = encoded(CHUNKS["times"]), encoded(CHUNKS["noise"])
    assert len(smooth) < 0.25 * 8 * CHUNK
    assert len(noise) <= 8 * CHUNK + 64  # stored blocks: 5 bytes per 64 kB, header and checksums


def test_the_deflated_part_is_one_zlib_stream():
    plain = hdf5_writing._byte_planes(CHUNKS["noise between flat bytes"]).tobytes()
    assert zlib.decompress(encoded(CHUNKS["noise between flat bytes"])[:-4]) == plain


def fletcher_by_the_book(data):
    """Word by word, folded as HDF5's H5_checksum_fletcher32 does."""
    sum1 = sum2 = 0
    padded = data + b"\0" * (len(data) % 2)
    for high, low in zip(padded[::2], padded[1::2], strict=True):
        sum1 += high << 8 | low
        sum1 = (sum1 & 0xFFFF) + (sum1 >> 16)
        sum2 += sum1
        sum2 = (sum2 & 0xFFFF) + (sum2 >> 16)
    return sum2 << 16 | sum1


@given(st.binary(max_size=300) | st.sampled_from([b"\xff\xff" * 4, b"\0\0\xff\xff", b"\0" * 6]))
def test_fletcher32_is_that_of_hdf5(data):
    assert fletcher32(data) == fletcher_by_the_book(data)
