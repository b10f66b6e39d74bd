"""Disturbances in C on numbers of words: engines for a fixed number of words against the one for any number,
and closed forms.
"""

from dataclasses import replace
from decimal import Decimal
from fractions import Fraction
from itertools import chain
from math import isnan

import pytest
from hypothesis import strategies as st

from tests.engine.bundles import start_components
from tests.engine.many_digits import exact_parts
from tests.engine.random_formulas import formula_scene
from tests.engine.random_parts import part_scenes, rigid_scenes
from tests.engine.runs import scene_of
from tests.engine.test_formula_tangent import TEXTS
from tests.engine.test_impact_disturbances import THROWN
from tests.engine.test_monodromy import SCENES
from tests.random_scenes import always
from vibsim.cases import load_case
from vibsim.cases.case import load_case_text
from vibsim.engine.errors import EngineError
from vibsim.engine.number_forms import WordsForm
from vibsim.engine.tangent.monodromy import Carrier
from vibsim.orbits import orbit_digits
from vibsim.orbits.search import orbit
from vibsim.physics.precision import WORDS, DigitsKit, is_built, number_kit

pytestmark = pytest.mark.skipif(not all(map(is_built, (*WORDS, 5))), reason="built without numbers of words")

DIGITS = (25, 45, 65)  # on 2, 3 and 4 words
PAIRED = (25, 45)  # of which there are 20 more
LOST = 9  # digits that scenes may lose by their own growth of errors


def carried(make, kit, end=None):
    """The motion of a scene with all unit disturbances, or the reason of its failure."""
    scene = make(kit.number, kit.pi)
    start = start_components(scene)
    unit = [[kit.number(int(i == j)) for j in range(len(start))] for i in range(len(start))]
    carrier = Carrier(scene, WordsForm(kit))
    try:
        return carrier.carried(start, scene.t_end if end is None else kit.number(end), unit)
    except EngineError as error:
        return error.reason


def exact(number):
    """A number of words as a fraction: those of two engines do not compute with each other."""
    mantissa, exponent = number.parts()
    return mantissa * Fraction(2) ** exponent


def assert_same(make, digits, end=None, lost=LOST):
    """The same events on both engines, and the same state, rate and disturbances but for the last digits; the
    former.
    """
    here, there = (carried(make, DigitsKit(digits, any_number), end) for any_number in (False, True))
    if isinstance(here, str) or isinstance(there, str):
        assert here == there
        return ()
    kinds = {kind for kind, _ in here.events}
    if "chatter" in kinds:
        return kinds
    known = isnan(here.undefined_at)
    assert sorted(here.events) == sorted(there.events) and known == isnan(there.undefined_at)
    rows = [(here.state, there.state), (here.rate, there.rate)]
    if known:
        rows.append(([*chain(*here.vectors)], [*chain(*there.vectors)]))
    for ours, theirs in rows:
        size = max(max(abs(float(value)) for value in theirs), 1e-6)
        off = max(abs(float(exact(a) - exact(b))) for a, b in zip(ours, theirs, strict=True))
        assert off <= size * 10.0 ** (lost - digits)
    return kinds


@pytest.mark.parametrize("label", SCENES)
def test_chosen_scenes(label):
    """Damped stops, friction that drops, a motor, a base."""
    scene, expected = SCENES[label]
    assert assert_same(exact_parts(scene), PAIRED[list(SCENES).index(label) % 2]) >= expected


def assert_same_parts(scene, digits):
    assert_same(exact_parts(scene), digits)


test_random_scenes = always(
    assert_same_parts,
    st.one_of(part_scenes(radians=6.0), rigid_scenes(radians=6.0)),
    st.sampled_from(PAIRED),
    few=7,
    many=300,
)


@pytest.mark.slow
@pytest.mark.timeout(7200)
@pytest.mark.parametrize("seed", range(30))
def test_many_random_formulas(seed):
    """To 0.3 s: soon behind, a body goes through 1e15 jumps of another one's force (seed 18)."""
    assert_same(exact_parts(replace(formula_scene(seed), t_end=0.3)), 30)


