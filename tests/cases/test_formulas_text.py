"""Formulas as text: grammar, numbers with units, units worked out, tables, and texts meant to do harm."""

import math
import time
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline

from vibsim.cases.any_unit import (
    FORCE,
    LENGTH,
    PURE,
    TIME,
    VELOCITY,
    any_quantity,
    dimension,
    rational_power,
    si_name,
)
from vibsim.cases.formula_text import FormulaError, names_in, pairs_of, with_pairs
from vibsim.cases.formula_values import Meaning, formula_node, meaning_of_number
from vibsim.cases.quantities import QuantityError
from vibsim.physics.formula_values import size_of, spline_pieces
from vibsim.physics.formulas import PI, num
from vibsim.physics.formulas import TIME as T


def names(**texts):
    """Numbers by name, and t, pi, d, v of a place."""
    known = {name: meaning_of_number(any_quantity(text)[0]) for name, text in texts.items()}
    inputs = {"t": Meaning(T, TIME), "pi": Meaning(PI, PURE)}
    return known | inputs | {"d": Meaning(("x", 0), LENGTH), "v": Meaning(("v", 0), VELOCITY)}


def node(text, wanted=None, **texts):
    return formula_node(text, names(**texts), wanted, "a force")


def error_of(text, wanted=None, **texts):
    with pytest.raises(FormulaError) as raised:
        node(text, wanted, **texts)
    return str(raised.value), text[raised.value.start : raised.value.end]


# Values: against Python's own reading of the same text.

MATHS = {name: getattr(math, name) for name in ("sin", "cos", "tan", "exp", "tanh", "atan", "sqrt")}
LEAVES = st.sampled_from(["t", "2", "0.5", "3", "pi", "a", "1.25"])


def expressions():
    def grown(inner):
        pairs = st.tuples(inner, st.sampled_from([" + ", " - ", "*", "/"]), inner).map("".join)
        powers = st.tuples(inner, st.sampled_from(["2", "3", "-1", "-2"])).map(lambda p: f"({p[0]})**{p[1]}")
        calls = st.tuples(st.sampled_from([*MATHS, "abs", ""]), inner).map(lambda p: f"{p[0]}({p[1]})")
        return st.one_of(pairs, powers, calls, inner.map(lambda text: f"-{text}"))

    return st.recursive(LEAVES, grown, max_leaves=12)


@given(expressions())
def test_a_formula_means_what_it_means_in_python(text):
    """Precedence, signs and functions, whatever stands beside what."""
    values = {"t": 0.7, "pi": math.pi, "a": 1.75, "abs": abs}
    try:
        expected = eval(text, {"__builtins__": {}}, MATHS | values)
    except (ArithmeticError, ValueError):
        return
    if isinstance(expected, complex) or not 1e-6 < abs(expected) < 1e6:
        return
    known = {"t": Meaning(T, PURE), "pi": Meaning(PI, PURE), "a": Meaning(num(Fraction(7, 4)), PURE)}
    try:
        found = size_of(formula_node(text, known, None), 0.7)
    except FormulaError:
        return  # a number that does not fit, or no value where rounding gives Python one
    assert found is None or found == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize(
    ("text", "value"),
    [("-2**2", -4), ("2**3**2", 512), ("2**-1", Fraction(1, 2)), ("7 - 2 - 1", 4), ("8/4/2", 1),
     ("1 - -1", 2), ("2*(3 + 4)", 14), ("1/3", Fraction(1, 3)), ("min(3, 1, 2) + max(1, 2)", 3),
     ("step(0) + step(-1) + 2*step(1)", 3), ("sign(-2) + sign(0) + 3*sign(5)", 2),
     ("where(1 < 1, 10, 20) + where(1 <= 1, 1, 2)", 21), ("where(2 > 1, 10, 20) + where(1 >= 2, 1, 2)", 12),
     ("mod(-1, 3) + mod(7/2, 3)", Fraction(5, 2)),
     ("abs(-1.5) + cos(0) + exp(0) + tanh(0) + log(1)", Fraction(7, 2)), ("0**1.5 + 0**2", 0)],
)  # fmt: skip
def test_numbers_alone_are_exact(text, value):
    assert node(text) == num(value)


