"""Closed form and Taylor series are two ways to one trajectory: same events, same times, same states."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import strategies as st

from tests.engine.random_parts import part_scenes
from tests.engine.runs import run
from tests.random_scenes import always, scenes
from vibsim.engine.flows.closed.matrices import jacobi
from vibsim.physics.numbers import Doubles
from vibsim.physics.two_blocks import TwoBlocks

# Both flows round each event and step to a few eps of the largest state; over the 40 rad of a run, with some
# ten events, an error grows as the difference of neighbours does, by 1e3 or so at most: 1e3 x 100 eps = 1e-11
CLOSE = 1e-10
SOON = 1e-14  # s; nearer than some roundings of times: twin stops and symmetric bodies meet in any order


def in_order(events):
    """Events as [(kind, part)], those that rounding alone puts in an order by kind and part."""
    instants, latest = [], None
    for t, *what in zip(*(events[name].tolist() for name in ("t", "kind", "part")), strict=True):
        if latest is None or t - latest > SOON:
            instants.append([])
        instants[-1].append(what)
        latest = t
    return [what for instant in instants for what in sorted(instant)]


def assert_flows_agree(scene):
    closed, taylor = run(replace(scene, method="closed_form")), run(replace(scene, method="taylor"))
    if closed.totals["uncertified"] or taylor.totals["uncertified"]:
        return  # a start at a gap or at rest, where rounding may decide
    assert in_order(closed.events) == in_order(taylor.events)
    for letter in "xv":
        names = [name for name in closed.samples if name.startswith(letter)]
        size = max(np.abs(closed.samples[name]).max(initial=0.0) for name in names)
        for name in names:
            apart = np.abs(closed.samples[name] - taylor.samples[name]).max(initial=0.0)
            assert apart <= CLOSE * size, name


test_flows_agree_on_random_scenes = always(
    assert_flows_agree,
    st.one_of(part_scenes(motor=False), scenes(sources=("none", "harmonic")).map(TwoBlocks.as_parts)),
    few=150,
    many=5000,
)


# Normal coordinates: what goes there and back is what it was.


@pytest.mark.parametrize("apart", [0.0, 1e-12, 1e-6, 1e-3, 0.3, -1e-6, -0.3])
@pytest.mark.parametrize("off", [0.5, -0.5, 1e-9])
def test_rotations_are_orthogonal_however_close_the_diagonal_is(apart, off):
    K = np.array([[1.0, off, 0.1], [off, 1.0 + apart, 0.0], [0.1, 0.0, 2.0]])
    V = np.array(jacobi(Doubles, K.tolist(), np.zeros((3, 3)).tolist()))
    # some 20 rotations, each orthogonal to a few roundings
    np.testing.assert_allclose(V.T @ V, np.eye(3), rtol=0, atol=1e-14)
    rotated = V.T @ K @ V
    np.testing.assert_allclose(rotated, np.diag(np.diag(rotated)), rtol=0, atol=1e-13)
