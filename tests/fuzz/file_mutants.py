"""Result files as another program, a full disk or a failing one would leave them."""

import shutil

import h5py
import numpy as np

from tests.results.damages import OF_ATTRIBUTES, OF_DATASETS, damage_attribute, datasets

NUMBERS = [np.nan, np.inf, -np.inf, -1e300, 1e300, 1e-320, 0.0, -1.0, 99, -128, 127, 2.0]
TEXTS = ["", "\x1b[2J", "{}", "[]", "null", '{"vibsim_case": 1}', "x" * 60_000, "$x^{2 $", "\u0001", "nan"]


def mutant(source, path, draw):
    """A copy of a result file with one or two damages."""
    shutil.copy(source, path)
    if draw.random() < 0.3:
        path.write_bytes(bytes_damaged(path.read_bytes(), draw))
        return
    names = datasets(path)
    with h5py.File(path, "r+") as file:
        for _ in range(draw.randint(1, 2)):
            name, attribute = draw.choice(names), draw.choice(list(file.attrs))
            try:
                draw.choice(DAMAGES)(file, name, attribute, draw)
            except (KeyError, TypeError, ValueError, OSError, AttributeError):
                continue  # the second damage found nothing left of what the first had damaged


def structure(file, name, attribute, draw):
    draw.choice(OF_DATASETS)(file, name)


def numbers(file, name, attribute, draw):
    value, dataset = draw.choice(NUMBERS), file[name]
    where = slice(None) if draw.random() < 0.5 else draw.randrange(max(1, dataset.shape[0]))
    with np.errstate(invalid="ignore"):
        dataset[where] = np.array(value).astype(dataset.dtype) if dataset.dtype.kind in "if" else "\x1b"


def another_attribute(file, name, attribute, draw):
    damage_attribute(file, attribute, draw.choice(list(OF_ATTRIBUTES.values())))


def another_text(file, name, attribute, draw):
    old = file.attrs[attribute]
    if not isinstance(old, str):
        file.attrs[attribute] = draw.choice(NUMBERS)
    elif old.startswith("{") and draw.random() < 0.7:
        at = draw.randrange(len(old))
        file.attrs[attribute] = old[:at] + draw.choice('0123456789"{}[]:,e-') + old[at + 1 :]
    else:
        file.attrs[attribute] = draw.choice(TEXTS)


def bytes_damaged(data, draw):
    """Flipped bytes, a hole, or an end that is missing."""
    what, at = draw.randrange(3), draw.randrange(len(data))
    if what == 0:
        changed = bytearray(data)
        for _ in range(draw.choice([1, 3, 30])):
            changed[draw.randrange(len(data))] = draw.randrange(256)
        return bytes(changed)
    return data[:at] if what == 1 else data[:at] + bytes(len(data[at : at + 4096])) + data[at + 4096 :]


DAMAGES = [structure, structure, numbers, another_attribute, another_text, another_text]
