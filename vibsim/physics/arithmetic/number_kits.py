"""Which number kit a run of many digits gets: python-flint's balls, or mpmath's floats without it."""

from collections.abc import Iterable
from importlib.util import find_spec
from threading import RLock
from typing import Protocol

from vibsim.lazy_names import named
from vibsim.physics.arithmetic.numbers import Kit, N, Number
from vibsim.physics.arithmetic.working_precision import FEWEST_DIGITS, MOST_DIGITS
from vibsim.physics.parts import Scene

KITS = {
    "flint": "vibsim.physics.arithmetic.multiprecision:Balls",
    "mpmath": "vibsim.physics.arithmetic.big_floats:BigFloats",
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
    def texts(self, values: Iterable[N], /) -> list[str]: ...


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
