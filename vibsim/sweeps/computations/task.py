"""What a computation of one run is made for."""

from dataclasses import dataclass

from vibsim.physics.parts import Scene
from vibsim.sweeps.statistics.quantities import Quantities


@dataclass(frozen=True)
class Task:
    """A run of `scene`, in which what `of` names is measured.

    Attributes
    ----------
    begin : time at which the transient ends [s]
    section : length of sections
    """

    scene: Scene
    of: Quantities
    begin: float
    section: int
