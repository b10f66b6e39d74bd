"""A branch has a kink where a sliding velocity comes to touch zero; it goes on behind it."""

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.polynomial import Polynomial
from scipy.optimize import minimize_scalar

import vibsim
from tests.command_line.made import call
from vibsim.cases import load_case
from vibsim.orbits import find_orbit, search_orbits
from vibsim.orbits.branches.branch import Branch, branch_lines, facts, read_branch
from vibsim.orbits.branches.continuing import continue_branch
from vibsim.orbits.branches.inspection import _gathered
from vibsim.orbits.branches.interpolant import _newton
from vibsim.orbits.branches.order_change import _zero
from vibsim.orbits.branches.special_points import STICKING, UNRESOLVED, Special
from vibsim.orbits.words import LETTERS

BELT = 0.7235  # [m/s]
SCENE = """
name: kink
bodies: {a: 0.8132 kg, b: 1.509 kg}
links:
  l0: {between: [a, ground], k: 50.56 N/m, c: 0.1555 N s/m}
  l1: {between: [b, a], k: 26.11 N/m, c: 0.3471 N s/m}
stops:
  s0: {between: [b, a], gap: 0.1566 m, acts: extension, k: 559.9 N/m, c: 0.3112 N s/m, release: force}
  s1: {between: [b, ground], gap: -0.04324 m, acts: extension, k: 1264 N/m, c: 1.786 N s/m, release: force}
friction:
  f0: {between: [b, ground], N: 1.24 N, belt: 0.7235 m/s, law: stribeck exponential, mu_s: 0.6452,
    mu_d: 0.2708, v0: 0.7119 m/s}
forces: {p: {on: a, A: 12.3 N, omega: 0.8499 Hz, phase: 46.16 deg}}
run: {t_end: 60 s, every: 20 ms}
"""
STATE = {"x_a": 0.1287625, "v_a": 5.7147503, "x_b": 0.4531174, "v_b": 0.8672522}


@pytest.fixture(scope="module")
def branch():
    case = load_case(SCENE)
    return vibsim.continue_branch(
        find_orbit(case.scene(), STATE, 1, case=case), "bodies.a", "0.813:0.8133 kg"
    )


def test_it_goes_on_behind_a_kink(branch):
    """The tangent turns by 0.45 there: steps across it were refused as too sharp, until none was left."""
    assert dict(branch.lines())["ends"] == "end of the range"
    assert dict(branch.lines())["index check"] == "holds everywhere"
    assert branch["parameter"][-1] == pytest.approx(0.8133, rel=1e-15)
    (stick,) = branch.specials
    assert stick.kind == "sticking" and len(stick.after) == len(stick.before) + 2


def test_there_a_sliding_velocity_touches_zero(branch):
    """On the orbit at the special point, by its least distance from the speed of the belt."""
    (stick,) = branch.specials
    state = dict(zip(branch.names, stick.orbit.state, strict=True))
    case = branch.case.with_values({"bodies.a": f"{stick.parameter!r} kg"})
    run = vibsim.simulate(
        case.with_values(
            {
                f"initial.{name[2:]}.{name[0]}": f"{value!r} {'m' if name[0] == 'x' else 'm/s'}"
                for name, value in state.items()
            }
        )
    )
    times = np.linspace(0.04, 0.08, 9)  # [s]
    at = min(times, key=lambda t: abs(run.at(t)["v_b"] - BELT))
    least = minimize_scalar(
        lambda t: run.at(t)["v_b"] - BELT,
        bounds=(at - 0.01, at + 0.01),
        method="bounded",
        options={"xatol": 1e-9},
    )
    assert abs(least.fun) < 1e-8


# Changes of the order of events, located by what goes to zero there.


KINDS = {letter: kind for kind, letter in LETTERS.items()}


@pytest.mark.parametrize("power", [1.0, 0.5])
def test_a_zero_is_told_from_one_side(power):
    """A contact's time goes like the root of the way to the graze, a stick's like the way itself."""
    zero = 0.731
    doubt, told = _zero([((zero - share) ** power, share) for share in (0.0, 0.5, 0.7)])
    assert told == pytest.approx(zero, abs=1e-13) and doubt < 1e-12


def test_a_zero_with_a_bend_is_doubted_as_much_as_it_is_wrong():
    """The doubt, by which nodes are put beside the place, is no less than the error."""
    zero = 0.731
    doubt, told = _zero([((zero - s) ** 0.5 * (1 + 0.1 * (zero - s)), s) for s in (0.0, 0.5, 0.7)])
    assert 1e-6 < abs(told - zero) < doubt < 0.1


def test_a_polynomial_goes_through_places_and_slopes():
    """Newton's divided differences with places that count twice: the cubic itself, and of a third place."""
    cubics = [Polynomial([0.3, -1.0, 2.0, 0.7]), Polynomial([1.0, 0.5, 0.0, -3.0])]

    def at(share, order=0):
        return np.array([cubic.deriv(order)(share) if order else cubic(share) for cubic in cubics])

    rows = [(share, at(share), at(share, 1)) for share in (0.0, 1.0)]
    np.testing.assert_allclose(_newton(rows, 0.3), at(0.3), atol=1e-15)
    np.testing.assert_allclose(_newton([*rows, (0.6, at(0.6), None)], 0.3), at(0.3), atol=1e-14)


def node_at(place, letters, smallest=1.0):
    """A node of one unknown and the parameter, whose equations have this smallest singular value."""
    point = SimpleNamespace(jacobian=lambda: np.array([[smallest, 0.0]]))
    word = tuple((KINDS[letter], 0) for letter in letters)
    return SimpleNamespace(z=np.array([place, 1.0]), word=word, ahead=1.0, level=False, point=point)


