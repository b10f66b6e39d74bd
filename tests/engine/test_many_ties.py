"""Many frictions that come to rest or let go together: against solvers that share nothing with the engine."""

import random
import threading
from itertools import combinations

import numpy as np
import pytest
from scipy.optimize import linprog, lsq_linear

from tests.engine.runs import differences, run, scene_of
from vibsim.cases import load_case
from vibsim.engine import c_engine
from vibsim.engine.columns import part_columns
from vibsim.engine.errors import EngineError, start_of
from vibsim.engine.events.automaton import Automaton
from vibsim.engine.events.settling import StickSlipResolution
from vibsim.engine.flows.expansion import Expansion
from vibsim.engine.modes import mode_table, row_maker
from vibsim.engine.modes.mode_table import ModeTable
from vibsim.engine.modes.status import STICK
from vibsim.engine.modes.ties import TooManyCuts, connected_sides
from vibsim.engine.trajectory import open_trajectory
from vibsim.physics.numbers import Doubles
from vibsim.physics.parts import GROUND, Friction
from vibsim.results.simulation import simulate_to_file

HEAVY = 1e9  # kg: a base that no force of some newtons moves


def rubbing_bodies(count, driven=1):
    """`count` bodies of which each rubs on each other one, as text of a case; one on the ground too. So many
    of them are driven, each at a rate of its own.
    """
    pairs = combinations(range(count), 2)
    ground = "g0: {between: [b3, ground], N: 1 N, mu: 1}"
    frictions = [f"f{i}_{j}: {{between: [b{i}, b{j}], N: 1 N, mu: 0.{i}{j}, static: 1.2}}" for i, j in pairs]
    links = [f"s{i}: {{between: [b{i}, ground], k: {100 - 7 * i} N/m}}" for i in range(driven)]
    rates = [f"omega: {1 + 0.2 * i} Hz, phase: {40 * i} deg" for i in range(driven)]
    forces = [f"d{i}: {{on: b{i}, A: 20 N, {rate}}}" for i, rate in enumerate(rates)]
    return f"""
bodies: {{{", ".join(f"b{i}: 1 kg" for i in range(count))}}}
links: {{{", ".join(links)}}}
friction: {{{", ".join(frictions).replace("mu: 0.0", "mu: 0.1")}, {ground}}}
forces: {{{", ".join(forces)}}}
run: {{t_end: 3 s, every: 10 ms}}
"""


@pytest.fixture
def eight(tmp_path):
    path = tmp_path / "eight.yaml"
    path.write_text(rubbing_bodies(8))
    return path


def sides(scene, part):
    """Row of the velocity of P against Q over the columns: bodies, base."""
    row = np.zeros(len(scene.bodies) + 1)
    for end, sign in ((part.P, 1), (part.Q, -1)):
        if end != GROUND:
            row[end if end >= 0 else -1] += sign
    return row


def coulomb_accelerations(scene, base):
    """Accelerations of the bodies at rest: with D a the accelerations of the ties and L their forces, M a =
    F - D' L has the least a' M a / 2 of all admissible L (Moreau): bounded least squares.
    """
    masses = np.array([body.m for body in scene.bodies] + [HEAVY])
    F = np.zeros(len(masses))
    F[-1] = HEAVY * base
    for force in scene.forces:
        F[force.on] += force.constant
    ties = [*scene.frictions, *scene.stops]
    D = np.array([sides(scene, tie) for tie in ties])
    low = [-tie.backward if isinstance(tie, Friction) else -np.inf if tie.sense > 0 else 0.0 for tie in ties]
    high = [tie.forward if isinstance(tie, Friction) else 0.0 if tie.sense > 0 else np.inf for tie in ties]
    scaled = D / np.sqrt(masses)
    solution = lsq_linear(scaled.T, F / np.sqrt(masses), (low, high), method="bvls", tol=1e-14)
    return ((F - D.T @ solution.x) / masses)[:-1]


