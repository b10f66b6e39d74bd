"""Which events the doubts of a certificate are about, and why: a scene for each reason."""

import random

import pytest

import vibsim
from tests.command_line.test_run import TOUCHING
from tests.engine.runs import run, scene_of
from tests.engine.test_chatter_ends import walls
from tests.engine.test_many_ties import rubbing_bodies
from tests.engine.test_release import closing
from tests.events.special_scenes import at_once, chain
from tests.events.test_balanced_starts import RELIEVED, along_with_the_base, balanced, two_beside
from tests.events.test_chains_at_rest import TORN_SOFTLY
from tests.events.test_order_of_events import ALIKE, AS_THE_BASE_BEGINS_TO_MOVE, METHODS, TWO_AT_ONCE
from tests.scenes import scene
from vibsim.engine import c_engine, doubts
from vibsim.engine.doubts import REASONS_OF_C
from vibsim.engine.errors import EngineError
from vibsim.engine.trajectory import open_trajectory

MOST = 8  # that are described
_, ORDER, TOUCH, SHORT_STEPS, SIDE, AT_ZERO = REASONS_OF_C


def told(scene, **options):
    """[(events, reason)] of the doubts of a run, and their times [s]; a run that fails has those before."""
    trajectory = open_trajectory(scene, **options)
    try:
        for _ in trajectory.blocks():
            pass
    except EngineError:
        pass
    found = trajectory.doubts
    assert len(found) == min(trajectory.totals["uncertified"], MOST)
    return [(doubt.events, doubt.reason) for doubt in found], [doubt.time for doubt in found]


# Doubts of the search for zeros.


@pytest.mark.parametrize("method", METHODS)
def test_two_events_in_one_instant(method):
    told_of, times = told(scene(**TWO_AT_ONCE, method=method).as_parts())
    assert {*told_of[0][0]} == {"contact at stop", "release at friction"}
    assert told_of[0][1] == ORDER
    assert times == pytest.approx([1.9262579850909] * len(times), abs=1e-12)
    between = [(("contact at stop",), SIDE)]  # behind the release
    assert told_of[1:] == (between if method == "closed_form" else [])


def test_the_places_are_called_by_the_names_of_the_case():
    """Which friction sticks first decides whether the other does, as it holds more than it slips with."""
    told_of, _ = told(scene_of(ALIKE, method="taylor"))
    assert told_of == [(("end of sliding at friction fa", "end of sliding at friction fb"), ORDER)] * 4


def test_a_switch_is_called_by_its_formula():
    told_of, times = told(scene_of(AS_THE_BASE_BEGINS_TO_MOVE))
    assert told_of[0] == (("impact at stop wall", "switch in the formula of base"), ORDER)
    assert times[0] == 1.0


@pytest.mark.parametrize("method", METHODS)
def test_a_touch(method):
    """Half a swing of the spring behind the release, and again a swing later."""
    told_of, times = told(scene_of(TOUCHING, method=method))
    assert told_of == [(("contact at stop",), TOUCH)] * len(told_of)
    assert times[0] == pytest.approx(0.31415927, abs=1e-7) and times[-1] == pytest.approx(
        1.57079633, abs=1e-7
    )


@pytest.mark.parametrize(
    ("seed", "told_first"),
    [(71, (("impact at stop s0",), SHORT_STEPS)), (79, (("release at stop s0",), AT_ZERO))],
)
def test_functions_that_stay_at_zero(seed, told_first):
    told_of, _ = told(chain(random.Random(seed)))
    assert told_first in told_of


# Doubts of the automaton.


def beside_the_base():
    """The base begins 20 mm sin 30 deg from zero, but for rounding."""
    return scene_of("""
bodies: {a: 1 kg}
base: {a: 20 mm, omega: 7 rad/s, phase: 30 deg}
stops: {wall: {between: [a, base], gap: 0 m, acts: compression, k: 30 N/m}}
initial: {a: {x: 0.010000000000000002 m}}
run: {t_end: 0.05 s, every: 10 ms}
""")


