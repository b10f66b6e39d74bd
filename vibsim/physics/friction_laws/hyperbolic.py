"""f = 1 / (1 + s): then (1 + s) f = 1, and f_n = -f_0 sum s_i f_(n-i)."""

from vibsim.physics.arithmetic.numbers import Kit, N

NUMBER = 0


def start(_kit: Kit[N], s: N) -> N:
    return 1 / (1 + s)


def argument(_n: int, s: N) -> N:
    return s


def following(total: N, f: list[N], _inverse: N) -> N:
    return -(f[0] * total)


def slope(f: N) -> N:
    return -(f * f)


def slopes(f: list[N]) -> list[N]:
    """Series of -f^2."""
    series = []
    for n in range(len(f)):
        total = f[0] * f[n]
        for i in range(1, n + 1):
            total = total + f[i] * f[n - i]
        series.append(-total)
    return series


def reach(_arguments: list[N], _tolerance_exponent: float, longest: float) -> float:
    """`longest`: the terms of f shrink from each to the next as those do that a step is measured by."""
    return longest