def change_at(place, before, after, smallest=1.0):
    """A change of the order of events between two words."""
    ends = (node_at(place, word, smallest) for word in (before, after))
    return Special(STICKING, node_at(place, after, smallest), *ends)


def told(*specials):
    return [(one.node.z[0], spelled(one.before.word), spelled(one.after.word)) for one in _gathered(specials)]


def spelled(word):
    return "".join(LETTERS[kind] for kind, _ in word)


@pytest.mark.parametrize(("smallest", "count"), [(5e-7, 1), (1e-3, 2)])
def test_changes_nearer_than_orbits_are_known_are_one(smallest, count):
    """Beside a family of orbits Newton's method leaves open where one lies: by 1e-12 over the smallest
    singular value. Two slips that come at once on each side of a symmetric orbit came up 7e-8 apart there.
    """
    listed = told(change_at(0.0, "", "su", smallest), change_at(7e-8, "su", "susu", smallest))
    assert len(listed) == count and listed[0][1] == "" and listed[-1][2] == "susu"


@pytest.mark.parametrize(
    ("first", "second"),
    [(("", "ho"), ("ho", "iho")), (("", "iho"), ("iho", "ho")), (("iho", "ho"), ("ho", ""))],
)
def test_a_landing_with_an_impact_and_without_is_one(first, second):
    """A flight that has just begun lands with the speed of rounding: then the engine tells no impact. The
    change that is one is where the flight begins.
    """
    ((place, before, after),) = told(change_at(0.0, *first), change_at(1e-9, *second))
    assert (before, after) == (first[0], second[1])
    assert place == (1e-9 if first == ("iho", "ho") else 0.0)


def test_what_comes_and_goes_by_rounding_is_none_and_what_lies_apart_stays():
    assert told(change_at(0.0, "", "su", 0.0), change_at(1e-9, "su", "", 0.0)) == []
    assert len(told(change_at(0.0, "", "ho"), change_at(1e-3, "ho", "iho"))) == 2


# The index check along branches of random scenes: what changes between two points is listed, or told of.


FEW, MANY = (0, 1), range(2, 40)


def random_case(seed):
    """One or two bodies on springs before an elastic stop, with or without friction, driven by one force."""
    random = np.random.default_rng(seed)

    def number(low, high):
        return f"{low + (high - low) * random.random():.4g}"

    two, rubs = random.random() < 0.5, random.random() < 0.5
    bodies = ["m: 1 kg"] + [f"b: {number(0.5, 3)} kg"] * two
    links = [f"spring: {{between: [m, ground], k: {number(0.5, 2)} N/m, c: {number(0.02, 0.2)} N s/m}}"]
    if two:
        links.append(f"tie: {{between: [m, b], k: {number(0.5, 3)} N/m, c: {number(0.02, 0.2)} N s/m}}")
    stop = f"between: [m, ground], gap: {number(0.2, 1)} m, acts: compression, k: {number(3, 30)} N/m"
    text = [
        f"name: random-{seed}",
        f"bodies: {{{', '.join(bodies)}}}",
        f"links: {{{', '.join(links)}}}",
        f"stops: {{wall: {{{stop}, law: elastic}}}}",
        f"forces: {{drive: {{on: m, A: {number(0.2, 1)} N, omega: {number(0.5, 1.5)} rad/s}}}}",
        "run: {t_end: 400 s, every: 0.5 s}",
    ]
    if rubs:
        text.append(f"friction: {{floor: {{between: [m, ground], N: {number(0.02, 0.2)} N, mu: 1}}}}")
    return load_case("\n".join(text))


def checked(seed, most):
    case = random_case(seed)
    omega = float(case.quantity("drive.omega").value)
    start = search_orbits(case, count=2, seed=seed)[0]
    branch = continue_branch(start, "drive.omega", f"{0.7 * omega}:{1.4 * omega} rad/s", max_points=most)
    index = branch["index"]
    for i in range(len(branch) - 1):
        between = [one for one in branch.specials if one.between == (i, i + 1)]
        if not any(one.kind == UNRESOLVED for one in between):
            assert index[i + 1] - index[i] == sum(one.jump for one in between), branch["parameter"][i]
    return branch


@pytest.mark.parametrize("seed", FEW)
def test_what_changes_is_listed(seed):
    checked(seed, 60)


@pytest.mark.slow
@pytest.mark.parametrize("seed", MANY)
def test_what_changes_is_listed_at_length(seed):
    checked(seed, 120)


def test_it_is_told_in_words_and_on_file(tmp_path):
    """Where it does not hold the parameter is named: in what is printed, in JSON and in the file."""
    case = load_case("gallery/bilinear-oscillator", {"drive.A": "0.355 N"})
    path = tmp_path / "branch.h5"
    branch = continue_branch(case, "drive.A", "0.35:0.37 N", out=path)
    assert dict(branch_lines(branch))["index check"] == "holds everywhere"
    assert facts(branch)["unresolved"] == [] and read_branch(path).attrs["unresolved"] == 0
    points, (first, *rest) = branch.records
    doubtful = Branch(branch.plan, points, [replace(first, kind=UNRESOLVED), *rest], branch.attrs)
    told = dict(branch_lines(doubtful))["index check"]
    assert told.startswith("does not hold at 0.36") and told.endswith(" N")
    assert facts(doubtful)["unresolved"] == [doubtful.special("UR1").parameter]
    assert "index check     holds everywhere" in call("info", path).stdout
    assert json.loads(call("info", path, "--json").stdout)["unresolved"] == []
