"""The number types of the engine in C: how Python's numbers go into it and come back.

Doubles go as they are. For runs of many digits the same engine is built on numbers of words of 64 bits
(`numbers/limbs.h`): a mantissa, an exponent and a sign. Up to 71 digits these are 2, 3 or 4 words, and each
number of words has an engine of its own. Beyond them one engine takes up to MOST_WORDS, and uses as many as
the digits of a run need. Numbers of python-flint or mpmath are rounded to them once, and those that come back
are exact.
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
from vibsim.physics.precision import BITS_PER_DIGIT, DigitsKit, MultiprecisionMissing

if TYPE_CHECKING:
    from vibsim.engine._engine import Run
    from vibsim.physics.parts import Scene

WORD, ENDLESS = 64, 2**31 - 1  # bits of a word; exponent of what is infinite
SPARE_BITS = 20  # that a number of words has beyond the unit round-off of a run, at least
WORDS = (2, 3, 4)  # of the engines that have a number of words of their own, see setup.py
MOST_WORDS = 53  # that the engine for any number of words can use; its numbers have room for one more
LEAST_ROOM = 40  # bytes of a number that rooms for results are measured by
NOT_BUILT = (
    "digits beyond double precision need the engine on words, which was not built here: its compiler has to"
    " have whole numbers of 128 bits, as gcc, clang and the package ziglang have"
)


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

    def room(self, most: int) -> int:
        """How many columns such an array may have where it would be `most` of numbers of few words."""
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

    @staticmethod
    def room(most: int) -> int:
        return most


class WordsForm(Generic[N]):
    """Numbers of `words` words, for runs on the numbers of `kit`.

    any_number : whether the engine for any number of words takes them, in whose numbers they are the highest
        of those that there is room for; as it has to where no engine was built for so many alone
    """

    def __init__(self, kit: DigitsKit[N], words: int, any_number: bool = False) -> None:
        self.kit, self.words = kit, words
        self.name = f"{WORD * words}-bit"
        self._module = engine_name(0 if any_number else words)
        room = words if words in WORDS and not any_number else MOST_WORDS + 1
        self._before, self._end = 8 * (room - words), 8 * room  # bytes: where words in use begin and end
        self._ends = Struct("<ii")  # exponent, sign
        self.type = np.dtype(
            {
                "names": ["words", "exponent", "sign"],
                "formats": [("<u8", (words,)), "<i4", "<i4"],
                "offsets": [self._before, self._end, self._end + 4],
                "itemsize": self._end + self._ends.size,
            }
        )

    @property
    def engine(self) -> Any:
        """The module of the engine on these numbers."""
        return import_module(self._module)

    def run(self, ints: bytes, numbers: bytes) -> Run:
        run: Run = self.engine.Run(ints, numbers, self.kit.bits)
        return run

    def order(self, _scene: Scene[N]) -> int:
        return self.kit.order()

    def tolerance_exponent(self, scene: Scene[N]) -> float:
        return self.kit.tolerance_exponent(scene)

    def handed(self, value: N | float) -> bytes:
        """The bytes of the number of words nearest to `value`."""
        number = self.kit.number(value) if isinstance(value, int | float | Fraction) else value
        if not self.kit.finite(number):
            return bytes(self._end) + self._ends.pack(ENDLESS, (number > 0) - (number < 0))
        mantissa, exponent = self.kit.parts(number)
        size = abs(mantissa)
        if not size:
            return bytes(self._end + self._ends.size)
        extra = size.bit_length() - WORD * self.words
        if extra > 0:
            size = (size + (1 << (extra - 1))) >> extra
            if size.bit_length() > WORD * self.words:
                size, extra = size >> 1, extra + 1
        else:
            size <<= -extra
        exponent += extra + WORD * self.words
        words = bytes(self._before) + size.to_bytes(8 * self.words, "little")
        return words + self._ends.pack(exponent, 1 if mantissa > 0 else -1)

    def packed(self, values: Iterable[N | float]) -> bytes:
        return b"".join(map(self.handed, values))

    def packed_rows(self, rows: Iterable[Iterable[N | float]]) -> bytes:
        return b"".join(map(self.packed, rows))

    def parts(self, value: bytes) -> tuple[int, int]:
        """Whole numbers m, e with value = m 2**e, of a finite number of words."""
        mantissa = int.from_bytes(value[self._before : self._end], "little")
        exponent, sign = self._ends.unpack_from(value, self._end)
        return sign * mantissa, exponent - WORD * self.words if sign else 0

    def taken(self, value: bytes) -> N:
        exponent, sign = self._ends.unpack_from(value, self._end)
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
        exponent, sign = self._ends.unpack_from(value, self._end)
        return sign * inf if exponent == ENDLESS else nearest_double(*self.parts(value))

    def state(self, values: tuple[Any, ...]) -> State[N]:
        t, x, v, phase, turns, w = values
        one = self.taken
        return State(one(t), list(map(one, x)), list(map(one, v)), one(phase), one(turns), one(w))

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
        made: bytes | None = self.engine.texts(
            np.ascontiguousarray(row).tobytes(), digits, width, self.kit.bits
        )
        if made is None:  # a number beyond 1e300 or so, or none at all
            return np.array(self.kit.texts_of(map(self.parts, self._each(row))), dtype=f"S{width}")
        return np.frombuffer(made, dtype=f"S{width}")

    def _each(self, row: np.ndarray) -> Iterator[bytes]:
        flat, width = np.ascontiguousarray(row).tobytes(), self.type.itemsize
        return (flat[at : at + width] for at in range(0, len(flat), width))


DOUBLES = DoubleForm()


def engine_name(words: int) -> str:
    """Name of the module of the engine on numbers of so many words."""
    return f"vibsim.engine._engine_{words if words in WORDS else 'words'}"


@lru_cache(maxsize=8)
def is_built(words: int) -> bool:
    """Whether the engine in C was built on numbers of so many words."""
    return find_spec(engine_name(words)) is not None


def digits_in_c() -> list[int]:
    """The most decimal digits of each number type of C with an engine of its own, the cheapest first."""
    return [ceil((WORD * words - SPARE_BITS) / BITS_PER_DIGIT) - 1 for words in WORDS]


def words_form(kit: DigitsKit[N]) -> WordsForm[N]:
    """The cheapest form of C that suffices for runs on the numbers of `kit`. Raises MultiprecisionMissing
    where the engine was not built on it.
    """
    words = max(min(WORDS), ceil((kit.bits + SPARE_BITS) / WORD))
    if not is_built(words):
        raise MultiprecisionMissing(NOT_BUILT)
    return WordsForm(kit, words)
