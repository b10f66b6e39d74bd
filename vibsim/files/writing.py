"""HDF5 files that are written whole: made in memory, so that a full disk fails in one plain write.

A write that fails inside HDF5 leaves a file that it insists on closing, and an error in words of its own.
"""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from vibsim.files.attributes import write_attrs
from vibsim.files.declarations import Dataset
from vibsim.files.output_file import output_file

LIBVER = ("earliest", "v110")  # opens in every HDF5 since 1.10, h5netcdf and netCDF4
STEP = 1 << 20  # bytes by which the image grows
FOR_INDEX = 2048  # bytes that the index of a compressed dataset takes: a short scale is smaller as it is
COMPRESSED = {"compression": "gzip", "compression_opts": 1, "shuffle": True, "fletcher32": True}


def write_hdf5(
    path: Path, attrs: Mapping[str, Any], declared: Iterable[Dataset], values: Mapping[str, Any]
) -> None:
    """Write a file of these root attributes and datasets to `path`, replacing what is there in one instant.

    values : what stands in each dataset, by name; its shape is told by the scales
    Raises ResultFileError where it cannot be written; then what was there is still there.
    """
    options = {"driver": "core", "backing_store": False, "block_size": STEP}
    with h5py.File(path.name, "w", libver=LIBVER, **options) as file:
        write_attrs(file.id, attrs)
        write_datasets(file, declared, values)
        file.flush()
        image = file.id.get_file_image()
    with output_file(path, force=True) as file:
        file.write(image)


def write_datasets(file: h5py.File, declared: Iterable[Dataset], values: Mapping[str, Any]) -> None:
    """Write datasets to an open file: scales first, then what is attached to them."""
    for dataset in sorted(declared, key=lambda each: not each.is_scale):
        group = dataset.name.rpartition("/")[0]
        if dataset.is_scale:
            _written(file, dataset, values[dataset.name]).make_scale(dataset.dims[0])
            continue
        scales = [file[f"{group}/{name}"] for name in dataset.dims]
        item = _written(file, dataset, np.reshape(values[dataset.name], [len(scale) for scale in scales]))
        for dimension, scale in zip(item.dims, scales, strict=True):
            dimension.attach_scale(scale)


def _written(file: h5py.File, dataset: Dataset, values: Any) -> h5py.Dataset:
    text = dataset.column.dtype == "text"
    array = np.asarray(values, object if text else dataset.column.dtype)
    plain = array.size == 0 or (dataset.is_scale and array.nbytes <= FOR_INDEX)
    options = {"dtype": h5py.string_dtype()} if text else {} if plain else COMPRESSED
    item = file.create_dataset(dataset.name, data=array, **options)
    write_attrs(item.id, dataset.column.attributes())
    return item
