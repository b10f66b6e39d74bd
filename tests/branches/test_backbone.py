"""Backbone curves: free vibrations without loss over their energy, against closed forms."""

import json
from math import acos, cos, pi, sin, sqrt

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import brentq

import vibsim
from tests.branches.made import K1, free_frequency, machine_rates
from tests.command_line.made import refused, told
from vibsim.cases import load_case
from vibsim.orbits import ReturnMap
from vibsim.orbits.branches.branch import read_branch
from vibsim.orbits.branches.continuing import continue_branch
from vibsim.orbits.branches.family import Reciprocal, restricted
from vibsim.orbits.branches.node import Conserved
from vibsim.orbits.branches.plan import BranchError, read_energy_span

FREE = {"excitation": "none", "coupling.c": "0", "friction": "none"}
FREE_WORDS = ["I-A", *(f"-s{key}={value}" for key, value in FREE.items()), "-s"]


@pytest.fixture(scope="module")
def machine(tmp_path_factory):
    path = tmp_path_factory.mktemp("backbone") / "machine.h5"
    case = load_case("I-A", FREE | {"x1": "1.2 mm"})
    return continue_branch(case, energy="0.08:0.6 mJ", out=path), path


def test_the_machine_against_the_closed_form(machine):
    branch, _ = machine
    amplitudes = np.sqrt(2 * branch["parameter"] / K1)
    exact = [free_frequency(a) for a in amplitudes]
    assert branch["parameter"][[0, -1]] == pytest.approx([8e-5, 6e-4], rel=1e-14)
    np.testing.assert_allclose(1 / branch["period"], exact, rtol=1e-12)
    assert (np.diff(1 / branch["period"]) > -1e-12).all() and 1 / branch["period"][-1] < 7.6975


def test_it_grazes_where_the_spring_holds_its_energy(machine):
    """E = k1 G^2 / 2."""
    branch, _ = machine
    assert [one.label for one in branch.specials] == ["GR1"]
    assert branch.special("GR1").parameter == pytest.approx(K1 * 1e-6 / 2, rel=1e-12)
    assert (branch["index"] == 0).all() and branch["stable"].all()
    np.testing.assert_allclose(branch["multipliers"], 1.0, atol=1e-6)  # of energy and momentum
    assert np.abs(branch["drift"]).max() < 1e-15


def test_on_file_gone_on_with_and_drawn(machine, tmp_path):
    branch, path = machine
    stored = read_branch(path)
    assert stored.points == branch.points and stored.key == "energy" and stored.unit == "J"
    assert [one.parameter for one in stored.specials] == [one.parameter for one in branch.specials]
    part = continue_branch(branch.case, energy="0.08:0.6 mJ", out=tmp_path / "part.h5", max_points=9)
    assert len(part) < len(branch)
    whole = continue_branch(branch.case, energy="0.08:0.6 mJ", out=tmp_path / "part.h5")
    assert whole.points == branch.points
    told("plot", path, "-o", tmp_path / "backbone.png")
    shown = told("info", path)
    assert "orbits of 1 swing over energy from 8e-5 to 0.0006 J" in shown and "frequency" in shown
    run = vibsim.simulate(branch.case_at(0))
    assert run["x1"][0] - run["x2"][0] == pytest.approx(branch["x1-x2"][0], rel=1e-12)


def test_without_a_gap_the_frequency_is_bilinear():
    """V3: 2 f1 f2 / (f1 + f2) = 7.6975 Hz at every energy."""
    case = load_case("I-A", FREE | {"G": "0 mm", "x1": "1 mm"})
    branch = continue_branch(case, energy="0.05:0.2 mJ")
    w1, w2 = machine_rates(m1=0.297)
    np.testing.assert_allclose(1 / branch["period"], w1 * w2 / (w1 + w2) / pi, rtol=1e-12)
    assert 1 / branch["period"][0] == pytest.approx(7.6975, abs=5e-5) and branch.specials == []


