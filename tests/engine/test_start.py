"""What rests at the start goes on under the forces that there are behind it, those of stops included."""

import random
from dataclasses import replace
from math import pi, sin

import pytest
from hypothesis import given, settings

from tests.engine.many_digits import exact_parts, truth
from tests.engine.random_parts import part_scenes
from tests.engine.runs import whole
from tests.engine.test_closed_cases import scene
from tests.events.special_scenes import machine
from vibsim.cases import load_case
from vibsim.engine.errors import EngineError, start_of
from vibsim.engine.events.automaton import Automaton, UnambiguousStart
from vibsim.engine.flows.expansion import Expansion
from vibsim.engine.modes.mode_table import ModeTable
from vibsim.engine.trajectory import open_trajectory
from vibsim.physics.numbers import Doubles
from vibsim.physics.parts import (
    BASE,
    COMPRESSION,
    GROUND,
    Body,
    Force,
    Friction,
    Harmonic,
    RigidStop,
    Scene,
    Stop,
)

LIMIT = 0.5  # of the friction between the bodies [N]


def two_bodies(stop, **parts):
    """Two bodies of 1 kg that rub on each other, the first before a stop."""
    rub = Friction("rub", 1, 0, LIMIT, LIMIT, 0.0)
    speeds = parts.pop("v", 0.0)
    bodies = (Body("a", 1.0, 0.0, speeds), Body("b", 1.0, 0.0, speeds))
    return Scene(bodies, stops=(stop,), frictions=(rub,), every_num=1, every_den=1000, **parts)


def test_a_stop_whose_damper_would_pull_moves_nothing():
    """Deep at the start, the base draws back: without a force both bodies stay, stuck to each other."""
    stop = Stop("s", BASE, 0, -0.002, 1, 1000.0, 100.0, "force")
    base = (Harmonic(0.005, 9.0, 9.0 / 6.283185307179586, 0.0, 0.0),)
    run = open_trajectory(two_bodies(stop, base=base, t_end=0.03), ledger=True)
    samples = [block.samples for block in run.blocks() if len(block.samples["time"])][-1]
    assert samples["s"][0] == 2 and not samples["rub"].any()
    assert not samples["x_a"].any() and not samples["x_b"].any()
    assert run.totals["loss_friction"] == 0.0


def test_a_damper_that_is_touched_at_the_start_sets_the_sense_of_slip():
    """The stop brakes a with c v = 3 N against a force of 1.6 N that alone would have it overtake b: b slips
    forwards under -LIMIT, a under 1.6 - 3 + LIMIT [N].
    """
    stop = Stop("s", GROUND, 0, 0.0, 1, 10.0, 20.0)
    push = (Force("push", 0, 1.6, ()),)
    run = open_trajectory(two_bodies(stop, forces=push, v=0.15, t_end=0.001), ledger=True)
    samples = [block.samples for block in run.blocks() if len(block.samples["time"])][-1]
    assert samples["s"][0] == 1 and samples["rub"][0] == 1
    # 1.6 - 20 * 0.15 + 0.5 = -0.9 m/s^2; the stop's force changes by 2 % within a millisecond
    assert samples["v_a"][-1] - 0.15 == pytest.approx(-0.9e-3, rel=0.03)
    assert samples["v_b"][-1] - 0.15 == pytest.approx(-LIMIT * 1e-3, rel=1e-9)
    assert run.totals["loss_friction"] > 0


