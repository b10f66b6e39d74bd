"""A branch has a kink where a sliding velocity comes to touch zero; it goes on behind it."""

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.polynomial import Polynomial
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, minimize_scalar

import vibsim
from tests.branches.made import word
from tests.command_line.made import call
from vibsim.cases import load_case
from vibsim.orbits import find_orbit, search_orbits
from vibsim.orbits.branches.branch import Branch, branch_lines, facts, read_branch
from vibsim.orbits.branches.continuing import continue_branch
from vibsim.orbits.branches.inspection import _gathered
from vibsim.orbits.branches.interpolant import _newton
from vibsim.orbits.branches.order_change import _zero
from vibsim.orbits.branches.special_points import STICKING, UNRESOLVED, Special
from vibsim.orbits.search import orbit
from vibsim.orbits.words import LETTERS
from vibsim.physics.parts import EVENT_KINDS
from vibsim.results.simulation import simulate

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
    start = find_orbit(case.scene(), STATE, 1, case=case)
    return vibsim.continue_branch(start, "bodies.a", "0.813:0.8133 kg")


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
    values = {"bodies.a": f"{stick.parameter!r} kg"}
    for name, value in zip(branch.names, stick.orbit.state, strict=True):
        values[f"initial.{name[2:]}.{name[0]}"] = f"{value!r} {'m' if name[0] == 'x' else 'm/s'}"
    run = vibsim.simulate(branch.case.with_values(values))

    def over_belt(t):
        return run.at(t)["v_b"] - BELT

    at = min(np.linspace(0.04, 0.08, 9), key=lambda t: abs(over_belt(t)))  # [s]
    least = minimize_scalar(over_belt, bounds=(at - 0.01, at + 0.01), options={"xatol": 1e-9})
    assert abs(least.fun) < 1e-8


# Changes of the order of events, located by what goes to zero there.


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
    return SimpleNamespace(z=np.array([place, 1.0]), word=word(letters), ahead=1.0, level=False, point=point)


def change_at(place, before, after, smallest=1.0):
    """A change of the order of events between two words."""
    ends = (node_at(place, letters, smallest) for letters in (before, after))
    return Special(STICKING, node_at(place, after, smallest), *ends)


def told(*specials):
    return [(one.node.z[0], spelled(one.before.word), spelled(one.after.word)) for one in _gathered(specials)]


def spelled(events):
    return "".join(LETTERS[kind] for kind, _ in events)


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
    check = dict(branch_lines(doubtful))["index check"]
    assert check.startswith("does not hold at 0.36") and check.endswith(" N")
    assert facts(doubtful)["unresolved"] == [doubtful.special("UR1").parameter]
    assert "index check     holds everywhere" in call("info", path).stdout
    assert json.loads(call("info", path, "--json").stdout)["unresolved"] == []


# Corners and kinks of branches where sticking and impacts meet, beside an integrator of its own.


SLIPPING = """
name: belt
bodies: {m: 1 kg}
links: {s: {between: [m, ground], force: "k*d + k3*d**3", k: 1 N/m, k3: 0.2 N/m^3}}
stops: {w: {between: [m, ground], law: rigid, gap: 1.2 m, acts: compression, e: 0.6}}
friction: {f: {between: [m, ground], N: 1 N, mu: "mud + (mus - mud)*exp(-s/vs)", mud: 0.5, mus: 1,
               vs: 0.5 m/s, belt: 1.44 m/s}}
initial: {m: {v: 1 m/s}}
run: {t_end: 200 s, every: 50 ms}
"""
SHAKEN = """
name: shaken
bodies: {m: 1 kg}
links: {s: {between: [m, base], k: 20 N/m, c: 0.3 N s/m}}
stops: {w: {between: [m, base], law: rigid, gap: 5 mm, acts: compression, e: 0.6}}
friction: {f: {between: [m, ground], N: 1 N, mu: 0.255}}
base: {a: 10 mm, omega: 1 Hz}
run: {t_end: 200 s, every: 20 ms}
"""
DRIVEN = """
name: driven
bodies: {m: 1 kg}
links: {s: {between: [m, ground], force: "k*d + k3*d**3 + c*v", k: 1 N/m, k3: 0.3 N/m^3, c: 0.1 N s/m}}
stops: {w: {between: [m, ground], law: rigid, gap: 0 m, acts: compression, e: 0.7}}
friction: {f: {between: [m, ground], N: 1 N, mu: 0.1}}
forces: {d: {on: m, A: 1 N, omega: 1.3 rad/s}}
run: {t_end: 400 s, every: 50 ms}
"""

MOTOR = """
name: motor
bodies: {f: 2 kg}
links: {s: {between: [f, ground], k: 3 kN/m, c: 4 N s/m}}
stops: {w: {between: [f, ground], law: rigid, gap: 3 mm, acts: compression, e: 0.5}}
friction: {g: {between: [f, ground], N: 10 N, mu: 0.3}}
rotors: {r: {on: f, m: 0.1 kg, e: 30 mm, J: 1e-3 kg m^2, M0: 0.5 N m, Omega0: 8 Hz}}
initial: {r: {w: 6 Hz}}
run: {t_end: 20 s, every: 5 ms}
"""


