"""Units and quantities: exact factors, typed here once more, and the texts that people write."""

from fractions import Fraction
from itertools import pairwise
from math import pi

import mpmath
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vibsim.cases import RangeError, load_case, parse_range
from vibsim.cases.quantities import UNITS, QuantityError, decimal_text, parse_quantity, unit_names
from vibsim.physics.elementary import radians_to_turns, times_two_pi, two_pi_bounds

# dimension, text, value in SI units
EXACT = [
    ("mass", "2 kg", "2"), ("mass", "2 g", "0.002"), ("mass", "2 t", "2000"),
    ("length", "3 m", "3"), ("length", "3 cm", "0.03"), ("length", "3 mm", "0.003"),
    ("length", "3 um", "0.000003"),
    ("time", "4 s", "4"), ("time", "4 ms", "0.004"), ("time", "4 us", "0.000004"),
    ("time", "4 min", "240"), ("time", "4 h", "14400"),
    ("velocity", "5 m/s", "5"), ("velocity", "5 mm/s", "0.005"), ("velocity", "5 cm/s", "0.05"),
    ("velocity", "6 m/min", "0.1"),
    ("acceleration", "6 m/s^2", "6"), ("acceleration", "6 mm/s^2", "0.006"),
    ("acceleration", "6 cm/s^2", "0.06"),
    ("inverse velocity", "6 s/m", "6"), ("inverse velocity", "6 s/mm", "6000"),
    ("inverse velocity", "6 s/cm", "600"),
    ("force", "7 N", "7"), ("force", "7 mN", "0.007"), ("force", "7 kN", "7000"),
    ("stiffness", "8 N/m", "8"), ("stiffness", "8 N/mm", "8000"), ("stiffness", "8 kN/m", "8000"),
    ("stiffness", "8 kN/mm", "8000000"),
    ("stiffness", "8 MN/m", "8000000"), ("stiffness", "8 N/cm", "800"),
    ("damping", "9 N s/m", "9"), ("damping", "9 N s/mm", "9000"), ("damping", "9 kN s/m", "9000"),
    ("damping", "9 kg/s", "9"),
    ("inertia", "1 kg m^2", "1"), ("inertia", "1 g m^2", "0.001"), ("inertia", "1 kg cm^2", "0.0001"),
    ("inertia", "1 g cm^2", "0.0000001"), ("inertia", "1 kg mm^2", "0.000001"),
    ("torque", "2 N m", "2"), ("torque", "2 mN m", "0.002"), ("torque", "2 kN m", "2000"),
    ("torque", "2 N cm", "0.02"), ("torque", "2 N mm", "0.002"),
    ("inverse angular rate", "2 s/rad", "2"),
    ("torsional stiffness", "2 N m/rad", "2"), ("torsional stiffness", "2 mN m/rad", "0.002"),
    ("torsional stiffness", "2 kN m/rad", "2000"), ("torsional stiffness", "2 MN m/rad", "2000000"),
    ("torsional damping", "2 N m s/rad", "2"), ("torsional damping", "2 mN m s/rad", "0.002"),
    ("torsional damping", "2 kN m s/rad", "2000"),
    ("angle", "3 rad", "3"), ("angular rate", "3 rad/s", "3"), ("number", "0.001", "0.001"),
]  # fmt: skip
TURNS = [
    ("angle", "180 deg", "1/2"), ("angle", "0.25 turn", "1/4"),
    ("angular rate", "5.5 Hz", "11/2"), ("angular rate", "330 rpm", "11/2"),
    ("angular rate", "5.5 rev/s", "11/2"), ("angular rate", "1980 deg/s", "11/2"),
]  # fmt: skip


@pytest.mark.parametrize(("dimension", "text", "value"), EXACT + TURNS)
def test_value_is_exact(dimension, text, value):
    quantity, per_turn = parse_quantity(text, dimension), (dimension, text, value) in TURNS
    assert (quantity.value, quantity.per_turn, quantity.text) == (Fraction(value), per_turn, text)


def test_every_unit_is_tested():
    tested = {text.partition(" ")[2] for _, text, _ in EXACT + TURNS}
    assert tested == set(UNITS)


