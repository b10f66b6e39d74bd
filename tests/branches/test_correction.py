"""Points of branches are orbits to rounding, beside a graze too, and cost few motions."""

from collections import Counter

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.branches.made import KEYS, RESONANT, orbit_of
from vibsim.cases import load_case
from vibsim.orbits.branches.continuing import continue_branch
from vibsim.orbits.branches.correction import correct
from vibsim.orbits.branches.family import Family, FamilyPoint, ScenePath

ACROSS = np.array([0.6, 0.8])


class OnACircle:
    """x^2 + p^2 = 1; the derivative by p that is handed over is too large."""

    settled = True

    def __init__(self, z):
        self.z = z
        self.residual = np.array([z @ z - 1.0])

    @property
    def narrow_slope(self):
        return 2 * self.z[1:]

    def jacobian(self, slope=None):
        return np.array([[2 * self.z[0], self.narrow_slope[0] if slope is None else slope[0]]])

    def moved(self, step, slope=None):
        return self.z + step


@pytest.mark.parametrize("share", [1.0, 0.8, 0.3, 0.1, 1.2, 1.25])
def test_a_rough_derivative_by_the_parameter_moves_no_point(share):
    """With it the steps grow shorter by a factor only, which looks as if rounding had begun."""
    on_curve = np.array([0.8, 0.6])
    start = on_curve + 2e-8 * ACROSS + 1e-8 * np.array([0.8, -0.6])
    point = correct(OnACircle, start, ACROSS, 1.0, slope=share * 2 * on_curve[1:]).point
    assert abs(point.residual[0]) < 2e-13


# Points of branches are orbits to rounding, beside a graze too.


@pytest.mark.parametrize(
    ("case", "key", "span"),
    [
        ("gallery/impact-oscillator-coco", "drive.omega", "0.3:3 rad/s"),
        ("gallery/energy-sink", "drive.A", "0.2:5 N"),
    ],
)
def test_up_to_the_graze_of_a_rigid_stop(case, key, span):
    """Newton's method went to and fro across the graze, and left residuals of 3e-9 and 8e-9 behind."""
    branch = continue_branch(case, key, span)
    assert "grazing" in {one.kind for one in branch.specials}
    assert branch["residual"].max() < 1e-12


def test_beside_the_graze_of_an_elastic_stop():
    """Newton's method was ended where its steps grew no shorter, to and fro across the graze, and left 5e-8.
    Multipliers are up to 7,000: the residual of a point is by the largest one larger than its error.
    """
    branch = continue_branch("gallery/impact-damper", "drive.A", "0.2:1.185 N")
    assert {one.kind for one in branch.specials} >= {"grazing", "branch point", "fold", "neimark-sacker"}
    wrong = branch["residual"] / abs(branch["multipliers"]).max(axis=1).clip(1.0)
    assert branch["residual"].max() < 1e-9 and wrong.max() < 1e-11


# Scenes over a number of a case, against those of the case with that number.


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


# How much work a point of a branch takes: counted, not timed.


@pytest.mark.parametrize("span", ["6.2:8 Hz", "5:8 Hz"])
def test_a_point_over_the_frequency_takes_few_motions_and_scenes(span, monkeypatch):
    """Newton's method begins with a derivative by the parameter that the points before tell, and asks for one
    of its own a point, which is the tangent's too: 3.5 motions with their derivative, 1.1 quotients and 3.8
    scenes. They were 3.9, 2.3 and 5.2.
    """
    counts = Counter()

    def counted(of, name):
        plain = getattr(of, name)

        def call(*arguments):
            counts[name] += 1
            return plain(*arguments)

        monkeypatch.setattr(of, name, call)

    counted(FamilyPoint, "__init__")
    counted(FamilyPoint, "_one_sided")
    counted(Family, "_new_map")
    branch = continue_branch(orbit_of(RESONANT), KEYS["I"], span)
    assert len(branch) > 400
    assert counts["__init__"] < 3.8 * len(branch)
    assert counts["_one_sided"] < 1.3 * len(branch)
    assert counts["_new_map"] < 4.2 * len(branch)