RIGID = """
name: wall
bodies: {m: 1 kg}
links: {spring: {between: [m, ground], k: 1 N/m}}
stops: {wall: {between: [m, ground], gap: 1 m, acts: compression, law: rigid, e: 1}}
initial: {m: {x: -1.5 m}}
run: {t_end: 40 s, every: 0.5 s}
"""


def test_a_rigid_stop_without_loss():
    """Half a swing takes acos(-G / a): the frequency goes from w / (2 pi) to twice that."""
    branch = continue_branch(load_case(RIGID), energy="0.6:2 J")
    amplitudes = np.sqrt(2 * branch["parameter"])
    np.testing.assert_allclose(branch["period"], 2 * np.arccos(-1 / amplitudes), rtol=1e-12)
    assert branch.ends == ("end of the range", "end of the range") and set(branch["word"]) == {"i"}


def test_a_run_and_its_file_begin_as_their_case_does(machine, tmp_path):
    branch, _ = machine
    run = vibsim.simulate(branch.case, overrides={"run.t_end": "1 s"})
    run.save(tmp_path / "run.h5")
    starts = (run, str(tmp_path / "run.h5"))
    of_run, of_file = (continue_branch(one, energy="0.08:0.6 mJ", max_points=3) for one in starts)
    np.testing.assert_array_equal(of_run["period"], of_file["period"])
    assert len(of_file) == 3


CHAIN = """
name: chain
bodies: {a: 1 kg, b: 2 kg}
links: {left: {between: [a, ground], k: 3 N/m}, tie: {between: [a, b], k: 2 N/m}}
stops: {wall: {between: [b, ground], gap: 0.2 m, acts: compression, law: elastic, k: 5 N/m}}
initial: {a: {x: 0.1 m}}
run: {t_end: 40 s, every: 0.5 s}
"""


def test_two_bodies_leave_their_linear_mode_at_the_stop():
    """In front of the stop the frequency is that of the mode; multipliers come as mu and 1 / mu."""
    case = load_case(CHAIN)
    values, shapes = np.linalg.eigh(np.array([[5.0, -2 / sqrt(2)], [-2 / sqrt(2), 1.0]]))
    mode = -shapes[:, 0] * [1, 1 / sqrt(2)] * np.sign(shapes[1, 0]) * 0.2
    orbit = vibsim.orbit(case, start={"x_a": mode[0], "x_b": mode[1], "v_a": 0.0, "v_b": 0.0})
    branch = continue_branch(orbit, energy="0.001:0.5 J")
    linear = branch["word"] == ""
    np.testing.assert_allclose(branch["period"][linear], 2 * pi / sqrt(values[0]), rtol=1e-11)
    assert linear.sum() > 3 and (branch["period"][~linear] < 2 * pi / sqrt(values[0])).all()
    np.testing.assert_allclose(np.prod(branch["multipliers"], axis=1), 1.0, atol=1e-9)
    shape = np.array([mode[0], mode[1]]) / mode[1] * 0.2
    graze = 0.5 * (3 * shape[0] ** 2 + 2 * (shape[0] - shape[1]) ** 2)
    assert branch.special("GR1").parameter == pytest.approx(graze, rel=1e-11)


def test_the_gradient_of_the_energy():
    of = ReturnMap(load_case(CHAIN).scene())
    conserved, X = Conserved(of.scene, of.coordinates), np.array([0.3, 0.4, -0.7])
    beside = [conserved.energy(X + s) - conserved.energy(X - s) for s in 1e-5 * np.eye(3)]
    np.testing.assert_allclose(conserved.gradient(X), np.array(beside) / 2e-5, rtol=1e-9)