@pytest.mark.parametrize("phase", (-pi / 2, pi / 2))
def test_a_base_that_turns_round_at_the_start_strikes_nothing(phase):
    """cos(90 deg) is 6e-17 in doubles: no impact and no beginning of a stick comes of it."""
    base = (Harmonic(0.001, 9.0, 9.0 / (2 * pi), 0.0, phase),)
    x = 0.001 if phase > 0 else -0.001
    parts = {"base": base, "t_end": 0.2, "every_den": 100}
    push = (Force("weight", 0, -1.0, ()),)
    table = (RigidStop("table", BASE, 0, 0.0, COMPRESSION, 0.5, at_start=True),)
    ball = open_trajectory(Scene((Body("m", 1.0, x, 0.0),), stops=table, forces=push, **parts))
    rub = (Friction("rub", 0, BASE, 1.0, 1.0, 0.0),)
    carried = open_trajectory(Scene((Body("m", 1.0, x, 0.0),), frictions=rub, **parts))
    for run, name in ((ball, "table"), (carried, "rub")):
        blocks = list(run.blocks())
        assert sum(len(block.events["t"]) for block in blocks) == 2  # start and end
        assert all((block.samples[name] == (3 if name == "table" else 0)).all() for block in blocks)
        assert blocks[-1].samples["x_m"][-1] == pytest.approx(0.001 * sin(9.0 * 0.2 + phase), abs=1e-17)


# Modes of plain starts against the automaton, which decides all of them.


def decided(of):
    """(mode, known zeros, doubts) of the start by the automaton; the mode by signs alone, or None."""
    table, doubts = ModeTable(of), []
    maker, automaton = (
        table.maker,
        Automaton(of, table.maker, Expansion(of, table), lambda t, *_: doubts.append(t)),
    )
    plain = UnambiguousStart(of, maker.ends)
    status = plain.status(start_of(of, Doubles)) if plain.known else None
    return (*automaton.initial(start_of(of, Doubles)), len(set(doubts))), status


@settings(max_examples=80)
@given(part_scenes())
def test_a_plain_start_is_what_the_automaton_says(of):
    of = replace(of, stops=tuple(replace(stop, at_start=False) for stop in of.stops))
    (status, known, doubts), plain = decided(of)
    assert plain is None or (plain, {}, 0) == (status, known, doubts)


@pytest.mark.parametrize(
    ("x", "v", "plain"),
    [
        (0.1, 0.5, True),
        (0.3, -0.5, True),
        (0.2, 0.5, False),  # at the stop
        (0.2 + 2.0**-54, 0.5, False),  # within its rounding
        (0.1, 0.0, False),  # at rest
        (0.1, 2.0**-60, True),
    ],
)
def test_which_starts_are_plain(x, v, plain):
    stop, rub = (
        Stop("wall", 0, GROUND, 0.2, COMPRESSION, 50.0, 0.0),
        Friction("rub", 0, GROUND, 1.0, 1.0, 0.0),
    )
    of = scene([Body("m", 1.0, x, v)], stops=(stop,), frictions=(rub,))
    (status, _, _), by_signs = decided(of)
    assert (by_signs is not None) == plain and by_signs in (None, status)


# A run that steps within its rounding ends with an error: it would never come to its end.


CRAWLING = """
bodies: {m: 1 kg}
links: {spring: {between: [m, ground], k: 1e8 N/m}}
initial: {m: {x: 1 mm}}
run: {t_end: 2e14 s, every: 1e14 s, method: taylor}
"""


@pytest.fixture
def crawling():
    """10,000 rad/s for 2e14 s: 1e17 steps."""
    return load_case(CRAWLING).scene()


def standstill(scene):
    with pytest.raises(EngineError, match="steps brought the run no further") as caught:
        for _ in open_trajectory(scene).blocks():
            pass
    return caught.value


def test_a_run_that_gets_nowhere_ends(crawling):
    error = standstill(crawling)
    assert error.reason == "standstill" and 0 < error.state.t < 2**-30 * crawling.t_end


@pytest.mark.slow
def test_special_scenes_that_creep_end():
    standstill(machine(random.Random(6241)))


def test_a_special_scene_that_crept_runs_as_in_many_digits():
    """On a stop without restitution: it comes to rest in doubt now, where it crept."""
    scene = machine(random.Random(4006))
    found = whole([block.events for block in open_trajectory(scene).blocks()])
    _, true, _, _ = truth(exact_parts(scene), 40)
    assert list(found["kind"]) == list(true["kind"]) and list(found["part"]) == list(true["part"])
    for name in ("t", "x_a", "v_a", "x_b", "v_b"):
        assert found[name] == pytest.approx(true[name], abs=1e-14)
