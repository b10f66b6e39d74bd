"""Ways to damage the structure of an HDF5 file, as other programs could: valid HDF5, and not what it was."""

import h5py
import numpy as np


def gone(file, name):
    del file[name]


def scalar(file, name):
    replace(file, name, 1.5)


def text(file, name):
    replace(file, name, np.full(file[name].shape, b"a text"))


def another_rank(file, name):
    shape, dtype = file[name].shape, file[name].dtype
    del file[name]
    file.create_dataset(name, (*shape, 2), dtype)


def references(file, name):
    targets = np.full(file[name].shape, file.ref, dtype=h5py.ref_dtype)
    replace(file, name, targets)


def another_type(file, name):
    replace(file, name, np.zeros(file[name].shape, "f4"))


def one_too_few(file, name):
    values, dtype = file[name][:-1], file[name].dtype
    del file[name]
    file.create_dataset(name, data=values, dtype=dtype)


def huge(file, name):
    shape, dtype = file[name].shape, file[name].dtype
    del file[name]
    file.create_dataset(name, tuple(10**12 for _ in shape), dtype, chunks=tuple(100 for _ in shape))


def elsewhere(file, name):
    del file[name]
    file[name] = h5py.ExternalLink("another.h5", "/x")


def nowhere(file, name):
    del file[name]
    file[name] = h5py.SoftLink("/nothing/there")


def a_group(file, name):
    del file[name]
    file.create_group(name)


def replace(file, name, values):
    del file[name]
    file[name] = values


OF_DATASETS = [
    gone, scalar, text, another_rank, references, another_type, one_too_few, huge, elsewhere, nowhere, a_group
]  # fmt: skip


def datasets(path):
    """Names of all datasets of a file."""
    names = []
    with h5py.File(path) as file:
        file.visititems(lambda name, item: names.append(name) if isinstance(item, h5py.Dataset) else None)
    return names


OF_ATTRIBUTES = {
    "gone": None,
    "an array": np.zeros((2, 2, 2)),
    "bytes": np.bytes_(b"bytes"),
    "nothing": h5py.Empty("f8"),
    "not a number": np.nan,
    "no text": "\udcff",
}


def damage_attribute(file, name, value):
    """Give an attribute another value; None takes it away."""
    del file.attrs[name]
    if isinstance(value, str):
        kind = h5py.string_dtype("ascii", 1)
        file.attrs.create(name, value.encode("utf-8", "surrogateescape"), dtype=kind)
        return
    if value is not None:
        file.attrs[name] = value
