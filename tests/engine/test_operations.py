"""Every operation of formulas, in doubles and in words; what the engine is told of formulas."""

import pickle
import re
from copy import deepcopy

import numpy as np
import pytest

from tests.engine.many_digits import exact_parts, truth
from tests.engine.runs import run, scene_of
from vibsim.engine.c_engine import CRun
from vibsim.engine.errors import EngineError
from vibsim.engine.flows.tape import POWER
from vibsim.engine.modes import parametric_rows
from vibsim.engine.modes.mode_table import ModeTable, mode_table
from vibsim.engine.modes.parametric_rows import recipe_of
from vibsim.engine.trajectory import open_trajectory
from vibsim.physics.parts import GROUND

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


def judged(scene, close=1e-12):
    """The run of a scene, whose events and states are those of 40 digits. They have elementary functions and
    series of their own, in whole numbers.

    close : of states [share of the largest one of a column]
    """
    found = run(scene, ledger=True, momentum=True)
    samples, events, *_ = truth(exact_parts(scene), 40)
    assert found.events["kind"].tolist() == events["kind"].tolist()
    assert np.abs(found.events["t"] - events["t"]).max() < 1e-12
    for name, column in samples.items():
        assert np.abs(found.samples[name] - column).max() <= close * np.abs(column).max(), name
    assert found.totals["uncertified"] == 0
    assert abs(found.totals["energy_residual_relative"]) < 1e-12
    assert abs(found.totals["momentum_residual_relative"]) < 1e-12
    return found


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
def test_every_operation(name):
    assert judged(oscillator(f"20*x + 4*({FUNCTIONS[name]})")).totals["steps"] > 5


def test_every_operation_is_on_some_tape():
    codes = set()
    for text in FUNCTIONS.values():
        maker = CRun(oscillator(f"20*x + {text}")).maker
        for rows in maker.by_status.values():
            codes |= {op.code for op in rows.tape.ops}
    assert codes >= set(range(POWER + 1)) - {4, 5}  # those read a motor, as in random scenes


def test_a_contact_by_a_power():
    fast = judged(
        scene_of("""
bodies: {ball: 1 kg}
stops: {wall: {between: [ball, ground], gap: 1 mm, acts: compression, force: "K*p**1.5", K: 1e6 N/m^1.5}}
initial: {ball: {v: 1 m/s}}
run: {t_end: 30 ms, every: 0.1 ms}
""")
    )
    duration = 0.012811349348247  # s: 2.94 (5 m / 4 K)^0.4 with v = 1 m/s
    assert fast.events["t"][1:3] == pytest.approx([0.001, 0.001 + duration], rel=1e-12)


def test_a_contact_that_may_not_pull_lets_go():
    fast = judged(
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
def test_sticking_under_a_load_that_varies(static):
    rub = f"""
friction:
  f: {{between: [a, ground], N: "max(0*F, 10*F + 8*F*sin(3*t/T))", mu: "0.2 + 0.1*exp(-(s/v0)**2)",
       static: {static}}}
forces: {{drive: {{on: a, A: 4 N, omega: 5 rad/s}}}}
"""
    assert judged(oscillator("4*x", rub, t_end=6.0)).totals["sticks"] > 1


@pytest.mark.parametrize("end", ("ground", "base"))
def test_rotors_on_bodies_and_states(end):
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
    assert judged(scene_of(text), 1e-11).samples["w_left"][-1] > 10


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
    whole_run = run(scene)
    start = {name: column[0] for name, column in whole_run.events.items()}
    trajectory = open_trajectory(scene, resume=start)
    for name, column in trajectory.state_at(whole_run.samples["time"][:-1]).items():
        assert column.tobytes() == whole_run.samples[name][:-1].tobytes(), name
    assert trajectory.run.run.tally()["state"][0] > 4  # C went all the way


@pytest.mark.parametrize(
    ("force", "told"),
    [
        ("1/(2*x*x)", "singularity.*spring"),  # falls into the centre
        ("1/(x - 1)", "t = 0.0 s.*spring"),
        ("9*x**(3/2)", "under a root.*spring"),
        ("x + (t - 5)**(1/2)", "t = 0.0 s.*under a root.*spring"),  # from the start on
        ("x + 2*sign(v)", "held"),
    ],
)
def test_where_a_motion_ends_is_told_with_the_part(force, told):
    with pytest.raises(EngineError, match=told):
        run(oscillator(force, t_end=9.0))


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
    run_of, anew = CRun(one), ModeTable(wider)
    anew.keys = deepcopy(run_of.keys)
    recipe = recipe_of(one, (("stops", 0, "gap"),), run_of.statuses[0], deepcopy(run_of.keys))
    assert recipe.packed([3.0]) == anew.packed(run_of.statuses[0])


def test_numbers_of_another_scene_in_the_parts_beside_formulas_are_those_of_that_scene():
    """Tables of scenes that differ in numbers alone share their rules."""
    for gap in (0.5, 0.25, 0.125):
        wall = f"wall: {{between: [a, ground], gap: {gap} m, acts: compression, k: 50 N/m, c: 1 N s/m}}"
        assert judged(oscillator("9*x + abs(v)", f"stops: {{{wall}}}")).totals["impacts"] > 0


def test_extremes_of_a_formula():
    """x'' + x + x^3 = 0 from rest at 1 m comes back to 1 m, and as far on the other side."""
    trajectory = open_trajectory(oscillator("x + x*x*x", t_end=10.0), extremes=([(0, GROUND)], 0.0))
    for _ in trajectory.blocks():
        pass
    (least,), (greatest,), _ = trajectory.extremes
    assert [least, greatest] == pytest.approx([-1.0, 1.0], abs=1e-14)
