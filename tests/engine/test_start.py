"""What rests at the start goes on under the forces that there are behind it, those of stops included."""

import random
from dataclasses import replace
from math import pi, sin

import pytest
from hypothesis import given, settings

from tests.engine.many_digits import exact_parts, truth
from tests.engine.random_parts import part_scenes
from tests.engine.runs import run, scene_of
from tests.events.special_scenes import machine
from vibsim.engine.errors import EngineError, start_of
from vibsim.engine.events.automaton import Automaton, UnambiguousStart
from vibsim.engine.flows.expansion import Expansion
from vibsim.engine.modes.mode_table import ModeTable
from vibsim.physics.numbers import Doubles

LIMIT = 0.5  # of the friction between the bodies [N]
# Two bodies of 1 kg that rub on each other, the first before a stop.
RUBBING = f"""
bodies: {{a: 1 kg, b: 1 kg}}
friction: {{rub: {{between: [b, a], N: {LIMIT} N, mu: 1}}}}
run: {{t_end: 30 ms, every: 1 ms}}
"""


def test_a_stop_whose_damper_would_pull_moves_nothing():
    """Deep at the start, the base draws back: without a force both bodies stay, stuck to each other."""
    more = """
stops: {s: {between: [base, a], gap: -2 mm, acts: extension, k: 1 kN/m, c: 100 N s/m, release: force}}
base: {a: 5 mm, omega: 9 rad/s}
"""
    found = run(scene_of(RUBBING + more), ledger=True)
    assert found.samples["s"][0] == 2 and not found.samples["rub"].any()
    assert not found.samples["x_a"].any() and not found.samples["x_b"].any()
    assert found.totals["loss_friction"] == 0.0


def test_a_damper_that_is_touched_at_the_start_sets_the_sense_of_slip():
    """The stop brakes a with 3 N against 1.6 N: b slips forwards under -LIMIT, a under LIMIT - 1.4 N."""
    more = """
stops: {s: {between: [ground, a], gap: 0 m, acts: extension, k: 10 N/m, c: 20 N s/m}}
forces: {push: {on: a, F0: 1.6 N}}
initial: {a: {v: 0.15 m/s}, b: {v: 0.15 m/s}}
"""
    found = run(scene_of(RUBBING + more, t_end="1 ms"), ledger=True)
    samples = found.samples
    assert samples["s"][0] == 1 and samples["rub"][0] == 1
    # 1.6 - 20 * 0.15 + 0.5 = -0.9 m/s^2; the stop's force changes by 2 % within a millisecond
    assert samples["v_a"][-1] - 0.15 == pytest.approx(-0.9e-3, rel=0.03)
    assert samples["v_b"][-1] - 0.15 == pytest.approx(-LIMIT * 1e-3, rel=1e-9)
    assert found.totals["loss_friction"] > 0


@pytest.mark.parametrize("side", (-1, 1))
@pytest.mark.parametrize(
    ("name", "code", "part"),
    [
        ("table", 3, "stops: {table: {between: [base, m], gap: 0 m, acts: compression, law: rigid, e: 0.5}}"),
        ("rub", 0, "friction: {rub: {between: [m, base], N: 1 N, mu: 1}}"),
    ],
)
def test_a_base_that_turns_round_at_the_start_strikes_nothing(side, name, code, part):
    """cos(90 deg) is 6e-17 in doubles: no impact and no beginning of a stick comes of it."""
    text = f"""
bodies: {{m: 1 kg}}
{part}
forces: {{weight: {{on: m, F0: {-1 if name == "table" else 0} N}}}}
base: {{a: 1 mm, omega: 9 rad/s, phase: {90 * side} deg}}
initial: {{m: {{x: {side} mm}}}}
run: {{t_end: 0.2 s, every: 10 ms}}
"""
    found = run(scene_of(text))
    assert len(found.events["t"]) == 2  # start and end
    assert (found.samples[name] == code).all()
    assert found.samples["x_m"][-1] == pytest.approx(0.001 * sin(9.0 * 0.2 + side * pi / 2), abs=1e-17)


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
    of = scene_of(f"""
bodies: {{m: 1 kg}}
stops: {{wall: {{between: [m, ground], gap: 20 cm, acts: compression, k: 50 N/m}}}}
friction: {{rub: {{between: [m, ground], N: 1 N, mu: 1}}}}
initial: {{m: {{x: {x} m, v: {v} m/s}}}}
""")
    (status, _, _), by_signs = decided(of)
    assert (by_signs is not None) == plain and by_signs in (None, status)


# A run that steps within its rounding ends with an error: it would never come to its end.


# 10,000 rad/s for 2e14 s: 1e17 steps.
CRAWLING = """
bodies: {m: 1 kg}
links: {spring: {between: [m, ground], k: 1e8 N/m}}
initial: {m: {x: 1 mm}}
run: {t_end: 2e14 s, every: 1e14 s, method: taylor}
"""


def standstill(scene):
    with pytest.raises(EngineError, match="steps or more brought the run no further") as caught:
        run(scene)
    return caught.value


def test_a_run_that_gets_nowhere_ends():
    crawling = scene_of(CRAWLING)
    error = standstill(crawling)
    assert error.reason == "standstill" and 0 < error.state.t < 2**-30 * crawling.t_end


@pytest.mark.slow
def test_special_scenes_that_creep_end():
    standstill(machine(random.Random(6241)))


def test_a_special_scene_that_crept_runs_as_in_many_digits():
    """On a stop without restitution: it comes to rest in doubt now, where it crept."""
    scene = machine(random.Random(4006))
    found = run(scene).events
    _, true, _, _ = truth(exact_parts(scene), 40)
    assert list(found["kind"]) == list(true["kind"]) and list(found["part"]) == list(true["part"])
    for name in ("t", "x_a", "v_a", "x_b", "v_b"):
        assert found[name] == pytest.approx(true[name], abs=1e-14)
