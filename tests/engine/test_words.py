"""The engine on numbers of 2, 3 and 4 words: each against the next longer one, of other order and steps."""

from dataclasses import replace
from decimal import Decimal
from fractions import Fraction
from math import floor
from random import Random

import numpy as np
import pytest
from hypothesis import given, settings

from tests.engine.many_digits import exact_parts
from tests.engine.random_formulas import formula_scene
from tests.engine.random_parts import part_scenes, rigid_scenes
from tests.engine.runs import whole
from vibsim.cases import load_case
from vibsim.engine.errors import EngineError
from vibsim.engine.number_forms import WORD, WORDS, WordsForm, digits_in_c, words_form
from vibsim.engine.truth import WordsTrajectory, open_truth
from vibsim.physics.parts import EVENT_KINDS
from vibsim.physics.precision import number_kit

pytest.importorskip("flint")

PAIRS = ((25, 45), (45, 65))  # digits, on 2, 3 and 4 words
LOST = 9  # digits that random scenes may lose by their own growth of errors


def told(make, digits, **options):
    """(kinds and parts of the events, their digits, totals), or the reason of a failure."""
    trajectory = open_truth(make, digits, **options)
    try:
        blocks = list(trajectory.blocks())
    except EngineError as error:
        return error.reason
    events, texts = (whole([getattr(b, name) for b in blocks]) for name in ("events", "event_digits"))
    kinds = list(zip(events["kind"].tolist(), events["part"].tolist(), strict=True))
    return kinds, texts, trajectory.totals


def assert_same_motion(make, digits, more, lost=LOST, **options):
    """Events in the same order, at the same times and states but for the last digits, where there are no
    doubts. Of an infinite sequence of impacts more digits have more: there the ends are the same.
    """
    here, there = (told(make, each, **options) for each in (digits, more))
    if isinstance(here, str) or isinstance(there, str):
        assert here == there
        return
    doubts = [found[2]["uncertified"] for found in (here, there)]
    if any(doubts):
        return  # rounding may decide: a tangency is known to half the digits
    hops = any(kind == EVENT_KINDS["chatter"] for kind, _ in here[0])
    assert hops or here[0] == there[0]
    compared = slice(-1, None) if hops else slice(None)
    left_out = sum(Decimal(here[2].get(name, 0.0)) for name in ("chatter_time", "chatter_speed"))
    for name, column in here[1].items():
        both = zip(column[compared], there[1][name][compared], strict=True)
        pairs = [(Decimal(a.decode()), Decimal(b.decode())) for a, b in both]
        size = max((abs(b) for _, b in pairs), default=Decimal(0))
        close = max(size, Decimal("1e-6")) * Decimal(10) ** (lost - digits) + left_out
        assert all(abs(a - b) <= close for a, b in pairs), name
    for name in here[2]:
        if name.startswith(("loss.", "work.", "impulse.", "energy_end")):
            assert here[2][name] == pytest.approx(there[2][name], rel=1e-12, abs=1e-14)


@pytest.mark.parametrize(("digits", "more"), PAIRS)
@settings(max_examples=8)
@given(scene=part_scenes())
def test_random_scenes(digits, more, scene):
    assert_same_motion(exact_parts(scene), digits, more, ledger=True, momentum=True)


@pytest.mark.parametrize(("digits", "more"), PAIRS)
@settings(max_examples=6)
@given(scene=rigid_scenes(radians=4.0))
def test_random_scenes_with_rigid_stops(digits, more, scene):
    assert_same_motion(exact_parts(scene), digits, more)


@pytest.mark.parametrize("seed", range(12))
def test_random_formulas(seed):
    assert_same_motion(exact_parts(replace(formula_scene(seed), t_end=0.3)), 30, 50)


@pytest.mark.slow
@pytest.mark.timeout(7200)
@pytest.mark.parametrize(("digits", "more"), PAIRS)
@settings(max_examples=300)
@given(scene=part_scenes())
def test_random_scenes_often(digits, more, scene):
    assert_same_motion(exact_parts(scene), digits, more)


