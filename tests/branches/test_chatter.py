"""Orbits with infinite sequences of impacts: how many of them are told one by one is no event."""

import numpy as np

from vibsim.branches import continue_branch
from vibsim.cases import load_case
from vibsim.orbits import find_orbit
from vibsim.orbits.returns.word import LETTERS, circle

KINDS = {letter: kind for kind, letter in LETTERS.items()}


def word(letters):
    return tuple((KINDS[letter], 0) for letter in letters)


def test_a_sequence_is_one_letter_wherever_the_section_cuts_it():
    assert circle(word("iiichoii")) == circle(word("choiiiii")) == circle(word("cho")) == word("cho")
    assert circle(word("ichsoiu")) == circle(word("chsoiu")) == word("chsoiu")
    assert len(circle(word("iii"))) == 3
    assert circle((("impact", 1), ("chatter", 0))) == (("chatter", 0), ("impact", 1))


def test_what_rests_in_each_period_is_followed():
    """The state on the section is forgotten, and comes back but for the rounding of its scale: Newton's
    method took more than 8 steps. The number of impacts before the rest is no change of the order of events.
    """
    branch = continue_branch("gallery/chattering-oscillator", "stops.wall.e", "0.79:0.81")
    assert branch.specials == [] and branch.ends == ("end of the range", "end of the range")
    assert np.abs(branch["multipliers"]).max() == 0.0 and set(branch["word"]) == {"cho"}
    numbers = {len(find(branch, point).events) for point in (0, len(branch) - 1)}
    assert len(numbers) == 2


def find(branch, point):
    """The orbit of a point, found anew."""
    at = branch.points[point].orbit
    case = load_case("gallery/chattering-oscillator", {"stops.wall.e": repr(at.parameter)})
    scene = case.scene()
    return find_orbit(scene, branch.map.coordinates.state(np.array(at.state)), 1, case=case)


def test_blows_at_a_moving_face():
    """Drifting oscillator: four grazings were told that were one impact more before the chatter's end."""
    branch = continue_branch("gallery/drifting-oscillator", "drive.A", "4:8 N", max_points=40)
    assert branch.specials == [] and len(set(branch["word"])) == 1
