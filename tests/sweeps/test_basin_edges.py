"""Saddles between attractors against closed forms, and against solvers that know nothing of vibsim's."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, root

import vibsim
from tests.sweeps.made import complete, short_plan
from vibsim.cases.case import load_case, load_case_text
from vibsim.sweeps.basin_edges import EdgeError, edge
from vibsim.sweeps.basin_measures import basin_entropy, uncertain_share, uncertainty_exponent
from vibsim.sweeps.basin_shocks import fatal_shock
from vibsim.sweeps.sweep_plan import PlanError

TWO_WELLS = """
bodies: {mass: 1 kg}
links:
  spring: {between: [mass, ground], force: "k3*d**3 - k1*d + c0*v", k1: 1 N/m, k3: 1 N/m^3, c0: 0.15 N s/m}
forces:
  drive: {on: mass, A: 0.02 N, omega: 1 rad/s, phase: 90 deg}
run: {t_end: 400 s, every: 50 ms}
"""
FREE_WELLS = TWO_WELLS.replace("forces:\n  drive: {on: mass, A: 0.02 N, omega: 1 rad/s, phase: 90 deg}\n", "")
FREE_WELLS = FREE_WELLS.replace("400 s", "80 s") + "initial: {mass: {x: 1.2 m}}\n"
IMPACTS = """
bodies: {mass: 1 kg}
links:
  spring: {between: [mass, ground], k: 1 N/m, c: 0.04 N s/m}
stops:
  wall: {between: [mass, ground], gap: 1 m, acts: extension, law: rigid, e: 0.8}
forces:
  drive: {on: mass, A: 1 N, omega: 1.5 rad/s, phase: 90 deg}
run: {t_end: 400 s, every: 50 ms}
"""
LEFT, RIGHT = {"x_mass": -1.2, "v_mass": 0.0}, {"x_mass": 1.2, "v_mass": 0.0}
TIGHT = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-13}


def of_two_wells(amplitude, t_end=2 * np.pi):
    """The map over one period of the drive, and its derivative, by DOP853 on the variational equations."""

    def rates(t, y):
        x, v, *rest = y
        D = np.array(rest).reshape(2, 2)
        A = np.array([[0, 1], [1 - 3 * x**2, -0.15]])
        return [v, amplitude * np.cos(t) + x - x**3 - 0.15 * v, *(A @ D).ravel()]

    def mapped(X):
        y = solve_ivp(rates, (0, t_end), [*X, 1, 0, 0, 1], **TIGHT).y[:, -1]
        return y[:2], y[2:].reshape(2, 2)

    return mapped


def test_the_saddle_of_two_wells_without_drive_is_the_top_of_the_hill():
    """x'' = x - x^3 - c x' at x = 0: exponents -c/2 +- sqrt(c^2/4 + 1), over the period of the idle drive."""
    found = edge(load_case_text(TWO_WELLS.replace("0.02 N", "0 N")), LEFT, RIGHT)
    exponents = -0.075 + np.array([1, -1]) * np.sqrt(0.075**2 + 1)
    assert np.abs(found.orbit.X).max() < 1e-12
    np.testing.assert_allclose(found.orbit.multipliers.real, np.exp(2 * np.pi * exponents), rtol=1e-9)
    assert [end.label.kind for end in found.sides] == ["rest", "rest"]
    assert sorted(round(end.label.state[0]) for end in found.sides) == [-1, 1]


def test_a_state_of_rest_between_two_others_is_told_with_its_exponents():
    found = edge(load_case_text(FREE_WELLS), LEFT, RIGHT)
    assert found.orbit is None
    assert np.abs(list(found.rest.state.values())).max() < 1e-12
    exponents = -0.075 + np.array([1, -1]) * np.sqrt(0.075**2 + 1)
    np.testing.assert_allclose(found.rest.rates, exponents, rtol=1e-9)


