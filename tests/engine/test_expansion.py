"""Derivatives of event functions at a state, and the bounds of their rounding."""

from math import cos, sin

import pytest

from tests.engine.many_digits import exact_parts
from tests.engine.random_formulas import formula_scene
from tests.engine.runs import scene_of
from vibsim.cases import load_case
from vibsim.engine.c_engine import CRun
from vibsim.engine.errors import State
from vibsim.engine.flows.base_motion import base_motion
from vibsim.engine.flows.expansion import Expansion
from vibsim.engine.modes.mode_table import ModeTable
from vibsim.engine.modes.packing import pack_state
from vibsim.engine.modes.rows import HOLD, STRIKE, SWITCH
from vibsim.engine.modes.status import OPEN, STICK, Status
from vibsim.engine.number_forms import WordsForm
from vibsim.engine.tangent.saltation import DisturbedForces
from vibsim.physics.numbers import Doubles
from vibsim.physics.precision import number_kit

SPRING = """
bodies: {ball: 2 kg}
links:
  spring:
    between: [ball, ground]
    k: 8 N/m
stops:
  wall: {between: [ball, ground], law: rigid, gap: 1 m, acts: extension, e: 0.5}
run: {t_end: 1 s}
"""
APART = Status((OPEN,), (), ())


def wall_of(scene):
    """(expansion, rows, event function) of the one stop, which is open."""
    table = ModeTable(scene)
    rows = table.maker.rows(APART)
    return Expansion(scene, table), rows, next(one for one in rows.events if one.kind == STRIKE)


def test_derivatives_of_a_vibration():
    """x = x0 cos 2 t + v0 / 2 sin 2 t; the wall is struck at x = -1 m."""
    expansion, rows, event = wall_of(scene_of(SPRING))
    x0, v0 = 0.25, 0.75
    expansion.look(State(3.0, [x0], [v0], 0.0, 0.0, 0.0), rows)
    gap, *rest = expansion.derivatives(event, 7)
    assert gap == 1 + x0
    turned = (x0, v0 / 2, -x0, -v0 / 2)
    assert rest == pytest.approx([turned[n % 4] * 2**n for n in range(1, 8)], rel=1e-15)


def test_derivatives_of_a_motion_by_a_formula():
    """x'' = -9 sin x, x''' = -9 v cos x, x'''' = 9 v^2 sin x + 81 sin x cos x."""
    law = SPRING.replace("k: 8 N/m", "force: 18 N * sin(d / (1 m))")
    expansion, rows, event = wall_of(scene_of(law))
    x, v = 0.4, -1.5
    expansion.look(State(0.0, [x], [v], 0.0, 0.0, 0.0), rows)
    known = [-9 * sin(x), -9 * v * cos(x), 9 * v * v * sin(x) + 81 * sin(x) * cos(x)]
    assert expansion.derivatives(event, 4)[2:] == pytest.approx(known, rel=1e-14)
    assert expansion.formulas()[0] == pytest.approx(18 * sin(x), rel=1e-15)


def in_digits(scene, digits=40):
    """(table of modes, scene) in numbers of so many digits, with exactly those doubles."""
    kit = number_kit(digits)
    exact = exact_parts(scene)(kit.number, kit.pi)
    return ModeTable(exact, WordsForm(kit)), exact


def moved(state, kit, shift=(), size=0):
    """A state with some motion, in numbers of the kit, and shifted by `size` times (dx, dv, dphi, dw)."""
    n, number = len(state.x), kit.number
    shift = shift or (0,) * (2 * n + 2)
    x = [number(x) + number(0.003) + size * shift[i] for i, x in enumerate(state.x)]
    v = [number(v) - number(0.02) + size * shift[n + i] for i, v in enumerate(state.v)]
    phi, w = number(0.3) + size * shift[-2], number(state.w) + size * shift[-1]
    return State(number(0.0), x, v, phi, number(0.0), w)


SCENES = {f"formulas {seed}": formula_scene(seed) for seed in (1, 2, 4, 7, 11, 13)}
SCENES |= {
    name: load_case(name).scene()
    for name in ("II-B", "gallery/coupled-clutches", "gallery/stack-of-blocks", "hard/spool-between-stops")
}


