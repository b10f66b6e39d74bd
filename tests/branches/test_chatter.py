"""Orbits with infinite sequences of impacts: how many of them are told one by one is no event."""

import numpy as np
import pytest

from vibsim.branches import continue_branch
from vibsim.cases import load_case
from vibsim.orbits import find_orbit
from vibsim.orbits.returns.word import LETTERS, circle
from vibsim.orbits.search.seeking import orbit

KINDS = {letter: kind for kind, letter in LETTERS.items()}


def word(letters):
    return tuple((KINDS[letter], 0) for letter in letters)


def test_a_sequence_is_one_letter_wherever_the_section_cuts_it():
    assert circle(word("iiichoii")) == circle(word("choiiiii")) == circle(word("cho")) == word("cho")
    assert circle(word("ichsoiu")) == circle(word("chsoiu")) == word("chsoiu")
    assert len(circle(word("iii"))) == 3
    assert circle(word("cuhso" + "ius" * 9)) == circle(word("cuhso" + "ius" * 8)) == circle(word("cuhso"))
    assert circle(word("siuscuhsoiu")) == circle(word("cuhsoiusius")) == circle(word("cuhso"))
    assert len(circle(word("cuhsoiuisius"))) == len(circle(word("cuhsoiuis"))) == 9
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


def test_a_rest_on_a_shaken_base_across_the_section_goes_on():
    """A plastic ball rests on the table at phase 0: a period later its gap and their rate are rounding. It
    began with a flight of that and came to rest at once, here and there along the branch. Of itself it rests
    for ever up to a w^2 = g, and is thrown up once a period beyond.
    """
    set_up = {"stops.table.e": "0", "base.phase": "0 deg", "base.a": "1.2 mm", "initial.ball.x": "10 mm"}
    start = orbit(load_case("gallery/ball-on-shaken-table", set_up))
    branch = continue_branch(start, "base.a", "0.9:2 mm")
    words = [(branch.spelled(one.before), branch.spelled(one.after)) for one in branch.specials]
    assert words == [("", "ho"), ("ho", "iho")]  # at first it lands as softly as rounding
    for special, error in zip(branch.specials, (1e-13, 1e-9), strict=True):
        assert special.parameter == pytest.approx(9.81e3 / 99.045444115315068**2, rel=error)


def test_slips_between_the_impacts_of_a_sequence_are_part_of_it():
    """Each blow moves the slider on, which sticks before the next: how many such slips are told depends on
    rounding. Where it does not stick any more before the next, from the first pair of impacts to the last,
    places accumulate by the factor 1/e; behind them it slides as the chatter ends.
    """
    branch = continue_branch("gallery/drifting-oscillator", "drive.F0", "0.01:2.1 N")
    assert branch.ends == ("end of the range", "end of the range")  # the multiplier goes like 1 / F0
    assert branch["parameter"].min() == pytest.approx(0.01)
    assert [one.kind for one in branch.specials] == ["sticking"] * 9 + ["doubling"]
    assert branch.spelled(branch.specials[0].before) == "cuhso" and branch.specials[8].after == word("chsoiu")
    places = np.array([one.parameter for one in branch.specials[:8]])
    np.testing.assert_allclose((np.diff(places)[:-1] / np.diff(places)[1:])[3:], 1 / 0.3, rtol=0.005)


def test_bodies_at_rest_on_each_other_across_the_section_stay_so():
    """A period later their gap is rounding: flights of that came and went along the branch. From F0 = A on
    the force presses the mass on the slider all the time.
    """
    start = orbit(load_case("gallery/drifting-oscillator", {"drive.F0": "5.5 N"}))
    branch = continue_branch(start, "drive.F0", "4.9:7 N")
    words = [branch.spelled(branch.specials[0].before)] + [
        branch.spelled(one.after) for one in branch.specials
    ]
    assert words == ["chsusoiu", "cuhsuso", "hsusou", "su"]
    assert branch.specials[-1].parameter == pytest.approx(5.0, rel=1e-11)