def scene_at_rest(rng):
    """Three to eight bodies at rest that rub on each other, on the ground and on a base that turns round,
    some of them on rigid stops.
    """
    n, base, places = rng.randint(3, 8), "", ["ground"]
    if rng.random() < 0.4:
        places = ["ground", "base"]
        base = f"base: {{a: {rng.uniform(0.01, 0.3)} m, omega: 1 Hz, phase: 90 deg}}"
    names = [f"b{i}" for i in range(n)]
    pairs = [(P, Q) for i, P in enumerate(names) for Q in [*names[i + 1 :], *places] if rng.random() < 0.9]
    frictions = [
        f"f{P}_{Q}: {{between: [{P}, {Q}], N: {rng.uniform(0.1, 2.0)} N, plus: {{mu: 1}}, "
        f"minus: {{mu: {rng.choice((1, 0.5))}}}}}"
        for P, Q in pairs
    ]
    stops = [
        f"r{k}: {{between: [b{k}, ground], gap: 0 m, "
        f"acts: {rng.choice(('extension', 'compression'))}, law: rigid, e: 0.5}}"
        for k in range(rng.choice((0, 0, 2)))
    ]
    return scene_of(f"""
bodies: {{{", ".join(f"{name}: {rng.uniform(0.5, 2.0)} kg" for name in names)}}}
stops: {{{", ".join(stops)}}}
friction: {{{", ".join(frictions)}}}
forces: {{{", ".join(f"F{name}: {{on: {name}, F0: {rng.uniform(-12, 12)} N}}" for name in names)}}}
{base}
run: {{t_end: 1 s}}
""")


def test_ties_obey_coulombs_law(monkeypatch):
    """Accelerations behind the start, where everything stands: unique, and those of the least energy."""
    descents, descend = [], StickSlipResolution._descend
    monkeypatch.setattr(StickSlipResolution, "_descend", lambda *args: descents.append(1) or descend(*args))
    rng = random.Random(30)
    for _ in range(40):
        scene = scene_at_rest(rng)
        table = ModeTable(scene)
        automaton = Automaton(scene, table.maker, Expansion(scene, table), lambda *_: None)
        state = start_of(scene, Doubles)
        status, _ = automaton.initial(state)
        base = -sum(term.amplitude * term.omega**2 for term in scene.base)
        ours = automaton.settling._accelerations(state, status)[: len(scene.bodies)]
        assert ours == pytest.approx(coulomb_accelerations(scene, base), rel=1e-6, abs=1e-7)
    assert len(descents) > 15  # the ties of one cut after the other are not always enough


def excess(scene, row):
    """By how much, at least, a tie that holds has to exceed its limit [N]; and the largest error of a
    velocity of slip [m/s], which has the sign of its status, or is 0.
    """
    n = len(scene.bodies)
    masses = np.array([body.m for body in scene.bodies])
    x, v = ([row[f"{name}_{body.name}"] for body in scene.bodies] for name in "xv")
    F = np.zeros(n)
    for link in scene.links:
        F[link.P] -= link.k * x[link.P]
    for force in scene.forces:
        F[force.on] += sum(one.amplitude * np.sin(one.omega * row["time"] + one.phase) for one in force.terms)
    D, limits, wrong = [], [], 0.0
    for friction, column in zip(scene.frictions, part_columns(scene), strict=True):
        side, sense = sides(scene, friction)[:n], row[column]
        slip = side @ v
        if sense == STICK:
            D.append(side)
            limits.append(friction.limits[0])
            wrong = max(wrong, abs(slip))
        else:
            F -= sense * friction.forward * side
            wrong = max(wrong, -sense * slip)
    # unknown: accelerations, forces of the ties that hold, excess; such ties have no acceleration
    D, k = np.array(D).reshape(-1, n), len(D)
    balance = np.hstack([np.diag(masses), D.T, np.zeros((n, 1))])
    together = np.hstack([D, np.zeros((k, k + 1))])
    within = np.vstack([np.hstack([np.zeros((k, n)), s * np.eye(k), -np.ones((k, 1))]) for s in (1, -1)])
    found = linprog(
        [0.0] * (n + k) + [1.0],
        within,
        limits + limits,
        np.vstack([balance, together]),
        [*F, *[0.0] * k],
        [(None, None)] * (n + k) + [(0.0, None)],
    )
    return found.fun, wrong


def test_eight_bodies_that_rub_on_each_other(eight):
    """29 frictions that hold more than they slip with: once they were tried in 3^29 combinations."""
    case = load_case(eight)
    scene = case.scene()
    fast = run(scene, ledger=True)
    assert fast.samples["time"][-1] == 3.0
    assert abs(fast.totals["energy_residual"]) < 1e-12
    slipping = [np.count_nonzero(fast.samples[name]) for name in part_columns(scene)]
    assert sum(count > 0 for count in slipping) > 5
    for i in range(0, len(fast.samples["time"]), 5):
        row = {name: column[i] for name, column in fast.samples.items()}
        over, wrong = excess(scene, row)
        assert over < 1e-9 and wrong < 1e-14


