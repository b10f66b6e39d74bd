"""The C engine equals the Python engine in every bit on scenes made of parts, and both give the bits that the
paper's cases have ever had.
"""

from dataclasses import replace
from hashlib import sha256
from unittest.mock import patch

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.engine.random_parts import part_scenes, rigid_scenes
from tests.engine.runs import Run, differences, outcome, run
from tests.scenes import CASE_NAMES, MOTORS, paper
from vibsim.engine.tangent.tangencies import Jumps
from vibsim.engine.tangent.tangent_space import dimension


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


@pytest.mark.parametrize("name", CASE_NAMES)
@pytest.mark.parametrize("method", ("closed_form", "taylor"))
def test_engines_agree_on_the_papers_cases(name, method):
    method = "taylor" if name in MOTORS else method
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
