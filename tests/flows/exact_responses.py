"""C, S, I and H of one oscillator to some 100 digits, and how much rounded arguments move them.

Divided differences of exp(r t) over the roots and the load's exponents, with 200 digits and points that
coincide moved 1e-60 apart: crude, obvious, and right far beyond double precision.
"""

import mpmath

DIGITS = 200
APART = mpmath.mpf(10) ** -60
NUDGE = mpmath.mpf(10) ** -30


def exact_responses(a, b, omega, t):
    """C [-], S [s], I [s^2], H [s^2, complex] and its rate H' [s] at time t.

    Of y'' + 2 a y' + b y, under a load of the frequency omega.
    """
    with mpmath.workdps(DIGITS):
        a, b, omega, t = (mpmath.mpf(value) for value in (a, b, omega, t))
        root = mpmath.sqrt(mpmath.mpc(a * a - b))
        roots = [-a + root, -a - root + APART * (1 + abs(a) + abs(root))]
        apart = APART * (1 + abs(a) + abs(root)) / 3
        S = divided_difference(roots, t)
        steady = divided_difference([*roots, apart], t)
        H = divided_difference([*roots, mpmath.mpc(apart, omega)], t)
        C = (roots[0] * mpmath.exp(roots[1] * t) - roots[1] * mpmath.exp(roots[0] * t)) / (
            roots[0] - roots[1]
        )
        return C.real, S.real, steady.real, H, S.real + mpmath.mpc(0, omega) * H


def divided_difference(points, t):
    """exp(. t)[points]."""
    values = [mpmath.exp(point * t) for point in points]
    for width in range(1, len(points)):
        values = [
            (values[i + 1] - values[i]) / (points[i + width] - points[i]) for i in range(len(values) - 1)
        ]
    return values[0]


def sensitivity(a, b, omega, t):
    """What one relative unit of change in a, b, omega and t moves C, S, I, H by, added up [units of each]."""
    with mpmath.workdps(DIGITS):
        here = exact_responses(a, b, omega, t)
        total = [mpmath.mpf(0)] * 5
        for which in range(4):
            arguments = [mpmath.mpf(value) for value in (a, b, omega, t)]
            arguments[which] *= 1 + NUDGE
            moved = exact_responses(*arguments)
            total = [sum_ + abs(q - p) / NUDGE for sum_, p, q in zip(total, here, moved, strict=True)]
        return here, total
