"""Orbits with infinite sequences of impacts: how many of them are told one by one is no event."""

import numpy as np
import pytest

from tests.branches.made import word
from vibsim.cases import load_case
from vibsim.orbits import find_orbit
from vibsim.orbits.branches.continuing import continue_branch
from vibsim.orbits.search import orbit
from vibsim.orbits.words import circle

OMEGA = 99.045444115315068  # [rad/s]


def test_a_sequence_is_one_letter_wherever_the_section_cuts_it():
    assert circle(word("iiichoii")) == circle(word("choiiiii")) == circle(word("cho")) == word("cho")
    assert circle(word("ichsoiu")) == circle(word("chsoiu")) == word("chsoiu")
    assert len(circle(word("iii"))) == 3
    assert circle(word("cuhso" + "ius" * 9)) == circle(word("cuhso" + "ius" * 8)) == circle(word("cuhso"))
    assert circle(word("siuscuhsoiu")) == circle(word("cuhsoiusius")) == circle(word("cuhso"))
    assert len(circle(word("cuhsoiuisius"))) == len(circle(word("cuhsoiuis"))) == 9
    assert circle((("impact", 1), ("chatter", 0))) == (("chatter", 0), ("impact", 1))


@pytest.mark.slow
def test_what_rests_in_each_period_is_followed():
    """The number of impacts before the rest is no change of the order of events."""
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
    """A plastic ball rests on the table at phase 0: a period later its gap and their rate are rounding. Of
    itself it rests for ever up to a w^2 = g, and is thrown up once a period beyond.
    """
    set_up = {"stops.table.e": "0", "base.phase": "0 deg", "base.a": "1.2 mm", "initial.ball.x": "10 mm"}
    start = orbit(load_case("gallery/ball-on-shaken-table", set_up))
    branch = continue_branch(start, "base.a", "0.9:2 mm")
    (special,) = branch.specials
    assert (branch.spelled(special.before), branch.spelled(special.after)) == ("", "iho")
    assert special.parameter == pytest.approx(9.81e3 / OMEGA**2, rel=1e-12)


@pytest.mark.parametrize(
    ("end", "before", "count"),
    [("0.0642", "cuhsoiuiiis", 5), pytest.param("0.01", "cuhso", 8, marks=pytest.mark.slow)],
)
def test_slips_between_the_impacts_of_a_sequence_are_part_of_it(end, before, count):
    """Each blow moves the slider on, which sticks before the next: how many such slips are told depends on
    rounding. Where it does not stick any more before the next, from the first pair of impacts to the last,
    places accumulate by the factor 1/e; behind them it slides as the chatter ends.
    """
    branch = continue_branch("gallery/drifting-oscillator", "drive.F0", f"{end}:2.1 N")
    assert branch.ends == ("end of the range", "end of the range")  # the multiplier goes like 1 / F0
    assert branch["parameter"].min() == pytest.approx(float(end))
    assert [one.kind for one in branch.specials] == ["sticking"] * (count + 1) + ["doubling"]
    assert branch.spelled(branch.specials[0].before) == before
    assert branch.specials[count].after == word("chsoiu")
    gaps = np.diff([one.parameter for one in branch.specials[count - 5 : count]])
    np.testing.assert_allclose(gaps[:-1] / gaps[1:], 1 / 0.3, rtol=0.005)


def test_bodies_at_rest_on_each_other_across_the_section_stay_so():
    """A period later their gap is rounding: flights of that came and went along the branch. From F0 = A on
    the force presses the mass on the slider all the time.
    """
    start = orbit(load_case("gallery/drifting-oscillator", {"drive.F0": "5.5 N"}))
    branch = continue_branch(start, "drive.F0", "4.9:7 N")
    words = [branch.specials[0].before] + [one.after for one in branch.specials]
    assert [branch.spelled(each) for each in words] == ["chsusoiu", "cuhsuso", "hsusou", "su"]
    assert branch.specials[-1].parameter == pytest.approx(5.0, rel=1e-11)


def test_a_chatter_that_passes_the_section_is_followed():
    """Seen from another phase nothing comes to the section, and the slider begins to stick between two blows
    at the same place.
    """
    places = []
    for phase in ("0 deg", "90 deg"):
        start = orbit(load_case("gallery/drifting-oscillator", {"drive.F0": "4.35 N", "drive.phase": phase}))
        branch = continue_branch(start, "drive.F0", "4.34:4.45 N")
        assert branch.ends == ("end of the range", "end of the range")
        (special,) = branch.specials
        assert special.kind == "sticking" and special.before == word("chsoiu")
        places.append(special.parameter)
    assert places[0] == pytest.approx(places[1], rel=1e-9)