@pytest.mark.parametrize("name", ["I-A", "I-B", "I-C", "II-A", "II-B", "II-C"])
@pytest.mark.parametrize(("digits", "more"), PAIRS)
def test_the_papers_cases(name, digits, more):
    case = load_case(name, {"run.t_end": "3 s", "run.every": "50 s"})
    assert_same_motion(case.exact_scene, digits, more, lost=4)


def test_the_cheapest_type_that_suffices_is_taken():
    assert [words_form(number_kit(digits)).words for digits in (20, 32, 33, 51, 52, 71)] == [2, 2, 3, 3, 4, 4]
    assert digits_in_c()[:3] == [32, 51, 71]
    case = load_case("I-A", {"run.t_end": "0.1 s"})
    assert isinstance(open_truth(case.exact_scene, 71), WordsTrajectory)


@pytest.mark.parametrize("words", WORDS)
def test_numbers_come_back_as_they_went(words):
    kit = number_kit(20)
    form = WordsForm(kit, words)
    for value in (0.0, 1.0, -1.0, 0.1, -(2.0**-1074), 1.7976931348623157e308, 5e-324, 3.0):
        assert form.double(form.handed(kit.number(value))) == value == float(form.taken(form.handed(value)))
    assert form.double(form.handed(float("-inf"))) == float("-inf")
    third = form.parts(form.handed(Fraction(1, 3)))
    error = abs(Fraction(third[0]) * Fraction(2) ** third[1] - Fraction(1, 3))
    assert error <= Fraction(1, 2 ** min(WORD * words, kit.bits + 32))
    assert floor(Fraction(third[0]).numerator) > 2**60


@pytest.mark.parametrize(("words", "digits"), [(2, 20), (2, 32), (3, 51), (4, 71)])
def test_texts_in_c_are_those_of_python(words, digits):
    """Of numbers whose digits go on, so that none lies half-way between two texts."""
    kit, draw = number_kit(digits), Random(digits)
    form = WordsForm(kit, words)
    thirds = [Fraction(draw.randrange(1, 10**20), 3 * 10**20) for _ in range(100)]
    values = [(-1) ** k * third * Fraction(10) ** draw.randint(-25, 15) for k, third in enumerate(thirds)]
    powers = [
        Fraction(10) ** k * (1 + sign * Fraction(1, 3 * 10 ** (digits + 9)))
        for k in (-7, 0, 9)
        for sign in (-1, 1)
    ]
    row = np.frombuffer(form.packed([*values, *powers, 0.0, 1.0, -0.5]), dtype=form.type)
    texts = form.texts(row)
    assert [text.decode() for text in texts] == kit.texts_of(map(form.parts, form._each(row)))
    assert Decimal(texts[-1].decode()) == Decimal("-0.5")


def test_texts_of_what_c_cannot_write_are_those_of_python():
    kit = number_kit(30)
    form = WordsForm(kit, 2)
    row = np.frombuffer(form.packed([Fraction(1, 3) * 10**200, Fraction(1, 3)]), dtype=form.type)
    assert [text[:32] for text in form.texts(row).tolist()] == [b"3.33333333333333333333333333333e"] * 2


@pytest.mark.parametrize("name", ["II-A", "II-B"])
def test_a_motor_keeps_the_digits_that_its_growth_of_errors_leaves(name):
    """In two lengths of numbers, whose sums of products have lengths of their own."""
    case = load_case(name, {"run.t_end": "30 s", "run.every": "50 s"})
    ends = [told(case.exact_scene, digits) for digits in (30, 65)]
    assert ends[0][0] == ends[1][0]
    assert (
        min(
            -abs(Decimal(one[-1].decode()) / Decimal(ends[1][1][column][-1].decode()) - 1).log10()
            for column, one in ends[0][1].items()
            if column != "t"
        )
        > 23
    )
