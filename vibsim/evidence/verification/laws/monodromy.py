"""V10: the determinant of the monodromy matrix, saltation included, is what Liouville says.

det = exp(int trace dt) x product of jump determinants. The trace is -c (1/m1 + 1/m2) with an ideal source;
a reversal of block 2 multiplies dv2 by (|S| - N) / (|S| + N), contacts and releases change nothing. With a
motor the momenta M(phi) (v1, w) shrink by int tr(C M^-1) dt, and velocities differ from them by det M.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import partial
from math import exp, log
from typing import Any

import numpy as np

from vibsim.cases import Case, shipped_case_names
from vibsim.engine.tangent.tangent_space import dimension
from vibsim.engine.trajectory import open_trajectory
from vibsim.evidence.verification.bounds.kicks import STATE_UNITS, UNIT
from vibsim.evidence.verification.check import Check
from vibsim.evidence.verification.row import Row, compared, number_row
from vibsim.evidence.verification.runs import BOTH, flows_of, made_case, named_case, run
from vibsim.physics.forces import transmitted_force
from vibsim.physics.modes import EVENT_KINDS
from vibsim.physics.two_blocks import TwoBlocks
from vibsim.results import Result

# one impact and two reversals a period; errors have fallen by exp(-c t / (2 m)) = 1e-39 at 100 s
PERIODIC = """
blocks: {m1: 0.297 kg, m2: 2.94 kg}
coupling: {k1: 200 N/m, c: 0.5 N s/m}
stop: {k2: 12400 N/m, G: 1 mm}
friction: {mu: 0.005}
excitation: {kind: harmonic, A: 1.14 N, omega: 5.5 Hz}
run: {t_end: 100 s, every: 10 ms}
"""
PERIOD = 1 / 5.5
MOTOR = {"run__t_end": "12 s", "run__every": "10 ms", "coupling__c": "0.5 N s/m"}
TURN = 1 / 4.0  # about one turn of the rotor of II-B [s]
# a piece's series is cut off at 1.65^20 / 20! = 9e-15, 80 units; the rest is rounding of up to five vectors
PIECE_UNITS = 400
BECAUSE = (
    "400 units per piece of the tangent flow: cut-off 9e-15, rounding of the vectors; and of S in the jumps"
)


def checks() -> list[Check]:
    """A periodic motion, a turn of the motor, and the identity over 300 s of the nine cases."""
    listed = [
        Check(f"V10/period/{flow}", "Monodromy of a periodic motion", partial(period, flow)) for flow in BOTH
    ]
    listed.append(Check("V10/turn/taylor", "Monodromy of II-B over a turn", turn))
    for name in shipped_case_names():
        title = f"Liouville's identity over 300 s of {name}"
        listed += [
            Check(f"V10/{name}/{flow}", title, partial(identity, name, flow), long=True)
            for flow in flows_of(named_case(name))
        ]
    return listed


def period(flow: str, engine: str) -> Iterator[Row]:
    """From the last contact but two to a period later."""
    case = made_case(PERIODIC, "periodic motion")
    yield from determinant_rows(f"V10/period/{flow}", case, flow, engine, PERIOD)


def turn(engine: str) -> Iterator[Row]:
    """About one turn of the rotor."""
    yield from determinant_rows("V10/turn/taylor", named_case("II-B", **MOTOR), "taylor", engine, TURN)


def determinant_rows(name: str, case: Case, flow: str, engine: str, span: float) -> Iterator[Row]:
    """The determinant over `span` [s] from a contact, by the tangent flow and by Liouville."""
    result = run(case, engine, flow)
    scene = replace(case.two_blocks(), method=flow)
    begins = np.flatnonzero(result.events["kind"] == EVENT_KINDS["contact_begin"])
    row = {column: values[begins[-3]] for column, values in result.events.items()}
    begin, end = float(row["t"]), float(row["t"]) + span
    totals = carried(replace(scene, t_end=end), engine, row)
    jumps, blur = jump_logarithms(scene, result, begin, end)
    expected = exp(smooth_logarithm(scene, result, begin, end) + sum(jumps))
    obtained = exp(float(np.sum(totals["growth"][-1, 1:])))
    bound = expected * (totals["tangent_pieces"] * PIECE_UNITS * UNIT + blur)
    what = f"determinant over {span:.4g} s, {len(jumps)} reversals"
    yield number_row(name, compared(what, expected, obtained, bound), BECAUSE)


def carried(scene: TwoBlocks, engine: str, resume: Mapping[str, float] | None = None) -> dict[str, Any]:
    """Totals of a run that carries all directions, from its start or from an event row."""
    sparse = scene.as_parts().without_samples()
    trajectory = open_trajectory(sparse, engine, resume, tangent=dimension(sparse))
    for _ in trajectory.blocks():
        pass
    return trajectory.totals


def jump_logarithms(scene: TwoBlocks, result: Result, begin: float, end: float) -> tuple[list[float], float]:
    """log (|S| - N) / (|S| + N) of the reversals, and how much rounding of S may move their sum."""
    jumps, blur = [], 0.0
    events = result.events
    for i in np.flatnonzero(events["kind"] == EVENT_KINDS["reversal"]):
        if not begin < events["t"][i] <= end:
            continue
        x1, v1, x2, v2 = (float(events[name][i]) for name in ("x1", "v1", "x2", "v2"))
        contact = bool(events["contact"][i])
        force = abs(transmitted_force(scene, x1 - x2, v1 - v2, contact))
        stiffness = scene.k1 + (scene.k2 if contact else 0.0)
        terms = stiffness * (abs(x1) + abs(x2) + abs(scene.G)) + scene.c * (abs(v1) + abs(v2))
        jumps.append(log((force - scene.N) / (force + scene.N)))
        blur += 2 * scene.N / (force**2 - scene.N**2) * STATE_UNITS * UNIT * terms
    return jumps, blur


def smooth_logarithm(scene: TwoBlocks, result: Result, begin: float, end: float) -> float:
    """Logarithm of the growth of a volume between the events."""
    grown = -scene.c / scene.m2 * (end - begin)
    if not scene.has_motor:
        return float(grown - scene.c / scene.m1 * (end - begin))
    ends = mass_determinant(scene, result.at(np.array([begin, end]))["phi"])
    return float(grown - damped(scene, result, begin, end) - log(ends[1] / ends[0]))


def mass_determinant(scene: TwoBlocks, phi: np.ndarray) -> np.ndarray:
    """det M = (m1 + m3)(J + m3 e^2) - (m3 e sin phi)^2."""
    coupling = scene.m3 * scene.e * np.sin(phi)
    return np.asarray((scene.m1 + scene.m3) * (scene.J + scene.m3 * scene.e**2) - coupling**2)


def damped(scene: TwoBlocks, result: Result, begin: float, end: float) -> float:
    """int tr(C M^-1) dt with C = diag(c, M0 / Omega0), by Gauss quadrature between the events.

    phi is smooth enough there: its accelerations jump with the forces, which are continuous but for friction.
    """
    nodes, weights = np.polynomial.legendre.leggauss(20)
    inner = result.events["t"][(result.events["t"] > begin) & (result.events["t"] < end)]
    edges = np.concatenate([[begin], inner, [end]])
    half = np.diff(edges) / 2
    times = ((edges[:-1] + edges[1:]) / 2)[:, None] + half[:, None] * nodes
    inverse = 1 / mass_determinant(scene, result.at(times)["phi"])
    inertia, mass = scene.J + scene.m3 * scene.e**2, scene.m1 + scene.m3
    trace = (scene.c * inertia + scene.M0 / scene.Omega0 * mass) * inverse
    return float(np.sum(half[:, None] * weights * trace))


def identity(name: str, flow: str, engine: str) -> Iterator[Row]:
    """What is missing in the identity over a whole run, sticking left out on both sides."""
    scene = replace(named_case(name).two_blocks(), method=flow)
    totals = carried(scene, engine)
    bound = totals["tangent_pieces"] * PIECE_UNITS * UNIT
    point = compared("what is missing", 0.0, float(totals["volume_residual"]), bound)
    yield number_row(f"V10/{name}/{flow}", point, BECAUSE)
