"""Natural rates, sets of bodies, pairs and periods of scenes, against closed forms and by hand."""

from itertools import pairwise
from math import inf, pi, sin, sqrt

import numpy as np
import pytest

from vibsim.cases.case import load_case_text
from vibsim.physics.connections import body_sets, drifting_sets, pairs_of
from vibsim.physics.rates import (
    all_rates,
    bilinear_frequencies,
    common_period,
    is_driven,
    natural_rates,
    reduced_mass,
    source_period,
)


def scene(*lines):
    return load_case_text("\n".join(lines)).scene()


def chain(count, held):
    """Equal bodies 1 kg in a row, springs 100 N/m between them, the first one held at the ground or not."""
    names = [f"b{i}" for i in range(count)]
    ends = [("ground", names[0])] * held + list(pairwise(names))
    links = [f"s{i}: {{between: [{P}, {Q}], k: 100 N/m}}" for i, (P, Q) in enumerate(ends)]
    return scene(
        f"bodies: {{{', '.join(f'{name}: 1 kg' for name in names)}}}", f"links: {{{', '.join(links)}}}"
    )


@pytest.mark.parametrize("count", [1, 2, 3, 7])
def test_a_chain_held_at_one_end(count):
    """w_j = 2 sqrt(k/m) sin((2 j - 1) pi / (4 n + 2))."""
    exact = [20 * sin((2 * j - 1) * pi / (4 * count + 2)) for j in range(1, count + 1)]
    np.testing.assert_allclose(natural_rates(chain(count, True)), exact, rtol=1e-12)


@pytest.mark.parametrize("count", [2, 3, 7])
def test_a_free_chain_has_one_rigid_motion(count):
    """w_j = 2 sqrt(k/m) sin(j pi / (2 n))."""
    exact = [20 * sin(j * pi / (2 * count)) for j in range(count)]
    np.testing.assert_allclose(all_rates(chain(count, False)), exact, rtol=1e-12, atol=0)


def test_a_pair_of_bodies_is_a_closed_form():
    """To the last bit, with several springs between the same ends; beside it a body alone."""
    found = scene(
        "bodies: {a: 2 kg, alone: 1 kg, b: 3 kg}",
        "links: {s: {between: [a, b], k: 70 N/m}, u: {between: [b, a], k: 30 N/m}}",
        "stops: {hit: {between: [a, b], gap: 1 mm, acts: compression, k: 900 N/m}}",
    )
    assert reduced_mass(found, 0, 2) == 1 / (1 / 2 + 1 / 3)
    assert all_rates(found) == [0.0, 0.0, sqrt(100 / (1 / (1 / 2 + 1 / 3)))]
    f1, f2 = (sqrt(k / 1.2) / (2 * pi) for k in (100, 1000))
    assert bilinear_frequencies(found) == [pytest.approx(2 * f1 * f2 / (f1 + f2), rel=1e-14)]


PARTS = (
    "bodies: {a: 1 kg, b: 1 kg, c: 1 kg, d: 1 kg}",
    "links: {s: {between: [a, b], k: 70 N/m}, damper: {between: [b, ground], c: 1 N s/m}}",
    "stops: {near: {between: [c, a], gap: 1 mm, acts: compression, k: 900 N/m},"
    " far: {between: [a, c], gap: 1 mm, acts: compression, k: 900 N/m}}",
    "friction: {rub: {between: [d, b], N: 1 N, mu: 0.1}}",
)


def test_what_drifts_and_what_moves_against_what():
    """A damper holds nothing; stops on both sides carry along; friction joins nothing."""
    found = scene(*PARTS)
    assert [one.bodies for one in drifting_sets(found)] == [(0, 1, 2), (3,)]
    assert [(pair.name, pair.P, pair.Q) for pair in pairs_of(found)] == [
        ("s", 0, 1),
        ("damper", 1, -1),
        ("near", 2, 0),
        ("rub", 3, 1),
    ]
    assert [(one.bodies, one.held) for one in body_sets(found, found.links)] == [
        ((0, 1), True),
        ((2,), False),
        ((3,), False),
    ]
    one_sided = scene(*PARTS[:2], PARTS[2].replace("[a, c]", "[c, a]"), PARTS[3])
    assert [one.bodies for one in drifting_sets(one_sided)] == [(0, 1), (2,), (3,)]


def drive(*terms):
    listed = ", ".join(f"f{i}: {{on: a, A: {A} N, omega: {omega}}}" for i, (A, omega) in enumerate(terms))
    return scene("bodies: {a: 1 kg}", f"forces: {{{listed}}}")


def test_periods_of_sources():
    assert source_period(drive((1, "2 Hz"), (1, "3 Hz"))) == pytest.approx(1.0, rel=1e-15)
    assert source_period(drive((1, "2 Hz"), (1, "13 rad/s"))) == pytest.approx(0.5, rel=1e-15)
    assert source_period(scene("bodies: {a: 1 kg}")) == inf
    assert not is_driven(scene("bodies: {a: 1 kg}"))
    assert source_period(chain(1, True)) == pytest.approx(2 * pi / 10)


def test_forces_of_no_strength_have_a_clock():
    """Only where there are no others: the first point of a sweep over an amplitude from 0 N on."""
    assert common_period(drive((0, "2 Hz"))).cycles == 2
    assert common_period(drive((0, "2 Hz"), (1, "3 Hz"))).turns == 1
