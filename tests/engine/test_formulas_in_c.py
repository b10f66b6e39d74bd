"""Formulas in the C engine: equal to the Python engine in every bit, whatever they are made of."""

import pickle
import re
from array import array
from functools import cache

import numpy as np
import pytest

from tests.engine.random_formulas import formula_scene
from tests.engine.runs import Run, differences, run, scene_of, whole
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
from vibsim.physics.parts import GROUND

MOST_EVENTS, MOST_STEPS = 150, 1500  # of a random scene, so that Python is done with it soon
PURE = {"x": "(d/L)", "v": "(v/v0)", "t": "(t/T)"}
NUMBERS = "{F: 1 N, L: 1 m, v0: 1 m/s, T: 1 s}"


def law(text):
    """A force [N] by a formula of pure numbers: displacement x, velocity v and time t in SI units."""
    return "F*(" + re.sub(r"\b[xvt]\b", lambda name: PURE[name.group()], text) + ")"


def oscillator(text, more="", x=1.0, t_end=3.0, end="ground"):
    """A body of 1 kg on a link with a law of pure numbers."""
    return scene_of(f"""
parameters: {NUMBERS}
bodies: {{a: 1 kg}}
links: {{spring: {{between: [a, {end}], force: "{law(text)}"}}}}
initial: {{a: {{x: {x} m}}}}
run: {{t_end: {t_end} s, every: 20 ms}}
{more}""")


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
    "exp": "exp(-x/2)",
    "log": "log(2 + x)",
    "sin": "sin(3*x)",
    "cos": "cos(3*x)",
    "tan": "tan(x/2)",
    "sinh": "sinh(x)",
    "cosh": "cosh(x)",
    "tanh": "tanh(5*v)",
    "atan": "atan(5*x)",
    "asin": "asin(x/2)",
    "acos": "acos(x/2)",
    "sqrt": "sqrt(2 + x)",
    "power": "(2 + x)**(7/5)",
    "inverse power": "(2 + x)**(-4/3)",
    "variable power": "(2 + x)**x",
    "quotient": "x/(1 + v*v)",
    "reciprocal": "1/(3 + x)",
    "time": "x*sin(4*t)",
    "pi": "pi*x*x*x",
    "velocity": "v*v*v",
    "abs": "abs(v)",
    "max": "max(x, v/3)",
    "min": "min(x, 1/4)",
    "where": "where(x > 0, 3/2*x, v/2)",
    "step": "step(t - 1/3)",
    "mod": "mod(2*t, 7/10)",
    "table": "table(x, [[-0.5, -1], [0, 0], [0.5, 1]], 'cubic')",
}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_every_operation_is_that_of_python(name):
    fast = agreed(oscillator(f"20*x + 4*({FUNCTIONS[name]})"), section=True)
    assert fast.totals["steps"] > 5 and fast.totals["uncertified"] == 0


def test_every_operation_is_on_some_tape():
    codes = set()
    for text in FUNCTIONS.values():
        maker = CRun(oscillator(f"20*x + {text}")).maker
        for rows in maker.by_status.values():
            codes |= {op.code for op in rows.tape.ops}
    assert codes >= set(range(POWER + 1)) - {4, 5}  # those read a motor, as in random scenes


def test_a_contact_by_a_power_is_that_of_python():
    fast = agreed(
        scene_of("""
bodies: {ball: 1 kg}
stops: {wall: {between: [ball, ground], gap: 1 mm, acts: compression, force: "K*p**1.5", K: 1e6 N/m^1.5}}
initial: {ball: {v: 1 m/s}}
run: {t_end: 30 ms, every: 0.1 ms}
""")
    )
    duration = 0.012811349348247  # s: 2.94 (5 m / 4 K)^0.4 with v = 1 m/s
    assert fast.events["t"][1:3] == pytest.approx([0.001, 0.001 + duration], rel=1e-12)


