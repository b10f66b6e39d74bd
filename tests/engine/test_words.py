"""The engine in C on numbers of words: its operations against python-flint's, and runs of the engines for a
fixed number of words against those of the engine for any number, which has other sums and functions.
"""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from decimal import Decimal
from fractions import Fraction
from math import inf, isnan, isqrt, nan, pi
from operator import add, mul, sub, truediv
from random import Random
from unittest.mock import patch

import numpy as np
import pytest
from hypothesis import strategies as st

from tests.engine.many_digits import exact_parts
from tests.engine.random_formulas import formula_scene
from tests.engine.random_parts import part_scenes, rigid_scenes
from tests.engine.runs import by_instant, scene_of, whole
from tests.random_scenes import always
from vibsim.cases import load_case
from vibsim.engine.errors import EngineError
from vibsim.engine.number_forms import WordsForm
from vibsim.engine.truth import open_truth
from vibsim.physics.precision import SPARE_BITS, WORD, WORDS, DigitsKit, digits_in_c, is_built, number_kit

flint = pytest.importorskip("flint")
pytestmark = pytest.mark.skipif(not all(map(is_built, (*WORDS, 5))), reason="built without numbers of words")

DIGITS = (25, 45, 65)  # on 2, 3 and 4 words
LOST = 9  # digits that random scenes may lose by their own growth of errors


def any_number(digits):
    """The kit of the engine for any number of words, of as many words as an engine of its own has."""
    return DigitsKit(digits, any_number=True)


def told(make, digits, **options):
    """(kinds and parts of the events, their digits, totals), or the reason of a failure."""
    trajectory = open_truth(make, digits, **options)
    try:
        blocks = list(trajectory.blocks())
    except EngineError as error:
        return error.reason
    events, texts = (whole([getattr(b, name) for b in blocks]) for name in ("events", "event_digits"))
    return by_instant(events), texts, trajectory.totals


def assert_same_motion(make, digits, lost=LOST, **options):
    """Events of both engines in the same order, at the same times and states but for the last digits, where
    there are no doubts.
    """
    here = told(make, digits, **options)
    with patch("vibsim.engine.truth.number_kit", any_number):
        there = told(make, digits, **options)
    if isinstance(here, str) or isinstance(there, str):
        assert here == there
        return
    doubts = [found[2]["uncertified"] for found in (here, there)]
    assert here[0] == there[0] or any(doubts)
    if any(doubts):
        return  # rounding may decide: a tangency is known to half the digits
    left_out = sum(Decimal(here[2].get(name, 0.0)) for name in ("chatter_time", "chatter_speed"))
    for name, column in here[1].items():
        pairs = [
            (Decimal(a.decode()), Decimal(b.decode())) for a, b in zip(column, there[1][name], strict=True)
        ]
        size = max((abs(b) for _, b in pairs), default=Decimal(0))
        close = max(size, Decimal("1e-6")) * Decimal(10) ** (lost - digits) + left_out
        assert all(abs(a - b) <= close for a, b in pairs), name
    for name in here[2]:
        if name.startswith(("loss.", "work.", "impulse.", "energy_end")):
            assert here[2][name] == pytest.approx(there[2][name], rel=1e-12, abs=1e-14)


def assert_alike(scene, digits):
    assert_same_motion(exact_parts(scene), digits, ledger=True, momentum=True)


test_random_scenes_move_alike = always(assert_alike, part_scenes(), st.sampled_from(DIGITS), few=30, many=900)
test_random_scenes_with_rigid_stops_move_alike = always(
    assert_alike, rigid_scenes(radians=4.0), st.sampled_from(DIGITS), few=18, many=300
)


@pytest.mark.parametrize("seed", range(12))
def test_random_formulas_move_alike(seed):
    assert_same_motion(exact_parts(replace(formula_scene(seed), t_end=0.3)), 30)


@pytest.mark.parametrize("name", ["I-A", "I-B", "I-C", "II-A", "II-B", "II-C"])
@pytest.mark.parametrize("digits", DIGITS)
def test_the_papers_cases_move_alike(name, digits):
    case = load_case(name, {"run.t_end": "3 s", "run.every": "50 s"})
    assert_same_motion(case.exact_scene, digits, lost=4)


def test_the_cheapest_type_that_suffices_is_taken():
    assert [number_kit(digits).words for digits in (20, 32, 33, 51, 52, 71)] == [2, 2, 3, 3, 4, 4]
    assert [number_kit(digits).words for digits in (72, 100, 300, 1000)] == [5, 6, 16, 53]
    assert digits_in_c() == [32, 51, 71]


def test_the_engine_for_any_number_of_words_takes_no_more_than_there_are():
    with pytest.raises(ValueError, match="have up to 3372 bits, got 3373"):
        number_kit(1000).engine.precision(3373)


OF_TWO = (add, sub, mul, truediv)
OF_ONE = ("sin", "cos", "exp", "expm1", "sinh", "cosh", "tanh", "atan", "asin", "acos", "log", "sqrt")


