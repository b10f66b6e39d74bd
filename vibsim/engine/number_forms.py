"""The number types of the engine in C: how Python's numbers go into it and come back.

Doubles go as they are. For runs of many digits the same engine is built on numbers of 2 to 4 words of 64 bits
(`numbers/limbs.h`): a mantissa, an exponent and a sign. Numbers of python-flint or mpmath are rounded to them
once, and those that come back are exact.
"""

from __future__ import annotations

from array import array
from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction
from functools import lru_cache
from importlib import import_module
from importlib.util import find_spec
from math import ceil, inf
from struct import Struct
from typing import TYPE_CHECKING, Any, Generic, Protocol

import numpy as np

from vibsim.engine.errors import State
from vibsim.physics import elementary
from vibsim.physics.numbers import Doubles, Kit, N, nearest_double, text_width
from vibsim.physics.precision import BITS_PER_DIGIT, DigitsKit

if TYPE_CHECKING:
    from vibsim.engine._engine import Run
    from vibsim.physics.parts import Scene

WORD, ENDLESS = 64, 2**31 - 1  # bits of a word; exponent of what is infinite
SPARE_BITS = 20  # that a number of words has beyond the unit round-off of a run, at least
WORDS = (2, 3, 4)  # of the engines that are built, see setup.py


class NumberForm(Protocol[N]):
    """A number type of the engine in C; `kit` is that of the numbers in Python that stand for it."""

    @property
    def kit(self) -> Kit[N]: ...
    def run(self, ints: bytes, numbers: bytes) -> Run:
        """A run on this type of a packed scene."""
        ...

    def order(self, scene: Scene[N]) -> int: ...
    def tolerance_exponent(self, scene: Scene[N]) -> float: ...
    def packed(self, values: Sequence[N]) -> bytes:
        """Numbers as C takes them."""
        ...

    def packed_rows(self, rows: Any) -> bytes:
        """A table of numbers, row by row; of doubles an array."""
        ...

    def handed(self, value: N) -> Any:
        """One number as an argument of a call."""
        ...

    def taken(self, value: Any) -> N:
        """One number that a call gave."""
        ...

    def all_taken(self, values: np.ndarray) -> np.ndarray:
        """Numbers that C filled an array of one row with."""
        ...

    def state(self, values: tuple[Any, ...]) -> State[N]:
        """A state that a call gave."""
        ...

    def empty(self, rows: int, columns: int) -> np.ndarray:
        """An array for C to fill with numbers."""
        ...


exponent_of = lru_cache(maxsize=16)(elementary.log2)  # of the one or two tolerances that there are


class DoubleForm:
    """Doubles."""

    kit = Doubles

    @staticmethod
    def run(ints: bytes, numbers: bytes) -> Run:
        import vibsim.engine._engine as _engine

        return _engine.Run(ints, numbers)

    @staticmethod
    def order(scene: Scene) -> int:
        return scene.order

    @staticmethod
    def tolerance_exponent(scene: Scene) -> float:
        return exponent_of(scene.tol)

    @staticmethod
    def packed(values: Sequence[float]) -> bytes:
        return array("d", values).tobytes()

    @staticmethod
    def packed_rows(rows: np.ndarray) -> bytes:
        return rows.tobytes()

    @staticmethod
    def handed(value: float) -> float:
        return value

    @staticmethod
    def taken(value: float) -> float:
        return value

    @staticmethod
    def all_taken(values: np.ndarray) -> np.ndarray:
        return np.array(values)

    @staticmethod
    def state(values: tuple[Any, ...]) -> State:
        return State(*values)

    @staticmethod
    def empty(rows: int, columns: int) -> np.ndarray:
        return np.empty((rows, columns))