@pytest.mark.parametrize(
    ("text", "value"),
    [("9.81 m/s^2*t**2/(1 m)", 9.81 * 4), ("3 N/m*(2 m)/(1 N)", 6), ("3 Hz*t", 12 * math.pi),
     ("180 deg", math.pi), ("60 rpm*(1 s)", 2 * math.pi),
     ("2 kN/mm/(1 N/m)", 2e6), ("3 m**2/(1 m)/(1 m)", 3), ("0.004 1/K*(100 K)", 0.4), ("1/K*(3 K)", 3),
     ("4 J/(kg K)*(1 kg)*(1 K)/(1 J)", 4), ("2 N/m^1.5*(4 m)**1.5/(1 N)", 16),
     ("2 m^(1/2)*(4 m)**0.5/(1 m)", 4), ("3 s/max(1, 2)/(1 s)", 1.5),
     ("1 ohm*(2 A)/(1 V) + 1 mH*(1 A)/(1 Wb)", 2.001)],
)  # fmt: skip
def test_units_behind_numbers(text, value):
    found = formula_node(text, {"t": Meaning(T, TIME)}, PURE)
    assert size_of(found, 2.0) == pytest.approx(value, rel=1e-14)


def test_a_unit_ends_before_a_name():
    assert node("3 N/m*d", FORCE) == ("mul", num(3), ("x", 0))
    assert node("3 N/m*m*d/(1 kg)", FORCE, m="2 kg") == ("mul", num(6), ("x", 0))
    assert node("12/m", m="4") == num(3), "a number has the name"
    assert node("1/m*d") == ("x", 0), "no number has it, so it is a unit"


def test_a_frequency_keeps_its_pi_exact():
    assert node("w*t", w="3 Hz") == ("mul", ("mul", num(6), PI), T)
    assert node("k", k="1 N m/deg") == ("div", num(180), PI)


@pytest.mark.parametrize(
    ("text", "message", "place"),
    [
        ("k*d + c*d", "N + N s: c*d is N s, must be N", "c*d"),
        ("c*d + k*d", "N s + N: c*d is N s, must be N", "c*d"),
        ("c*d", "comes to N s, must be N, a force", "c*d"),
        ("k*d + 3", "N + a pure number: 3 is a pure number, must be N", "3"),
        ("k*d*sin(t)", "t is s, must be a pure number in sin(...)", "t"),
        ("k*d*2**t", "t is s, must be a pure number as the exponent in 2**t", "t"),
        ("k*d**(v/v)", "d is m, so its exponent must be a number, not (v/v)", "(v/v)"),
        ("max(k*d, c*d)", "N, N s: c*d is N s, must be N", "c*d"),
        ("where(t < d, k*d, k*d)", "s < m: d is m, must be s", "d"),
        ("mod(k*d, 1 m)", "N, m: 1 m is m, must be N", "1 m"),
        ("table(d, [[0 s, 0 N], [1 s, 1 N]])", "m, s: [[0 s, 0 N], [1 s, 1 N]] is s, must be m", None),
    ],
)
def test_units_that_do_not_fit(text, message, place):
    found = error_of(text, FORCE, k="200 N/m", c="2 N s/m")
    assert found[0] == message
    assert place is None or found[1] == place


def test_a_literal_zero_fits_any_unit_and_a_product_with_it_has_one():
    assert node("max(0, k*d)", FORCE, k="1 N/m")[0] == "choose"
    assert node("where(t < 1 s, 0, -0)", FORCE) == num(0)
    assert "is m" in error_of("k*d + 0*d", FORCE, k="1 N/m")[0]


