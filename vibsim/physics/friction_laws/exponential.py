"""f = exp(-s): then f' = -s' f, and n f_n = -sum i s_i f_(n-i)."""

from vibsim.physics.numbers import Kit, N

NUMBER = 1


def start(kit: Kit[N], s: N) -> N:
    return kit.decay(s)


def argument(n: int, s: N) -> N:
    return n * s


def following(total: N, _f: list[N], inverse: N) -> N:
    return -(total * inverse)


def slope(f: N) -> N:
    return -f


def slopes(f: list[N]) -> list[N]:
    """Series of -f."""
    return [-value for value in f]
