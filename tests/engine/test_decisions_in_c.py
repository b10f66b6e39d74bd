"""Events of scenes with dry friction that C takes by itself: few are left to Python."""

import pytest

import vibsim.engine.c_engine as c_engine
from tests.engine.random_parts import RATE
from tests.engine.runs import run
from tests.engine.test_closed_cases import harmonic, scene
from vibsim import load_case
from vibsim.physics.parts import (
    AT_GAP,
    BASE,
    COMPRESSION,
    GROUND,
    Body,
    Clearance,
    Force,
    Friction,
    Link,
    Scene,
    Stop,
)


@pytest.fixture
def asked(monkeypatch):
    """How many decisions C has left to Python."""
    events, decide = [], c_engine.CRun._decide

    def counting(self, number, event, *more):
        events.append(self.rows_of(number).events[event])
        return decide(self, number, event, *more)

    monkeypatch.setattr(c_engine.CRun, "_decide", counting)
    return lambda: len(events)


@pytest.mark.parametrize(
    "name, t_end, most",
    [
        ("gallery/friction-oscillator", "50 s", 0),  # a driven body that stands each time it turns round
        ("gallery/drifting-capsule", "1 s", 0),  # two driven bodies, one of which sticks
        ("hard/spool-between-stops", "20 ms", 2),  # impacts, and standing between them
        ("gallery/pile-driver", "6 s", 2),  # impacts that tear a pile loose
        ("gallery/stack-of-blocks", "2 s", 0),  # two of three frictions at their limits as one turns round
        ("gallery/energy-harvester", "0.3 s", 0),  # damped stops that let go, and are left later
        ("gallery/coupled-clutches", "1.5 s", 2),  # ties that drop beside others; two loads jump
    ],
)
def test_cases(asked, name, t_end, most):
    of = load_case(name, {"run.t_end": t_end}).scene()
    fast = run(of, ledger=True, momentum=True)
    assert len(fast.events["t"]) > 8 and asked() <= most


def test_the_drifting_oscillator(asked):
    """1023 impacts and 40 ends of their sequences in 20 s: Python is asked at these and what follows them."""
    run(load_case("gallery/drifting-oscillator").scene())
    assert asked() < 110


def test_a_body_that_stands_on_what_moves(asked):
    """A block on a shaken table, held by a damped spring, and one that a spring ties to the table."""
    of = scene(
        [Body("block", 1.0, 0.0, 0.0), Body("held", 0.5, 0.0, 0.0)],
        links=(Link("spring", 0, GROUND, 10.0, 0.1), Link("own", 1, BASE, 20.0, 0.1)),
        frictions=(Friction("table", 0, BASE, 1.5, 1.5, 0.0), Friction("floor", 1, GROUND, 0.6, 0.6, 0.0)),
        base=(harmonic(0.05, 1.1),),
    )
    fast = run(of, ledger=True)
    assert fast.totals["sticks"] > 10 and asked() <= 2


def test_ties_that_bear_a_damped_stop(asked):
    """A hammer strikes a damped stop on a block that friction holds: the force jumps, the block stays."""
    of = scene(
        [Body("hammer", 1.0, 0.0, 0.0), Body("block", 2.0, 0.0, 0.0)],
        stops=(Stop("anvil", 0, 1, 0.01, COMPRESSION, 500 * RATE**2, 2.0, AT_GAP),),
        links=(Link("spring", 0, GROUND, RATE**2, 0.0),),
        frictions=(Friction("floor", 1, GROUND, 400.0, 400.0, 0.0),),
        forces=(Force("drive", 0, 0.0, (harmonic(1.0, 1.3),)),),
    )
    fast = run(of, ledger=True)
    assert fast.totals["impacts"] > 10 and asked() <= 1


def test_a_clearance_against_a_base_that_runs_away_is_violated():
    """The body follows the base, which is faster: the velocity of the body alone says that they near."""
    of = Scene(
        (Body("a", 1.0, 0.0, -0.1),),
        base=(harmonic(-0.1, 10.0),),
        clearances=(Clearance("reach", 0, BASE, 0.03),),
        t_end=0.5,
    )
    assert run(of).totals["violations"] > 0
