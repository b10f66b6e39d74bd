"""Events that C takes by itself: few are left to Python; and energy over many impacts."""

import numpy as np
import pytest

import vibsim.engine.c_engine as c_engine
from tests.engine.impacts import GRAVITY, METHODS, ball
from tests.engine.runs import run, scene_of
from vibsim import load_case
from vibsim.engine.modes.mode_table import ModeTable
from vibsim.engine.modes.rows import STRIKE


@pytest.fixture
def asked(monkeypatch):
    """How many decisions C has left to Python: of all kinds, or of one."""
    kinds, decide = [], c_engine.CRun._decide

    def counting(self, number, event, *more):
        kinds.append(self.rows_of(number).events[event].kind)
        return decide(self, number, event, *more)

    monkeypatch.setattr(c_engine.CRun, "_decide", counting)
    return lambda kind=None: len(kinds) if kind is None else kinds.count(kind)


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
        ("gallery/hertz-chain", "20 s", 0),  # contacts that a force growing from zero begins
    ],
)
def test_cases(asked, name, t_end, most):
    of = load_case(name, {"run.t_end": t_end}).scene()
    fast = run(of, ledger=True, momentum=True)
    assert len(fast.events["t"]) >= 8 and asked() <= most


def test_a_body_that_stands_on_what_moves(asked):
    """A block on a shaken table, held by a damped spring, and one that a spring ties to the table."""
    of = scene_of("""
bodies: {block: 1 kg, held: 0.5 kg}
links:
  spring: {between: [block, ground], k: 10 N/m, c: 0.1 N s/m}
  own: {between: [held, base], k: 20 N/m, c: 0.1 N s/m}
friction:
  table: {between: [block, base], N: 1.5 N, mu: 1}
  floor: {between: [held, ground], N: 0.6 N, mu: 1}
base: {a: 5 cm, omega: 1.1 Hz}
run: {t_end: 10 s, every: 50 ms}
""")
    assert run(of, ledger=True).totals["sticks"] > 10 and asked() <= 2


def test_ties_that_bear_a_damped_stop(asked):
    """A hammer strikes a damped stop on a block that friction holds: the force jumps, the block stays."""
    of = scene_of("""
bodies: {hammer: 1 kg, block: 2 kg}
stops: {anvil: {between: [hammer, block], gap: 1 cm, acts: compression, k: 19.7 kN/m, c: 2 N s/m}}
links: {spring: {between: [hammer, ground], k: 39.5 N/m}}
friction: {floor: {between: [block, ground], N: 400 N, mu: 1}}
forces: {drive: {on: hammer, A: 1 N, omega: 1.3 Hz}}
run: {t_end: 10 s, every: 50 ms}
""")
    assert run(of, ledger=True).totals["impacts"] > 10 and asked() <= 1


def test_a_clearance_against_a_base_that_runs_away_is_violated():
    """The body follows the base, which is faster: the velocity of the body alone says that they near."""
    of = scene_of("""
bodies: {a: 1 kg}
base: {a: -0.1 m, omega: 10 Hz}
clearances: {reach: {between: [a, base], distance: 3 cm}}
initial: {a: {v: -0.1 m/s}}
run: {t_end: 0.5 s, every: 5 ms}
""")
    assert run(of).totals["violations"] > 0


# Impacts on rigid stops.


@pytest.mark.parametrize("count", (20_000, pytest.param(1_000_000, marks=pytest.mark.slow)))
def test_a_ball_keeps_its_energy(asked, count):
    """Speeds stay within two units in the last place of sqrt(2 g h); Python is not asked once."""
    h = 0.05
    of = ball(1.0, h, t_end=(count + 0.1) * 2 * np.sqrt(2 * h / GRAVITY)).without_samples()
    found = run(of, ledger=True)
    assert found.totals["impacts"] == pytest.approx(count, abs=1)
    speeds = np.abs(found.events["before_v_ball"][1:-1])
    assert np.ptp(speeds) <= 2 * np.spacing(speeds[0]) and found.totals["loss_stops"] == 0
    assert speeds[0] == pytest.approx(np.sqrt(2 * GRAVITY * h), rel=1e-15)
    assert asked() == 0


@pytest.mark.parametrize("method", METHODS)
def test_chatter_is_pythons_at_its_end_alone(asked, method):
    """e = 0.8: 140 impacts from 1 s down to the resolution of time."""
    fast = run(ball(0.8, 0.05, method=method, t_end=2.0), ledger=True, momentum=True)
    assert fast.totals["impacts"] > 100 and fast.totals["chatters"] + fast.totals["rests"] >= 1
    assert asked(STRIKE) < fast.totals["impacts"] / 8


BOX = """
bodies: {a: 1 kg, b: 0.4 kg}
links: {l: {between: [a, base], k: 30 N/m, c: 0.2 N s/m}}
stops:
  between: {between: [a, b], gap: 2 mm, acts: compression, law: rigid, e: 0.7}
  left: {between: [a, base], gap: 2 cm, acts: extension, law: rigid, e: 0.9}
  right: {between: [b, base], gap: 3 cm, acts: compression, law: rigid, e: 1}
  far: {between: [b, ground], gap: 0.2 m, acts: compression, law: rigid, e: 0.5}
base: {a: 1 cm, omega: 1.7 Hz, phase: 0.3 rad}
initial: {a: {v: 0.2 m/s}, b: {x: 1 cm, v: -0.1 m/s}}
run: {t_end: 8 s, every: 50 ms}
"""


