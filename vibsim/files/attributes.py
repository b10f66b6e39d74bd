"""HDF5 attributes: text, whole numbers, floats and small arrays, written the direct (fast) way."""

from collections.abc import Mapping
from typing import Any

import h5py
import numpy as np
from h5py import h5a, h5s, h5t

TEXT = h5py.string_dtype()
PLAIN = (h5t.TypeStringID, h5t.TypeIntegerID, h5t.TypeFloatID)


def write_attrs(location: Any, attrs: Mapping[str, Any]) -> None:
    """Write attributes of an HDF5 object (low-level id): replaces those that exist, leaves out None."""
    for name, value in attrs.items():
        if value is not None:
            _write(location, name.encode(), value)


def read_attrs(location: Any) -> dict[str, Any]:
    """Attributes of a file, group or dataset as plain values: str, int, float, or an array.

    A name that is no UTF-8, which h5py gives as bytes, is none of ours, and left out, as is what is neither
    text nor numbers.
    """
    attrs = location.attrs
    return {
        name: _plain(attrs[name]) for name in attrs if isinstance(name, str) and _of_plain_type(attrs, name)
    }


def read_attr(location: Any, name: str, otherwise: Any = None) -> Any:
    """One attribute as h5py gives it; `otherwise` where there is none of text or numbers."""
    attrs = location.attrs
    return attrs[name] if name in attrs and _of_plain_type(attrs, name) else otherwise


def _of_plain_type(attrs: Any, name: str) -> bool:
    """Whether an attribute is text or numbers. Others are not even read: by a byte of it that another program
    or a disk has changed a text becomes a list of nothing known, over which HDF5 ends the process.
    """
    return isinstance(attrs.get_id(name).get_type(), PLAIN)


def _write(location: Any, name: bytes, value: Any) -> None:
    data = np.asarray(value, TEXT if isinstance(value, str) else None, order="C")
    space = h5s.create_simple(data.shape) if data.shape else h5s.create(h5s.SCALAR)
    if h5a.exists(location, name):
        h5a.delete(location, name)
    h5a.create(location, name, h5t.py_create(data.dtype, logical=True), space).write(data)


def _plain(value: Any) -> Any:
    return value.item() if isinstance(value, np.generic) else value
