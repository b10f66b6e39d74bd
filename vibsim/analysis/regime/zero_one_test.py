"""The 0-1 test for chaos: K near 1 for a chaotic series, near 0 for a regular one.

Gottwald and Melbourne, "On the implementation of the 0-1 test for chaos", SIAM J. Appl. Dyn. Syst. 8 (2009)
129: the modified mean square displacement, the correlation method, and the median over many frequencies c.
"""

import numpy as np

from vibsim.physics.arithmetic.sines import sine_cosine
from vibsim.physics.arithmetic.sums import dot, mean

FREQUENCIES = 100
LOWEST, HIGHEST = np.pi / 5, 4 * np.pi / 5  # of c; nearer to 0 and pi lie resonances of every series
SHARE = 10  # displacements over up to 1/10 of the series
GOLDEN = (np.sqrt(5) - 1) / 2


def zero_one(series: np.ndarray) -> float:
    """K of a series (n) sampled so far apart that neighbours are not alike; nan for a constant one.

    For each c the path p + iq = sum of phi_j exp(i c j) is formed, then its mean square displacement M over n
    steps, then D = M less the oscillating part (mean phi)^2 (1 - cos nc)/(1 - cos c). D grows with n where
    the path diffuses, as under chaos, and stays bounded else: K is the correlation of D with n.
    """
    series = np.asarray(series, dtype=float)
    spread = float(np.ptp(series))
    if not spread:
        return float("nan")
    series = (series - series.min()) / spread
    steps = np.arange(1, max(2, len(series) // SHARE) + 1)
    c = frequencies()[:, np.newaxis]
    sine, cosine = sine_cosine(c * np.arange(1, len(series) + 1))
    p, q = np.cumsum(series * cosine, axis=1), np.cumsum(series * sine, axis=1)
    oscillating = mean(series) ** 2 * (1 - cosine[:, steps - 1]) / (1 - cosine[:, :1])
    return float(np.median(correlations(steps, square_displacements(p, q, steps) - oscillating)))


def frequencies() -> np.ndarray:
    """Values of c that fill the range evenly and are no fractions of pi."""
    places = (0.5 + GOLDEN * np.arange(FREQUENCIES)) % 1.0
    return np.asarray(LOWEST + (HIGHEST - LOWEST) * places)


def square_displacements(p: np.ndarray, q: np.ndarray, steps: np.ndarray) -> np.ndarray:
    """Mean of (p[j + n] - p[j])^2 + (q[j + n] - q[j])^2 over the first j, for the n of `steps` (m).

    p, q (k, count); result (k, m), the same j for all n. (b - a)^2 = b^2 + a^2 - 2 a b: sums, and Fourier
    transforms for the products.
    """
    count = p.shape[1]
    starts = count - int(steps[-1])
    products = _lagged_products(p, starts, steps) + _lagged_products(q, starts, steps)
    sums = np.cumsum(p * p + q * q, axis=1)
    later = sums[:, steps + starts - 1] - sums[:, steps - 1]
    return np.asarray((later + sums[:, starts - 1 : starts] - 2 * products) / starts)


def _lagged_products(x: np.ndarray, starts: int, steps: np.ndarray) -> np.ndarray:
    """Sums of x[j] x[j + n] over the first `starts` j, for the n of `steps`: (k, m).

    Complex numbers are multiplied in parts: numpy's own products round differently on processors with FMA.
    """
    length = 2 ** (x.shape[1] + starts).bit_length()
    first, whole = np.fft.rfft(x[:, :starts], length), np.fft.rfft(x, length)
    spectrum = np.empty_like(whole)
    spectrum.real = first.real * whole.real + first.imag * whole.imag
    spectrum.imag = first.real * whole.imag - first.imag * whole.real
    return np.fft.irfft(spectrum, length)[:, steps]


def correlations(steps: np.ndarray, displacements: np.ndarray) -> np.ndarray:
    """Correlation coefficient with the steps (m) of each row (k, m); 0 where nothing moves."""
    a = steps - mean(steps)
    b = displacements - mean(displacements)[:, np.newaxis]
    size = np.sqrt(dot(a, a) * dot(b, b))
    return np.asarray(np.divide(dot(b, a), size, out=np.zeros(len(b)), where=size > 0))