@pytest.mark.parametrize(
    ("text", "message", "place"),
    [
        ("", "is empty; a formula is written like k*d + c*v", ""),
        ("k*", "ends where a number, a name or a bracket is due", ""),
        ("(k", "the bracket at character 1 is not closed; the formula ends", ""),
        ("k)", "a bracket is closed that was not opened", ")"),
        ("2 k", "k is no unit; write a sign between 2 and k, such as *", "k"),
        ("k d", "a sign such as * is due before d", "d"),
        ("k^2", "^ has no place in a formula; write a power with **, such as x**2", "^"),
        ("k²", "² has no place in a formula; write a power with **, such as x**2", "²"),
        ("π*k", "π has no place in a formula; write pi", "π"),
        ("|k|", "| has no place in a formula; write abs(...)", "|"),
        ("k % 2", "% has no place in a formula; write a remainder as mod(a, b)", "%"),
        ("k.real", ". has no place in a formula; a name has no parts; numbers begin with a digit", "."),
        ("k = 2", "= has no place in a formula; a formula has no =", "="),
        ("sine(k)", "no function sine (did you mean sin?); there are", "sine"),
        ("sin", "the function sin needs its argument: sin(...)", "sin"),
        ("max(k)", "max has 2 to 20 arguments, got 1", "max(k)"),
        ("where(k, 1, 2)", "where(...) begins with a comparison, such as where(t < 1 s, a, b)", "k"),
        ("k < 2", "< stands once, in where(a < b, then, else)", "<"),
        ("k*(d > 1)", "> stands once, in where(a < b, then, else)", ">"),
        ("where(1 < k < 2, 1, 2)", "< stands once, in where(a < b, then, else)", "<"),
        ("k if d < 1 else 2", "if is written where(a < b, then, else)", "if"),
        ("where(k < 1 and d < 2, 1, 2)", "and is written where(a < b, where(c < d, then", "and"),
        ("where(k < d or d < k, 1, 2)", "or is written where(a < b, then, where(c < d, then, else))", "or"),
        ("[1, 2]", "a list of pairs stands in table(...) only", "["),
        ("'k'", "a text stands in table(...) only", "'k'"),
        ("kk*d", "unknown name kk; known here: k, t, pi, d, v", "kk"),
        ("k/0", "division by zero: 0 is 0", "0"),
        ("log(0)", "log(0): the logarithm of a number that is not above 0", "log(0)"),
        ("sqrt(-1)", "sqrt(-1): the root of a negative number", "sqrt(-1)"),
        ("(-1)**0.5", "a negative number to a power that is no whole number, got (-1)**0.5", "(-1)**0.5"),
        ("asin(2)", "asin(2): asin of a number beyond -1 to 1", "asin(2)"),
        ("mod(k, d)", "N/m, m: d is m, must be N/m", "d"),
        ("mod(t, 0)", "0 must be > 0, in mod(a, b)", "0"),
        ("mod(t, t)", "t must be a number that does not change, in mod(a, b)", "t"),
        ("3 m^99", "a power of a unit must be between -12 and 12", "3"),
        ("3 Hz^0.5", "Hz^0.5 has a root of a turn; write the frequency in rad/s, the angle in rad", "3"),
        ("3 J/kg K", "write a unit with two factors below the line as J/(kg K) or J/kg/K", "3"),
        ("table(t, [[1 s, 1]])", "a table needs at least two pairs", "[[1 s, 1]]"),
        (
            "table(t, [[1 s, 1], [1 s, 2]])",
            "the first numbers of pairs must rise; those of pairs 1 and 2 do not",
            "[[1 s, 1], [1 s, 2]]",
        ),
        ("table(t, [[1 s, t], [2 s, 2 s]])", "t must be a number, in a table", "t"),
        ("table(t, 3)", "here table(...) has a list of pairs or the name of a CSV file in quotes", "3"),
        (
            'table(t, [[0 s, 1], [1 s, 2]], "step")',
            'step is no way between pairs; there are "linear" and "cubic"',
            None,
        ),
    ],
)
def test_what_is_wrong_is_said_with_its_place(text, message, place):
    found = error_of(text, k="200 N/m")
    assert found[0].replace('"step"', "step").startswith(message)
    assert place is None or found[1] == place


# Texts that are meant to do harm.