@pytest.mark.parametrize(
    ("dimension", "text", "canonical"),
    [("damping", "1 N*s/m", "1 N s/m"), ("damping", "1 N.s/m", "1 N s/m"), ("damping", "1 N·s/m", "1 N s/m"),
     ("damping", "1 N⋅s / m", "1 N s/m"), ("damping", "1Ns/m", "1 N s/m"),
     ("damping", "1   N  s/m", "1 N s/m"), ("inertia", "1 kg*m^2", "1 kg m^2"),
     ("inertia", "1 kg m²", "1 kg m^2"), ("inertia", "1 kg·m**2", "1 kg m^2"),
     ("inertia", "1 kgm^2", "1 kg m^2"), ("inertia", "1 kg m2", "1 kg m^2"),
     ("inertia", "1 kg m ^ 2", "1 kg m^2"), ("torque", "1 Nm", "1 N m"), ("torque", "1 mN·m", "1 mN m"),
     ("length", "1 µm", "1 um"), ("length", "1 μm", "1 um"), ("length", "1mm", "1 mm"),
     ("length", " 1 mm ", "1 mm"), ("length", "1", "1 m"), ("acceleration", "9.81 m/s²", "9.81 m/s^2"),
     ("acceleration", "9.81 m/s2", "9.81 m/s^2"), ("angle", "90°", "90 deg"), ("angle", "1", "1 rad"),
     ("angular rate", "60 rev/min", "60 rpm"), ("angular rate", "60 1/min", "60 rpm"),
     ("time", "5 sec", "5 s"), ("time", "1/60 s", "1/60 s"), ("number", "1e-3", "1e-3")],
)  # fmt: skip
def test_spellings(dimension, text, canonical):
    quantity = parse_quantity(text, dimension)
    assert quantity.text == canonical
    assert parse_quantity(canonical, dimension) == quantity


LENGTH = "must be a length in m, mm, um or cm"
TORQUE = "must be a torque in N m, mN m, kN m, N cm or N mm"


@pytest.mark.parametrize(
    ("dimension", "text", "message"),
    [("length", "", LENGTH + ", got nothing"), ("length", "mm", LENGTH + ", got mm"),
     ("length", "1 2 mm", LENGTH + ", got 1 2 mm"),
     ("length", "1 MM", LENGTH + ", got 1 MM; unknown unit MM (did you mean mm?)"),
     ("length", "1 mm^2", LENGTH + ", got 1 mm^2; unknown unit mm^2 (did you mean mm?)"),
     ("length", "1_000 mm", LENGTH + ", got 1_000 mm"), ("length", "0x10", LENGTH + ", got 0x10"),
     ("length", "1,5 mm", LENGTH + ", got 1,5 mm; write decimals with a point"),
     ("length", "١ mm", LENGTH + ", got ١ mm"), ("length", "nan", "must be finite, got nan"),
     ("length", "-.INF mm", "must be finite, got -.INF mm"),
     ("length", "Infinity", "must be finite, got Infinity"),
     ("length", "−1 mm", "write the minus sign as -, got −1 mm"),
     ("number", "5 %", "must be a plain number, got 5 %"),
     ("number", "5 kg", "must be a plain number, got 5 kg"),
     ("torque", "1 nm", TORQUE + ", got 1 nm; unknown unit nm (did you mean N m?)"),
     ("angular rate", "5.5", "needs a unit (Hz, rpm, rev/s, deg/s, rad/s), got 5.5"),
     ("angular rate", "0", "needs a unit (Hz, rpm, rev/s, deg/s, rad/s), got 0"),
     ("angular rate", "5 deg", "must be an angular rate in Hz, rpm, rev/s, deg/s or rad/s, got 5 deg"),
     ("time", "5/0 s", "division by zero in 5/0"),
     ("time", "1e400 s", "does not fit double precision (2.3e-308 to 2.2e307), got 1e400 s"),
     ("force", "1e306 kN", "does not fit double precision (2.3e-308 to 2.2e307), got 1e306 kN"),
     ("length", "-1e-307 um", "does not fit double precision (2.3e-308 to 2.2e307), got -1e-307 um")],
)  # fmt: skip
def test_what_is_wrong(dimension, text, message):
    with pytest.raises(QuantityError) as caught:
        parse_quantity(text, dimension)
    assert str(caught.value) == message


