import numpy as np
import pytest

from vibsim.plots.sheet import amount, rounded, scale_for, seconds, symbol


@pytest.mark.parametrize(
    ("largest", "unit", "label"),
    [
        (0.0868, "m", "mm"),
        (0.352, "m", "mm"),
        (1.0, "m", "m"),
        (0.001, "m", "mm"),
        (0.000999, "m", "µm"),
        (5.0, "m", "m"),
        (12e3, "N", "kN"),
        (0.112, "m/s", "mm/s"),
        (2.2, "m/s", "m/s"),
        (0.005, "N m", "mN m"),
        (0.0, "m", "m"),
        (3e-13, "m", "fm"),
        (3e-22, "m", "am"),
    ],
)
def test_prefix_puts_the_largest_magnitude_between_1_and_1000(largest, unit, label):
    scale = scale_for(unit, [0.0, -largest], np.empty(0))
    assert scale.unit == label
    assert 1 <= scale(largest) < 1000 or largest in (0.0, 3e-22)


def test_label_carries_the_unit():
    assert scale_for("m", [0.02]).label("Displacement") == "Displacement (mm)"


def test_nan_is_no_magnitude():
    assert scale_for("m", [np.nan, 0.02], [np.nan]).unit == "mm"


def test_seconds():
    assert seconds((290.0, 300.0)) == "290–300 s"


def test_rounded_decimals_tell_values_apart():
    assert rounded([0.001, 53 / 3500, 0.1]) == ["0.001", "0.0151", "0.1"]
    assert rounded([1.00001, 1.00002]) == ["1.00001", "1.00002"]
    assert rounded([2.5, 2.5]) == ["2.5", "2.5"]
    assert rounded([12345.6]) == ["12300"]
    assert rounded([]) == []


def test_amounts():
    assert amount(12600, "N/m") == "12.6 kN/m"
    assert amount(1.00022e6, "N/m") == "1 MN/m"
    assert amount(200, "N/m") == "200 N/m"
    assert scale_for("m", [3e7]).unit == "km"


def test_symbols():
    assert symbol("x1") == "$x_{1}$"
    assert symbol("v_drill") == r"$v_\mathrm{drill}$"
