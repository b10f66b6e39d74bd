"""Changes of the order of events, located by what goes to zero there."""

from types import SimpleNamespace

import numpy as np
import pytest
from numpy.polynomial import Polynomial

from vibsim.orbits.branches.inspection import _gathered
from vibsim.orbits.branches.interpolant import _newton
from vibsim.orbits.branches.order_change import _zero
from vibsim.orbits.branches.special_points import STICKING, Special
from vibsim.orbits.words import LETTERS

KINDS = {letter: kind for kind, letter in LETTERS.items()}


@pytest.mark.parametrize("power", [1.0, 0.5])
def test_a_zero_is_told_from_one_side(power):
    """A contact's time goes like the root of the way to the graze, a stick's like the way itself."""
    zero = 0.731
    doubt, told = _zero([((zero - share) ** power, share) for share in (0.0, 0.5, 0.7)])
    assert told == pytest.approx(zero, abs=1e-13) and doubt < 1e-12


def test_a_zero_with_a_bend_is_doubted_as_much_as_it_is_wrong():
    """The doubt, by which nodes are put beside the place, is no less than the error."""
    zero = 0.731
    doubt, told = _zero([((zero - s) ** 0.5 * (1 + 0.1 * (zero - s)), s) for s in (0.0, 0.5, 0.7)])
    assert 1e-6 < abs(told - zero) < doubt < 0.1


def test_a_polynomial_goes_through_places_and_slopes():
    """Newton's divided differences with places that count twice: the cubic itself, and of a third place."""
    cubics = [Polynomial([0.3, -1.0, 2.0, 0.7]), Polynomial([1.0, 0.5, 0.0, -3.0])]

    def at(share, order=0):
        return np.array([cubic.deriv(order)(share) if order else cubic(share) for cubic in cubics])

    rows = [(share, at(share), at(share, 1)) for share in (0.0, 1.0)]
    np.testing.assert_allclose(_newton(rows, 0.3), at(0.3), atol=1e-15)
    np.testing.assert_allclose(_newton([*rows, (0.6, at(0.6), None)], 0.3), at(0.3), atol=1e-14)


def node_at(place, letters, smallest=1.0):
    """A node of one unknown and the parameter, whose equations have this smallest singular value."""
    point = SimpleNamespace(jacobian=lambda: np.array([[smallest, 0.0]]))
    word = tuple((KINDS[letter], 0) for letter in letters)
    return SimpleNamespace(z=np.array([place, 1.0]), word=word, ahead=1.0, level=False, point=point)


def change_at(place, before, after, smallest=1.0):
    """A change of the order of events between two words."""
    ends = (node_at(place, word, smallest) for word in (before, after))
    return Special(STICKING, node_at(place, after, smallest), *ends)


def told(*specials):
    return [(one.node.z[0], spelled(one.before.word), spelled(one.after.word)) for one in _gathered(specials)]


def spelled(word):
    return "".join(LETTERS[kind] for kind, _ in word)


@pytest.mark.parametrize(("smallest", "count"), [(5e-7, 1), (1e-3, 2)])
def test_changes_nearer_than_orbits_are_known_are_one(smallest, count):
    """Beside a family of orbits Newton's method leaves open where one lies: by 1e-12 over the smallest
    singular value. Two slips that come at once on each side of a symmetric orbit came up 7e-8 apart there.
    """
    listed = told(change_at(0.0, "", "su", smallest), change_at(7e-8, "su", "susu", smallest))
    assert len(listed) == count and listed[0][1] == "" and listed[-1][2] == "susu"


@pytest.mark.parametrize(
    ("first", "second"),
    [(("", "ho"), ("ho", "iho")), (("", "iho"), ("iho", "ho")), (("iho", "ho"), ("ho", ""))],
)
def test_a_landing_with_an_impact_and_without_is_one(first, second):
    """A flight that has just begun lands with the speed of rounding: then the engine tells no impact. The
    change that is one is where the flight begins.
    """
    ((place, before, after),) = told(change_at(0.0, *first), change_at(1e-9, *second))
    assert (before, after) == (first[0], second[1])
    assert place == (1e-9 if first == ("iho", "ho") else 0.0)


def test_what_comes_and_goes_by_rounding_is_none_and_what_lies_apart_stays():
    assert told(change_at(0.0, "", "su", 0.0), change_at(1e-9, "su", "", 0.0)) == []
    assert len(told(change_at(0.0, "", "ho"), change_at(1e-3, "ho", "iho"))) == 2
