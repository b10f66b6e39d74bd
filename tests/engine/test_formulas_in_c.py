"""Formulas in the C engine: equal to the Python engine in every bit, whatever they are made of."""

import pickle
from array import array
from dataclasses import replace
from fractions import Fraction
from functools import cache

import numpy as np
import pytest

from tests.engine.random_formulas import formula_scene
from tests.engine.runs import Run, differences, run, whole
from vibsim.engine import _engine
from vibsim.engine.c_engine import CRun
from vibsim.engine.errors import EngineError
from vibsim.engine.flows.closed.modal import pitches
from vibsim.engine.flows.tape import POWER
from vibsim.engine.modes import parametric_rows
from vibsim.engine.modes.mode_table import mode_table
from vibsim.engine.modes.packing import pack_scene, packed_mode
from vibsim.engine.modes.parametric_rows import recipe_of
from vibsim.engine.trajectory import open_trajectory
from vibsim.physics.formulas import (
    ONE,
    PI,
    TIME,
    ZERO,
    absolute,
    add,
    call,
    choose,
    div,
    largest,
    mul,
    num,
    power,
    smallest,
    sub,
)
from vibsim.physics.parts import (
    AT_FORCE,
    BASE,
    COMPRESSION,
    GROUND,
    ROTOR,
    STATE,
    Body,
    Force,
    Friction,
    Link,
    RigidStop,
    Rotor,
    Scene,
    Stop,
)

X, V = ("x", 0), ("v", 0)
MOST_EVENTS, MOST_STEPS = 150, 1500  # of a random scene, so that Python is done with it soon


def oscillator(law, *parts, x=1.0, v=0.0, t_end=3.0, **more):
    """A body of 1 kg on a link with a law."""
    link = Link("spring", 0, GROUND, 0.0, 0.0, law)
    return Scene(
        (Body("a", 1.0, x, v), *parts), links=(link,), t_end=t_end, every_num=1, every_den=50, **more
    )


def bounded(scene, **options):
    """The run of C or the sentence with which it failed; None where it is too long for Python."""
    trajectory, blocks, events = open_trajectory(scene, "c", **options), [], 0
    try:
        for block in trajectory.blocks():
            blocks.append(block)
            events += len(block.events["t"])
            if events > MOST_EVENTS or trajectory.totals["steps"] > MOST_STEPS:
                return None
    except EngineError as error:
        return None if trajectory.totals["steps"] > MOST_STEPS else str(error)
    tables = [whole([getattr(block, name) for block in blocks]) for name in ("samples", "events", "section")]
    return Run(*tables, trajectory.totals)


def agreed(scene, **options):
    """The run of C, or its sentence, after Python has come to the same; None where it is too long."""
    try:
        fast = bounded(scene, **options)
    except EngineError as error:
        fast = str(error)
    if fast is None:
        return None
    try:
        slow = run(scene, "python", **options)
    except EngineError as error:
        assert fast == str(error)
        return fast
    assert differences(fast, slow) == []
    return fast


@cache
def agreed_random(seed):
    """What both engines come to of a random scene, with all that a run can keep."""
    return agreed(formula_scene(seed), section=True, ledger=True, momentum=True)