@pytest.mark.parametrize(
    ("words", "code", "message"),
    [
        (["I-A", "--energy", "1:2"], 2, "the force "),
        (["II-B", "--energy", "1:2"], 2, "does not keep its energy: the motor, the damper of link"),
        (["gallery/block-on-belt", "--energy", "1:2"], 2, "the friction belt"),
        (["gallery/bouncing-ball", "--energy", "1:2"], 2, "the restitution of stop"),
        (["I-A", "--energy", "1:2", "--omega", "3:4"], 2, "--energy is a range of its own"),
        (["I-A", "--energy", "1"], 2, "is not FROM:TO with an optional unit"),
        (["I-A", "--energy", "2:1 J"], 2, "energies must be above 0 and the first the lesser"),
        ([*FREE_WORDS, "x1=1mm", "--energy", "1:2"], 2, "the start has an energy of 0.0001 J, outside"),
        ([*FREE_WORDS, "x1=0mm", "--energy", "1:2"], 4, "on this run it comes to rest"),
    ],
)
def test_what_is_refused(words, code, message):
    assert message in refused("continue", *words, code=code)


def test_the_command(tmp_path):
    words = [*FREE_WORDS, "x1=1.2mm", "--energy", "0.1:0.2 mJ", "-o", tmp_path / "b.h5"]
    found = json.loads(told("continue", *words, "--json"))
    assert found["key"] == "energy" and found["unit"] == "J"
    assert found["parameter_to"] == pytest.approx(2e-4)


def test_units_of_energies():
    assert read_energy_span("5:50 mJ") == pytest.approx((5e-3, 5e-2))
    assert read_energy_span("1e-5:0.1") == read_energy_span("1e-5:0.1J") == (1e-5, 0.1)
    for text in ("1:2 N", "a:b", "1:2:3", "", "1 J:2 J J"):
        with pytest.raises(BranchError, match="is not FROM:TO"):
            read_energy_span(text)


# Where orbits of a backbone curve lose their stability, against Hill's equation with two values.


TWINS = """
name: twins
bodies: {{a: 1 kg, b: 1 kg}}
links:
  left: {{between: [a, ground], k: 1 N/m}}
  right: {{between: [b, ground], k: 1 N/m}}
  tie: {{between: [a, b], k: {tie} N/m}}
stops:
  one: {{between: [a, ground], gap: 1 m, acts: compression, law: elastic, k: 8 N/m}}
  other: {{between: [b, ground], gap: 1 m, acts: compression, law: elastic, k: 8 N/m}}
initial: {{a: {{x: -{x} m}}, b: {{x: -{x} m}}}}
run: {{t_end: 60 s, every: 0.5 s}}
"""


def twins(tie, energy):
    """Both bodies swing alike: k = 1 N/m in front of their stops at 1 m, 9 N/m beyond; E = a^2."""
    return load_case(TWINS.format(tie=tie, x=sqrt(energy)))


def trace(energy, tie):
    """mu + 1/mu of their difference u: u'' + (1 + 2 tie) u = 0, with 8 more in contact (Meissner 1918)."""
    a, one, other = sqrt(energy), sqrt(1 + 2 * tie), sqrt(9 + 2 * tie)
    if a <= 1:
        return 2 * cos(2 * pi * one)
    apart, joined = 2 * acos(-1 / a), 2 * acos(1 / 9 / sqrt(1 / 81 + (a * a - 1) / 9)) / 3
    free, held = one * apart, other * joined
    return 2 * cos(free) * cos(held) - (one / other + other / one) * sin(free) * sin(held)


@pytest.mark.parametrize(
    ("tie", "kind", "tau", "brackets", "span"),
    [
        (0.75, "doubling", -2, ((4.0, 4.4), (5.6, 6.0)), "3.6:6.4 J"),
        (1.2, "branch point", 2, ((1.01, 1.05), (1.15, 1.25)), "0.9:1.3 J"),
    ],
)
def test_two_bodies_that_swing_alike(tie, kind, tau, brackets, span):
    branch = continue_branch(twins(tie, sum(brackets[1]) / 2 + 0.05), energy=span)
    traces = branch["multipliers"].sum(axis=1).real - 1  # of a pair, beside the 1 of the energy
    np.testing.assert_allclose(traces, [trace(E, tie) for E in branch["parameter"]], atol=1e-10)
    exact = [brentq(lambda E: trace(E, tie) - tau, *bracket, xtol=1e-15, rtol=1e-15) for bracket in brackets]
    told = [one for one in branch.specials if one.kind == kind]
    assert [one.parameter for one in told] == pytest.approx(exact, rel=1e-11)
    assert [one.jump for one in told] == [1, -1]
    between = (branch["parameter"] > exact[0]) & (branch["parameter"] < exact[1])
    assert between.any() and (branch["index"] == between).all() and (branch["stable"] == ~between).all()
    others = [one.parameter for one in branch.specials if one.kind != kind]
    grazes = [1.0] if branch["parameter"].min() < 1 else []  # both graze their stops at once, E = gap^2
    assert others == pytest.approx(grazes, rel=1e-12)
    assert branch.ends == ("end of the range", "end of the range")


