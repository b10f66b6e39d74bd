"""f = exp(-s): then f' = -s' f, and n f_n = -sum i s_i f_(n-i)."""

from vibsim.physics.arithmetic.numbers import Doubles, Kit, N

NUMBER = 1
CIRCLES = (4, 3, 2, 5, 1, 6, 8, 12, 16)  # binary exponents of radius over step, the likeliest first
LN2 = 0.6875  # ln 2, a little less
ALLOWANCE = 4.0  # binary: sqrt(2 pi p), by which Cauchy's estimate lies above the terms of exp(-z)
HALVINGS = 256  # of the square of the step; more are needed by no order and tolerance that a case may ask for


def start(kit: Kit[N], s: N) -> N:
    return kit.exp(-s)


def argument(n: int, s: N) -> N:
    return n * s


def following(total: N, _f: list[N], inverse: N) -> N:
    return -(total * inverse)


def slope(f: N) -> N:
    return -f


def slopes(f: list[N]) -> list[N]:
    """Series of -f."""
    return [-value for value in f]


def reach(arguments: list[N], tolerance_exponent: float, longest: float) -> float:
    """Binary exponent of the longest step, up to `longest`, for which the terms that the series of f
    leaves out stay below the tolerance beside f(0) = 1.

    Far from s = 0 the terms of f are as small as exp(-s_0), and those left out may yet grow up to 1: the
    last ones kept do not tell. With g(r) = sum |s_n| r^n, |f(z)| <= exp(g(|z|) - s_0), so by Cauchy's
    estimate what p terms leave out at h is about exp(g(R) - s_0) (h / R)^p at most, on any circle of
    radius R = 2^k h.
    """
    s = [float(value) for value in arguments]
    sizes = [0.0] + [abs(s[n]) / n for n in range(1, len(s))]
    room = [s[0] + LN2 * (len(s) * k + (tolerance_exponent + ALLOWANCE)) for k in CIRCLES]
    most = Doubles.exponent(room[-1])
    for n in range(1, len(s)):  # what the widest circle asks of each term alone
        if sizes[n] != 0.0:
            longest = min(longest, (most + 1 - Doubles.exponent(sizes[n])) / n - 1.0)
    for _ in range(HALVINGS):
        if longest >= 1000.0 or _converges(sizes, room, Doubles.power_of_two(longest)):
            break
        longest = longest - 0.5
    return longest


def _converges(sizes: list[float], room: list[float], h: float) -> bool:
    """Whether g(2^k h) is within `room` on one of the circles."""
    for i, k in enumerate(CIRCLES):
        radius, growth = 2.0**k * h, 0.0
        for size in reversed(sizes):
            growth = growth * radius + size
        if growth <= room[i]:
            return True
    return False
