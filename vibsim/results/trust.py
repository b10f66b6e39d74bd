"""Until when a run is right: its error at every sample, and the trust horizon."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from math import inf
from typing import TYPE_CHECKING, Any

import numpy as np

from vibsim.physics.parts import Scene
from vibsim.results.columns import tables_of
from vibsim.results.trust_companion import Companion, companion_scene, described, third_scene
from vibsim.results.trust_estimate import ErrorEstimate

if TYPE_CHECKING:
    from vibsim.cases import Case

COLUMN = "error_estimate"
GoOn = Callable[[], bool]
AT_ONCE = 100_000  # samples


class NoTrust:
    """What takes the place of `Trust` in a run that is not judged."""

    columns: tuple[str, ...] = ()
    t_reached = inf  # of what judges [s]

    def __enter__(self) -> "NoTrust":
        return self

    def __exit__(self, *failure: object) -> None:
        pass

    def judged(
        self, samples: Mapping[str, np.ndarray], go_on: GoOn, left_out: np.ndarray | float = 0.0
    ) -> Mapping[str, np.ndarray]:
        """The samples as they are."""
        return samples

    def attrs(self, t_reached: float) -> dict[str, Any]:
        """Nothing is known."""
        return {}


class Trust(NoTrust):
    """Judges a run of `case` while it is computed, by a companion on the same engine.

    case, scene : what is run. To be entered for as long as the run goes.
    """

    columns = (COLUMN,)

    def __init__(self, case: "Case", scene: Scene, engine: str):
        other = companion_scene(case, scene)
        self._method, self._engine = described(other), engine
        self._third = third_scene(other, scene)
        self._estimate = ErrorEstimate(scene, case.number("run.trust_tolerance"))
        self._companion = Companion(other, engine)
        self._names = tables_of(scene).displacements

    def __enter__(self) -> "Trust":
        self._companion.start()
        return self

    def __exit__(self, *failure: object) -> None:
        self._companion.close()

    @property
    def t_reached(self) -> float:  # type: ignore[override]
        """Time that the companion has reached [s]; infinite once it has ended."""
        return self._companion.t_reached

    def judged(
        self, samples: Mapping[str, np.ndarray], go_on: GoOn, left_out: np.ndarray | float = 0.0
    ) -> dict[str, np.ndarray]:
        """The next block of samples with the column `error_estimate` [m]; `go_on` as in `Companion.take`.

        left_out : distance [m] at each sample that the run has left out of infinite sequences of impacts, as
        its companion has
        """
        ours = np.stack([samples[name] for name in self._names])
        theirs = self._companion.take(ours.shape[1], go_on)
        third = partial(self._by_a_third_run, go_on)
        return {**samples, COLUMN: self._estimate.update(samples["time"], ours, theirs, left_out, third)}

    def _by_a_third_run(self, go_on: GoOn, count: int, last: int, until: float) -> np.ndarray:
        """Displacements [m] of a third run at the `last` of its first `count` samples, up to `until` [s]."""
        companion = Companion(replace(self._third, t_end=until), self._engine)
        companion.start()
        try:
            for done in range(0, count - last, AT_ONCE):
                companion.take(min(AT_ONCE, count - last - done), go_on)
            return companion.take(last, go_on)
        finally:
            companion.close()

    def attrs(self, t_reached: float) -> dict[str, Any]:
        """Attributes of the file: horizon [s], tolerance [m], method, and the largest estimate [m].

        The horizon is `t_reached` where the tolerance is never passed.
        """
        return {
            "trust_horizon_s": self._estimate.horizon(t_reached),
            "trust_tolerance_m": self._estimate.tolerance,
            "trust_method": self._method,
            "error_estimate_max": self._estimate.largest,
        }