def slip_back(x, v, belt, gap):
    """Slip on the belt from (x, v) over an impact at the gap, if there is one ahead: (x, v) where the slip
    velocity next turns before zero, or where the gap is met again.
    """

    def rates(t, y):
        slip = y[1] - belt
        force = 0.5 + 0.5 * np.exp(-abs(slip) / 0.5)
        return [y[1], force - y[0] - 0.2 * y[0] ** 3]

    def wall(t, y):
        return y[0] - gap

    def turn(t, y):
        return rates(t, y)[1]

    wall.direction, wall.terminal, turn.direction, turn.terminal = 1, True, -1, True
    options = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-13}
    if x < gap:
        x, v = solve_ivp(rates, [0, 20], [x, v], events=[wall], **options).y[:, -1]
    start = [x - 1e-14, -0.6 * v]
    return solve_ivp(rates, [0, 20], start, events=[wall, turn], **options).y[:, -1]


def test_a_cycle_that_slips_has_a_fold_beside_the_corner():
    """The corner is where the slip from the place at which the spring is as strong as what holds just comes
    back to the belt; the orbits that slip all the time end in a fold 4.5e-5 m/s below it.
    """
    branch = continue_branch(load_case(SLIPPING), "friction.f.belt", "1.44:1.46 m/s")
    (held,) = (root.real for root in np.roots([0.2, 0, 1, -1]) if abs(root.imag) < 1e-9)
    corner = brentq(lambda belt: slip_back(held, belt - 1e-13, belt, 1.2)[1] - belt, 1.44, 1.46, xtol=1e-11)
    assert [one.label for one in branch.specials] == ["CO1", "F1"]
    assert branch.special("CO1").parameter == pytest.approx(corner, abs=2e-9)
    assert 4e-5 < branch.special("CO1").parameter - branch.special("F1").parameter < 5e-5
    assert [one.jump for one in branch.specials] == [1, -1]
    assert branch.ends == ("end of the range", "end of the range") and set(branch["word"]) == {"isu", "i"}


def test_a_stick_that_begins_just_before_an_impact_is_born_at_a_kink():
    """The mass comes to the wall as fast as the belt; the slope of the branch jumps from 0.6 to 170 there."""
    start = SLIPPING.replace("1.2 m,", "0.836 m,").replace("1.44 m/s", "1 m/s")
    branch = continue_branch(load_case(start), "stops.w.gap", "0.834:0.837 m")
    kink = brentq(lambda gap: slip_back(gap, 1.0, 1.0, gap)[1] - 1.0 + 1e-13, 0.834, 0.837, xtol=1e-11)
    (born,) = branch.specials
    assert born.kind == "sticking"
    assert {branch.spelled(born.before), branch.spelled(born.after)} == {"i", "ius"}
    assert born.parameter == pytest.approx(kink, abs=1e-9)
    assert branch.ends == ("end of the range", "end of the range")


def test_sticking_until_an_impact_ends_orbits_at_a_corner():
    """Orbits that reverse at the impact, and those that stick until it, end each other: one multiplier is on
    one side of 1 and on the other, and both exist on one side of the corner only.
    """
    branch = continue_branch(load_case(SHAKEN), "friction.f.mu", "0.254:0.266")
    corner = branch.special("CO1")
    beside = [corner.between[0] - 1, corner.between[1] + 1]
    one, other = branch["multipliers"][beside].real.max(axis=1)
    assert (one - 1) * (other - 1) < 0 and corner.jump == -1
    assert np.all(branch["parameter"][beside] > corner.parameter)
    assert branch.ends == ("end of the range", "end of the range")


def test_a_rigid_stop_is_grazed_where_friction_reverses():
    """Friction between the ends of a stop reverses where the gap turns; the graze there is told as any other.
    Beyond it the case's own start is inside the stop, and an orbit of the branch can be run all the same.
    """
    branch = continue_branch(load_case(DRIVEN), "stops.w.gap", "-0.2:0 m")
    (graze,) = branch.specials
    assert graze.kind == "grazing" and branch.ends[0].startswith("a rigid stop is grazed")
    assert (branch.spelled(graze.before), branch.spelled(graze.after)) == ("irrirr", "irrrr")
    run = simulate(branch.case_at(1))
    turns = run.events["x_m"][run.events["kind"] == EVENT_KINDS["reversal"]]
    nearest = turns[np.argmin(np.abs(turns - graze.parameter))]
    assert nearest == pytest.approx(graze.parameter, abs=1e-6)
    assert run.case.values["stops.w.gap"].value < 0


def test_no_step_goes_over_a_fold_or_a_graze_to_other_orbits():
    """Orbits that strike the stop have a fold, and a graze ends them together with those that stay clear.

    Multipliers tell a step to other orbits, though not where a rigid stop is grazed: such steps went over
    both. The graze is where the motion without the stop just reaches it.
    """
    branch = continue_branch(load_case(MOTOR), "friction.g.mu", "0.19:0.41")
    fold, graze = (one for one in branch.specials if one.kind != "order")
    assert (fold.kind, graze.kind) == ("fold", "grazing")
    assert branch["parameter"].max() <= fold.parameter and set(branch["word"]) == {"irr"}
    values = {"friction.g.mu": f"{graze.parameter!r}", "stops.w": "none"}
    events = orbit(load_case(MOTOR).with_values(values)).run.events
    turns = events["x_f"][events["kind"] == EVENT_KINDS["reversal"]]
    assert turns.max() == pytest.approx(3e-3, rel=1e-9)
