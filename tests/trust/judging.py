"""How good an error estimate is: against the truth, the same case in 45 digits from its exact decimals."""

from dataclasses import dataclass

import numpy as np
from vibsim.flows.closed_form import ClosedForm
from vibsim.flows.taylor import Taylor
from vibsim.kernel.driver import Driver

from vibsim.results import simulate

DIGITS = 45  # chaos takes 1e16 from the first error in the longest of these runs
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
    """The larger of the errors of x1 and x2 at every sample, and the larger of |x1| and |x2| [m]."""
    from vibsim.physics.multiprecision import Balls

    kit = Balls(DIGITS)
    scene = case.exact_two_blocks(kit.number)
    driver = Driver(scene, kit, (Taylor if scene.has_motor else ClosedForm)(scene, kit))
    rows = []
    while not driver.finished:
        driver.run(2000, 2000, 1000)
        rows += [(float(state.t), *_split(state.x1), *_split(state.x2)) for state, _ in driver.take()[0]]
    time, *true = np.array(rows).T
    np.testing.assert_array_equal(time, run.time)
    ours = [run["x1"], run["x2"] if "x2" in run else np.zeros(len(run))]
    errors = [np.abs((ours[i] - true[2 * i]) - true[2 * i + 1]) for i in range(2)]
    return np.max(errors, axis=0), np.max(np.abs(ours), axis=0)


def _split(x):
    """A ball's midpoint as an unevaluated sum of two doubles."""
    high = float(x.mid())
    return high, float((x.mid() - high).mid())