@pytest.mark.parametrize(
    "text",
    ["__import__('os').system('true')", "().__class__.__bases__", "t.__class__", "lambda: t",
     "[x for x in t]", "t if t else t", "exec('t')", "open('/etc/passwd')", "f'{t}'", "t; t", "t\x00",
     "globals", "0x10*t", "1_000*t", "1j*t", "t := 3", "t ** t ** t ** _", "ｔ + t", "t\\\n+ t"],
)  # fmt: skip
def test_nothing_of_python_gets_through(text):
    with pytest.raises(FormulaError):
        node(text)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("+".join(["t"] * 100_000), "more than 2000 operations"),
        ("(" * 100_000 + "t", "nested more than 40 deep"),
        ("sin(" * 10_000 + "t", "nested more than 40 deep"),
        ("-" * 100_000 + "t", "more than 2000 operations"),
        ("2**" * 10_000 + "2", "nested more than 40 deep"),
        ("1" * 100_000, "a number may have at most 200 characters"),
        ("1e99999999", "does not fit double precision"),
        ("2**9999999999", "powers beyond 64 are not supported"),
        ("((2**64)**64)**64", "does not fit double precision"),
        ("(((1 + d/(1 m))**64)**64)**64", "is too large when it is written out"),
        ("abs(" * 12 + "d" + ")" * 12, "is too large when it is written out"),
        ("table(t, [" + "[1 s, 2]," * 100_000 + "])", "more than 10000 pairs in tables"),
        ("d" + " " * 100_000 + "*d", "longer than 50000 characters"),
    ],
)
def test_what_would_take_long_is_refused_fast(text, message):
    start = time.process_time()
    assert message in error_of(text)[0]
    assert time.process_time() - start < 20  # 0.6 s, say


def test_two_thousand_terms_are_no_deep_tree():
    """A sum of many terms is joined in halves, so that what walks the tree needs no deep recursion."""
    found = node("+".join(["d*t"] * 1000), k="1 N")

    def depth(one):
        return 1 + max((depth(part) for part in one if isinstance(part, tuple)), default=0)

    assert depth(found) < 25


def test_names_are_found_once_and_in_order():
    assert names_in("b*t + a*sin(b) + 3 N") == ("b", "t", "a")
    assert names_in("b*(t + ") == ("b", "t"), "of a text that is none too"


# Units by themselves.


@pytest.mark.parametrize(
    ("text", "canonical", "value", "turns", "si"),
    [("1e6 N/m^1.5", "1e6 N/m^1.5", 10**6, 0, "N/m^1.5"), ("2 N s^2/m^2", "2 N s^2/m^2", 2, 0, "kg/m"),
     ("0.05 V s/rad", "0.05 V s/rad", Fraction(1, 20), 0, "N m/A"),
     ("1 mH", "1 mH", Fraction(1, 1000), 0, "H"), ("5 kg m2", "5 kg m^2", 5, 0, "kg m^2"),
     ("5 kgm^2", "5 kg m^2", 5, 0, "kg m^2"), ("3 N*s/m", "3 N s/m", 3, 0, "N s/m"),
     ("2 Nm", "2 N m", 2, 0, "N m"), ("0.1 Hz/s", "0.1 Hz/s", Fraction(1, 10), 1, "1/s^2"),
     ("2 N m/deg", "2 N m/deg", 720, -1, "N m"), ("1/3 N/m", "1/3 N/m", Fraction(1, 3), 0, "N/m"),
     ("0.004 1/K", "0.004 1/K", Fraction(1, 250), 0, "1/K"),
     ("0.004/K", "0.004 1/K", Fraction(1, 250), 0, "1/K"), ("3 µF", "3 uF", Fraction(3, 10**6), 0, "F"),
     ("4 J/(kg K)", "4 J/kg/K", 4, 0, "m^2/s^2/K"), ("12", "12", 12, 0, "")],
)  # fmt: skip
def test_any_quantity(text, canonical, value, turns, si):
    quantity, of = any_quantity(text)
    assert (quantity.text, quantity.value, quantity.per_turn, si_name(of)) == (canonical, value, turns, si)
    assert any_quantity(canonical) == (quantity, of)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("abc", "must be a number with its unit, such as 3 N/m^2; got abc"),
        ("1,5 N", ",5 N is no unit; write decimals with a point"),
        ("3 N/mmm", "unknown unit mmm (did you mean mm?)"),
        ("3 kg^", "kg^ is no unit"),
        ("1 1/min", "1/min may be rpm or 1/(60 s); write rpm, or 1/s"),
        ("1e400 N", "does not fit double precision"),
    ],
)
def test_what_is_no_quantity(text, message):
    with pytest.raises(QuantityError) as raised:
        any_quantity(text)
    assert message in str(raised.value)