def test_the_saddle_of_two_driven_wells_is_that_of_newtons_method_on_dop853():
    found = edge(load_case_text(TWO_WELLS), LEFT, RIGHT)
    mapped = of_two_wells(0.02)
    X = root(lambda X: mapped(X)[0] - X, [0.0, 0.0], jac=lambda X: mapped(X)[1] - np.eye(2), tol=1e-13).x
    np.testing.assert_allclose(found.orbit.X, X, rtol=0, atol=1e-9)
    multipliers = np.sort(np.linalg.eigvals(mapped(X)[1]).real)[::-1]
    np.testing.assert_allclose(found.orbit.multipliers.real, multipliers, rtol=1e-7)
    assert found.orbit.multipliers.real[0] > 1 > found.orbit.multipliers.real[1]


def test_both_sides_of_the_first_pair_are_where_dop853_goes():
    """The pair that bisection found, moved apart by a millionth: where independent runs end."""
    found = edge(load_case_text(TWO_WELLS), LEFT, RIGHT)
    one, other = (np.array(list(state.values())) for state in found.pair)
    assert 0 < np.abs(other - one).max() < 1e-10

    def rates(t, y):
        return [y[1], 0.02 * np.cos(t) + y[0] - y[0] ** 3 - 0.15 * y[1]]

    for start, side in ((one - [1e-6, 0], -1), (other + [1e-6, 0], 1)):
        assert np.sign(solve_ivp(rates, (0, 80 * np.pi), start, **TIGHT).y[0, -1]) == side


def impact_map(X, flights=20):
    """x'' + 0.04 x' + x = cos(1.5 t), x >= -1, v -> -0.8 v: state after one period from X, by the closed form
    of each flight and Brent's method; and the impacts.
    """
    zeta, w = 0.02, 1.5
    rate = np.sqrt(1 - zeta**2)
    particular = 1 / (1 - w**2 + 2j * zeta * w)

    def flight(t0, x0, v0):
        forced = particular * np.exp(1j * w * t0)
        steady, slope = forced.real, (1j * w * forced).real
        a = x0 - steady
        b = (v0 - slope + zeta * a) / rate

        def at(t):
            s, decay = t - t0, np.exp(-zeta * (t - t0))
            free = decay * (a * np.cos(rate * s) + b * np.sin(rate * s))
            sloped = decay * rate * (b * np.cos(rate * s) - a * np.sin(rate * s)) - zeta * free
            forced = particular * np.exp(1j * w * t)
            return free + forced.real, sloped + (1j * w * forced).real

        return at

    T, t, (x, v), impacts = 2 * np.pi / w, 0.0, X, []
    for _ in range(flights):
        at = flight(t, x, v)
        grid = np.linspace(t + 1e-9, T, 4000)
        below = np.flatnonzero(at(grid)[0] < -1)
        if not len(below):
            return np.array(at(T)), impacts
        begin = grid[below[0] - 1] if below[0] else t + 1e-12
        t = brentq(lambda s, at=at: at(s)[0] + 1, begin, grid[below[0]])
        x, v = -1.0, -0.8 * at(t)[1]
        impacts.append((t, v))
    raise AssertionError("too many impacts")


def test_the_saddle_of_an_impact_oscillator_closes_in_closed_form():
    found = edge(load_case_text(IMPACTS), {"x_mass": -0.8, "v_mass": 0}, {"x_mass": 3, "v_mass": 0})
    X = found.orbit.X
    image, impacts = impact_map(X)
    assert len(impacts) == 1 and found.orbit.spelled == "i"
    np.testing.assert_allclose(image, X, rtol=0, atol=1e-9)
    h = 1e-6
    columns = [(impact_map(X + h * e)[0] - impact_map(X - h * e)[0]) / (2 * h) for e in np.eye(2)]
    multipliers = np.sort(np.linalg.eigvals(np.array(columns).T).real)[::-1]
    np.testing.assert_allclose(found.orbit.multipliers.real, multipliers, rtol=1e-5)
    determinant = np.prod(found.orbit.multipliers).real  # r^2 exp(-2 zeta T)
    assert determinant == pytest.approx(0.64 * np.exp(-0.04 * 2 * np.pi / 1.5), rel=1e-9)
    words = {end.orbit.spelled for end in found.sides}
    assert words == {"", "i"}


