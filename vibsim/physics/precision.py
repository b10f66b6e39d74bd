"""Number kits of any precision: on python-flint's arb, or some thirty times slower on mpmath without it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from fractions import Fraction
from importlib.util import find_spec
from threading import RLock
from typing import Any, Generic, Protocol

from vibsim.physics.numbers import Kit, N, Number, beyond, decimal_text, nearest_double
from vibsim.physics.parts import Scene

GUARD_BITS = 32
BITS_PER_DIGIT = 3.3219280948873626
FEWEST_DIGITS, MOST_DIGITS = 20, 1000


class WorkingPrecision(Generic[N]):
    """A precision of `digits` decimal digits; `bits` say the same, arithmetic goes GUARD_BITS beyond.

    A kit adds its arithmetic, `parts(x)`: whole numbers m, e with x = m 2**e, and `nearest(x)`.
    """

    no_exponent = -(10**6)
    eps: N
    two_pi: N
    number: Callable[[Any], N]
    nearest: Callable[[Any], N]
    sine_cosine: Callable[[Any], tuple[N, N]]

    def __init__(self, digits: int) -> None:
        self.digits = digits
        self.bits = int(digits * BITS_PER_DIGIT) + 1

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

    def rounded_sine_cosine(self, angle: Any) -> tuple[N, N]:
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

    def unwind(self, angle: N, turns: N) -> N:
        """angle + 2 pi turns [rad]."""
        return angle + turns * self.two_pi


Ball = Any  # flint.arb
BigFloat = Any  # mpf: mpmath tells no types


class Balls(WorkingPrecision[Ball]):
    """Arithmetic of `digits` decimal digits, on python-flint's arb. There is one working precision in a
    process at a time: the last kit made sets it.

    Arb numbers carry a radius. The state is stripped of it where a segment starts (`State.settled`), because
    radii follow worst cases while the right digits of a chaotic run are told by its own error growth: compare
    two precisions. Inside a segment decisions are those of doubles: event functions are compared without
    radii, so that one that rests at zero is zero. The unit round-off `eps` stands GUARD_BITS above the
    working precision: radii are far below what a decision allows for rounding.
    """

    name = "arb"

    def __init__(self, digits: int) -> None:
        import flint

        super().__init__(digits)
        self.arb, self._fraction, self._context = flint.arb, flint.fmpq, flint.ctx
        self.library = f"python-flint {flint.__version__}"
        self.activate()
        self.eps = self.arb(2) ** -self.bits
        self.inf = self.arb("inf")
        self.pi = self.arb.pi()
        self.two_pi = 2 * self.pi

    def activate(self) -> None:
        """Make this kit's precision that of the process."""
        self._context.prec = self.bits + GUARD_BITS

    @staticmethod
    def exact(t: Ball) -> Ball:
        """The time `t` without its radius."""
        return t.mid()

    @staticmethod
    def all_exact(values: list[Ball]) -> list[Ball]:
        """The list `values` without radii."""
        return [value.mid() for value in values]

    def number(self, value: Ball | float | Fraction) -> Ball:
        """`value` as arb."""
        if isinstance(value, Fraction):
            return self.arb(self._fraction(value.numerator, value.denominator))
        return self.arb(value)

    sin = staticmethod(lambda x: x.sin())
    cos = staticmethod(lambda x: x.cos())
    sine_cosine = staticmethod(lambda x: x.sin_cos())
    exp = staticmethod(lambda x: x.exp())
    expm1 = staticmethod(lambda x: x.expm1())
    log = staticmethod(lambda x: x.log())
    sinh = staticmethod(lambda x: x.sinh())
    cosh = staticmethod(lambda x: x.cosh())
    tanh = staticmethod(lambda x: x.tanh())
    asin = staticmethod(lambda x: x.asin())
    acos = staticmethod(lambda x: x.acos())
    atan = staticmethod(lambda x: x.atan())
    finite = staticmethod(lambda x: x.is_finite())

    @staticmethod
    def sqrt(x: Ball) -> Ball:
        """Square root; of the non-negative part where x is zero but for its radius."""
        return x.nonnegative_part().sqrt() if not x > 0 else x.sqrt()

    def power(self, a: Ball, p: Ball) -> Ball:
        """a**p for a >= 0, nan of a below 0. Of a that is zero but for its radius: from 0 to the power of the
        greatest that it may be; infinite for p < 0.
        """
        if a > 0 and a.is_finite():
            return a**p
        if p == 0 or a < 0 or not (a >= 0 or a.is_finite()):
            return self.number(1) if p == 0 else self.number(math.nan)
        if p < 0 or not a.is_finite():
            return self.number(0) if p < 0 and a > 0 else self.inf
        return (a.nonnegative_part().upper() ** p).union(self.number(0)) if a != 0 else a

    def next_after(self, t: Ball, _towards: float) -> Ball:
        """The next larger time: one unit in the last place on."""
        return (t + (abs(t) + self.eps) * self.eps).mid()

    @staticmethod
    def parts(x: Ball) -> tuple[int, int]:
        """Whole numbers m, e of the middle m 2**e of x."""
        mantissa, exponent = x.mid().man_exp()
        return int(mantissa), int(exponent)

    def of_parts(self, mantissa: int, exponent: int) -> Ball:
        """mantissa 2**exponent, exactly."""
        return self.arb((mantissa, exponent))

    def power_of_two(self, y: float) -> Ball:
        """2**y for a float y."""
        return self.arb(2) ** self.arb(y)

    @staticmethod
    def nearest(turns: Ball) -> Ball:
        """The whole number nearest to the middle of `turns`. Rounding is taken off before the floor: that of
        a ball which holds a whole number is two numbers.
        """
        return (turns.mid() + 0.5).mid().floor()


