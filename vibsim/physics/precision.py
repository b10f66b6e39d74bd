"""Numbers of many digits: those of the engine in C on words, for what Python computes and decides.

For runs of many digits the engine is built on numbers of words of 64 bits (`engine/numbers/limbs.h`): a
mantissa, an exponent and a sign. Up to 71 digits these are 2, 3 or 4 words, and each number of words has an
engine of its own. Beyond them one engine takes up to MOST_WORDS, and uses as many as the digits of a run
need.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from fractions import Fraction
from functools import lru_cache
from importlib import import_module
from math import ceil
from typing import Any, Generic

from vibsim import __version__
from vibsim.physics.numbers import N, Number, abs, beyond, decimal_text
from vibsim.physics.parts import Scene

WORD = 64  # bits of a word
SPARE_BITS = 20  # that a number has beyond the unit round-off of a run, at least
WORDS = (2, 3, 4)  # of the engines that have a number of words of their own, see setup.py
MOST_WORDS = 53  # that the engine for any number of words can use; its numbers have room for one more
BITS_PER_DIGIT = 3.3219280948873626
FEWEST_DIGITS, MOST_DIGITS = 20, 1000
NOT_BUILT = (
    "digits beyond double precision need the engine on words, which was not built here: its compiler has to"
    " have whole numbers of 128 bits, as gcc, clang and the package ziglang have"
)


class MultiprecisionMissing(ImportError):
    """The engine was not built on numbers of so many words."""


def engine_name(words: int) -> str:
    """Name of the module of the engine on numbers of so many words."""
    return f"vibsim.engine._engine_{words if words in WORDS else 'words'}"


@lru_cache(maxsize=8)
def is_built(words: int) -> bool:
    """Whether the engine in C was built on numbers of so many words."""
    try:
        import_module(engine_name(words))
    except ModuleNotFoundError:
        return False
    return True


def digits_in_c() -> list[int]:
    """The most decimal digits of each number type of C with an engine of its own, the cheapest first."""
    return [ceil((WORD * words - SPARE_BITS) / BITS_PER_DIGIT) - 1 for words in WORDS]


class DigitsKit(Generic[N]):
    """Arithmetic of `digits` decimal digits, or of `bits`. Numbers have SPARE_BITS more at least: their own
    rounding is far below the unit round-off `eps` that decisions allow for.

    They compute with the precision that their thread has set last (`activate`).
    any_number : whether they are those of the engine for any number of words, however few suffice
    Raises MultiprecisionMissing where the engine was not built on such numbers.
    """

    eps: N
    inf: N
    pi: N
    two_pi: N
    zero: N

    def __init__(self, digits: int, any_number: bool = False) -> None:
        self.digits = digits
        self.bits = int(digits * BITS_PER_DIGIT) + 1
        self.words = max(min(WORDS), ceil((self.bits + SPARE_BITS) / WORD))
        engine = 0 if any_number else self.words
        self.room = engine if engine in WORDS else MOST_WORDS + 1  # words of a number in memory
        if not is_built(engine):
            raise MultiprecisionMissing(NOT_BUILT)
        self.name, self.library = f"{WORD * self.words}-bit", f"vibsim {__version__}"
        of: Any = import_module(engine_name(engine))
        self.engine = of
        self.sin, self.cos, self.sine_cosine = of.sin, of.cos, of.sine_cosine
        self.power, self.sqrt, self.next_after = of.power, of.sqrt, of.next_after
        self.activate()
        self.eps, self.pi, self.zero = of.number(1, -self.bits), of.pi(), of.number(0, 0)
        self.inf, self.two_pi = self.number(float("inf")), 2 * self.pi

    def function(self, name: str) -> Callable[[N], N]:
        """The elementary function that formulas call by that name."""
        of: Callable[[N], N] = getattr(self.engine, name)
        return of

    def activate(self) -> None:
        """Have this thread compute with the kit's precision."""
        self.engine.precision(self.bits)

    def number(self, value: Any) -> N:
        """The number nearest to a number, a float, a whole number or a Fraction."""
        if isinstance(value, float):
            return self.zero + value
        if isinstance(value, int | Fraction):
            return self._nearest_to(*value.as_integer_ratio()) if value else self.zero
        if not isinstance(value, type(self.zero)):
            raise TypeError(f"{value!r} is no number of {self.words} words, nor can it be made one")
        return value

    def _nearest_to(self, over: int, under: int) -> N:
        """The number nearest to a quotient of whole numbers."""
        size = WORD * self.words
        up = size + 1 + under.bit_length() - abs(over).bit_length()  # of one or two bits more than there are
        high, rest = divmod(abs(over) << max(up, 0), under << max(-up, 0))
        extra = high.bit_length() - size
        half, below = 1 << (extra - 1), high & ((1 << extra) - 1)
        mantissa = (high >> extra) + (below > half or (below == half and (rest > 0 or high >> extra & 1)))
        if mantissa.bit_length() > size:
            mantissa, extra = mantissa >> 1, extra + 1
        number: N = self.engine.number(mantissa if over > 0 else -mantissa, extra - up)
        return number

    def parts(self, x: Any) -> tuple[int, int]:
        """Whole numbers m, e with x = m 2**e, of a finite number."""
        parts: tuple[int, int] = x.parts()
        return parts

    def order(self, _scene: Scene[N] | None = None) -> int:
        """Order of the Taylor flow: half the logarithm of the precision, where the work per time is least."""
        return max(20, int(0.36 * self.bits))

    def tolerance_exponent(self, _scene: Scene[N] | None = None) -> float:
        """The Taylor flow goes to the working precision."""
        return -float(self.bits)

    def power_of_two(self, y: float) -> N:
        """2**y for a float y."""
        power: N = self.power(2, y)
        return power

    def rounded(self, values: Iterable[N | float]) -> list[float]:
        """The doubles nearest to `values`."""
        return [float(value) for value in values]

    def texts_of(self, parts: Iterable[tuple[int, int]]) -> list[str]:
        """Numbers m 2**e, by their whole numbers m, e, as decimal texts of all `digits`."""
        return [decimal_text(one, self.digits) for one in parts]

    def rounded_sine_cosine(self, angle: N) -> tuple[N, N]:
        """Sine and cosine of an angle [rad] that is rounded: 0 where rounding hides them."""
        return beyond(self.eps * abs(angle), self.sine_cosine(angle), self.number(0))

    def turn_angle(self, cycles: N, cycles_lo: N, t: N) -> N:
        """2 pi (cycles + cycles_lo) t reduced to [-pi, pi] [rad]."""
        turns = (self.number(cycles) + cycles_lo) * t
        return self.two_pi * (turns - self.nearest(turns))

    def reduce_angle(self, angle: N) -> tuple[N, N]:
        """`angle` [rad] moved into [-pi, pi], and the whole turns taken out."""
        turns = self.nearest(angle / self.two_pi)
        return angle - turns * self.two_pi, turns

    def nearest(self, turns: N) -> N:
        """The whole number nearest to `turns`."""
        whole: N = self.engine.floor(turns + 0.5)
        return whole

    def unwind(self, angle: N, turns: N) -> N:
        """angle + 2 pi turns [rad]."""
        return angle + turns * self.two_pi


def number_kit(digits: int) -> DigitsKit[Number]:
    """The kit of `digits` decimal digits.

    Raises ValueError for digits outside FEWEST_DIGITS to MOST_DIGITS, MultiprecisionMissing.
    """
    if not FEWEST_DIGITS <= digits <= MOST_DIGITS:
        raise ValueError(f"digits must be {FEWEST_DIGITS} to {MOST_DIGITS}, got {digits}")
    return DigitsKit(digits)