@pytest.mark.parametrize("exponent", ["999999999", "-999999999", "+999999999", "9" * 150])
def test_a_huge_exponent_is_refused_before_it_is_multiplied_out(exponent):
    with pytest.raises(QuantityError, match="does not fit"):
        parse_quantity(f"1e{exponent} m", "length")
    assert parse_quantity(f"0e{exponent} m", "length").value == 0


def test_numbers_are_rounded_once():
    """0.1 cm is 0.001 exactly; 0.1 * 0.01 in doubles is not."""
    assert parse_quantity("0.1 cm", "length").number() == 0.001
    assert parse_quantity("297 g", "mass").number() == 0.297
    assert parse_quantity("3 um", "length").number() == 3e-6 != 3 * 1e-6 + 1e-21


def test_two_pi_is_enclosed():
    with mpmath.workdps(400):
        exact = 2 * mpmath.pi
        for bits in (64, 192, 1000):
            low, high = two_pi_bounds(bits)
            below, above = (mpmath.mpf(bound.numerator) / bound.denominator for bound in (low, high))
            assert below < exact < above and 0 < high - low < Fraction(1, 2**bits)


@given(st.fractions(min_value=Fraction(-(10**9)), max_value=10**9))
def test_hertz_to_radians_is_correctly_rounded(turns):
    with mpmath.workdps(80):
        exact = 2 * mpmath.pi * turns.numerator / turns.denominator
        assert times_two_pi(turns) == float(exact)
        assert times_two_pi(turns, 2) == float(exact * 2 * mpmath.pi)


@given(st.fractions(min_value=Fraction(1, 10**6), max_value=10**9))
def test_radians_to_hertz_is_a_double_double(radians):
    high, low = radians_to_turns(radians)
    with mpmath.workdps(80):
        exact = mpmath.mpf(radians.numerator) / radians.denominator / (2 * mpmath.pi)
        assert high == float(exact)
        assert abs(exact - high - low) <= abs(exact) * mpmath.mpf(2) ** -105


def test_degrees_of_a_half_turn():
    assert parse_quantity("180 deg", "angle").number() == pi
    assert parse_quantity("1 Hz", "angular rate").number() == 2 * pi


@given(st.fractions())
def test_decimal_text_reads_back(value):
    assert parse_quantity(decimal_text(value), "number").value == value


@pytest.mark.parametrize(
    ("value", "text"),
    [(Fraction(61, 20), "3.05"), (Fraction(-61, 20), "-3.05"), (Fraction(7), "7"), (Fraction(0), "0"),
     (Fraction(1, 10**8), "1e-8"), (Fraction(10**9), "1e9"), (Fraction(120), "120"),
     (Fraction(10, 3), "10/3"), (Fraction(1, 1000), "0.001"), (Fraction(1, 8), "0.125")],
)  # fmt: skip
def test_decimal_text(value, text):
    assert decimal_text(value) == text


def test_unit_names_of_angular_rate_begin_with_hertz():
    assert unit_names("angular rate") == ["Hz", "rpm", "rev/s", "deg/s", "rad/s"]


@given(
    st.decimals(allow_nan=False, allow_infinity=False, places=6), st.sampled_from(sorted(filter(None, UNITS)))
)
def test_any_number_with_any_unit_reads_back(number, name):
    text = f"{number} {name}"
    dimension = UNITS[name].dimension
    try:
        quantity = parse_quantity(text, dimension)
    except QuantityError as error:
        assert "does not fit" in str(error) or len(text) > 200
        return
    assert quantity.value == Fraction(number) * UNITS[name].factor
    assert parse_quantity(quantity.text, dimension) == quantity


# Ranges: counted in exact decimals.


COUNT = "behind / stands how many values, a whole number, such as 3:7/9, and the unit behind it"
HOW = "write FROM:TO:STEP, FROM:TO/COUNT, 'log FROM:TO/COUNT' or A,B,C, with a unit at the end"
BY_RATIO = "a range by ratio is 'log FROM:TO/COUNT', such as 'log 1:1000/31 N/m'"


def texts(text, **options):
    return [value.text for value in parse_range(text, **options)]