def in_arb(number):
    return flint.arb(number.parts())


def number_of(kit, mantissa, exponent):
    """The number nearest to mantissa 2**exponent."""
    return kit.number(mantissa * Fraction(2) ** exponent)


@pytest.mark.parametrize(("digits", "tries"), [(30, 40), (45, 40), (70, 40), (100, 40), (300, 15), (1000, 5)])
def test_operations_are_those_of_arb(digits, tries):
    """Errors in units of the last bit of all words, of which 2^SPARE_BITS make the round-off."""
    kit, draw = number_kit(digits), Random(digits)
    length = WORD * kit.words
    flint.ctx.prec = length + 100

    def errors(ours, exact):
        return float(abs((in_arb(ours) - exact) / exact) * flint.arb(2) ** length)

    def number(size):
        return number_of(kit, draw.choice((-1, 1)) * (draw.getrandbits(length) | 1), size - length)

    for _ in range(tries):
        a, b, sine = number(draw.randint(-6, 4)), number(draw.randint(-6, 4)), number(draw.randint(-9, 0))
        for of in OF_TWO:
            assert errors(of(a, b), of(in_arb(a), in_arb(b))) < 2, of
        assert errors(a**-7, in_arb(a) ** -7) < 32
        assert errors(kit.power(abs(a), b), in_arb(abs(a)) ** in_arb(b)) < 2 ** (SPARE_BITS - 8)
        for name in OF_ONE:
            x = sine if name in ("asin", "acos") else abs(a) if name in ("log", "sqrt") else a
            exact = getattr(in_arb(x), name)()
            assert errors(getattr(kit.engine, name)(x), exact) < 2 ** (SPARE_BITS - 8), name


@pytest.mark.parametrize("digits", [30, 45, 70, 100])
def test_functions_at_their_edges_are_those_of_arb(digits):
    """Arguments that are tiny, huge, of either sign and, of a logarithm, near 1: relative errors."""
    kit = number_kit(digits)
    length = WORD * kit.words
    flint.ctx.prec = 4 * length + 2000

    def off(name, x):
        """In units of the last place."""
        exact = getattr(in_arb(x), name)()
        return float(abs(in_arb(getattr(kit.engine, name)(x)) / exact - 1) * flint.arb(2) ** length)

    root = isqrt(2 << 2 * (length - 1))  # of 2, in 2^(1 - length)
    for k in (2, 5, 6, 7, 20, 52, 53, 60, length - 1, length + 2, 900):
        for sign in (1, -1):
            tiny, huge = number_of(kit, sign * root, 1 - length - k), number_of(kit, sign, k)
            beside = kit.number(1) + number_of(kit, sign, -min(k, length - 1))
            for name in ("atan", "expm1", "exp", "tanh", "sinh", "sin", "asin"):
                assert off(name, tiny) < 2 ** (SPARE_BITS - 8), (name, k, sign)
            for name, x in (("log", beside), ("log", number_of(kit, 1, sign * k)), ("atan", huge)):
                assert off(name, x) < 2 ** (SPARE_BITS - 8), (name, k, sign)
            assert off("exp", number_of(kit, sign, min(k, 7))) < 2 ** (SPARE_BITS - 8)
    zero, one = kit.number(0), kit.number(1)
    of = kit.engine
    assert of.log(one) == of.atan(zero) == of.expm1(zero) == 0 and of.exp(zero) == 1
    assert float(of.atan(number_of(kit, 1, 10**6))) == pi / 2


@pytest.mark.parametrize(("few", "many"), [(71, 100), (100, 150)])
@pytest.mark.parametrize("name", ["II-B", "I-B"])
def test_runs_have_the_digits_of_finer_ones(name, few, many):
    """A motor and the closed form; the finer run in a thread of its own, as the precision of C is."""
    case = load_case(name, {"run.t_end": "2 s", "run.every": "50 s"})
    with ThreadPoolExecutor(1) as thread:
        finer = thread.submit(told, case.exact_scene, many).result()
    coarser = told(case.exact_scene, few)
    assert coarser[0] == finer[0]
    for column in coarser[1]:
        for a, b in zip(coarser[1][column], finer[1][column], strict=True):
            off = abs(Decimal(a.decode()) - Decimal(b.decode()))
            assert off <= max(abs(Decimal(b.decode())), Decimal("1e-6")) * Decimal(10) ** (4 - few), column


@pytest.mark.parametrize(
    ("digits", "method"), [(100, "taylor"), (300, "closed_form"), (300, "taylor"), (1000, "closed_form")]
)
def test_a_free_vibration_is_that_of_its_formula(digits, method):
    """x = e^(-a t) (cos w t + a / w sin w t), w^2 = k - a^2, of a unit mass."""
    a, k, end = 0.125, 2.0, 1.5
    scene = scene_of(f"""
bodies: {{m: 1 kg}}
links: {{k: {{between: [m, ground], k: {k} N/m, c: {2 * a} N s/m}}}}
initial: {{m: {{x: 1 m}}}}
run: {{t_end: {end} s, method: {method}}}
""")
    _, at_events, _ = told(exact_parts(scene), digits)
    flint.ctx.prec = 4000
    w = flint.arb(k - a * a).sqrt()
    decay, (sine, cosine) = flint.arb(-a * end).exp(), (w * end).sin_cos()
    x, v = decay * (cosine + a / w * sine), -decay * k / w * sine
    for name, exact in (("x_m", x), ("v_m", v)):
        off = abs(flint.arb(at_events[name][-1].decode()) / exact - 1)
        assert off < flint.arb(10) ** (2 - digits), name


