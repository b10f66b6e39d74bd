"""Settings of the number kits of any precision: bits, tolerance and order for so many decimal digits."""

from collections.abc import Iterable
from importlib.util import find_spec
from threading import RLock
from typing import Generic, Protocol

from vibsim.lazy import named
from vibsim.physics import elementary
from vibsim.physics.numbers import Kit, N, Number, decimal_text, nearest_double
from vibsim.physics.parts import Scene

GUARD_BITS = 32
BITS_PER_DIGIT = 3.3219280948873626
FEWEST_DIGITS, MOST_DIGITS = 20, 1000


class WorkingPrecision(Generic[N]):
    """A precision of `digits` decimal digits; `bits` say the same, arithmetic goes GUARD_BITS beyond.

    A kit adds its arithmetic and `parts(x)`: whole numbers m, e with x = m 2**e.
    """

    no_exponent = -(10**6)

    def __init__(self, digits: int) -> None:
        self.digits = digits
        self.bits = int(digits * BITS_PER_DIGIT) + 1
        self.series_terms = self._terms()

    def _terms(self) -> int:
        """Terms after which 2^n / n! is below round-off."""
        n, exponent = 1, 1.0
        while exponent > -self.bits - 4:
            n += 1
            exponent += 1 - elementary.log2(n)
        return n

    def order(self, _scene: Scene[N] | None = None) -> int:
        """Order of the Taylor flow: half the logarithm of the precision, where the work per time is least."""
        return max(20, int(0.36 * self.bits))

    def tolerance_exponent(self, _scene: Scene[N] | None = None) -> float:
        """The Taylor flow goes to the working precision."""
        return -float(self.bits)

    def parts(self, x: N) -> tuple[int, int]:
        """Whole numbers m, e with x = m 2**e: each kit's own."""
        raise NotImplementedError

    def exponent(self, x: N) -> int:
        """Binary exponent of x; `no_exponent` for x = 0."""
        mantissa, exponent = self.parts(x)
        return exponent + mantissa.bit_length() if mantissa else self.no_exponent

    def rounded(self, values: Iterable[N | float]) -> list[float]:
        """The doubles nearest to `values`."""
        return [value if isinstance(value, float) else nearest_double(*self.parts(value)) for value in values]

    def texts(self, values: Iterable[N]) -> list[str]:
        """`values` as decimal texts of all `digits`."""
        return self.texts_of(map(self.parts, values))

    def texts_of(self, parts: Iterable[tuple[int, int]]) -> list[str]:
        """The same of whole numbers m, e that stand for m 2**e."""
        return [decimal_text(one, self.digits) for one in parts]


# Which number kit a run of many digits gets: python-flint's balls, or mpmath's floats without it.


KITS = {
    "flint": "vibsim.physics.multiprecision:Balls",
    "mpmath": "vibsim.physics.big_floats:BigFloats",
}
MISSING = "digits beyond double precision need python-flint (or mpmath): pip install 'vibsim[reference]'"


one_precision = RLock()  # held while a kit is at work: libraries have one working precision in a process


class DigitsKit(Kit[N], Protocol[N]):
    """A kit of so many digits; `library` is the name and version of what computes with them."""

    @property
    def library(self) -> str: ...
    @property
    def digits(self) -> int: ...
    @property
    def bits(self) -> int: ...
    @property
    def pi(self) -> N: ...
    @property
    def two_pi(self) -> N: ...
    def activate(self) -> None: ...
    def order(self, scene: Scene[N] | None = None, /) -> int: ...
    def parts(self, x: N, /) -> tuple[int, int]: ...
    def of_parts(self, mantissa: int, exponent: int, /) -> N: ...
    def texts(self, values: Iterable[N], /) -> list[str]: ...
    def texts_of(self, parts: Iterable[tuple[int, int]], /) -> list[str]: ...


class MultiprecisionMissing(ImportError):
    """Neither python-flint nor mpmath is installed; the message names the extra."""


def installed_library() -> str:
    """Name of the package that runs of many digits use here. Raises MultiprecisionMissing without any."""
    library = next((name for name in KITS if find_spec(name) is not None), None)
    if library is None:
        raise MultiprecisionMissing(MISSING)
    return library


def number_kit(digits: int) -> DigitsKit[Number]:
    """The kit of `digits` decimal digits.

    Raises ValueError for digits outside FEWEST_DIGITS to MOST_DIGITS, MultiprecisionMissing.
    """
    if not FEWEST_DIGITS <= digits <= MOST_DIGITS:
        raise ValueError(f"digits must be {FEWEST_DIGITS} to {MOST_DIGITS}, got {digits}")
    kit: DigitsKit[Number] = named(KITS[installed_library()])(digits)
    return kit