# Pendulum: the saddle is the upright one.


def test_between_rest_and_turning_a_pendulum_has_its_upright_rest():
    """x'' = 0.5 - sin x - 0.5 x' as a body: rests at asin 0.5 + 2 pi k, saddles at pi - asin 0.5."""
    text = """
bodies: {arm: 1 kg m^2}
links:
  weight: {between: [arm, ground], force: "M*sin(d) + c0*v", M: 1 N m, c0: 0.5 N m s/rad}
forces:
  torque: {on: arm, F0: 0.5 N m}
run: {t_end: 200 s, every: 50 ms}
"""
    case = load_case_text(text)
    found = edge(case, {"x_arm": 0.5, "v_arm": 0.0}, {"x_arm": 5.0, "v_arm": 0.0})
    upright, down = np.pi - np.arcsin(0.5), np.arcsin(0.5)
    assert found.rest.state["x_arm"] == pytest.approx(upright, abs=1e-9)
    slope = np.sqrt(1 - 0.25)
    assert found.rest.rates == pytest.approx(-0.25 + np.array([1, -1]) * np.sqrt(0.0625 + slope), rel=1e-9)
    ends = sorted(end.label.state[0] for end in found.sides)
    assert ends == pytest.approx([down, down + 2 * np.pi], abs=1e-6)


def test_rest_and_stick_slip_are_parted_by_the_slipping_cycle():
    """Without sticking x'' + 0.1 x' + x = mu(1.5 - x'): the unstable cycle, by DOP853 run backwards, which
    comes to it.
    """
    found = edge("gallery/belt-oscillator", {"x_block": 0.6, "v_block": 0}, {"x_block": 1, "v_block": 1.5})
    assert found.orbit.spelled == "" and {end.label.kind for end in found.sides} == {"rest", "periodic"}

    def backwards(t, y):
        return [-y[1], y[0] + 0.1 * y[1] - 0.5 - 0.5 * np.exp((y[1] - 1.5) / 0.5)]

    def turns(t, y):
        return y[1]

    turns.direction = -1  # in reversed time: the least displacement
    run = solve_ivp(backwards, (0, 400), [0.55, 1.0], events=turns, **TIGHT)
    least = min(run.y_events[0][-2:, 0])
    assert found.orbit.X[0] == pytest.approx(least, abs=1e-7)
    period = np.diff(run.t_events[0])[-1]
    assert found.orbit.period == pytest.approx(period, rel=1e-7)


# From a sweep, and what cannot be done.


@pytest.fixture(scope="module")
def cantilever(tmp_path_factory):
    path = tmp_path_factory.mktemp("edges") / "cantilever.h5"
    axes = {"tip.x": "-4:4/8 mm", "tip.v": "-450:450/8 mm/s"}
    plan = short_plan(axes, load_case("gallery/cantilever"), compute="attractor", section=0)
    return path, complete(plan, path)[0]


def test_numbers_of_a_sweep_and_their_orbits_give_one_saddle(cantilever, tmp_path):
    path, sweep = cantilever
    by_number = edge(path, 0, "1").orbit
    case = load_case("gallery/cantilever")
    ends = [edge(sweep, 0, 1).sides[k].orbit for k in (0, 1)]
    by_orbit = edge(case, *ends).orbit
    np.testing.assert_allclose(by_orbit.X, by_number.X, rtol=1e-9)
    assert by_number.multipliers.real[0] > 1 > by_number.multipliers.real[1] > 0
    stored = vibsim.open_result(by_number.save(tmp_path / "saddle.h5"))
    again = vibsim.orbit(stored)
    np.testing.assert_allclose(again.X, by_number.X, rtol=1e-12)
    branch = vibsim.continue_branch(stored, "base.omega", "12.5:13.2 Hz")
    assert not branch["stable"].all()


