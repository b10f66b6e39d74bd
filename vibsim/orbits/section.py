"""The section on which the orbits of a scene are looked at.

Ideal sources: phase 0 of the common period of all forces and the base, so the time of return is known. A
motor: its angle phi = 0 mod 2 pi, so phi is known and the time of return is not.
"""

from dataclasses import dataclass
from math import pi

from vibsim.orbits.errors import NoSection
from vibsim.physics.period import Period, common_period


@dataclass(frozen=True)
class Section:
    """Where an orbit begins and ends.

    period : the common period of ideal sources, or None
    pinned : number of the component of the state that the section fixes at 0, or None; such a section is met
        again where the component has advanced by `advance`, after a time that is not known beforehand
    """

    period: Period | None = None
    pinned: int | None = None
    advance: float = 0.0

    @property
    def timed(self) -> bool:
        """Whether the time between two returns is known."""
        return self.pinned is None

    def time(self, n: int) -> float:
        """Time of n periods of the source [s]; of timed sections only."""
        assert self.period is not None
        return float(self.period.end(n))


def section_of(scene):
    """The section of a scene. Raises NoSection where there is none."""
    if scene.motor is not None:
        if any(term.amplitude != 0 and term.cycles != 0 for term in scene.harmonics):
            raise NoSection(
                "a motor whose speed is free and a force or base of its own frequency have no common period, "
                "so the scene has no periodic orbit; leave out one of them"
            )
        return Section(pinned=2 * len(scene.bodies), advance=2 * pi)
    period = common_period(scene)
    if period is not None:
        return Section(period)
    if any(term.amplitude != 0 and term.cycles != 0 for term in scene.harmonics):
        raise NoSection(
            "the frequencies of forces and base have no common period (no exact ratio of whole numbers), "
            "so the motion is at best quasi-periodic"
        )
    raise NoSection(
        "nothing drives the scene with a period: no harmonic force, moving base or motor; "
        "orbits are looked for by the phase of a source"
    )
