"""What a sweep computes of each point on demand, besides its usual statistics, while the run streams by.

Each computation is made for one run, is shown its blocks from the transient's end on, and answers at the end.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, Protocol

from vibsim.cases.spelling import did_you_mean
from vibsim.engine.tangent.tangent_space import dimension as exponents
from vibsim.engine.trajectories.blocks import Block
from vibsim.physics.parts import Scene
from vibsim.sweeps.computations import (
    capture_verdict,
    certificate,
    contact_section,
    end_state,
    grazing,
    impact_velocity,
    lyapunov,
    orbit,
    power,
    regime_label,
)
from vibsim.sweeps.computations.task import Task
from vibsim.sweeps.statistics.columns import Columns
from vibsim.sweeps.statistics.measured_run import MeasuredRun
from vibsim.sweeps.statistics.quantities import Quantities

Window = tuple[float, float]  # of the whole periods [s]; of everything after the transient without periods


class Computation(Protocol):
    """One computation of one run, made for a `Task`."""

    def update(self, block: Block) -> None:
        """Take the next block; the first may begin before the transient ends."""

    def values(self, window: Window, run: MeasuredRun, measured: dict[str, Any]) -> dict[str, Any]:
        """By column a float, or an array where the column has a further dimension.

        measured : what the computations before this one have come to
        """


@dataclass(frozen=True)
class Kind:
    """A computation that can be asked for.

    Attributes
    ----------
    title : what it is, for the list
    columns : what it stores of a scene; nothing where it makes no sense
    suits : what the scene must have for it to make sense, in words
    make : the computation of one run
    ledger : whether the run must keep the energy ledger, which takes half as long again
    samples : whether it reads samples
    """

    title: str
    columns: Callable[[Quantities], Columns]
    suits: str
    make: Callable[[Task], Computation]
    ledger: bool = False
    samples: bool = False


COMPUTATIONS = {
    "power": Kind(power.TITLE, power.columns, "with a source", power.Power, ledger=True),
    "impact-velocity": Kind(
        impact_velocity.TITLE, impact_velocity.columns, "with a stop", impact_velocity.ImpactVelocity
    ),
    "contact-section": Kind(
        contact_section.TITLE, contact_section.columns, "with a stop", contact_section.ContactSection
    ),
    "grazing": Kind(grazing.TITLE, grazing.columns, "with a stop", grazing.Grazing),
    "certificate": Kind(certificate.TITLE, certificate.columns, "", certificate.Certificate),
    "capture": Kind(
        capture_verdict.TITLE, capture_verdict.columns, "with a motor", capture_verdict.CaptureVerdict
    ),
    "lyapunov": Kind(lyapunov.TITLE, lyapunov.columns, "", lyapunov.Lyapunov),
    "lyapunov-spectrum": Kind(lyapunov.SPECTRUM_TITLE, lyapunov.spectrum_columns, "", lyapunov.Spectrum),
    "regime": Kind(
        regime_label.TITLE, regime_label.columns, "with a source", regime_label.RegimeLabel, samples=True
    ),
    "orbit": Kind(orbit.TITLE, orbit.columns, "with a source", orbit.Orbit, samples=True),
    "end-state": Kind(
        end_state.TITLE,
        end_state.columns,
        "that move freely, under constant forces alone",
        end_state.EndState,
        samples=True,
    ),
}


def read_computations(names: str | Iterable[str], of: Quantities) -> tuple[str, ...]:
    """The computations of these names (one, or several), each once, in the order of `COMPUTATIONS`.

    "all" stands for all that the scene has use for. Raises ValueError for a name that there is not.
    """
    chosen = {names} if isinstance(names, str) else set(names)
    if "all" in chosen:
        return fitting(COMPUTATIONS, of)
    for name in sorted(chosen - set(COMPUTATIONS)):
        allowed = ", ".join([*COMPUTATIONS, "all"])
        raise ValueError(
            f"nothing to compute is called {name!r}{did_you_mean(name, COMPUTATIONS)}; allowed: {allowed}"
        )
    return tuple(name for name in COMPUTATIONS if name in chosen)


def fitting(names: Iterable[str], of: Quantities) -> tuple[str, ...]:
    """Those of the computations that the scene has use for."""
    return tuple(name for name in names if COMPUTATIONS[name].columns(of))


def length_of(dimension: str, scene: Scene, section: int) -> int:
    """Length of a further dimension; sections have as many points as the sweep says."""
    lengths: dict[str, Callable[[], int]] = {
        "section": lambda: section,
        "contact": lambda: section,
        "quantile": lambda: len(impact_velocity.QUANTILES),
        "exponent": lambda: exponents(scene),
        "multiplier": lambda: orbit.multipliers(scene),
    }
    return lengths[dimension]()