def test_a_contact_that_may_not_pull_lets_go_where_it_does_in_python():
    fast = agreed(
        scene_of("""
bodies: {a: 1 kg}
stops:
  wall: {between: [a, ground], gap: 1 cm, acts: compression, release: force,
         force: "k*p*(1 + lam*pv)", k: 1 kN/m, lam: 0.5 s/m}
initial: {a: {v: 3 m/s}}
run: {t_end: 0.5 s}
""")
    )
    assert fast.totals["impacts"] == 1 and fast.events["t"][2] < fast.events["t"][3]


@pytest.mark.parametrize("static", (1, 1.5), ids=("plain", "static"))
def test_sticking_under_a_load_that_varies_is_that_of_python(static):
    rub = f"""
friction:
  f: {{between: [a, ground], N: "max(0*F, 10*F + 8*F*sin(3*t/T))", mu: "0.2 + 0.1*exp(-(s/v0)**2)",
       static: {static}}}
forces: {{drive: {{on: a, A: 4 N, omega: 5 rad/s}}}}
"""
    fast = agreed(oscillator("4*x", rub, t_end=6.0))
    assert fast.totals["sticks"] > 1


@pytest.mark.parametrize("end", ("ground", "base"))
def test_rotors_on_bodies_and_states_are_those_of_python(end):
    text = f"""
bodies: {{frame: 3 kg}}
links: {{spring: {{between: [frame, {end}], k: 900 N/m, c: 2 N s/m}}}}
states: {{i: {{rate: "(U - R*i - Ke*w_left)/L", start: 0 A, U: 12 V, R: 2 ohm, Ke: 0.05 V s/rad, L: 10 mH}}}}
rotors:
  left: {{on: frame, m: 0.1 kg, e: 0.1 m, J: 1e-3 kg m^2,
         torque: "Kt*i - b*w", Kt: 0.05 N m/A, b: 1e-4 N m s/rad}}
  right: {{on: frame, m: 0.2 kg, e: 0.1 m, J: 0 kg m^2, torque: "-T0*cos(phi)", T0: 0.02 N m}}
initial: {{left: {{phi: 1 rad}}, right: {{phi: 7 rad, w: 30 rad/s}}}}
run: {{t_end: 1 s, every: 20 ms}}
"""
    if end == "base":
        text += 'base: {x: "a*(sin(w0*t) + sin(w0*t)**2)", a: 1 cm, w0: 9 rad/s}\n'
        text += "friction: {tie: {between: [frame, base], N: 80 N, mu: 1}}\n"
    fast = agreed(scene_of(text), section=True)
    assert fast.samples["w_left"][-1] > 10


def test_a_kink_costs_no_call_of_python():
    """Only the first turns of each switch are decided by Python; nothing is told of any of them."""
    scene = oscillator("100*x + v*abs(v)", t_end=20.0)
    of = CRun(scene)
    decided = []
    decide = of._decide
    of._decide = lambda *args: decided.append(args) or decide(*args)
    blocks = list(of.blocks())
    assert decided == [] and sum(block[2].shape[1] for block in blocks) == 2
    assert len(of.statuses) == 2


def test_states_behind_kinks_are_read_in_c():
    scene = oscillator("100*x + v*abs(v)", t_end=5.0)
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
    scene = oscillator("1/(2*x*x)")
    told = agreed(scene)
    assert "singularity" in told and "spring" in told


def test_a_singular_start_is_told_by_both_engines():
    told = agreed(oscillator("1/(x - 1)"))
    assert "t = 0.0 s" in told and "spring" in told


def test_what_becomes_negative_under_a_root_is_told_by_both_engines():
    told = agreed(oscillator("9*x**(3/2)"))
    assert "under a root" in told and "spring" in told


def test_a_force_that_holds_the_motion_at_its_jump_is_told_by_both_engines():
    told = agreed(oscillator("x + 2*sign(v)", t_end=9.0))
    assert "held" in told


# the first of them always, all by `make verify`
SEEDS = [pytest.param(first, marks=pytest.mark.slow if first >= 20 else ()) for first in range(0, 200, 10)]


