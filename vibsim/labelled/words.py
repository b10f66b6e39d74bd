"""Codes as the words that they stand for."""

import numpy as np

from vibsim.files.declarations import Column


def words_of(column: Column, codes: np.ndarray) -> np.ndarray:
    """The words of codes (an object array of their shape); None for a code without a word, such as NaN."""
    words = np.full(np.shape(codes), None, dtype=object)
    for word, code in column.flags.items():
        words[np.asarray(codes) == code] = word
    return words
