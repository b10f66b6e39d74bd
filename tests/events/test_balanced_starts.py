"""Motions that begin in balance: certified only where no rounding decides which way they leave a limit."""

import random

import pytest

from tests.events.coincidences import two_blocks
from tests.events.test_certificate import assert_none_missed
from tests.scenes import harmonic, scene
from tests.trajectories import ENGINES, run
from vibsim.engine.errors import EngineError


def balanced(method, F0=-1.0, x1=-0.01, **changes):
    """Block 1 at rest on its stop, 100 N/m times 0.01 m against 1 N: 0 in doubles, 2e-17 N by 40 digits."""
    blocks = {"m1": 1.0, "m2": None, "k1": 100.0, "c": 0.0, "k2": 400.0, "G": abs(x1), "N": None}
    start = {"x1": x1, "x2": None, "v2": None, "t_end": 4.0, "every_den": 50}
    return scene(harmonic(1.0, 0.0, F0), **{**blocks, **start, "method": method, **changes})


METHODS = ("closed_form", "taylor")
everywhere = pytest.mark.parametrize(("engine", "method"), [(e, m) for e in ENGINES for m in METHODS])


@everywhere
def test_a_start_on_the_stop_that_only_rounding_balances_is_in_doubt(engine, method):
    """The exact motion swings by 2e-19 m and touches the stop once a period; doubles do not move."""
    assert run(balanced(method), engine).totals["uncertified"] > 0


@everywhere
def test_a_departure_by_a_later_derivative_than_rounding_hides_is_in_doubt(engine, method):
    """The force begins to grow as well; exactly, the block leaves the stop and meets it 1.2e-17 s later."""
    assert run(balanced(method, A=-1.0), engine).totals["uncertified"] > 0


@everywhere
def test_blocks_that_move_on_together_in_rounded_balance_are_in_doubt(engine, method):
    """Spring, friction and force leave no acceleration of either block but for 2e-17 N."""
    both = {"m1": 0.5, "m2": 1.0, "N": 1.0, "v1": -0.1, "v2": -0.1, "x2": 0.0, "k2": 3000.0, "t_end": 1.2}
    assert run(balanced(method, **both), engine).totals["uncertified"] > 0


@everywhere
@pytest.mark.parametrize(
    ("x1", "F0", "A"), [(0.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, 1.0, -1.0), (-0.01, 0.0, 0.0)]
)
def test_a_plain_start_on_the_stop_is_certified(engine, method, x1, F0, A):
    """A slack spring and a force that begins at zero leave nothing to round; else the forces are plain."""
    result = run(balanced(method, F0, x1, A=A, t_end=0.2), engine)
    assert result.totals["uncertified"] == 0


def judge(make, seeds):
    """Hold scenes to the exact flow; those that double precision cannot go on with say so."""
    for seed in seeds:
        try:
            assert_none_missed(make(random.Random(seed)))
        except EngineError as error:
            assert error.reason == "crowded", (seed, error)


def test_coincidences_of_two_blocks():
    judge(two_blocks, range(100, 160))


@pytest.mark.slow
@pytest.mark.timeout(3600)
def test_many_coincidences_of_two_blocks():
    judge(two_blocks, range(4000))
