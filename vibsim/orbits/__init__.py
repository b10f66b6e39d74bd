"""Periodic orbits of a scene, stable or not: what a run settles on, and what it would leave.

    section_of(scene)           where an orbit is looked at: phase 0 of the source, or phi = 0 of a motor
    ReturnMap(scene, n)         from the section to the section after n periods or turns, with its derivative
    solve(return_map, X, T)     Newton's method for a fixed point of it
    find_orbit(scene, state)    the orbit next to a state, its multipliers, word and margins

Names are imported when they are used.
"""

from typing import TYPE_CHECKING

from vibsim.lazy_names import lazy_names

if TYPE_CHECKING:
    from vibsim.orbits.errors import OrbitError as OrbitError
    from vibsim.orbits.finding import find_orbit as find_orbit
    from vibsim.orbits.newton import solve as solve
    from vibsim.orbits.orbit import Orbit as Orbit
    from vibsim.orbits.return_map import ReturnMap as ReturnMap
    from vibsim.orbits.section import section_of as section_of

__getattr__, __dir__, __all__ = lazy_names(
    __name__,
    {
        "vibsim.orbits.errors": ["OrbitError"],
        "vibsim.orbits.finding": ["find_orbit"],
        "vibsim.orbits.newton": ["solve"],
        "vibsim.orbits.orbit": ["Orbit"],
        "vibsim.orbits.return_map": ["ReturnMap"],
        "vibsim.orbits.section": ["section_of"],
    },
)