@pytest.mark.parametrize("name", SCENES)
def test_rounding_is_within_its_bounds(name):
    """Of doubles against 40 digits, where a run starts and at a state moved from there."""
    run = CRun(SCENES[name])
    table, exact = in_digits(run.scene)
    rows, same_rows = run.maker.rows(run.first[1]), table.maker.rows(run.first[1])
    expansion, truth = run.expansion, Expansion(exact, table)
    expansion.look(moved(run.first[0], Doubles), rows)
    truth.look(moved(run.first[0], truth.kit), same_rows)
    count, wrong = 2 * run.n + 3, 0
    for event, same in zip(rows.events, same_rows.events, strict=True):
        values, bounds = expansion.derivatives(event, count), expansion.bounds(event, count, False)
        largest = max(map(abs, values))
        for value, bound, right in zip(values, bounds, truth.derivatives(same, count), strict=True):
            wrong += abs(value - right) > 0
            assert abs(value - right) <= bound <= 1e-10 * largest
    assert wrong > 0


def tie(state, rows, given):
    """Give tied columns of a state the velocities of a mode; given: those of ground and base."""
    for c, leader in enumerate(rows.leader[: len(state.v)]):
        if leader != c and c not in rows.follow:
            state.v[c] = (*state.v, *given)[leader] + rows.drift[c]


def slopes_of_events(scene, status, start):
    """(change of each event function of ties and switches by a disturbance as saltation has it, the same as
    difference quotient in 40 digits) in a mode at a state moved from `start`.
    """
    table, exact = in_digits(scene)
    kit, rows, expansion, n = table.form.kit, table.maker.rows(status), Expansion(exact, table), len(start.x)
    shift = [kit.number((-1) ** i * (i + 1)) for i in range(2 * n + 2)]
    step = kit.number(2) ** -40
    at = moved(start, kit)
    tie(at, rows, (kit.number(0), base_motion(exact, kit, at.t)[1]))
    vector = shift if scene.motor else shift[: 2 * n]
    vector[n : 2 * n] = [vector[n + c] if c < n else kit.number(0) for c in rows.leader[:n]]  # as ties allow
    forces = DisturbedForces(exact, kit, rows, at, vector)
    for event in (one for one in rows.events if one.kind in (HOLD, SWITCH)):
        values = []
        for size in (step, -step):
            there = moved(start, kit, [*vector, 0, 0][: 2 * n + 2], size)
            there.v[:] = [v + size * dv for v, dv in zip(at.v, vector[n:], strict=False)]
            expansion.look(there, rows)
            values.append(expansion.derivatives(event, 0)[0])
        yield float(forces.of(event)), float((values[0] - values[1]) / (2 * step))


@pytest.mark.parametrize("name", [*SCENES, *(f"formulas {seed}" for seed in (3, 5, 6, 8, 9, 10))])
def test_disturbed_event_functions_are_difference_quotients(name):
    scene = SCENES.get(name) or formula_scene(int(name.split()[1]))
    run = CRun(scene)
    start, status = run.first
    stuck = status.with_frictions(dict.fromkeys(range(len(scene.frictions)), STICK))
    found = [*slopes_of_events(scene, status, start)]
    found += slopes_of_events(scene, run.automaton.departures.with_sides(start, stuck), start)
    for value, right in found:
        assert value == pytest.approx(right, rel=1e-9, abs=1e-9)


def test_what_was_not_looked_at_has_no_derivatives():
    scene = scene_of(SPRING)
    expansion, rows, _ = wall_of(scene)
    state = State(0.0, [0.0], [1.0], 0.0, 0.0, 0.0)
    packed, run = pack_state(state), expansion.run
    for call in (lambda: run.derivatives(0, 1), lambda: run.bounds(0, 1, False, False, 0.0), run.formulas):
        with pytest.raises(ValueError, match="looked at"):
            call()
    expansion.look(state, rows)
    for number, count in ((-1, 1), (1, 1), (0, -1), (0, expansion.order)):
        with pytest.raises(ValueError, match="looked at"):
            run.derivatives(number, count)
        with pytest.raises(ValueError, match="looked at"):
            run.bounds(number, count, False, False, 0.0)
    for mode in (-1, 1):
        with pytest.raises(ValueError, match="cannot look"):
            run.look(mode, packed)
    with pytest.raises(ValueError, match="not a packed state"):
        run.look(0, packed[:-8])
    started = CRun(scene)
    with pytest.raises(ValueError, match="cannot look"):
        started.run.look(0, pack_state(state))
