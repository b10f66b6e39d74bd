"""Multipliers of conservative orbits: some are 1 because energy and momenta are kept, the others come as
mu and 1 / mu.

What is kept gives left eigenvectors of the derivative P' with eigenvalue 1, and disturbances that change
nothing of it stay such. Restricted to these P' has the other multipliers alone. Their characteristic
polynomial q is palindromic (the restricted map is symplectic): q(x) = x^k Q(x + 1/x), with a polynomial Q of
degree k in tau = mu + 1/mu. An orbit is spectrally stable while all tau are real and within [-2, 2]. It loses
that where a tau passes 2 (a branch point, or the energy turns round), where one passes -2 (period doubling),
or where two within that interval meet and become complex: four multipliers leave the circle at once (Krein
1950; stability of nonlinear normal modes by multipliers: Peeters et al. 2009).
"""

from collections.abc import Sequence
from itertools import combinations
from math import sqrt

import numpy as np
from numpy.polynomial import chebyshev

from vibsim.once import once
from vibsim.orbits.matrices import directions, eigenvalues, length_of, modulus, product, square_root


def restricted(matrix: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """A matrix (m, m) on the vectors that `rows` (t, m), left eigenvectors of it, are orthogonal to."""
    _, vectors, _ = directions(rows / np.array([[length_of(row)] for row in rows]))
    within = vectors[len(rows) :]
    return product(product(within, matrix), within.T)


class Reciprocal:
    """The k pairs of multipliers mu, 1 / mu of a restricted derivative (2k, 2k)."""

    def __init__(self, inner: np.ndarray):
        self.inner = inner

    @once
    def series(self) -> np.ndarray:
        """Q(tau) as a Chebyshev series in tau / 2, since x^j + x^-j = 2 T_j(tau / 2)."""
        factors = [1 + 0j]  # of the characteristic polynomial, the highest power first
        for mu in eigenvalues(self.inner) if len(self.inner) else ():
            factors = [one - mu * other for one, other in zip([*factors, 0j], [0j, *factors], strict=True)]
        coefficients = np.array([each.real for each in factors])
        middle = len(self.inner) // 2
        series = (coefficients[middle::-1] + coefficients[middle:]).copy()
        series[0] /= 2
        return np.asarray(series)

    @once
    def traces(self) -> list[complex]:
        """tau = mu + 1/mu of each pair."""
        if len(self.series) < 2:
            return []
        return [2 * root for root in eigenvalues(chebyshev.chebcompanion(self.series))]

    @property
    def fold(self) -> float:
        """det(1 - P') without the kept: Q(2), zero with a pair at 1."""
        return float(chebyshev.chebval(1.0, self.series))

    @property
    def doubling(self) -> float:
        """det(1 + P') without the kept, but for its sign: Q(-2), zero with a pair at -1."""
        return float(chebyshev.chebval(-1.0, self.series))

    @once
    def collision(self) -> float:
        """Discriminant of Q: zero where two pairs meet, negative where two have become complex."""
        product = complex(1.0)
        for one, other in combinations(self.traces, 2):
            product *= (one - other) ** 2
        return product.real

    @property
    def outside(self) -> int:
        """Number of multipliers outside the unit circle: one of each pair whose tau is not in [-2, 2]."""
        return sum(tau.imag != 0 or abs(tau.real) > 2 for tau in self.traces)

    @property
    def multipliers(self) -> list[complex]:
        """All 2k, of each pair the one not inside the circle first."""
        return [mu for tau in self.traces for mu in _pair(tau)]


def _pair(tau: complex) -> Sequence[complex]:
    """mu and 1 / mu of their sum."""
    half = tau / 2
    if tau.imag == 0 and abs(half.real) <= 1:
        rise = sqrt((1 - half.real) * (1 + half.real))
        return complex(half.real, rise), complex(half.real, -rise)
    root = square_root(half * half - 1)
    mu = max(half + root, half - root, key=modulus)
    return mu, 1 / mu