@pytest.mark.parametrize("first", SEEDS)
def test_random_scenes_are_those_of_python(first):
    compared = [agreed_random(seed) for seed in range(first, first + 10)]
    assert sum(one is not None for one in compared) > 5


ROTOR = "rotors: {r: {on: a, m: 0.1 kg, e: 1 m, J: 0.9 kg m^2}}\n"


def test_tables_of_modes_tell_formulas_apart():
    one = oscillator("9*x + x**3")
    scenes = [one, oscillator("8*x + x**3"), oscillator("9*x + x**3", ROTOR)]
    scenes.append(oscillator("9*x + x**3", ROTOR.replace("0.1 kg", "0.2 kg")))
    scenes.append(oscillator("9*x + x**3", 'base: {x: "q*t", q: 1 m/s}', end="base"))
    tables = {id(mode_table(scene)) for scene in scenes}
    assert len(tables) == len(scenes)
    assert mode_table(pickle.loads(pickle.dumps(one))) is mode_table(one)


RIGID = "stops: {s: {between: [a, ground], gap: 2 m, acts: compression, law: rigid, e: 0.5}}\n"


def test_modes_of_other_formulas_are_not_of_one_form():
    one, other = oscillator("9*x + x**3", RIGID), oscillator("x + x**3", RIGID)
    assert parametric_rows.differences(one, other) is None
    wider = oscillator("9*x + x**3", RIGID.replace("2 m", "3 m"))
    assert parametric_rows.differences(one, wider) == {("stops", 0, "gap"): 3.0}
    run_of = CRun(one)
    assert recipe_of(one, (("stops", 0, "gap"),), run_of.statuses[0], dict(run_of.keys)) is None


def test_numbers_of_another_scene_in_the_parts_beside_formulas_are_those_of_that_scene():
    """Tables of scenes that differ in numbers alone share their rules."""
    for gap in (0.5, 0.25, 0.125):
        wall = f"wall: {{between: [a, ground], gap: {gap} m, acts: compression, k: 50 N/m, c: 1 N s/m}}"
        assert agreed(oscillator("9*x + abs(v)", f"stops: {{{wall}}}")).totals["impacts"] > 0


HUGE = (2**31 - 1, 10**6, -(10**6), -(2**31))


def with_int(ints, place, value):
    values = array("i", ints)
    values[place] = value
    return values.tobytes()


@pytest.mark.parametrize("which", (0, 1), ids=("scene", "mode"))
def test_no_index_of_a_tape_reaches_beyond_its_table(which):
    """Each whole number in turn is far out: it is refused, or what it says does no harm."""
    parts = ROTOR + 'base: {x: "q*sin(t/T)", q: 1 cm}\nstates: {z: {rate: "0*z/T", start: 0 m}}\n'
    parts += 'forces: {f: {on: a, force: "F*atan(x_a/L)"}}\n'
    scene = oscillator("20*x + tanh(x) + sin(3*x)", parts, end="base")
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
    scene = oscillator("20*x + tanh(5*v)")
    of = CRun(scene)
    mode = [*packed_mode(of.rows_of(0), dict(of.keys)).packed]
    mode[part] = mode[part][:-8]
    with pytest.raises(ValueError, match="packed numbers"):
        _engine.Run(*pack_scene(scene, pitches(scene))).add_mode(*mode)


def test_extremes_of_a_formula_are_those_of_python():
    scene = oscillator("x + x*x*x", t_end=10.0)
    found = []
    for engine in ("c", "python"):
        trajectory = open_trajectory(scene, engine, extremes=([(0, GROUND)], 0.0))
        assert trajectory.engine == engine
        for _ in trajectory.blocks():
            pass
        found.append(trajectory.extremes)
    assert found[0] == found[1] and found[0][1][0] == pytest.approx(1.0, abs=1e-14)
    assert np.isfinite(found[0][0]).all()
