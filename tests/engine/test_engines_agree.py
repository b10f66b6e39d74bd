"""The C engine equals the Python engine in every bit on scenes made of parts, and both give the bits that the
paper's cases have ever had.
"""

from dataclasses import replace
from hashlib import sha256
from unittest.mock import patch

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.engine.random_parts import LENGTH, part_scenes, rigid_scenes
from tests.engine.runs import Run, differences, outcome, run
from tests.scenes import paper
from vibsim.engine.flows.closed.matrices import jacobi
from vibsim.engine.tangent.tangencies import Jumps
from vibsim.engine.tangent.tangent_space import dimension
from vibsim.physics.numbers import Doubles


def assert_engines_agree(scene, tangent=0, dither=0):
    options = {"ledger": True, "momentum": True, "section": True, "tangent": tangent, "dither": dither}
    fast, slow = outcome(scene, "c", **options), outcome(scene, "python", **options)
    if isinstance(slow, Run) and isinstance(fast, Run):
        assert differences(fast, slow) == []
    else:
        assert fast == slow
    return slow


# SHA-256 (its beginning) of samples and events over 20 s: the same on every machine
PINNED = {
    ("I-A", "closed_form"): "88ff0d711b8cc442",
    ("I-A", "taylor"): "c144d7f7725b31b2",
    ("I-B", "closed_form"): "5e56461727a958d5",
    ("I-B", "taylor"): "e80c2d20865766bd",
    ("I-C", "closed_form"): "0142ec79d41ddb46",
    ("I-C", "taylor"): "a54c1d4bc7145f0b",
    ("I-A-eq211", "closed_form"): "f758f1eb0db118f8",
    ("I-A-eq211", "taylor"): "6374514a3259d219",
    ("I-B-eq211", "closed_form"): "0413ea4165e0ff54",
    ("I-B-eq211", "taylor"): "bae710bed803f1f2",
    ("I-C-eq211", "closed_form"): "e64c6b664d38efef",
    ("I-C-eq211", "taylor"): "6a82af7030685af0",
    ("II-A", "taylor"): "9593cfd33793cd5d",
    ("II-B", "taylor"): "9f1864d6b82e9a3b",
    ("II-C", "taylor"): "0ed900c406f65ae9",
}


@pytest.mark.parametrize(("name", "method"), PINNED)
def test_papers_cases_are_bit_for_bit_what_they_were(name, method):
    result = run(paper(name, method=method, t_end=20.0).as_parts())
    digest = sha256()
    for table, besides in ((result.samples, ()), (result.events, ("part",))):
        for column, values in table.items():
            digest.update(b"" if column in besides else (values + 0).tobytes())
    assert digest.hexdigest()[:16] == PINNED[name, method]
    assert result.totals["impacts"] > 0 and result.totals["uncertified"] == 0


@pytest.mark.parametrize(("name", "method"), PINNED)
def test_engines_agree_on_the_papers_cases(name, method):
    scene = paper(name, method=method, t_end=4.0).as_parts()
    result = assert_engines_agree(scene, dimension(scene))
    assert result.totals["impacts"] > 2
    assert len(result.totals["growth"]) > 50 and result.totals["rank_losses"] > 0


@settings(max_examples=50)
@given(part_scenes(motor=False))
def test_random_scenes_by_the_flow_that_suits_each_mode(scene):
    assert_engines_agree(scene)


@settings(max_examples=50)
@given(part_scenes())
def test_random_scenes_by_taylor(scene):
    assert_engines_agree(replace(scene, method="taylor"))


@settings(max_examples=40)
@given(part_scenes(), st.integers(1, 10), st.sampled_from(("auto", "taylor")))
def test_random_scenes_with_disturbances(scene, count, method):
    assert_engines_agree(replace(scene, method=method), min(count, dimension(scene)))


@settings(max_examples=40)
@given(part_scenes())
def test_disturbances_that_python_takes_through_events(scene):
    """As where C knows no saltation: bit for bit what C does by itself."""
    with patch.object(Jumps, "in_c", lambda *_: False):
        assert_engines_agree(scene, dimension(scene))


@settings(max_examples=25)
@given(rigid_scenes(), st.integers(0, 2))
def test_random_scenes_with_rigid_stops(scene, dither):
    assert_engines_agree(scene, dither=dither)


@pytest.mark.slow
@pytest.mark.timeout(1800)
@settings(max_examples=5000)
@given(part_scenes())
def test_many_random_scenes(scene):
    assert_engines_agree(scene, dimension(scene))


# Closed form and Taylor series give the same motion: two ways from the same equations of motion.


CLOSE = 1e-10 * LENGTH  # rounding of some hundred steps of 1e-16 each, grown by a few impacts
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
    closed, taylor = run(scene), run(replace(scene, method="taylor"))
    if closed.totals["uncertified"] or taylor.totals["uncertified"]:
        return  # a start at a gap or at rest, where rounding may decide
    assert in_order(closed.events) == in_order(taylor.events)
    for name in (column for column in closed.samples if column.startswith("x_")):
        assert np.abs(closed.samples[name] - taylor.samples[name]).max() < CLOSE


@settings(max_examples=50)
@given(part_scenes(motor=False))
def test_flows_agree_on_random_scenes(scene):
    assert_flows_agree(scene)


@pytest.mark.slow
@pytest.mark.timeout(1800)
@settings(max_examples=5000)
@given(part_scenes(motor=False))
def test_flows_agree_on_many_random_scenes(scene):
    assert_flows_agree(scene)


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
