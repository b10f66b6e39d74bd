"""The number types of the engine in C: how Python's numbers go into it and come back."""

from __future__ import annotations

from array import array
from collections.abc import Iterable, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any, Generic

import numpy as np

from vibsim.physics.numbers import Doubles, Kit, N, text_width
from vibsim.physics.precision import WORD, DigitsKit

if TYPE_CHECKING:
    from vibsim.engine._engine import Run

LEAST_ROOM = 40  # bytes of a number that rooms for results are measured by


class NumberForm(Generic[N]):
    """Doubles, or another number type of the engine in C; `kit` is that of the numbers in Python that stand
    for it.
    """

    def __init__(self, kit: Kit[N]) -> None:
        self.kit = kit

    def run(self, ints: bytes, numbers: bytes) -> Run:
        """A run on this type of a packed scene."""
        import vibsim.engine._engine as _engine

        return _engine.Run(ints, numbers)

    def packed(self, values: Sequence[N]) -> bytes:
        """Numbers as C takes them."""
        return array("d", values).tobytes()  # type: ignore[type-var]

    def packed_rows(self, rows: Any) -> bytes:
        """A table of numbers, row by row; of doubles an array."""
        packed: bytes = rows.tobytes()
        return packed

    def all_taken(self, values: np.ndarray) -> np.ndarray:
        """Numbers that C filled an array of one row with."""
        return np.array(values)

    def empty(self, rows: int, columns: int) -> np.ndarray:
        """An array for C to fill with numbers."""
        return np.empty((rows, columns))

    def room(self, most: int) -> int:
        """How many columns such an array may have where it would be `most` of numbers of few words."""
        return most


class WordsForm(NumberForm[N]):
    """Numbers of words, for runs on the numbers of `kit`, which are the same as objects of Python."""

    kit: DigitsKit[N]

    def __init__(self, kit: DigitsKit[N]) -> None:
        super().__init__(kit)
        self.engine = kit.engine
        before, end = 8 * (kit.room - kit.words), 8 * kit.room  # bytes: where words in use begin and end
        self.type = np.dtype(
            {
                "names": ["words", "exponent", "sign"],
                "formats": [("<u8", (kit.words,)), "<i4", "<i4"],
                "offsets": [before, end, end + 4],
                "itemsize": end + 8,
            }
        )

    def run(self, ints: bytes, numbers: bytes) -> Run:
        run: Run = self.engine.Run(ints, numbers, self.kit.bits)
        return run

    def packed(self, values: Iterable[N | Fraction]) -> bytes:
        number = self.kit.number  # of cycles per second, say
        packed: bytes = self.engine.packed(
            [number(one) if isinstance(one, Fraction) else one for one in values]
        )
        return packed

    def packed_rows(self, rows: Iterable[Iterable[N]]) -> bytes:
        return b"".join(map(self.packed, rows))

    def all_taken(self, values: np.ndarray) -> np.ndarray:
        """As objects."""
        numbers = np.empty(len(values), dtype=object)
        numbers[:] = self._each(values)
        return numbers

    def empty(self, rows: int, columns: int) -> np.ndarray:
        return np.empty((rows, columns), dtype=self.type)

    def room(self, most: int) -> int:
        return most * LEAST_ROOM // max(LEAST_ROOM, self.type.itemsize)

    def doubles(self, values: np.ndarray) -> np.ndarray:
        """The doubles nearest to numbers of words, which are finite."""
        words = values["words"]
        rest = np.bitwise_or.reduce(words[..., :-1], axis=-1) != 0  # decides where half a unit is left
        sizes = (words[..., -1] | rest.astype("u8")).astype("f8")
        rounded: np.ndarray = values["sign"] * np.ldexp(
            sizes, np.where(values["sign"] == 0, 0, values["exponent"] - WORD)
        )
        return rounded

    def texts(self, row: np.ndarray) -> np.ndarray:
        """Numbers of words as decimal texts of all digits of the kit, in ASCII."""
        digits, width = self.kit.digits, text_width(self.kit.digits)
        made: bytes | None = self.engine.texts(np.ascontiguousarray(row).tobytes(), digits, width)
        if made is None:  # a number beyond 1e300 or so, or none at all
            return np.array(self.kit.texts_of(map(self.kit.parts, self._each(row))), dtype=f"S{width}")
        return np.frombuffer(made, dtype=f"S{width}")

    def _each(self, row: np.ndarray) -> list[N]:
        numbers: list[N] = self.engine.unpacked(np.ascontiguousarray(row).tobytes())
        return numbers


DOUBLES = NumberForm(Doubles)