FUNCTIONS = {
    "exp": call("exp", mul(num("-1/2"), X)),
    "log": call("log", add(num(2), X)),
    "sin": call("sin", mul(num(3), X)),
    "cos": call("cos", mul(num(3), X)),
    "tan": call("tan", mul(num("1/2"), X)),
    "sinh": call("sinh", X),
    "cosh": call("cosh", X),
    "tanh": call("tanh", mul(num(5), V)),
    "atan": call("atan", mul(num(5), X)),
    "asin": call("asin", mul(num("1/2"), X)),
    "acos": call("acos", mul(num("1/2"), X)),
    "sqrt": call("sqrt", add(num(2), X)),
    "power": power(add(num(2), X), num("7/5")),
    "inverse power": power(add(num(2), X), num("-4/3")),
    "variable power": power(add(num(2), X), X),
    "quotient": div(X, add(ONE, mul(V, V))),
    "reciprocal": div(ONE, add(num(3), X)),
    "time": mul(X, call("sin", mul(num(4), TIME))),
    "pi": mul(PI, X),
    "velocity": mul(V, mul(V, V)),
    "abs": absolute(V, "abs(v)"),
    "max": largest(X, mul(num("1/3"), V), "max(x, v/3)"),
    "min": smallest(X, num("1/4"), "min(x, 1/4)"),
    "where": choose(X, mul(num("3/2"), X), mul(num("1/2"), V), "where(x > 0, 1.5 x, 0.5 v)"),
    "step": choose(sub(TIME, num("1/3")), ONE, ZERO, "step(t - 1/3)"),
    "mod": ("mod", mul(num(2), TIME), num("7/10"), "mod(2 t, 0.7)"),
    "table": (
        "table",
        X,
        (Fraction(-1, 2), Fraction(0), Fraction(1, 2)),
        ((Fraction(-1), Fraction(2)), (Fraction(0), Fraction(3), Fraction(-1))),
        "table(x)",
    ),
}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_every_operation_is_that_of_python(name):
    law = add(mul(num(20), X), mul(num(4), FUNCTIONS[name]))
    fast = agreed(oscillator(law), section=True)
    assert fast.totals["steps"] > 5 and fast.totals["uncertified"] == 0


def test_every_operation_is_on_some_tape():
    codes = set()
    for law in FUNCTIONS.values():
        maker = CRun(oscillator(add(mul(num(20), X), law))).maker
        for rows in maker.by_status.values():
            codes |= {op.code for op in rows.tape.ops}
    assert codes >= set(range(POWER + 1)) - {4, 5}  # those read a motor, as in random scenes


def test_a_contact_by_a_power_is_that_of_python():
    law = mul(num(10**6), power(sub(X, num("1/1000")), num("3/2")))
    wall = Stop("wall", 0, GROUND, 0.001, COMPRESSION, 0.0, 0.0, force=law)
    scene = Scene((Body("ball", 1.0, 0.0, 1.0),), stops=(wall,), t_end=0.03, every_num=1, every_den=10000)
    fast = agreed(scene)
    assert fast.events["t"][1:3] == pytest.approx(
        [0.001, 0.013811349348247], rel=1e-12
    )  # 2.94 (5 m / 4 K)^0.4


def test_a_contact_that_may_not_pull_lets_go_where_it_does_in_python():
    depth, rate = sub(X, num("1/100")), V
    law = mul(mul(num(1000), depth), add(ONE, mul(num("1/2"), rate)))
    wall = Stop("wall", 0, GROUND, 0.01, COMPRESSION, 0.0, 0.0, AT_FORCE, False, law)
    fast = agreed(Scene((Body("a", 1.0, 0.0, 3.0),), stops=(wall,), t_end=0.5))
    assert fast.totals["impacts"] == 1 and fast.events["t"][2] < fast.events["t"][3]


def friction(static, load, mu):
    """A friction of body 0 on the ground with a load and a law of the speed, by direction."""
    slips = tuple(mul(load, mu(mul(num(sense), V))) for sense in (1, -1))
    holds = tuple(mul(load, mul(static, mu(ZERO))) for _ in (1, -1))
    return Friction("f", 0, GROUND, 0.0, 0.0, 0.0, slips=slips, holds=holds, rises=(static != ONE,) * 2)


@pytest.mark.parametrize("static", (ONE, num("3/2")), ids=("plain", "static"))
def test_sticking_under_a_load_that_varies_is_that_of_python(static):
    def mu(s):
        return add(num("1/5"), mul(num("1/10"), call("exp", mul(num(-1), mul(s, s)))))

    load = largest(ZERO, add(num(10), mul(num(8), call("sin", mul(num(3), TIME)))), "max(0, N)")
    drive = Force("F", 0, 0.0, (), mul(num(4), call("sin", mul(num(5), TIME))))
    scene = oscillator(mul(num(4), X), frictions=(friction(static, load, mu),), forces=(drive,), t_end=6.0)
    fast = agreed(scene)
    assert fast.totals["sticks"] > 1


