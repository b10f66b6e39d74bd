"""The 0-1 test for chaos: K near 1 for a chaotic series, near 0 for a regular one.

Gottwald and Melbourne, "On the implementation of the 0-1 test for chaos", SIAM J. Appl. Dyn. Syst. 8 (2009)
129: the modified mean square displacement, the correlation method, and the median over many frequencies c.
"""

import numpy as np

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
    path = np.cumsum(series * np.exp(1j * c * np.arange(1, len(series) + 1)), axis=1)
    oscillating = series.mean() ** 2 * (1 - np.cos(steps * c)) / (1 - np.cos(c))
    return float(np.median(correlations(steps, square_displacements(path, steps) - oscillating)))


def frequencies() -> np.ndarray:
    """Values of c that fill the range evenly and are no fractions of pi."""
    places = (0.5 + GOLDEN * np.arange(FREQUENCIES)) % 1.0
    return LOWEST + (HIGHEST - LOWEST) * places


def square_displacements(path: np.ndarray, steps: np.ndarray) -> np.ndarray:
    """Mean of |path[j + n] - path[j]|^2 over the first j, for the n of `steps` (m); the same j for all.

    path (k, count), complex; result (k, m). |b - a|^2 = |b|^2 + |a|^2 - 2 Re(a* b): sums, and a Fourier
    transform for the products.
    """
    count = path.shape[1]
    kept = count - int(steps[-1])
    length = 2 ** (count + kept).bit_length()
    first, whole = np.fft.fft(path[:, :kept], length), np.fft.fft(path, length)
    products = np.fft.ifft(np.conj(first) * whole)[:, steps].real
    sums = np.cumsum(np.abs(path) ** 2, axis=1)
    later = sums[:, steps + kept - 1] - sums[:, steps - 1]
    return (later + sums[:, kept - 1 : kept] - 2 * products) / kept


def correlations(steps: np.ndarray, displacements: np.ndarray) -> np.ndarray:
    """Correlation coefficient with the steps (m) of each row (k, m); 0 where nothing moves."""
    a = steps - steps.mean()
    b = displacements - displacements.mean(axis=1, keepdims=True)
    size = np.sqrt((a @ a) * np.sum(b * b, axis=1))
    return np.divide(b @ a, size, out=np.zeros(len(b)), where=size > 0)