@pytest.mark.parametrize("digits", (20, 45, 65, 75, 1000))
def test_numbers_are_the_nearest_ones(digits):
    kit = number_kit(digits)
    for value in (0.0, 1.0, -1.0, 0.1, -(2.0**-1074), 1.7976931348623157e308, 5e-324, 3.0, inf, -inf):
        assert float(kit.number(value)) == value == kit.number(value)
    assert isnan(float(kit.number(nan))) and kit.number(nan) != kit.number(nan)
    for value in (Fraction(1, 3), Fraction(-(10**40), 7), Fraction(5 * 10**400 + 1), Fraction(-1, 3**900)):
        mantissa, exponent = kit.parts(kit.number(value))
        off = abs(mantissa * Fraction(2) ** exponent - value)
        assert abs(mantissa).bit_length() == WORD * kit.words and off <= Fraction(2) ** exponent / 2
    form = WordsForm(kit)
    assert list(form.all_taken(np.frombuffer(form.packed([kit.pi, 1, 0.5]), dtype=form.type))) == [
        kit.pi,
        1,
        0.5,
    ]


def test_numbers_behave_as_those_of_python():
    number = number_kit(40).number
    three = number(3)
    assert [three + 1, 1 + three, three - 0.5, 0.5 - three, 2 * three, 3 / three] == [4, 4, 2.5, -2.5, 6, 1]
    assert [three**2, three**-1 * 3, number(9) ** 0.5, abs(-three), +three] == [9, 1, 3, 3, 3]
    assert three > 2 and 2 < three <= 3 and three != "3" and not number(0) and three
    assert hash(three) == hash(3) and hash(number(1) / 3) == hash(number(1) / 3)
    assert sum([three, three]) == 6 and max(three, 4) == 4 and repr(three) == "number(3.0)"
    with pytest.raises(TypeError):
        three + "1"
    with pytest.raises(TypeError, match="number of words is needed, got str"):
        number_kit(40).sin("1")
    with pytest.raises(TypeError):
        three + number_kit(20).number(1)  # of another engine
    with pytest.raises(TypeError, match="is no number of 3 words"):
        number(number_kit(20).number(1))
    with pytest.raises(ValueError, match="no parts"):
        number(inf).parts()
    with pytest.raises(OverflowError):
        three + 2**70


@pytest.mark.parametrize("digits", [20, 32, 51, 71, 72, 1000])
def test_texts_in_c_are_those_of_python(digits):
    """Of numbers whose digits go on, so that none lies half-way between two texts."""
    kit, draw = number_kit(digits), Random(digits)
    form = WordsForm(kit)
    thirds = [Fraction(draw.randrange(1, 10**20), 3 * 10**20) for _ in range(100)]
    values = [(-1) ** k * third * Fraction(10) ** draw.randint(-25, 15) for k, third in enumerate(thirds)]
    powers = [
        Fraction(10) ** k * (1 + sign * Fraction(1, 3 * 10 ** (digits + 9)))
        for k in (-7, 0, 9)
        for sign in (-1, 1)
    ]
    row = np.frombuffer(form.packed([*map(kit.number, [*values, *powers]), 0.0, 1.0, -0.5]), dtype=form.type)
    texts = form.texts(row)
    assert [text.decode() for text in texts] == kit.texts_of(map(kit.parts, form.all_taken(row)))
    assert Decimal(texts[-1].decode()) == Decimal("-0.5")


def test_texts_of_what_c_cannot_write_are_those_of_python():
    kit = number_kit(30)
    form = WordsForm(kit)
    row = np.frombuffer(
        form.packed([kit.number(Fraction(1, 3) * 10**200), kit.number(Fraction(1, 3))]), dtype=form.type
    )
    assert [text[:32] for text in form.texts(row).tolist()] == [b"3.33333333333333333333333333333e"] * 2


@pytest.mark.parametrize("name", ["II-A", "II-B"])
def test_a_motor_keeps_the_digits_that_its_growth_of_errors_leaves(name):
    """In two lengths of numbers, whose sums of products have lengths of their own."""
    case = load_case(name, {"run.t_end": "30 s", "run.every": "50 s"})
    ends = [told(case.exact_scene, digits) for digits in (30, 65)]
    assert ends[0][0] == ends[1][0]
    for column in ends[0][1].keys() - {"t"}:
        one, other = (Decimal(table[column][-1].decode()) for _, table, _ in ends)
        assert abs(one / other - 1) < Decimal("1e-23"), column