def test_the_sweep_of_the_paper_has_81_exact_values():
    values = parse_range("3:7:0.05", bare_unit="Hz")
    assert len(values) == 81
    assert [value.value for value in values] == [3 + Fraction(i, 20) for i in range(81)]
    assert [value.text for value in values][:3] == ["3 Hz", "3.05 Hz", "3.1 Hz"]
    assert values[-1].text == "7 Hz"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("1:2:0.5", ["1", "1.5", "2"]),
        ("0:0.3:0.1", ["0", "0.1", "0.2", "0.3"]),  # 0.3 / 0.1 < 3 in doubles
        ("1:2:0.4", ["1", "1.4", "1.8"]),
        ("2:1:0.5", ["2", "1.5", "1"]),
        ("2:1:-0.5", ["2", "1.5", "1"]),
        ("-1:1:1", ["-1", "0", "1"]),
        ("1:1:1", ["1"]),
        ("1:2:5", ["1"]),
        ("1e-8:3e-8:1e-8", ["1e-8", "2e-8", "3e-8"]),
        ("3:7/5", ["3", "4", "5", "6", "7"]),
        ("7:3/3", ["7", "5", "3"]),
        ("0:1/4", ["0", "1/3", "2/3", "1"]),
        ("1,2,3", ["1", "2", "3"]),
        ("3, 1, 3", ["3", "1", "3"]),
        ("5", ["5"]),
        ("1/3", ["1/3"]),
        ("3:3.2:0.1 Hz", ["3 Hz", "3.1 Hz", "3.2 Hz"]),
        ("3Hz:3.2Hz:0.1Hz", ["3 Hz", "3.1 Hz", "3.2 Hz"]),
        ("1:2:0.5mm", ["1 mm", "1.5 mm", "2 mm"]),
        ("20:21/2 rad/s", ["20 rad/s", "21 rad/s"]),
        ("1 mm, 2 mm", ["1 mm", "2 mm"]),
        ("1, 2 mm", ["1 mm", "2 mm"]),
        ("1 mm, 2 cm", ["1 mm", "2 cm"]),
        ("log 1:1000/4 N/m", ["1 N/m", "10 N/m", "100 N/m", "1000 N/m"]),
        ("log 1000:1/4", ["1000", "100", "10", "1"]),
        ("log 1:2/3", ["1", "1.4142135623731", "2"]),  # 1.41421356237310 to 15 digits
        (" log  0.1mm:10/5 ", ["0.1 mm", "0.316227766016838 mm", "1 mm", "3.16227766016838 mm", "10 mm"]),
        ("1,2 N*s/m", ["1 N s/m", "2 N s/m"]),
    ],
)
def test_values(text, expected):
    assert texts(text) == expected


def test_a_bare_unit_is_for_ranges_without_a_unit():
    assert texts("1:2:1", bare_unit="Hz") == ["1 Hz", "2 Hz"]
    assert texts("1,2", bare_unit="Hz") == ["1 Hz", "2 Hz"]
    assert texts("60:120:60 rpm", bare_unit="Hz") == ["60 rpm", "120 rpm"]
    assert texts("1, 2 rpm", bare_unit="Hz") == ["1 rpm", "2 rpm"]


def test_one_unit_may_stand_anywhere_in_a_range():
    assert texts("0:2mm/5") == texts("0mm:2/5") == ["0 mm", "0.5 mm", "1 mm", "1.5 mm", "2 mm"]
    assert texts("0:2 mm / 5") == texts("0:2/5 mm") == texts("0:2 mm:0.5")
    assert texts("3 Hz:4:1") == ["3 Hz", "4 Hz"]
    assert texts("0:1 N/m/2") == texts("0:1/2 N/m") == ["0 N/m", "1 N/m"]
    assert texts("0:1 / 2 N/m") == texts("0:1/ 2N/m") == ["0 N/m", "1 N/m"]