MIRRORED = """
name: mirrored
bodies: {m: 1 kg}
links: {spring: {between: [m, ground], k: 1 N/m}}
stops:
  right: {between: [m, ground], gap: 1 m, acts: extension, law: elastic, k: 3 N/m}
  left: {between: [m, ground], gap: 1 m, acts: compression, law: elastic, k: 3 N/m}
initial: {m: {x: 0.9 m}}
run: {t_end: 100 s, every: 0.5 s}
"""


def test_stops_on_both_sides_are_grazed_at_one_energy():
    """A mirrored oscillator meets both where k gap^2 / 2 is its energy: one graze."""
    branch = continue_branch(MIRRORED, energy="0.3:2 J")
    (graze,) = branch.specials
    assert graze.kind == "grazing" and graze.parameter == pytest.approx(0.5, rel=1e-12)
    assert [branch.spelled(word) for word in (graze.before, graze.after)] == ["", "b1 e1 b2 e2"]


def hamiltonian(detuning):
    """The map over unit time of two oscillators, the second with negative energy, coupled by 0.1."""
    energy = np.diag([1.0, -1.0 - detuning, 1.0, -1.0 - detuning])
    energy[0, 1] = energy[1, 0] = 0.1
    return expm(np.block([[np.zeros((2, 2)), np.eye(2)], [-np.eye(2), np.zeros((2, 2))]]) @ energy)


@pytest.mark.parametrize("detuning", [-0.4, -0.2, -0.05, 0.0, 0.05, 0.2, 0.4])
def test_four_multipliers_leave_the_circle_where_two_pairs_meet(detuning):
    """Krein: pairs of opposite signature; near resonance they are a quadruple."""
    matrix = hamiltonian(detuning)
    pairs, exact = Reciprocal(matrix), np.linalg.eigvals(matrix)
    outside = int((abs(exact) > 1 + 1e-6).sum())
    assert pairs.outside == outside == (2 if abs(detuning) < 0.1 else 0)
    assert (pairs.collision < 0) == (outside == 2)
    told = np.array(pairs.multipliers)
    assert all(abs(told - mu).min() < 1e-12 for mu in exact)
    assert pairs.fold == pytest.approx(np.linalg.det(np.eye(4) - matrix), rel=1e-10)
    assert pairs.doubling == pytest.approx(np.linalg.det(np.eye(4) + matrix), rel=1e-10)


def test_what_is_kept_is_taken_out():
    """A map with left eigenvectors of 1 has the other multipliers on what is orthogonal to them."""
    rng = np.random.default_rng(5)
    basis = rng.normal(size=(6, 6))
    blocks = np.eye(6)
    blocks[2:, 2:] = hamiltonian(0.4)
    blocks[2:, :2] = rng.normal(size=(4, 2))
    matrix = np.linalg.inv(basis) @ blocks @ basis
    inner = restricted(matrix, basis[:2])
    exact = np.linalg.eigvals(hamiltonian(0.4))
    assert all(abs(np.linalg.eigvals(inner) - mu).min() < 1e-12 for mu in exact)


def test_bodies_that_move_alike_have_one_order_of_events():
    """Which of two blows at one instant comes first is not told by rounding: no change of order is listed."""
    branch = continue_branch(twins(0.3, 5.0), energy="4.5:6 J")
    assert set(branch["word"]) == {"b1 b2 e1 e2"} and branch.specials == []


