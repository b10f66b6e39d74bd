"""Laws of motion: mirror symmetry, Liouville's formula, balances; a motor alone (V8 to V11, V21)."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import partial
from math import cos, exp, expm1, log, pi, sin
from typing import Any

import numpy as np

from vibsim.cases import Case, shipped_case_names
from vibsim.cases.problems import counted
from vibsim.cases.quantities import Quantity
from vibsim.engine.tangent.tangent_space import dimension
from vibsim.engine.trajectory import open_trajectory
from vibsim.evidence.verification.checks import (
    BOTH,
    REASON,
    STATE_UNITS,
    UNIT,
    Check,
    CheckRow,
    compared,
    counted_row,
    flows_of,
    made_case,
    named_case,
    number_row,
    relative_rounding,
    run,
    worst_row,
)
from vibsim.physics.parts import EVENT_KINDS, Scene
from vibsim.physics.two_blocks import TwoBlocks, transmitted_force
from vibsim.results import Result

# V11: work in = stored + dissipated; and each entry of the ledger where a closed form gives it.


CLOSURE = 1e-12  # relative to the largest entry: what the ledger promises
SLIDING = """
blocks: {m1: 0.297 kg, m2: 2.94 kg}
coupling: {k1: 0 N/m}
friction: {mu: 0.001}
initial: {v2: 0.05 m/s}
run: {t_end: 10 s, every: 0.1 s}
"""
DAMPED = """
blocks: {m1: 0.297 kg, m2: fixed}
coupling: {k1: 200 N/m, c: 30 N s/m}
initial: {x1: 10 mm}
run: {t_end: 3 s, every: 10 ms}
"""
DRIVEN = """
blocks: {m1: 0.297 kg, m2: fixed}
coupling: {k1: 0 N/m}
excitation: {kind: harmonic, A: 0.3 N, omega: 2 Hz}
run: {t_end: 0.7 s, every: 10 ms}
"""


def energy_ledger_checks() -> list[Check]:
    """The nine cases by their flows, and the entries."""
    listed = [Check("V11/entries", "Entries of the ledger with a closed form", entries)]
    for name in shipped_case_names():
        case = named_case(name)
        listed += [
            Check(f"V11/{name}/{flow}", f"Ledger of {name} over 300 s", partial(closure, name, flow))
            for flow in flows_of(case)
        ]
    return listed


def closure(name: str, flow: str) -> Iterator[CheckRow]:
    """Error of the balance at the end, relative to the largest entry."""
    residual = float(run(named_case(name), flow).attrs["energy_residual_relative"])
    point = compared("what is missing, relative", 0.0, residual, CLOSURE)
    yield number_row(f"V11/{name}/{flow}", point, "promised: 1e-12 of the largest entry")


def entries() -> Iterator[CheckRow]:
    """Friction, damper, ideal source and motor, each alone."""
    spin = OMEGA0 * -expm1(-20.0 / TAU)
    speed = 0.3 * (1 - cos(4 * pi * 0.7)) / (0.297 * 4 * pi)
    for what, text, column, expected, conditioning in (
        ("friction loss = m2 v^2 / 2", SLIDING, "loss_friction", 2.94 * 0.05**2 / 2, 4),
        ("viscous loss = k1 x^2 / 2", DAMPED, "loss_viscous", 200 * 0.01**2 / 2, 4),
        ("work of a force = m1 v^2 / 2", DRIVEN, "work_source", 0.297 * speed**2 / 2, 4 * pi),
        (
            "work of a motor = (J + m3 e^2) w^2 / 2",
            HEAVY,
            "work_source",
            TAU * 0.005 / OMEGA0 * spin**2 / 2,
            6,
        ),
    ):
        changes = {"initial__phi": "0 rad", "run__t_end": "20 s"} if text is HEAVY else {}
        result = run(made_case(text, what, **changes))
        bound = 2 * expected * relative_rounding(result, conditioning)
        point = compared(what, expected, float(result.attrs[column]), bound, "J")
        yield number_row("V11/entries", point, f"{REASON}; energy is quadratic")


# V8: a scene seen in a mirror gives the mirrored trajectory, bit for bit.


MIRROR_SYMMETRY_SPAN = "60 s"
NAMES = ("hard/contact-lost-as-it-sticks", "hard/separatrix-passage")  # with a start that is not at rest
FLIPPED: tuple[str, ...] = ("excitation.A", "excitation.A.e", "excitation.F0", "excitation.e")
FLIPPED += tuple(f"initial.{name}" for name in ("x1", "v1", "x2", "v2"))
ODD = ("x1", "v1", "x2", "v2", "friction")  # change sign; all else stays


def mirror_symmetry_checks() -> list[Check]:
    """One check per case and flow."""
    listed = []
    for name in (*shipped_case_names(), *NAMES):
        case = mirrored_case(name)
        listed += [
            Check(
                f"V8/{name.rpartition('/')[2]}/{flow}",
                f"{name} in a mirror",
                partial(mirror_symmetry_rows, name, flow),
            )
            for flow in flows_of(case)
        ]
    return listed


def mirrored_case(name: str) -> Case:
    """The case that is mirrored."""
    return named_case(name, **({} if name.startswith("hard/") else {"run__t_end": MIRROR_SYMMETRY_SPAN}))


def mirrored(case: Case) -> Case:
    """The case in a mirror: signs of state and of A, F0 or e, and the stop on the other side."""
    changes = {}
    for key in FLIPPED:
        value = case.values.get(key)
        if isinstance(value, Quantity):
            text = value.text
            changes[key] = text[1:] if text.startswith("-") else f"-{text}"
    acts = case.values.get("stop.acts")
    if acts is not None:
        changes["stop.acts"] = "compression" if acts == "extension" else "extension"
    return case.with_values(changes)


def mirror_symmetry_rows(name: str, flow: str) -> Iterator[CheckRow]:
    """Count of numbers of samples and events that are not the mirror images of the others."""
    case = mirrored_case(name)
    ours, theirs = (run(scene, flow) for scene in (case, mirrored(case)))
    wrong = sum(
        differing(table[column], image[column], -1 if column in ODD else 1)
        for table, image in ((ours, theirs), (ours.events, theirs.events))
        for column in table
    )
    because = "the equations are odd, and so is rounding"
    yield counted_row(f"V8/{name.rpartition('/')[2]}/{flow}", "numbers that differ", 0, wrong, because)


def differing(values: np.ndarray, image: np.ndarray, sign: int) -> int:
    """Numbers that are not `sign` times their image; all of them where the lengths differ."""
    if len(values) != len(image):
        return max(len(values), len(image))
    return int(np.count_nonzero(values != sign * image))


# V21: the momentum of the paper's pair changes by friction and by the source alone.
#
# Spring, damper and stop act between the blocks; the motor's imbalance moves with block 1 and is part of p.


MOMENTUM_LEDGER_SPAN = {"run__t_end": "10 s", "run__every": "1 s"}
CASES = ("I-A", "II-B")


def momentum_ledger_checks() -> list[Check]:
    """A run with a force and one with a motor."""
    title = "First moment of the ledger of {}"
    return [Check(f"V21/{name}", title.format(name), partial(momentum_ledger_rows, name)) for name in CASES]


def momentum_ledger_rows(name: str) -> Iterator[CheckRow]:
    """The closure; and momentum from the last state alone against what friction and source gave."""
    scene = named_case(name, **MOMENTUM_LEDGER_SPAN).scene()
    trajectory = open_trajectory(scene, momentum=True)
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


# V10: the determinant of the monodromy matrix, saltation included, is what Liouville says.
#
# det = exp(int trace dt) x product of jump determinants. The trace is -c (1/m1 + 1/m2) with an ideal source;
# a reversal of block 2 multiplies dv2 by (|S| - N) / (|S| + N), contacts and releases change nothing. With a
# motor the momenta M(phi) (v1, w) shrink by int tr(C M^-1) dt, and velocities differ from them by det M.


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


def monodromy_checks() -> list[Check]:
    """A periodic motion, a turn of the motor, and the identity over 300 s of the nine cases."""
    listed = [
        Check(f"V10/period/{flow}", "Monodromy of a periodic motion", partial(period, flow)) for flow in BOTH
    ]
    listed.append(Check("V10/turn/taylor", "Monodromy of II-B over a turn", turn))
    for name in shipped_case_names():
        title = f"Liouville's identity over 300 s of {name}"
        listed += [
            Check(f"V10/{name}/{flow}", title, partial(identity, name, flow))
            for flow in flows_of(named_case(name))
        ]
    return listed


def period(flow: str) -> Iterator[CheckRow]:
    """From the last contact but two to a period later."""
    case = made_case(PERIODIC, "periodic motion")
    yield from determinant_rows(f"V10/period/{flow}", case, flow, PERIOD)


def turn() -> Iterator[CheckRow]:
    """About one turn of the rotor."""
    yield from determinant_rows("V10/turn/taylor", named_case("II-B", **MOTOR), "taylor", TURN)


def determinant_rows(name: str, case: Case, flow: str, span: float) -> Iterator[CheckRow]:
    """The determinant over `span` [s] from a contact, by the tangent flow and by Liouville."""
    result = run(case, flow)
    scene = replace(case.two_blocks(), method=flow)
    begins = np.flatnonzero(result.events["kind"] == EVENT_KINDS["contact_begin"])
    row = {column: values[begins[-3]] for column, values in result.events.items()}
    begin, end = float(row["t"]), float(row["t"]) + span
    totals = carried(replace(scene, t_end=end), row)
    jumps, rounding = jump_logarithms(scene, result, begin, end)
    expected = exp(smooth_logarithm(scene, result, begin, end) + sum(jumps))
    obtained = exp(float(np.sum(totals["growth"][-1, 1:])))
    bound = expected * (totals["tangent_pieces"] * PIECE_UNITS * UNIT + rounding)
    what = f"determinant over {span:.4g} s, {counted(len(jumps), 'reversal')}"
    yield number_row(name, compared(what, expected, obtained, bound), BECAUSE)


def carried(scene: TwoBlocks, resume: Mapping[str, float] | None = None) -> dict[str, Any]:
    """Totals of a run that carries all directions, from its start or from an event row."""
    sparse = scene.as_parts().without_samples()
    trajectory = open_trajectory(sparse, resume, tangent=dimension(sparse))
    for _ in trajectory.blocks():
        pass
    return trajectory.totals


def jump_logarithms(scene: TwoBlocks, result: Result, begin: float, end: float) -> tuple[list[float], float]:
    """log (|S| - N) / (|S| + N) of the reversals, and how much rounding of S may move their sum."""
    jumps, rounding = [], 0.0
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
        rounding += 2 * scene.N / (force**2 - scene.N**2) * STATE_UNITS * UNIT * terms
    return jumps, rounding


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


def identity(name: str, flow: str) -> Iterator[CheckRow]:
    """Error of the identity over a whole run, sticking left out on both sides."""
    scene = replace(named_case(name).two_blocks(), method=flow)
    totals = carried(scene)
    bound = totals["tangent_pieces"] * PIECE_UNITS * UNIT
    point = compared("what is missing", 0.0, float(totals["volume_residual"]), bound)
    yield number_row(f"V10/{name}/{flow}", point, BECAUSE)


# V9: the motor on a block that does not move runs up exponentially.
#
# (J + m3 e^2) w' = M0 (1 - w / Omega0), so w = Omega0 + (w0 - Omega0) exp(-t / tau) with
# tau = Omega0 (J + m3 e^2) / M0.


HEAVY = """
blocks: {m1: 1e30 kg, m2: fixed}
coupling: {k1: 0 N/m}
excitation: {kind: motor, m3: 0.03 kg, e: 0.11 m, J: 0.001 kg m^2, M0: 0.005 N m, Omega0: 5.5 Hz}
initial: {phi: 0.3 rad}
run: {t_end: 60 s, every: 0.5 s}
"""
OMEGA0 = 2 * pi * 5.5
TAU = OMEGA0 * (0.001 + 0.03 * 0.11**2) / 0.005


def motor_run_up_checks() -> list[Check]:
    """V9."""
    return [Check("V9/taylor", "Run-up of the motor alone", motor_run_up_rows)]


def motor_run_up_rows() -> Iterator[CheckRow]:
    """Speed and angle from three speeds at the start."""
    speeds, angles = [], []
    for start in (0.0, -20.0, 50.0):
        result = run(made_case(HEAVY, "motor alone", initial__phidot=f"{start} rad/s"))
        t = result.time
        decay = np.exp(-t / TAU)
        w = OMEGA0 + (start - OMEGA0) * decay
        phi = 0.3 + OMEGA0 * t + (start - OMEGA0) * TAU * (1 - decay)
        rounded = relative_rounding(result, 3, memory=TAU)
        for i in range(0, len(t), 10):
            at = f"{t[i]:g} s from {start:g} rad/s"
            speeds.append(
                compared(f"speed at {at}", w[i], float(result["phidot"][i]), OMEGA0 * rounded, "rad/s")
            )
            bound = max(1.0, OMEGA0 * t[i]) * rounded
            angles.append(compared(f"angle at {at}", phi[i], float(result["phi"][i]), bound, "rad"))
    yield worst_row("V9/taylor", speeds, REASON)
    yield worst_row("V9/taylor", angles, REASON)
