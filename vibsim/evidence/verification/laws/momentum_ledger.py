"""V21: the momentum of the paper's pair changes by friction and by the source alone.

Spring, damper and stop act between the blocks; the motor's imbalance moves with block 1 and is part of p.
"""

from collections.abc import Iterator
from functools import partial
from math import sin

from vibsim.engine.trajectory import open_trajectory
from vibsim.evidence.verification.check import Check
from vibsim.evidence.verification.row import Row, compared, counted_row, number_row
from vibsim.evidence.verification.runs import named_case
from vibsim.physics.parts import Scene

CLOSURE = 1e-12  # relative to the largest entry, as the ledger of energy promises
SPAN = {"run__t_end": "10 s", "run__every": "1 s"}
CASES = ("I-A", "II-B")


def checks() -> list[Check]:
    """A run with a force and one with a motor."""
    title = "First moment of the ledger of {}"
    return [Check(f"V21/{name}", title.format(name), partial(rows, name)) for name in CASES]


def rows(name: str, engine: str) -> Iterator[Row]:
    """The closure; and momentum from the last state alone against what friction and source gave."""
    scene = named_case(name, **SPAN).scene()
    trajectory = open_trajectory(scene, engine, momentum=True)
    blocks = list(trajectory.blocks())
    totals, last = trajectory.totals, blocks[-1].events
    point = compared("what is missing, relative", 0.0, float(totals["momentum_residual_relative"]), CLOSURE)
    yield number_row(f"V21/{name}", point, "promised: 1e-12 of the largest entry")
    end = momenta(scene, {column: float(values[-1]) for column, values in last.items()})
    impulses = float(totals["impulse_source"]), float(totals["impulse_ground"])
    expected = float(totals["momentum_start"]) + sum(impulses)
    size = max(map(abs, [*end, *impulses]))
    point = compared("momentum at the end", expected, sum(end), CLOSURE * size, "N s")
    yield number_row(f"V21/{name}", point, "of the last state; 1e-12 of the largest entry")
    others = [key for key, value in totals.items() if key.startswith("impulse.") and value]
    wrong = sum(not key.startswith(("impulse.ground", "impulse.forces")) for key in others)
    yield counted_row(f"V21/{name}", "impulses of other parts", 0, wrong, "parts between blocks give none")


def momenta(scene: Scene, state: dict[str, float]) -> list[float]:
    """m v of each body, and what the imbalance on one adds: m3 (v - e phidot sin phi) [N s]."""
    own = [body.m * state[f"v{body.name}"] for body in scene.bodies]
    motor = scene.motor
    if motor is not None:
        own.append(motor.m3 * state[f"v{scene.bodies[motor.on].name}"])
        own.append(-motor.m3 * motor.e * state["phidot"] * sin(state["phi"]))
    return own
