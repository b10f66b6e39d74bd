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

    For each c, Eq. (2.1): p + iq = sum of phi_j exp(i c j); Eq. (2.2): its mean square displacement M over n
    steps; Eq. (3.1): D = M less the oscillating part (mean phi)^2 (1 - cos nc)/(1 - cos c). K is the
    correlation of D with n.
    """
    series = np.asarray(series, dtype=float)
    spread = float(np.ptp(series))
    if not spread:
        return float("nan")
    series = (series - series.min()) / spread
    steps = np.arange(1, max(2, len(series) // SHARE) + 1)
    found = [_correlation(steps, _displacement(series, c, steps)) for c in frequencies()]
    return float(np.median(found))


def frequencies() -> np.ndarray:
    """Values of c that fill the range evenly and are no fractions of pi."""
    places = (0.5 + GOLDEN * np.arange(FREQUENCIES)) % 1.0
    return LOWEST + (HIGHEST - LOWEST) * places


def _displacement(series: np.ndarray, c: float, steps: np.ndarray) -> np.ndarray:
    """D of Eq. (3.1) at the steps."""
    path = np.cumsum(series * np.exp(1j * c * np.arange(1, len(series) + 1)))
    kept = len(series) - int(steps[-1])
    moved = [np.mean(np.abs(path[n : n + kept] - path[:kept]) ** 2) for n in steps.tolist()]
    oscillating = series.mean() ** 2 * (1 - np.cos(steps * c)) / (1 - np.cos(c))
    return np.array(moved) - oscillating


def _correlation(steps: np.ndarray, displacement: np.ndarray) -> float:
    """Correlation coefficient; 0 where nothing moves."""
    a, b = steps - steps.mean(), displacement - displacement.mean()
    size = float(np.sqrt((a @ a) * (b @ b)))
    return float(a @ b) / size if size else 0.0