def pushed_and_pulled():
    """30 N/m times 0.1 m against 0.7 N s/m times 30/7 m/s: deep in a stop whose force is zero."""
    return scene_of("""
bodies: {a: 1 kg}
stops:
  wall: {between: [a, ground], gap: 0.2 m, acts: compression, k: 30 N/m, c: 0.7 N s/m, release: force}
initial: {a: {x: 0.3 m, v: -4.285714285714286 m/s}}
run: {t_end: 0.05 s, every: 10 ms}
""")


def chosen_at_rest():
    """Where a comes before 20 mm the choice is by c, which rests where it turns."""
    return scene_of("""
bodies: {a: 1 kg, c: 1 kg}
links: {s: {between: [a, ground], k: 100 N/m}}
forces: {f: {on: a, force: "A*step(where(x_a < d, x_c - rest, -x_a))", A: 2 N, d: 20 mm, rest: 1 mm}}
initial: {a: {v: 1 m/s}, c: {x: 1 mm}}
run: {t_end: 0.5 s, every: 10 ms}
""")


AUTOMATON = {
    doubts.LEAVES: (lambda: balanced("auto").as_parts(), ("contact at stop",)),
    doubts.CROSSES: (lambda: TORN_SOFTLY, ("release at stop touch",)),
    doubts.LOADED: (lambda: scene_of(RELIEVED), ("release at stop floor",)),
    doubts.SIGN: (pushed_and_pulled, ("zero force at stop wall",)),
    doubts.HOLDS: (
        lambda: scene_of(rubbing_bodies(8), t_end=0.4),
        ("friction f0_1", "friction f0_2", "friction f0_3", "26 more"),
    ),
    doubts.SLOW: (lambda: along_with_the_base(2.0**-52), ("friction f",)),
    doubts.ORDER: (lambda: walls((0.8, 0.3), 2.0**-54), ("impact at stop wall0", "impact at stop wall1")),
    doubts.ENDLESS: (lambda: at_once(random.Random(60)), ("impact at stop s0", "impact at stop s1")),
    doubts.TOUCHED: (lambda: closing(1, 0.125), ("contact at stop ab", "limit of clearance limit")),
    doubts.START: (beside_the_base, ("contact at stop wall",)),
    doubts.SIDE: (chosen_at_rest, ("switch in the formula of f",)),
    doubts.START_AT_REST: (lambda: two_beside(1.000000000000001, 1.0), ("stop",)),
}


@pytest.mark.parametrize("reason", AUTOMATON)
def test_decisions_that_rounding_could_turn(reason):
    make, events = AUTOMATON[reason]
    told_of, _ = told(make())
    assert (events, reason) in told_of


# What becomes of them.


def test_they_are_described_for_modes_that_c_has_forgotten(monkeypatch):
    scene = scene_of(ALIKE, method="taylor")
    expected = told(scene)
    monkeypatch.setattr(c_engine, "MOST_BYTES", 0)
    assert told(scene) == expected


def test_a_run_that_begins_anew_forgets_them():
    scene = scene_of(TOUCHING)
    trajectory = open_trajectory(scene)
    for _ in range(2):
        for _ in trajectory.blocks():
            pass
        once = trajectory.doubts
        assert once
        trajectory.restart(scene)
        assert trajectory.doubts == []


def test_a_run_of_many_digits_has_them():
    result = vibsim.simulate(TOUCHING, {"run.t_end": "0.5 s"}, digits=20)
    assert result.attrs["uncertified"] == len(result.doubts) > 0
    for time, events, reason in result.doubts:
        assert (events, reason) == (("contact at stop",), TOUCH)
        assert time == pytest.approx(0.31415927, abs=1e-7)


def test_a_run_in_no_doubt_has_none():
    scene = scene_of(TOUCHING, {"G": "2 cm"})
    assert run(scene).totals["uncertified"] == 0
    assert told(scene) == ([], [])