class BigFloats(WorkingPrecision[BigFloat]):
    """Arithmetic of `digits` decimal digits on mpmath's numbers, in a context of its own.

    They are plain floats without a radius: decisions close to round-off go by the margin `eps` alone, which
    stands GUARD_BITS above the working precision.
    """

    name = "mpf"

    def __init__(self, digits: int) -> None:
        import mpmath

        super().__init__(digits)
        self.library = f"mpmath {mpmath.__version__}"
        self._from_parts = mpmath.libmp.from_man_exp
        self.context = context = mpmath.mp.clone()
        context.prec = self.bits + GUARD_BITS
        self.eps = context.ldexp(1, -self.bits)
        self.inf = context.inf
        self.pi = +context.pi
        self.two_pi = 2 * self.pi
        self.sin, self.cos, self.exp, self.expm1 = context.sin, context.cos, context.exp, context.expm1
        self.sinh, self.cosh, self.log = context.sinh, context.cosh, context.log
        self.tanh, self.atan = context.tanh, context.atan
        self.finite = context.isfinite

    def sine_cosine(self, x: BigFloat) -> tuple[BigFloat, BigFloat]:
        """Sine and cosine of an angle [rad]."""
        cosine, sine = self.context.cos_sin(x)
        return sine, cosine

    def activate(self) -> None:
        """Nothing to do: the precision belongs to the numbers' context."""

    def number(self, value: BigFloat | float | Fraction) -> BigFloat:
        """`value` as mpf."""
        if isinstance(value, Fraction):
            return self.context.mpf(value.numerator) / value.denominator
        return self.context.mpf(value)

    @staticmethod
    def exact(t: BigFloat) -> BigFloat:
        """The time `t` on the grid of the number type."""
        return t

    @staticmethod
    def all_exact(values: list[BigFloat]) -> list[BigFloat]:
        """The list `values`: they carry nothing besides their digits."""
        return values

    def asin(self, x: BigFloat) -> BigFloat:
        """Angle [rad] from -pi/2 to pi/2 of a sine; nan beyond 1."""
        return self.context.asin(x) if abs(x) <= 1 else self.context.nan

    def acos(self, x: BigFloat) -> BigFloat:
        """Angle [rad] from 0 to pi of a cosine; nan beyond 1."""
        return self.context.acos(x) if abs(x) <= 1 else self.context.nan

    def power(self, a: BigFloat, p: BigFloat) -> BigFloat:
        """a**p for a >= 0, nan of a below 0."""
        if p == 0 or not a >= 0:
            return self.number(1) if p == 0 else self.context.nan
        if a == 0:
            return self.inf if p < 0 else a
        return self.context.power(a, p)

    def sqrt(self, x: BigFloat) -> BigFloat:
        """Square root; 0 where rounding has left x below it."""
        return self.context.sqrt(x) if x > 0 else self.context.zero

    def next_after(self, t: BigFloat, _towards: float) -> BigFloat:
        """The next larger time: one unit in the last place on."""
        return t + (abs(t) + self.eps) * self.eps

    @staticmethod
    def parts(x: Any) -> tuple[int, int]:
        """Whole numbers m, e with x = m 2**e."""
        sign, mantissa, exponent, _ = x._mpf_
        return (-int(mantissa) if sign else int(mantissa)), int(exponent)

    def of_parts(self, mantissa: int, exponent: int) -> BigFloat:
        """mantissa 2**exponent, exactly."""
        return self.context.make_mpf(self._from_parts(mantissa, exponent))

    def power_of_two(self, y: float) -> BigFloat:
        """2**y for a float y."""
        return self.context.mpf(2) ** y

    def nearest(self, turns: BigFloat) -> BigFloat:
        """The whole number nearest to `turns`."""
        return self.context.floor(turns + 0.5)


# Which number kit a run of many digits gets: python-flint's balls, or mpmath's floats without it.


KITS: dict[str, type[Any]] = {"flint": Balls, "mpmath": BigFloats}
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
    kit: DigitsKit[Number] = KITS[installed_library()](digits)
    return kit
