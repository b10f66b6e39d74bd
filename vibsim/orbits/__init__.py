"""Periodic orbits of a scene, stable or not: what a run settles on, and what it would leave.

    seeking.orbit(case)         the orbit that the run of a case goes to, or one near a start: vibsim.orbit
    search_orbits(case, 50)     the orbits that are found from random starts
    monodromy(case, state, T)   what becomes of small disturbances of a state, and of parameters
    find_orbit(scene, state)    the orbit of a scene next to a state, its multipliers, word and margins
    section_of(scene)           where an orbit is looked at: phase 0 of the source, or phi = 0 of a motor
    ReturnMap(scene, n)         from the section to the section after n periods or turns, with its derivative
    solve(return_map, X, T)     Newton's method for a fixed point of it

Names are imported when they are used.
"""

from typing import TYPE_CHECKING

from vibsim.lazy import lazy_names

if TYPE_CHECKING:
    from vibsim.orbits.coordinates import OrbitError as OrbitError
    from vibsim.orbits.coordinates import section_of as section_of
    from vibsim.orbits.newton import solve as solve
    from vibsim.orbits.orbit import Orbit as Orbit
    from vibsim.orbits.orbit import save_orbit as save_orbit
    from vibsim.orbits.orbit_digits import refine as refine
    from vibsim.orbits.return_map import ReturnMap as ReturnMap
    from vibsim.orbits.search import find_orbit as find_orbit
    from vibsim.orbits.search import search_orbits as search_orbits
    from vibsim.orbits.slopes import monodromy as monodromy

__getattr__, __dir__, __all__ = lazy_names(__name__)