@pytest.mark.parametrize(
    ("text", "message"),
    [("", "the range is empty"), ("a:b:c", f"a:b:c is no range; {HOW}"),
     ("1:2:3:4", f"1:2:3:4 is no range; {HOW}"),
     ("1:2", "1:2 has no step; write it as FROM:TO:STEP or FROM:TO/COUNT"),
     ("1, 2/0", "division by zero in 1, 2/0"), ("1/2:2:1", f"1/2:2:1 is no range; {HOW}"),
     ("1:2:0", "1:2:0: the step must not be 0"),
     ("1:2:-0.1", "1:2:-0.1: the step leads away from 2; leave its sign out"),
     ("1:2/1", "1:2/1: at least 2 values are needed, got 1"),
     ("1:2/0", "1:2/0: at least 2 values are needed, got 0"), ("1,,2", "an empty item in the list 1,,2"),
     ("1,2,", "an empty item in the list 1,2,"),
     ("1:1e9:1", "1:1e9:1 has 1e+09 values; at most 1,000,000 are allowed"),
     ("0:1/2000000", "0:1/2000000 has 2e+06 values; at most 1,000,000 are allowed"),
     ("0:1:1e-999999999", "does not fit double precision (2.3e-308 to 2.2e307), got 1e-999999999"),
     ("1:2/-3", f"unknown unit /-3 in the range 1:2/-3; {COUNT}"),
     ("1:2/2.5", f"unknown unit /2.5 in the range 1:2/2.5; {COUNT}"),
     ("1:2/1e3", f"unknown unit /1e3 in the range 1:2/1e3; {COUNT}"),
     ("1:2:0.1 herz", "unknown unit herz in the range 1:2:0.1 herz (did you mean Hz?)"),
     ("1 mm:2 cm:1 mm", "1 mm:2 cm:1 mm: write one unit, at the end, such as 3:7:0.05 Hz"),
     ("1 mm, 2", "1 mm, 2: write one unit for all values, or one behind each"),
     ("1 mm, 2, 3 cm", "1 mm, 2, 3 cm: write one unit for all values, or one behind each"),
     ("log 1:2", f"log 1:2: {BY_RATIO}"), ("log 1:2:0.1", f"log 1:2:0.1: {BY_RATIO}"),
     ("log 1,2", f"log 1,2: {BY_RATIO}"), ("log", f"log: {BY_RATIO}"),
     ("log1:2/3", f"log1:2/3 is no range; {HOW}"),
     ("log 0:1/3", "log 0:1/3: both ends of a range by ratio must be above 0"),
     ("log 1:-1/3", "log 1:-1/3: both ends of a range by ratio must be above 0"),
     ("log 1:2/1", "log 1:2/1: at least 2 values are needed, got 1"),
     ("log 1:2/2000000", "log 1:2/2000000 has 2e+06 values; at most 1,000,000 are allowed"),
     ("log 1 mm:2 cm/3", "log 1 mm:2 cm/3: write one unit, at the end, such as 3:7:0.05 Hz"),
     ("nan", f"nan is no range; {HOW}")],
)  # fmt: skip
def test_what_is_wrong_with_a_range(text, message):
    with pytest.raises(RangeError) as caught:
        parse_range(text)
    assert str(caught.value) == message


@given(
    st.decimals(min_value=-1000, max_value=1000, places=3),
    st.decimals(min_value=-1000, max_value=1000, places=3),
    st.decimals(min_value="0.5", max_value=100, places=3),
)
def test_steps_are_exact_and_stay_inside(a, b, h):
    values = [value.value for value in parse_range(f"{a}:{b}:{h}")]
    low, high = min(a, b), max(a, b)
    assert values[0] == Fraction(a)
    assert all(Fraction(low) <= value <= Fraction(high) for value in values)
    assert {abs(y - x) for x, y in pairwise(values)} <= {Fraction(h)}
    assert abs(Fraction(b) - values[-1]) < Fraction(h)


@given(st.integers(-1000, 1000), st.integers(-1000, 1000), st.integers(2, 200))
def test_spaced_values_include_both_ends(a, b, n):
    values = [value.value for value in parse_range(f"{a}:{b}/{n}")]
    assert (len(values), values[0], values[-1]) == (n, a, b)


@given(st.integers(1, 10**6), st.integers(1, 10**6), st.integers(2, 60))
def test_values_by_ratio_are_powers_of_one_number(a, b, n):
    """The i-th to the power n - 1 is a^(n-1-i) b^i, within n - 1 times the half digit of its rounding."""
    values = [value.value for value in parse_range(f"log {a}:{b}/{n}")]
    assert (len(values), values[0], values[-1]) == (n, a, b)
    for i, value in enumerate(values):
        exact = Fraction(a) ** (n - 1 - i) * Fraction(b) ** i
        assert abs(value ** (n - 1) / exact - 1) <= (n - 1) * Fraction(501, 10**17)


def test_texts_of_a_range_go_into_a_case():
    case = load_case("II-B")
    for value in parse_range("3:4/4 Hz"):
        assert case.with_values({"Omega0": value.text}).quantity("Omega0").value == value.value
