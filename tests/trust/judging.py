"""How good an error estimate is: against the truth, the same case in 45 digits from its exact decimals."""

from dataclasses import dataclass
from decimal import Context, Decimal

import numpy as np

from vibsim.engine.truth import open_truth
from vibsim.results import simulate
from vibsim.results.columns import tables_of

DIGITS = 45  # chaos takes 1e16 from the first error in the longest of these runs
EXACT = Context(prec=1100)
FACTOR = 30.0
TOLERANCES = (1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4)  # [m]


@dataclass(frozen=True)
class Judged:
    """One run: share of the samples whose estimate is within the factor, and of those that are too low.

    samples : those with a true error above one ulp; horizons : tolerance -> (estimated, true) [s] for every
    tolerance that the true error passes
    """

    name: str
    samples: int
    within: float
    too_low: float
    horizons: dict[float, tuple[float, float]]

    @property
    def latest(self):
        """Longest estimated horizon as a multiple of the true one; 0 where no tolerance is passed."""
        return max((estimated / true for estimated, true in self.horizons.values()), default=0.0)


def judged(case) -> Judged:
    """The estimate of `case`, judged at its samples."""
    run = simulate(case)
    error, size = true_error(case, run)
    known = (error > np.spacing(size)) & (run.time > 0)
    ratio = run.error_estimate[known] / error[known]
    within = (ratio >= 1 / FACTOR) & (ratio <= FACTOR)
    passed = [tolerance for tolerance in TOLERANCES if error.max() > tolerance]
    horizons = {
        tolerance: (horizon(run.time, run.error_estimate, tolerance), horizon(run.time, error, tolerance))
        for tolerance in passed
    }
    count = int(known.sum())
    return Judged(
        case.name,
        count,
        within.mean() if count else 1.0,
        (ratio < 1 / FACTOR).mean() if count else 0.0,
        horizons,
    )


def horizon(time, error, tolerance):
    """Time of the first sample whose error passes the tolerance [s]; of the last sample where none does."""
    passed = np.flatnonzero(error > tolerance)
    return float(time[passed[0] if len(passed) else -1])


def true_error(case, run):
    """The largest error of the displacements of all bodies at every sample, and the largest of them [m]."""
    names = tables_of(case.scene()).displacements
    blocks = list(open_truth(case.exact_scene, DIGITS).blocks())
    np.testing.assert_array_equal(np.concatenate([block.samples["time"] for block in blocks]), run.time)
    errors = []
    for name in names:
        texts = np.concatenate([block.sample_digits[name] for block in blocks])
        pairs = zip(run[name].tolist(), texts, strict=True)
        exact = [EXACT.subtract(Decimal(ours), Decimal(text.decode())) for ours, text in pairs]
        errors.append(np.abs(np.array(exact, dtype=float)))
    return np.max(errors, axis=0), np.max([np.abs(run[name]) for name in names], axis=0)
