"""What the multipliers of an orbit say: which bifurcations are near."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from vibsim.cases.number import number
from vibsim.orbits.matrices import modulus
from vibsim.orbits.multipliers import ON_CIRCLE

if TYPE_CHECKING:
    from vibsim.orbits.orbit import Orbit

NEAR = 0.02  # distance of a multiplier from the unit circle that is worth telling


@dataclass(frozen=True)
class Neighbour:
    """A multiplier near the unit circle. kind: "fold", "period doubling" or "Neimark-Sacker"; "family" for
    one that is 1 but for rounding.
    """

    kind: str
    mu: complex

    @property
    def text(self) -> str:
        if self.kind == "family":
            return "a multiplier is 1: one of a family of orbits, or a fold"
        shown = number(self.mu.real, 6) if self.mu.imag == 0 else f"magnitude {number(modulus(self.mu), 6)}"
        article = "a Neimark-Sacker point" if self.kind == "Neimark-Sacker" else f"a {self.kind}"
        return f"{article} is near (multiplier {'of ' * (self.mu.imag != 0)}{shown})"


def neighbours(orbit: Orbit) -> list[Neighbour]:
    """The bifurcations that are near, the nearest first."""
    near = [mu for mu in orbit.multipliers.tolist() if mu.imag >= 0 and abs(modulus(mu) - 1) < NEAR]
    return [Neighbour(_kind(mu), mu) for mu in sorted(near, key=lambda mu: abs(modulus(mu) - 1))]


def _kind(mu: complex) -> str:
    if mu.imag != 0:
        return "Neimark-Sacker"
    if mu.real < 0:
        return "period doubling"
    return "family" if modulus(mu - 1) < ON_CIRCLE else "fold"