ROW_OF_THREE = """
name: chain
bodies: {a: 1 kg, b: 1.09 kg, c: 1.28 kg}
links:
  held: {between: [a, ground], k: 1 N/m}
  one: {between: [a, b], k: 1.58 N/m}
  two: {between: [b, c], k: 1.97 N/m}
stops: {wall: {between: [c, ground], gap: 1 m, acts: compression, law: elastic, k: 9.38 N/m}}
initial: {a: {x: -0.1 m}}
run: {t_end: 40 s, every: 0.5 s}
"""
MASSES = np.array([1, 1.09, 1.28])
STIFFNESS = np.array([[2.58, -1.58, 0], [-1.58, 3.55, -1.97], [0, -1.97, 1.97]])


def flow(joined):
    """The matrix of the chain's motion (x, v), and what the stop at 1 m adds."""
    matrix, constant = np.zeros((7, 7)), 9.38 / 1.28 if joined else 0.0
    matrix[:3, 3:6] = np.eye(3)
    matrix[3:6, :3] = -STIFFNESS / MASSES[:, None]
    matrix[5, 2] -= constant
    matrix[5, 6] = constant
    return matrix


def swing(state, period):
    """Where a swing through the stop leads, and its derivative by the start: matrix exponentials, the contact
    between by its ends (an elastic stop leaves disturbances as they are).
    """
    free, held = flow(False), flow(True)
    start = np.array([*state, 1.0])

    def gap(matrix, begin, t):
        return (expm(matrix * t) @ begin)[2] - 1

    times = np.linspace(0, period, 200)
    first = next(i for i, t in enumerate(times) if gap(free, start, t) > 0)
    begins = brentq(lambda t: gap(free, start, t), times[first - 1], times[first], xtol=1e-15)
    struck = expm(free * begins) @ start
    last = next(t for t in times[1:] if gap(held, struck, t) < 0)
    lasts = brentq(lambda t: gap(held, struck, t), last - times[1], last, xtol=1e-15)
    whole = expm(free * (period - begins - lasts)) @ expm(held * lasts) @ expm(free * begins)
    return (whole @ start)[:6], whole[:6, :6]


def discriminant(matrix):
    """Of the two traces beside the multipliers 1, 1 of time and energy: negative for a quadruple."""
    quartic, _ = np.polydiv(np.poly(matrix), [1.0, -2.0, 1.0])
    return (quartic[1] + quartic[3]) ** 2 / 4 - 4 * (quartic[2] - 2)


@pytest.mark.slow
def test_four_multipliers_of_a_chain_leave_the_circle():
    """Where vibsim says Neimark-Sacker, matrix exponentials have two equal traces; between, a quadruple."""
    case = load_case(ROW_OF_THREE)
    _, shapes = np.linalg.eigh(STIFFNESS / np.sqrt(np.outer(MASSES, MASSES)))
    mode = shapes[:, 0] / np.sqrt(MASSES)
    mode *= -0.95 / mode[2]
    names = [f"{quantity}_{body}" for quantity in "xv" for body in "abc"]
    orbit = vibsim.orbit(case, start=dict(zip(names, [*mode, 0.0, 0.0, 0.0], strict=True)))
    branch = continue_branch(orbit, energy="0.12:0.53 J", max_points=120)
    points = [one for one in branch.specials if one.kind == "neimark-sacker"]
    assert [one.jump for one in points] == [2, -2]
    for one in points:
        state = dict(zip(branch.names, one.orbit.state, strict=True)) | {"v_a": 0.0}
        end, matrix = swing([state[name] for name in names], one.period)
        np.testing.assert_allclose(end, [state[name] for name in names], atol=1e-11)
        assert discriminant(matrix) == pytest.approx(0, abs=1e-8)
    for i in np.flatnonzero(branch["word"] == "be"):
        state = {name: branch[name][i] for name in branch.names} | {"v_a": 0.0}
        _, matrix = swing([state[name] for name in names], branch["period"][i])
        assert branch["index"][i] == (2 if discriminant(matrix) < 0 else 0)
    assert set(branch["index"]) == {0, 2}
