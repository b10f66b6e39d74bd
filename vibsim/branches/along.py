"""Points one behind the other along a curve, with arrays by name."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np


class Along:
    """`curve["parameter"]` and so on along `points`; a class of it says what it is, and its arrays."""

    noun = "curve"
    points: Sequence[Any]

    @property
    def _arrays(self) -> Mapping[str, np.ndarray]:
        raise NotImplementedError

    def __len__(self) -> int:
        return len(self.points)

    def keys(self) -> list[str]:
        """Names of the arrays along it."""
        return [*self._arrays]

    def __getitem__(self, name: str) -> np.ndarray:
        """An array along it, first axis the points. Raises KeyError with the names that there are."""
        if name not in self._arrays:
            raise KeyError(f"{name} is not in this {self.noun}; it has {', '.join(self._arrays)}")
        return self._arrays[name]