@pytest.mark.parametrize(
    ("names", "message"),
    [
        ((0, 7), "no attractor 7 in this sweep: its attractors are 0 to 1"),
        ((0, "1m"), "no start of this sweep ends on a mirror image of attractor 1"),
        ((0, {"x_tip": 0.0, "v_tip": 0.0}), "0 is the number of an attractor"),
    ],
)
def test_attractors_that_are_not_there(cantilever, names, message):
    with pytest.raises(PlanError, match=message):
        edge(cantilever[0], *names)


def test_two_starts_on_one_attractor_have_no_edge():
    with pytest.raises(EdgeError, match=r"both starts end on the same attractor, rest .at x_mass"):
        edge(load_case_text(FREE_WELLS), RIGHT, {"x_mass": 1.1, "v_mass": 0.0})


def test_nothing_starts_inside_a_rigid_stop():
    with pytest.raises(EdgeError, match="the second start lies inside the rigid stop wall"):
        edge(load_case_text(IMPACTS), {"x_mass": 0.0, "v_mass": 0.0}, {"x_mass": -2.0, "v_mass": 0.0})


@pytest.mark.slow
def test_a_boundary_that_is_a_jump_of_a_formula_has_no_saddle():
    """A force that pushes away from x = 0 by 1 N at once: starts part there, and no orbit is between."""
    text = TWO_WELLS.replace("k1*d", "where(d > 0, F1, -F1)").replace("k1: 1 N/m", "F1: 1 N")
    with pytest.raises(EdgeError, match=r"no saddle orbit.*, are far from each other at the next period"):
        edge(load_case_text(text), LEFT, RIGHT)


# Minimal fatal shocks.


def backwards(t, y):
    """Rates of x'' = x - x^3 - 0.15 x' in reversed time."""
    return [-y[1], -(y[0] - y[0] ** 3 - 0.15 * y[1])]


def stable_manifold_at(x):
    """Speed at which the stable manifold of x = 0 of x'' = x - x^3 - 0.15 x' first passes x, by DOP853
    backwards from the hill.
    """
    rate = -0.075 - np.sqrt(0.075**2 + 1)

    def passes(t, y):
        return y[0] - x

    passes.terminal = True
    start = np.sign(x) * 1e-7 * np.array([1, rate])
    return solve_ivp(backwards, (0, 100), start, events=passes, **TIGHT).y_events[0][0, 1]


def test_the_least_shock_in_speed_reaches_the_stable_manifold():
    shock = fatal_shock(load_case_text(FREE_WELLS.replace("80 s", "160 s")), RIGHT, "mass.v")
    assert shock.change == {"v_mass": shock.change["v_mass"]} or shock.change["x_mass"] == 0
    assert shock.change["v_mass"] == pytest.approx(stable_manifold_at(1.0), rel=1e-6)
    assert shock.destination.label.state[0] == pytest.approx(-1, abs=1e-3)


def test_without_damping_the_least_shock_is_that_of_the_energy():
    """From x = 1 to the hill: v^2 / 2 = 1/4 + c W, W the integral of |v| dx on the way, sqrt(2) / 3 without
    damping; so v = 1 / sqrt 2 and a share 2 c W, and two values of c tell the limit to c^2.
    """
    limits = []
    for c in (0.08, 0.04):
        text = FREE_WELLS.replace("c0: 0.15", f"c0: {c}").replace("80 s", "500 s")
        limits.append(abs(fatal_shock(load_case_text(text), RIGHT, "v_mass").change["v_mass"]))
    assert 2 * limits[1] - limits[0] == pytest.approx(np.sqrt(0.5), rel=2e-3)
    assert limits[0] > limits[1] > np.sqrt(0.5)