@pytest.mark.parametrize(("label", "end"), [("mathieu", 1.0), ("hertz", 0.1)])
def test_formulas_keep_the_digits(label, end):
    """Pieces that are halved, and a contact by a power: 30 digits against difference quotients in 51."""
    case = load_case_text(TEXTS[label], {"run.t_end": f"{end} s"})
    found, many, shift = carried(case.exact_scene, number_kit(30)), number_kit(51), Fraction(1, 10**19)
    scene = case.exact_scene(many.number, many.pi)
    start, carrier = start_components(scene), Carrier(scene, WordsForm(many))
    largest = max(abs(float(value)) for value in chain(*found.vectors))
    assert len(found.events) == (2 if label == "hertz" else 0)
    for k, ours in enumerate(found.vectors):
        small = many.number(shift)
        there, back = (
            carrier.carried([x + by if i == k else x for i, x in enumerate(start)], scene.t_end, ())
            for by in (small, -small)
        )
        assert found.events == there.events == back.events
        for value, one, other in zip(ours, there.state, back.state, strict=True):
            assert abs(float(exact(one - other) / (2 * shift) - exact(value))) < 1e-28 * largest


@pytest.mark.parametrize(
    ("name", "end"),
    [("gallery/captured-motor", 0.01), ("gallery/two-exciters", 0.01), ("gallery/driven-pendulum", 0.3)],
)
def test_formulas_and_rotors(name, end):
    assert_same(load_case(name).exact_scene, 25, end, lost=5)


def impacts(v):
    """A body thrown at a wall 1 m ahead against a force that stops it there where v is 2 m/s."""
    return exact_parts(scene_of(THROWN, {"m.v": v, "wall.e": 0.5}))


@pytest.mark.parametrize("digits", DIGITS)
def test_an_impact_in_closed_form(digits):
    """v^2 = v0^2 - 4 at the wall, S = [[-e, 0], [(1 + e) a / v, -e]]."""
    kit = number_kit(digits)
    end = carried(impacts(2.5), kit)
    v, e, a = kit.sqrt(kit.number(2.25)), kit.number(0.5), kit.number(-2)
    first = (kit.number(2.5) - v) / 2
    left = kit.number(1.5) - first
    jump = (1 + e) * a / v
    S = [[-e, kit.number(0)], [jump, -e]]
    before, after = [[1, first], [0, 1]], [[1, left], [0, 1]]
    expected = product(after, product(S, before))
    assert end.events == (("impact", 0),) and isnan(end.undefined_at)
    for i in (0, 1):
        for j in (0, 1):
            assert abs(float(end.vectors[j][i] - expected[i][j])) < 10.0 ** (3 - digits)


def product(one, other):
    return [[sum(one[i][k] * other[k][j] for k in (0, 1)) for j in (0, 1)] for i in (0, 1)]


def test_what_has_no_derivative_is_told():
    grazed = carried(impacts(2.0), number_kit(30))
    missed = carried(impacts(1.9), number_kit(30))
    assert not isnan(grazed.undefined_at) and isnan(missed.undefined_at)


def test_disturbances_leave_the_motion_as_it_is():
    """To the last of all bits."""
    case, kit = load_case("II-B", {"run.t_end": "0.3 s"}), number_kit(40)
    scene = case.exact_scene(kit.number, kit.pi)
    start, carrier = start_components(scene), Carrier(scene, WordsForm(kit))
    unit = [[kit.number(int(i == j)) for j in range(6)] for i in range(6)]
    with_all, with_one = (carrier.carried(start, scene.t_end, of) for of in (unit, [unit[2]]))
    assert [kit.parts(x) for x in with_all.state] == [kit.parts(x) for x in with_one.state]
    assert [kit.parts(x) for x in with_all.vectors[2]] == [kit.parts(x) for x in with_one.vectors[0]]
    none = carrier.carried(start, scene.t_end, [])
    assert [kit.parts(x) for x in with_all.state] == [kit.parts(x) for x in none.state]


def test_an_orbit_has_the_same_digits_beyond_a_fixed_number_of_words():
    found = orbit(load_case("gallery/block-on-belt"))
    few, many = (orbit_digits.refine(found, digits) for digits in (30, 60))
    pairs = [(few.period, many.period), *((few.state[name], many.state[name]) for name in few.state)]
    for one, other in [*pairs, *zip(chain(*few.multipliers), chain(*many.multipliers), strict=True)]:
        assert abs(Decimal(one) - Decimal(other)) < Decimal("1e-28")
