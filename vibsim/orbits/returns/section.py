"""The section on which the orbits of a scene are looked at.

Ideal sources: phase 0 of the common period of all forces and the base, so the time of return is known. A
motor: its angle phi = 0 mod 2 pi, so phi is known and the time of return is not. Neither: the velocity of a
body that springs bring back is 0, at its least or its greatest displacement, where fewer stops act.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

from vibsim.orbits.errors import NoSection
from vibsim.physics.parts import Link, Scene, Stop, columns_of
from vibsim.physics.period import Period, common_period


@dataclass(frozen=True)
class Section:
    """Where an orbit begins and ends.

    period : the common period of ideal sources, or None
    pinned : number of the component of the state that the section fixes at 0, or None; such a section is met
        again where the component has advanced by `advance`, after a time that is not known beforehand
    body : name of the body at whose turn it is, where nothing drives the scene, or empty; `advance` is 0 then
    sense : 1 at the least displacement of the body, -1 at the greatest
    """

    period: Period | None = None
    pinned: int | None = None
    advance: float = 0.0
    body: str = ""
    sense: int = 1

    @property
    def timed(self) -> bool:
        """Whether the time between two returns is known."""
        return self.pinned is None

    @property
    def turning(self) -> bool:
        """Whether it is where a body turns round, as nothing drives the scene."""
        return bool(self.body)

    @property
    def of_return(self) -> str:
        """What is counted from one return to the next."""
        if self.body:
            return f"swing of {self.body}"
        return "period of the source" if self.timed else "turn of the motor"

    @property
    def place(self) -> str:
        """Where it is, in words."""
        if self.body:
            side = "least" if self.sense > 0 else "greatest"
            return f"{columns_of(self.body)[1]} = 0, at the {side} displacement of {self.body}"
        return "phase 0 of the source" if self.timed else "phi = 0"

    @property
    def component(self) -> int:
        """The pinned component, of sections whose time of return is not known."""
        assert self.pinned is not None
        return self.pinned

    def time(self, n: int) -> float:
        """Time of n periods of the source [s]; of timed sections only."""
        assert self.period is not None
        return float(self.period.end(n))


def section_of(scene: Scene) -> Section:
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
    for i, body in enumerate(scene.bodies):
        if any(i in (part.P, part.Q) for part in _springs(scene)):
            return Section(pinned=len(scene.bodies) + i, body=body.name, sense=_freer_side(scene, i))
    raise NoSection(
        "an orbit needs a periodic source (a harmonic force, a moving base or a motor), or a spring that "
        "brings a body back; the scene has neither"
    )


def _freer_side(scene: Scene, body: int) -> int:
    """1 where no more stops act at the least displacement of a body than at the greatest, else -1: an orbit
    that just grazes a stop does so where its body turns.
    """
    sides = [
        stop.sense if body == stop.P else -stop.sense for stop in scene.stops if body in (stop.P, stop.Q)
    ]
    return -1 if sum(sides) > 0 else 1


def _springs(scene: Scene) -> list[Link | Stop]:
    """Links and elastic stops with stiffness."""
    parts: list[Link | Stop] = [*scene.links, *(stop for _, stop in scene.elastic_stops)]
    return [part for part in parts if part.k]