@pytest.mark.parametrize("held", (False, True), ids=("free", "on a base that moves"))
def test_rotors_on_bodies_and_states_are_those_of_python(held):
    bodies = (
        Body("frame", 3.0, 0.0, 0.0),
        Body("left", 2e-3, 1.0, 0.0, ROTOR),
        Body("right", 2e-3, 7.0, 30.0, ROTOR),
        Body("i", 1.0, 0.0, 0.0, STATE),
    )
    rotors = (Rotor(1, 0, 0.01), Rotor(2, 0, 0.02))
    current = mul(num(100), sub(sub(num(12), mul(num(2), ("v", 3))), mul(num("1/20"), ("v", 1))))
    forces = (
        Force("left", 1, 0.0, (), sub(mul(num("1/20"), ("v", 3)), mul(num("1/10000"), ("v", 1)))),
        Force("right", 2, 0.0, (), mul(num("-1/50"), call("cos", ("x", 2)))),
        Force("i", 3, 0.0, (), current),
    )
    P, Q = (0, BASE) if held else (0, GROUND)
    tie = (Friction("tie", P, Q, 80.0, 80.0, 0.0),) if held else ()
    base = {"base_formula": mul(num("1/100"), call("sin", mul(num(9), TIME)))} if held else {}
    scene = Scene(
        bodies, (Link("spring", P, Q, 900.0, 2.0),), (), tie, forces, rotors=rotors, t_end=1.0, **base
    )
    fast = agreed(scene, section=True)
    assert fast.samples["w_left"][-1] > 10


def test_a_kink_costs_no_call_of_python():
    """Only the first turns of each switch are decided by Python; nothing is told of any of them."""
    scene = oscillator(add(mul(num(100), X), mul(V, absolute(V, "abs(v)"))), t_end=20.0)
    of = CRun(scene)
    decided = []
    decide = of._decide
    of._decide = lambda *args: decided.append(args) or decide(*args)
    blocks = list(of.blocks())
    assert decided == [] and sum(block[2].shape[1] for block in blocks) == 2
    assert len(of.statuses) == 2


def test_states_behind_kinks_are_read_in_c():
    scene = oscillator(add(mul(num(100), X), mul(V, absolute(V, "abs(v)"))), t_end=5.0)
    whole_run = run(scene, "c")
    start = {name: column[0] for name, column in whole_run.events.items()}
    trajectory = open_trajectory(scene, "c", resume=start)
    for name, column in trajectory.state_at(whole_run.samples["time"][:-1]).items():
        assert column.tobytes() == whole_run.samples[name][:-1].tobytes(), name
    assert trajectory.run.run.tally()["state"][0] > 4  # C went all the way


def test_restarts_from_events_go_on_as_they_did():
    found = 0
    for seed in range(20):
        scene, fast = formula_scene(seed), agreed_random(seed)
        if not isinstance(fast, Run) or len(fast.events["t"]) < 4 or scene.rigid_stops:
            continue
        row = {name: column[2] for name, column in fast.events.items()}
        again = run(scene, "c", resume=row), run(scene, "python", resume=row)
        assert differences(*again) == []
        found += 1
    assert found > 1


def test_a_singularity_is_told_with_its_part_by_both_engines():
    """x'' = -1/x falls into the centre."""
    scene = oscillator(mul(num("1/2"), div(ONE, mul(X, X))))
    told = agreed(scene)
    assert "singularity" in told and "spring" in told


def test_a_singular_start_is_told_by_both_engines():
    told = agreed(oscillator(div(ONE, sub(X, ONE))))
    assert "t = 0.0 s" in told and "spring" in told


def test_what_becomes_negative_under_a_root_is_told_by_both_engines():
    told = agreed(oscillator(mul(num(9), power(X, num("3/2")))))
    assert "under a root" in told and "spring" in told


def test_a_force_that_holds_the_motion_at_its_jump_is_told_by_both_engines():
    sign = choose(V, ONE, num(-1), "sign(v)")
    told = agreed(oscillator(add(X, mul(num(2), sign)), t_end=9.0))
    assert "held" in told


# the first of them always, all by `make verify`
SEEDS = [pytest.param(first, marks=pytest.mark.slow if first >= 20 else ()) for first in range(0, 200, 10)]


@pytest.mark.parametrize("first", SEEDS)
def test_random_scenes_are_those_of_python(first):
    compared = [agreed_random(seed) for seed in range(first, first + 10)]
    assert sum(one is not None for one in compared) > 5