def test_modes_that_are_forgotten_come_back(monkeypatch):
    """A run that keeps no modes has the bits of one that keeps them all."""
    scene = scene_of(rubbing_bodies(4, driven=4))
    kept = run(scene, ledger=True)
    monkeypatch.setattr(c_engine, "MOST_BYTES", 0)
    monkeypatch.setattr(row_maker, "MOST_EVENTS", 0)
    for name in ("MOST_BYTES", "MOST_RULES"):
        monkeypatch.setattr(mode_table, name, 0)
    mode_table._tables.clear()
    assert differences(kept, run(scene, ledger=True)) == []
    mode_table._tables.clear()


def test_modes_without_end_take_bounded_memory(monkeypatch):
    """Of hundreds of modes, each with up to 62 cuts, C and Python hold no more than they may."""
    mode_table._tables.clear()
    for module, name, most in ((c_engine, "MOST_BYTES", 200_000), (mode_table, "MOST_BYTES", 200_000)):
        monkeypatch.setattr(module, name, most)
    monkeypatch.setattr(row_maker, "MOST_EVENTS", 4000)
    met, forget = set(), c_engine.CRun._forget_modes
    monkeypatch.setattr(c_engine.CRun, "_forget_modes", lambda run: (met.update(run.statuses), forget(run)))
    trajectory = open_trajectory(scene_of(rubbing_bodies(6, driven=6)))
    engine = trajectory.run
    for _ in trajectory.blocks():
        assert engine.told <= 200_000 + 20_000  # one of them
        assert sum(1 + len(rows.events) for rows in engine.table.maker.by_status.values()) <= 4000
        assert sum(map(mode_table.bytes_of, engine.table._packed.values())) <= 200_000
    assert len(met | {*engine.statuses}) > 100 > 2 * len(engine.statuses) > 0
    mode_table._tables.clear()


def test_more_cuts_than_are_counted_end_with_a_sentence(tmp_path):
    """Thirteen bodies that rub on each other and one on the ground: 2^13 - 1 sets of them can be cut off."""
    path = tmp_path / "thirteen.yaml"
    path.write_text(rubbing_bodies(13))
    with pytest.raises(
        EngineError, match=r"t = 0.0 s: bodies hold each other .* more than 4095 .*: b0, b1, "
    ):
        run(load_case(path).scene())


def test_forty_bodies_in_a_row_are_held_by_their_neighbours():
    """On the ground and side by side: 820 rows of neighbours can slip as one."""
    n = 40
    edges = [(i, n) for i in range(n)] + [(i, i + 1) for i in range(n - 1)]
    assert connected_sides(range(n), edges, n) == [
        tuple(range(first, first + size)) for size in range(1, n + 1) for first in range(n - size + 1)
    ]
    with pytest.raises(TooManyCuts):
        connected_sides(range(13), list(combinations(range(14), 2)), 13)


def hangs_together(columns, edges):
    reached, ahead = set(), [min(columns)]
    while ahead:
        reached.add(c := ahead.pop())
        ahead += [b for pair in edges for a, b in (pair, pair[::-1]) if a == c and b in columns - reached]
    return reached == columns


def test_cuts_are_all_that_leave_two_sides_that_hang_together():
    rng = random.Random(7)
    for _ in range(200):
        n = rng.randint(2, 6)
        columns = rng.sample(range(n), n)
        edges = [(columns[i], rng.choice(columns[:i])) for i in range(1, n)]
        edges += [tuple(rng.sample(columns, 2)) for _ in range(rng.randint(1, 2 * n))]
        reference, others = columns[0], sorted(columns[1:])
        assert connected_sides(others, edges, reference) == [
            side
            for size in range(1, n)
            for side in combinations(others, size)
            if hangs_together(set(side), edges) and hangs_together(set(columns) - set(side), edges)
        ]


def test_a_decision_without_end_hears_that_it_is_to_stop(eight, tmp_path, monkeypatch):
    """What was computed before it is kept, its energy accounted for, and no thread goes on."""

    asked = []  # by the decision whether it is to stop

    def forever(settling, state, candidate, *rest):
        while True:
            settling.departures.enter(state, candidate)
            asked.append(1)

    monkeypatch.setattr(StickSlipResolution, "_descend", forever)
    result = simulate_to_file(eight, tmp_path / "eight.h5", watch=lambda _: len(asked) < 100)
    assert not result.complete
    assert len(result) == 39 and result.time[-1] == 0.38
    assert abs(result.attrs["energy_residual"]) < 1e-12
    assert not [one for one in threading.enumerate() if one.name.startswith("vibsim")]