@pytest.mark.slow
def test_the_least_shock_in_all_is_the_nearest_point_of_the_stable_manifold():
    """Distances with displacements by a natural rate, that of the start of the case: sqrt(3 1.2^2 - 1)."""
    shock = fatal_shock(load_case_text(FREE_WELLS), RIGHT)
    weight = shock.size and np.sqrt(3 * 1.2**2 - 1)
    rate = -0.075 - np.sqrt(0.075**2 + 1)
    run = solve_ivp(backwards, (0, 25), [1e-7, 1e-7 * rate], max_step=1e-3, **TIGHT)
    nearest = np.sqrt((weight * (run.y[0] - 1)) ** 2 + run.y[1] ** 2).min()
    assert shock.size == pytest.approx(nearest, rel=1e-5)


def test_shocks_that_cannot_be_asked_for():
    message = r"a shock along 'mass.y': no such initial value; this case has mass.x"
    with pytest.raises(PlanError, match=message):
        fatal_shock(load_case_text(FREE_WELLS), RIGHT, "mass.y")


# Measures of basins on planes whose boundaries are known.


def test_a_straight_boundary_has_an_exponent_of_one():
    """n starts on either side of a straight line are uncertain at n steps."""
    labels = np.zeros((256, 256), dtype=int)
    labels[:, 100:] = 1
    for steps in (1, 2, 4, 8):
        assert uncertain_share(labels, steps) == (256 * 2 * steps, 256 * 256)
    slope = uncertainty_exponent(labels)
    assert slope.value == pytest.approx(1, abs=1e-12) and slope.error < 1e-12


def test_a_cantor_set_of_strips_has_its_dimension():
    """Middle thirds: the boundary along one axis has the dimension ln 2 / ln 3, alpha = 1 - that = 0.369."""
    line = np.zeros(3**6, dtype=int)

    def fill(first, length, label):
        if length >= 3:
            third = length // 3
            line[first + third : first + 2 * third] = label
            fill(first, third, 3 - label)
            fill(first + 2 * third, third, 3 - label)

    fill(0, len(line), 1)
    labels = np.broadcast_to(line, (3**6, 3**6))
    alpha = uncertainty_exponent(labels).value
    assert alpha == pytest.approx(1 - np.log(2) / np.log(3), abs=0.1)


def test_undecided_starts_make_no_boundary():
    labels = np.zeros((64, 64), dtype=int)
    labels[30] = -1
    assert uncertain_share(labels, 1) == (0, 63 * 64)
    assert np.isnan(uncertainty_exponent(labels).value)


def test_entropy_of_boxes_by_hand():
    """Of 25 boxes five are crossed, 2 of 5 columns in each: p = 0.4 and 0.6."""
    labels = np.zeros((25, 25), dtype=int)
    labels[:, 12:] = 1
    of_one = -(0.4 * np.log(0.4) + 0.6 * np.log(0.6))
    entropy, boundary, boxes, crossed = basin_entropy(labels)
    assert (boxes, crossed) == (25, 5)
    assert entropy == pytest.approx(5 * of_one / 25, rel=1e-14)
    assert boundary == pytest.approx(of_one, rel=1e-14)


def test_entropy_of_noise_is_that_of_its_labels():
    """Four labels at random: ln 4, less what 25 draws of them lack, (4 - 1) / (2 25) to first order."""
    labels = np.random.default_rng(1).integers(0, 4, (200, 200))
    entropy, boundary, _, _ = basin_entropy(labels)
    assert entropy == boundary == pytest.approx(np.log(4) - 3 / 50, abs=5e-3)
    assert boundary > np.log(2)


def test_a_small_plane_has_no_entropy():
    assert np.isnan(basin_entropy(np.zeros((10, 10), dtype=int))[0])
