"""f = 1 / (1 + s): then (1 + s) f = 1, and f_n = -f_0 sum s_i f_(n-i)."""

from typing import Any

NUMBER = 0


def start(_kit: Any, s: Any) -> Any:
    return 1 / (1 + s)


def argument(_n: int, s: Any) -> Any:
    return s


def following(total: Any, f: list[Any], _inverse: Any) -> Any:
    return -(f[0] * total)


def slope(f: Any) -> Any:
    return -(f * f)


def slopes(f: list[Any]) -> list[Any]:
    """Series of -f^2."""
    series = []
    for n in range(len(f)):
        total = f[0] * f[n]
        for i in range(1, n + 1):
            total = total + f[i] * f[n - i]
        series.append(-total)
    return series
