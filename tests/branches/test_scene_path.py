"""Scenes over a number of a case, against those of the case with that number."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vibsim.cases import load_case
from vibsim.orbits.branches.family import ScenePath

PATHS = [
    ("II-B", ("excitation.Omega0",), "Hz"),
    ("I-A-eq211", ("excitation.omega",), "Hz"),  # the amplitude follows by its rule
    ("I-A", ("blocks.m2",), "kg"),  # and with it friction
    ("II-B", ("friction.mu",), ""),
    ("gallery/ball-on-shaken-table", ("base.a",), "mm"),
    ("gallery/impact-oscillator", ("forces.drive.omega",), "rad/s"),
]


@pytest.mark.parametrize(("name", "keys", "unit"), PATHS)
@settings(max_examples=10)
@given(share=st.floats(1.0, 1.5))
def test_the_same_scene(name, keys, unit, share):
    case = load_case(name)
    value = float(case.quantity(keys[0]).text.split()[0]) * share
    changed = case.with_values(dict.fromkeys(keys, f"{value!r} {unit}".strip()))
    assert ScenePath(case, keys, unit).scene(value) == changed.scene()


def test_where_bodies_start_need_not_suit():
    """A ball at the height of a table that swings further."""
    path = ScenePath(load_case("gallery/ball-on-shaken-table"), ["base.a"], "mm")
    assert path.scene(3.0).base[0].amplitude == 3e-3


def test_bounds_hold():
    with pytest.raises(ValueError, match="must be >= 0, got -1 N s/m"):
        ScenePath(load_case("II-B"), ["coupling.c"], "N s/m").scene(-1.0)