@pytest.mark.parametrize("method", METHODS)
def test_bodies_and_a_shaken_box(asked, method):
    """Impacts of two bodies on each other and on walls that move, with works, losses and impulses."""
    fast = run(scene_of(BOX, method=method), ledger=True, momentum=True)
    assert fast.totals["impacts"] > 20
    assert asked(STRIKE) <= 2


@pytest.mark.parametrize("method", METHODS)
def test_impacts_that_let_slip(asked, method):
    """Impacts that make a slider slip, and those on it while it slips: Python is asked where hops end."""
    of = load_case("gallery/drifting-oscillator", {"run.t_end": "4 s", "run.method": method}).scene()
    fast = run(of, ledger=True, momentum=True)
    impacts, ends = fast.totals["impacts"], fast.totals["chatters"]
    assert impacts > 150 and 4 <= ends < 10
    assert asked(STRIKE) <= 2 * ends + 2  # some hops before the last it is not clear whether they are
    assert asked() == asked(STRIKE)  # rests end in C, also where what bears them comes to rest


def test_ties_that_let_go_as_another_one_sticks(asked, monkeypatch):
    """Two blocks on a floor, the upper one driven: it sticks on the lower one, which tears loose there. What
    C takes has the bits of what Python decides.
    """
    of = scene_of("""
bodies: {below: 2 kg, above: 1 kg}
links: {spring: {between: [below, ground], k: 300 N/m}}
friction:
  floor: {between: [below, ground], N: 2 N, mu: 1}
  between: {between: [above, below], N: 8 N, mu: 1}
forces: {drive: {on: above, A: 9 N, omega: 0.7 Hz}}
run: {t_end: 30 s, every: 50 ms}
""")
    fast = run(of, ledger=True)
    pairs = list(zip(fast.kinds, fast.kinds[1:], fast.times, fast.times[1:], strict=False))
    assert sum(pair[:2] == ("stick_end", "stick_begin") and pair[2] == pair[3] for pair in pairs) > 30
    assert asked() <= 1
    monkeypatch.setattr(ModeTable, "rule", lambda *_: None)
    decided = run(of, ledger=True)
    assert asked() > 150
    assert all(np.array_equal(fast.events[name], decided.events[name]) for name in fast.events)
    assert fast.totals == decided.totals


def test_impacts_that_turn_frictions_round(asked):
    """Two blocks on a belt, a rail and each other between two walls, one of which moves."""
    of = scene_of("""
bodies: {a: 1 kg, b: 0.4 kg}
stops:
  between: {between: [a, b], gap: 3 cm, acts: compression, law: rigid, e: 0.9}
  left: {between: [ground, a], gap: 5 cm, acts: compression, law: rigid, e: 1}
  right: {between: [b, base], gap: 6 cm, acts: compression, law: rigid, e: 1}
friction:
  belt: {between: [a, ground], N: 1 N, plus: {mu: 0.3}, minus: {mu: 0.2}, belt: 0.15 m/s}
  rail: {between: [b, base], N: 1 N, plus: {mu: 0.05}, minus: {mu: 0.1}}
  rub: {between: [a, b], N: 0.1 N, mu: 1}
forces: {drive: {on: a, A: 3 N, omega: 1.1 Hz}}
base: {a: 2 cm, omega: 1.7 Hz, phase: 0.3 rad}
initial: {a: {v: 0.5 m/s}, b: {x: 1 cm, v: -0.3 m/s}}
run: {t_end: 8 s, every: 50 ms}
""")
    fast = run(of, ledger=True, momentum=True)
    assert fast.totals["impacts"] > 40 and fast.totals["reversals"] > 20
    assert asked(STRIKE) < fast.totals["impacts"] / 5


def test_a_rotor_is_struck_with_its_body(asked):
    """A motor of limited power on a body between two walls: each impact changes the speed of its rotor."""
    of = scene_of("""
bodies: {body: 1 kg}
stops:
  left: {between: [ground, body], gap: 4 mm, acts: compression, law: rigid, e: 0.8}
  right: {between: [body, ground], gap: 6 mm, acts: compression, law: rigid, e: 0.8}
friction: {rail: {between: [body, ground], N: 0.2 N, mu: 1}}
motor: {on: body, m3: 0.2 kg, e: 3 cm, J: 1e-4 kg m^2, M0: 0.05 N m, Omega0: 60 rad/s}
run: {t_end: 3 s, every: 50 ms}
""")
    fast = run(of, ledger=True, momentum=True)
    assert fast.totals["impacts"] > 40
    assert asked(STRIKE) < fast.totals["impacts"] / 5
    assert fast.totals["energy_residual"] == pytest.approx(0, abs=1e-12)


def test_what_sticks_on_the_base_is_struck_with_its_velocity():
    """A body rides on a shaken base, another hops on it; rounding of the stretch is no approach."""
    of = scene_of("""
bodies: {rider: 1 kg, carriage: 1.0023052380778996 kg}
stops: {buffer: {between: [carriage, rider], gap: 0 m, acts: extension, law: rigid, e: 0.3}}
friction: {bed: {between: [base, carriage], N: 0.39478417604357435 N, mu: 1}}
base: {terms: [{a: -3.53 mm, omega: 1 Hz}, {a: 2.63 mm, omega: 8.45629000211985 rad/s}]}
run: {t_end: 80 ms, every: 25 ms}
""")
    assert run(of, ledger=True, momentum=True).totals["impacts"] > 10
