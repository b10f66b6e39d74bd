"""f = exp(-s): then f' = -s' f, and n f_n = -sum i s_i f_(n-i)."""

from typing import Any

NUMBER = 1


def start(kit: Any, s: Any) -> Any:
    return kit.decay(s)


def argument(n: int, s: Any) -> Any:
    return n * s


def following(total: Any, _f: list[Any], inverse: Any) -> Any:
    return -(total * inverse)


def slope(f: Any) -> Any:
    return -f


def slopes(f: list[Any]) -> list[Any]:
    """Series of -f."""
    return [-value for value in f]
