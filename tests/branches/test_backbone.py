"""Backbone curves: free vibrations without loss over their energy, against closed forms."""

import json
from math import acos, pi, sqrt

import numpy as np
import pytest

import vibsim
from tests.command_line.made import call
from vibsim.cases import load_case
from vibsim.orbits import ReturnMap
from vibsim.orbits.branches.branch import read_branch
from vibsim.orbits.branches.continuing import continue_branch
from vibsim.orbits.branches.node import Conserved
from vibsim.orbits.branches.plan import BranchError, read_energy_span

FREE = {"excitation": "none", "coupling.c": "0", "friction": "none"}
FREE_WORDS = ["I-A", *(f"-s{key}={value}" for key, value in FREE.items()), "-s"]
K1, K2, MASS = 200.0, 12400.0, 1 / (1 / 0.297 + 1 / 2.94)  # of the paper's machine
W1, W2 = sqrt(K1 / MASS), sqrt((K1 + K2) / MASS)


def frequency(a, G):
    """Of the machine with the free amplitude a [m] before its stop at G: half a swing takes t1 without
    contact and t2 with it.
    """
    if a <= G:
        return W1 / (2 * pi)
    d, V = G * K1 / (K1 + K2), a * W1 * sqrt(1 - (G / a) ** 2)
    return 1 / (2 * (acos(-G / a) / W1 + acos(d / sqrt(d**2 + (V / W2) ** 2)) / W2))


@pytest.fixture(scope="module")
def machine(tmp_path_factory):
    path = tmp_path_factory.mktemp("backbone") / "machine.h5"
    case = load_case("I-A", FREE | {"x1": "1.2 mm"})
    return continue_branch(case, energy="0.08:0.6 mJ", out=path), path


def test_the_machine_against_the_closed_form(machine):
    branch, _ = machine
    amplitudes = np.sqrt(2 * branch["parameter"] / K1)
    exact = [frequency(a, 1e-3) for a in amplitudes]
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
    assert call("plot", path, "-o", tmp_path / "backbone.png").exit_code == 0
    shown = call("info", path).stdout
    assert "orbits of 1 swing over energy from 8e-5 to 0.0006 J" in shown and "frequency" in shown
    run = vibsim.simulate(branch.case_at(0))
    assert run["x1"][0] - run["x2"][0] == pytest.approx(branch["x1-x2"][0], rel=1e-12)


def test_without_a_gap_the_frequency_is_bilinear():
    """V3: 2 f1 f2 / (f1 + f2) = 7.6975 Hz at every energy."""
    case = load_case("I-A", FREE | {"G": "0 mm", "x1": "1 mm"})
    branch = continue_branch(case, energy="0.05:0.2 mJ")
    f1, f2 = W1 / (2 * pi), W2 / (2 * pi)
    np.testing.assert_allclose(1 / branch["period"], 2 * f1 * f2 / (f1 + f2), rtol=1e-12)
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
    of_run, of_file = (
        continue_branch(one, energy="0.08:0.6 mJ", max_points=3) for one in (run, str(tmp_path / "run.h5"))
    )
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
    done = call("continue", *words)
    assert done.exit_code == code and message in done.stderr and "Traceback" not in done.stderr


def test_the_command(tmp_path):
    words = [*FREE_WORDS, "x1=1.2mm"]
    told = json.loads(
        call("continue", *words, "--energy", "0.1:0.2 mJ", "-o", tmp_path / "b.h5", "--json").stdout
    )
    assert told["key"] == "energy" and told["unit"] == "J" and told["parameter_to"] == pytest.approx(2e-4)


def test_units_of_energies():
    assert read_energy_span("5:50 mJ") == pytest.approx((5e-3, 5e-2))
    assert read_energy_span("1e-5:0.1") == read_energy_span("1e-5:0.1J") == (1e-5, 0.1)
    for text in ("1:2 N", "a:b", "1:2:3", "", "1 J:2 J J"):
        with pytest.raises(BranchError, match="is not FROM:TO"):
            read_energy_span(text)