def test_broken_powers_of_prefixes_are_right_to_a_thousand_digits():
    root = rational_power(Fraction(1000), Fraction(3, 2))
    assert abs(root**2 - 10**9) < Fraction(1, 10**1000)
    assert rational_power(Fraction(1, 100), Fraction(3, 2)) == Fraction(1, 1000)
    assert any_quantity("1 N/cm^1.5")[0].value == 1000


def test_powers_of_units_of_many_kinds_have_names():
    assert si_name(dimension(1, 0, -2)) == "N/m"
    assert si_name(dimension(1, -1, -2)) == "Pa"
    assert si_name(dimension(1, 2, -4, -1)) == "V/s"


# Tables.


@pytest.mark.parametrize("count", [3, 4, 5, 7, 39, 60, 200])
def test_the_cubic_spline_is_that_of_scipy(count):
    draw = np.random.default_rng(count)
    knots, values = np.cumsum(draw.uniform(0.1, 1, count)), draw.normal(size=count)
    pieces = spline_pieces([Fraction(x) for x in knots], [Fraction(y) for y in values])
    expected = CubicSpline(knots, values).c
    for i, piece in enumerate(pieces):
        for power, coefficient in enumerate(piece):
            assert float(coefficient) == pytest.approx(expected[3 - power, i], rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("count", [4, 30, 45])
def test_the_spline_of_a_cubic_is_that_cubic(count):
    """Not-a-knot reproduces cubics; exactly with few knots, to 1e-60 with many."""
    knots = [Fraction(i * i + 3 * i, 7) for i in range(count)]
    pieces = spline_pieces(knots, [x**3 - 2 * x for x in knots])
    for knot, (a, b, c, d) in zip(knots, pieces, strict=False):
        errors = [a - knot**3 + 2 * knot, b - 3 * knot**2 + 2, c - 3 * knot, d - 1]
        assert max(map(abs, errors)) <= (0 if count < 40 else Fraction(1, 10**60))


def test_two_pairs_make_a_line_and_columns_may_be_in_turns():
    line = node('table(t, [[0 s, 1 N], [2 s, 5 N]], "cubic")')
    assert line[:4] == node("table(t, [[0 s, 1 N], [2 s, 5 N]])")[:4]
    found = node("table(w, [[1 Hz, 0 rpm], [2 Hz, 60 rpm]])", w="1.5 Hz")
    assert size_of(found) == pytest.approx(math.pi)
    assert size_of(node("table(t, [[0 s, 1], [1 s, 3]])"), 9.0) == 3
    message = "a column of a table has one kind of unit: Hz, rpm and deg, or rad/s and rad"
    assert error_of("table(w, [[1 Hz, 0], [20 rad/s, 1]])", w="1 Hz")[0] == message


def test_a_csv_file_becomes_pairs():
    text, places = with_pairs("2*table(t, 'a.csv') + k", lambda name: "t [ms], F [N]\n0, 1\n500, -2e3\n")
    assert text == "2*table(t, [[0 ms, 1 N], [500 ms, -2e3 N]]) + k"
    assert text[places[0][0] :][: places[0][2]] == "[[0 ms, 1 N], [500 ms, -2e3 N]]"
    assert pairs_of("x [1], y []\n\n1,2\n3,4\n") == "[[1, 2], [3, 4]]"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "is empty; it begins with a line such as: t [s], F [N]"),
        ("0,1\n1,2\n", "the first line must be like `t [s], F [N]`, got 0"),
        ("t [s], F [N], x [m]\n", "must have two columns, got 3"),
        ("t [s]; F [N]\n0,5; 1\n", "columns are separated by commas, and decimals have a point; got semi"),
        ("t [s]\tF [N]\n0\t1\n", "columns are separated by commas, and decimals have a point; got tabs"),
        ("t [s], F [parsec]\n", "column F: unknown unit parsec"),
        ("t [s], F [N]\n1,2,3\n", "row 2 has 3 columns, must have 2"),
        ("t [s], F [N]\n1,two\n", "row 2 must be two numbers, got 1,two"),
        ("t [s], F [N]\n" + "1,2\n" * 10_001, "has more than 10000 rows"),
    ],
)
def test_csv_files_that_are_none(text, message):
    with pytest.raises(ValueError) as raised:
        pairs_of(text)
    assert str(raised.value).startswith(message)