class WordsForm(Generic[N]):
    """Numbers of `words` words, for runs on the numbers of `kit`."""

    def __init__(self, kit: DigitsKit[N], words: int) -> None:
        self.kit, self.words = kit, words
        self.name = f"{WORD * words}-bit"
        self._ends = Struct("<ii")  # exponent, sign
        self.type = np.dtype([("words", "<u8", (words,)), ("exponent", "<i4"), ("sign", "<i4")])

    def run(self, ints: bytes, numbers: bytes) -> Run:
        run: Run = import_module(f"vibsim.engine._engine_{self.words}").Run(ints, numbers, self.kit.bits)
        return run

    def order(self, _scene: Scene[N]) -> int:
        return self.kit.order()

    def tolerance_exponent(self, scene: Scene[N]) -> float:
        return self.kit.tolerance_exponent(scene)

    def handed(self, value: N | float) -> bytes:
        """The bytes of the number of words nearest to `value`."""
        number = self.kit.number(value) if isinstance(value, int | float | Fraction) else value
        if not self.kit.finite(number):
            return bytes(8 * self.words) + self._ends.pack(ENDLESS, (number > 0) - (number < 0))
        mantissa, exponent = self.kit.parts(number)
        size = abs(mantissa)
        if not size:
            return bytes(8 * self.words + self._ends.size)
        extra = size.bit_length() - WORD * self.words
        if extra > 0:
            size = (size + (1 << (extra - 1))) >> extra
            if size.bit_length() > WORD * self.words:
                size, extra = size >> 1, extra + 1
        else:
            size <<= -extra
        exponent += extra + WORD * self.words
        return size.to_bytes(8 * self.words, "little") + self._ends.pack(exponent, 1 if mantissa > 0 else -1)

    def packed(self, values: Iterable[N | float]) -> bytes:
        return b"".join(map(self.handed, values))

    def packed_rows(self, rows: Iterable[Iterable[N | float]]) -> bytes:
        return b"".join(map(self.packed, rows))

    def parts(self, value: bytes) -> tuple[int, int]:
        """Whole numbers m, e with value = m 2**e, of a finite number of words."""
        mantissa = int.from_bytes(value[: 8 * self.words], "little")
        exponent, sign = self._ends.unpack_from(value, 8 * self.words)
        return sign * mantissa, exponent - WORD * self.words if sign else 0

    def taken(self, value: bytes) -> N:
        exponent, sign = self._ends.unpack_from(value, 8 * self.words)
        if exponent == ENDLESS:
            return self.kit.inf * self.kit.number(sign)
        return self.kit.of_parts(*self.parts(value))

    def all_taken(self, values: np.ndarray) -> np.ndarray:
        """As objects."""
        numbers = np.empty(len(values), dtype=object)
        numbers[:] = [self.taken(one) for one in self._each(values)]
        return numbers

    def double(self, value: bytes) -> float:
        """The double nearest to a number that a call gave."""
        exponent, sign = self._ends.unpack_from(value, 8 * self.words)
        return sign * inf if exponent == ENDLESS else nearest_double(*self.parts(value))

    def state(self, values: tuple[Any, ...]) -> State[N]:
        t, x, v, phase, turns, w = values
        one = self.taken
        return State(one(t), list(map(one, x)), list(map(one, v)), one(phase), one(turns), one(w))

    def empty(self, rows: int, columns: int) -> np.ndarray:
        return np.empty((rows, columns), dtype=self.type)

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
        width = text_width(self.kit.digits)
        engine = import_module(f"vibsim.engine._engine_{self.words}")
        made: bytes | None = engine.texts(np.ascontiguousarray(row).tobytes(), self.kit.digits, width)
        if made is None:  # a number beyond 1e300 or so, or none at all
            return np.array(self.kit.texts_of(map(self.parts, self._each(row))), dtype=f"S{width}")
        return np.frombuffer(made, dtype=f"S{width}")

    def _each(self, row: np.ndarray) -> Iterator[bytes]:
        flat, width = np.ascontiguousarray(row).tobytes(), self.type.itemsize
        return (flat[at : at + width] for at in range(0, len(flat), width))


DOUBLES = DoubleForm()


@lru_cache(maxsize=8)
def is_built(words: int) -> bool:
    """Whether the engine in C was built on numbers of so many words."""
    return find_spec(f"vibsim.engine._engine_{words}") is not None


def digits_in_c() -> list[int]:
    """The most decimal digits that each number type of C suffices for, the cheapest first."""
    return [ceil((WORD * words - SPARE_BITS) / BITS_PER_DIGIT) - 1 for words in WORDS if is_built(words)]


def words_form(kit: DigitsKit[N]) -> WordsForm[N] | None:
    """The cheapest form of C that suffices for runs on the numbers of `kit`; None where none does, or where
    the engine was not built on it.
    """
    for words in WORDS:
        if kit.bits + SPARE_BITS <= WORD * words and is_built(words):
            return WordsForm(kit, words)
    return None