def test_tables_of_modes_tell_formulas_apart():
    one, other = oscillator(mul(num(9), X)), oscillator(mul(num(8), X))
    rotor = replace(one, bodies=(*one.bodies, Body("r", 1.0, 0.0, 0.0, ROTOR)))
    scenes = (one, other, rotor, replace(rotor, rotors=(Rotor(1, 0, 0.1),)), replace(one, base_formula=TIME))
    tables = {id(mode_table(scene)) for scene in scenes}
    assert len(tables) == len(scenes)
    assert mode_table(pickle.loads(pickle.dumps(one))) is mode_table(one)


def test_modes_of_other_formulas_are_not_of_one_form():
    one = oscillator(mul(num(9), X), stops=(RigidStop("s", 0, GROUND, 2.0, COMPRESSION, 0.5),))
    assert parametric_rows.differences(one, replace(one, links=(replace(one.links[0], force=X),))) is None
    stiff = replace(one, stops=(replace(one.stops[0], gap=3.0),))
    assert parametric_rows.differences(one, stiff) == {("stops", 0, "gap"): 3.0}
    run_of = CRun(one)
    assert recipe_of(one, (("stops", 0, "gap"),), run_of.statuses[0], dict(run_of.keys)) is None


def test_numbers_of_another_scene_in_the_parts_beside_formulas_are_those_of_that_scene():
    """Tables of scenes that differ in numbers alone share their rules."""
    wall = Stop("wall", 0, GROUND, 0.5, COMPRESSION, 50.0, 1.0)
    law = add(mul(num(9), X), absolute(V, "abs(v)"))
    for gap in (0.5, 0.25, 0.125):
        assert agreed(oscillator(law, stops=(replace(wall, gap=gap),))).totals["impacts"] > 0


HUGE = (2**31 - 1, 10**6, -(10**6), -(2**31))


def with_int(ints, place, value):
    values = array("i", ints)
    values[place] = value
    return values.tobytes()


@pytest.mark.parametrize("which", (0, 1), ids=("scene", "mode"))
def test_no_index_of_a_tape_reaches_beyond_its_table(which):
    """Each whole number in turn is far out: it is refused, or what it says does no harm."""
    base = {"base_formula": mul(num("1/100"), call("sin", TIME))}
    law = add(mul(num(20), sub(X, ("x", BASE))), add(*(FUNCTIONS[name] for name in ("atan", "tanh"))))
    scene = replace(
        oscillator(
            add(law, FUNCTIONS["sin"]), Body("r", 1.0, 0.0, 0.0, ROTOR), Body("z", 1.0, 0.0, 0.0, STATE)
        ),
        rotors=(Rotor(1, 0, 0.1),),
        **base,
    )
    of = CRun(scene)
    packed = pack_scene(scene, pitches(scene)), packed_mode(of.rows_of(0), dict(of.keys)).packed
    refused = 0
    for place in range(len(packed[which][0]) // 4):
        for value in HUGE:
            numbers = [*packed]
            numbers[which] = (with_int(packed[which][0], place, value), packed[which][1])
            try:
                _engine.Run(*numbers[0]).add_mode(*numbers[1])
            except (ValueError, MemoryError):
                refused += 1
    assert refused > 2 * len(packed[which][0]) // 4


@pytest.mark.parametrize("part", (0, 1), ids=("ints", "doubles"))
def test_a_tape_cut_short_is_refused(part):
    scene = oscillator(add(mul(num(20), X), FUNCTIONS["tanh"]))
    of = CRun(scene)
    mode = [*packed_mode(of.rows_of(0), dict(of.keys)).packed]
    mode[part] = mode[part][:-8]
    with pytest.raises(ValueError, match="packed numbers"):
        _engine.Run(*pack_scene(scene, pitches(scene))).add_mode(*mode)


def test_extremes_of_a_formula_are_those_of_python():
    scene = oscillator(add(X, mul(X, mul(X, X))), t_end=10.0)
    found = []
    for engine in ("c", "python"):
        trajectory = open_trajectory(scene, engine, extremes=([(0, GROUND)], 0.0))
        assert trajectory.engine == engine
        for _ in trajectory.blocks():
            pass
        found.append(trajectory.extremes)
    assert found[0] == found[1] and found[0][1][0] == pytest.approx(1.0, abs=1e-14)
    assert np.isfinite(found[0][0]).all()
