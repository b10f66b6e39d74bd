"""The states that count as true: the Python engine in 40 digits, for the very doubles of the shipped scenes.

python -m tests.budgets.truth prints the table of `true_states.py`. Needs python-flint.
"""

import math
from dataclasses import replace

from vibsim.cases import load_case
from vibsim.engine.driver import Driver
from vibsim.engine.truth import bare
from vibsim.physics.precision import Balls

INSTANTS = {"I-C": (20,), "II-A": (20, 40), "II-B": (20, 50), "II-C": (20, 40)}  # s


def true_states(name, times):
    """{(name, t): state} at `times` [s]."""
    kit = Balls(40)
    scene = load_case(name).two_blocks()
    numbers = {key: kit.number(value) for key, value in vars(scene).items() if isinstance(value, float)}
    if scene.source == "harmonic":
        numbers["omega"] = kit.two_pi * (numbers["cycles"] + numbers["cycles_lo"])
    run = {"t_end": kit.number(times[-1]), "every_num": math.gcd(*times), "every_den": 1}
    parts = bare(replace(scene, **{**numbers, **run}, method="taylor").as_parts(), kit)
    driver = Driver(parts, kit)
    driver.run(math.inf, math.inf, 10**9)
    states = {round(float(state.t)): state for state, _ in driver.samples}
    return {(name, t): _doubles(kit, parts, states[t]) for t in times}


def _doubles(kit, scene, state):
    motor = (kit.unwind(state.phase, state.turns), state.w) if scene.has_motor else ()
    moving = (value for pair in zip(state.x, state.v, strict=True) for value in pair)
    return tuple(float(value) for value in (*moving, *motor))


if __name__ == "__main__":
    for case, instants in INSTANTS.items():
        for key, values in true_states(case, instants).items():
            print(f"    {key}: {values},", flush=True)