def test_a_branch_ends_where_friction_takes_no_more_of_the_static_force():
    """Mass and slider move as one, and rest for ever shorter: at 8 N nothing is left to slow them down. They
    speed up from rest and come to it again just then, by A (1 - cos w t) / (m w).
    """
    start = orbit(load_case("gallery/drifting-oscillator", {"drive.F0": "6 N"}))
    branch = continue_branch(start, "drive.F0", "5.5:9 N")
    assert branch.ends == (
        "end of the range",
        "friction takes the static force on mass and slider up to 8 N: beyond, it speeds them up without end",
    )
    assert branch["parameter"][-1] == pytest.approx(8.0, abs=1e-8) and branch.specials == []
    assert branch["drift"][-1] == pytest.approx(5.0 / (1.5 * 4 * np.pi) * 0.5, rel=1e-6)


@pytest.mark.parametrize("phase", ["199 deg", "200 deg", "250 deg"])
def test_a_flight_of_rounding_from_a_rest_is_told_once(phase):
    """Seen from there the plastic ball is thrown up, rests by rounding, and is thrown up again, within 2e-10
    of a w^2 = g; at first it lands as softly as rounding, with an impact or without.
    """
    set_up = {"stops.table.e": "0", "base.phase": phase, "base.a": "1.5 mm"}
    branch = continue_branch(orbit(load_case("gallery/ball-on-shaken-table", set_up)), "base.a", "0.9:2 mm")
    (special,) = branch.specials
    assert (branch.spelled(special.before), branch.spelled(special.after)) == ("", "iho")
    assert special.parameter == pytest.approx(9.81e3 / OMEGA**2, rel=1e-9)


@pytest.mark.slow
def test_blows_that_a_chatter_loses_one_by_one_are_told_one_by_one():
    """A ball of e = 0.2: each last blow is lost in a graze, where a multiplier is infinite on the side with
    it and the branch has a corner, sharper than a right angle. The parameter runs on from the first graze
    (those of a chatter of more than 9 blows are told at once) to the last but one.
    """
    set_up = {"stops.table.e": "0.2", "base.a": "2 mm", "initial.ball.x": "9 mm"}
    start = orbit(load_case("gallery/ball-on-shaken-table", set_up))
    branch = continue_branch(start, "base.a", "1.9:2.19 mm")
    assert all(one.kind != "unresolved" for one in branch.specials)
    lost = [one for one in branch.specials if one.kind in ("grazing", "corner")]
    assert [len(one.after) for one in lost] == [9, 8, 7, 6, 5, 4]
    for one in lost[1:]:
        gap, scale = last_turn(one.parameter * 1e-3, *one.orbit.state, len(one.after))
        assert abs(gap) < 1e-12 * scale


def last_turn(a, x, v, blows):
    """The gap where it turns last in a period of a ball of e = 0.2 that begins so at phase 60 deg [m], and
    the amplitude of the table: flights under g, blows by bisection.
    """

    def gap(t):
        return x + v * (t - begin) - 9.81 * (t - begin) ** 2 / 2 - a * np.sin(OMEGA * t + np.pi / 3)

    def rate(t):
        return v - 9.81 * (t - begin) - a * OMEGA * np.cos(OMEGA * t + np.pi / 3)

    def bisected(of, low, high):
        for _ in range(200):
            middle = (low + high) / 2
            low, high = (middle, high) if of(middle) * of(low) > 0 else (low, middle)
        return low

    begin, period = 0.0, 2 * np.pi / OMEGA
    for _ in range(blows):
        t = begin + period * np.arange(1, 2**18) / 2**18
        below = int(np.flatnonzero(gap(t) < 0)[0])
        hit = bisected(gap, float(t[below - 1]), float(t[below])) if below else float(t[0])
        arrived, table = v - 9.81 * (hit - begin), a * OMEGA * np.cos(OMEGA * hit + np.pi / 3)
        x, v, begin = a * np.sin(OMEGA * hit + np.pi / 3), table - 0.2 * (arrived - table), hit
    t = begin + period * np.arange(1, 2**18) / 2**18
    at = int(np.flatnonzero((rate(t[:-1]) < 0) & (rate(t[1:]) >= 0))[0])
    turn = bisected(rate, float(t[at]), float(t[at + 1]))
    return gap(turn), a
