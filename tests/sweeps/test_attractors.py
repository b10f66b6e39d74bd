"""Attractors of sweeps: labels against runs judged by hand, in any order, after a kill, and their numbers."""

import h5py
import numpy as np
import pytest

import vibsim
from tests.sweeps.made import (
    assert_same_points,
    batches_of_one,
    complete,
    in_memory,
    run_stored,
    short_plan,
    swept,
    until,
)
from vibsim.analysis.attractor import observables
from vibsim.cases.case import load_case, load_case_text
from vibsim.results.hdf5_reading import ResultFileError
from vibsim.sweeps.attractor_changes import attractor_changes
from vibsim.sweeps.attractors import gather
from vibsim.sweeps.points import compute_point
from vibsim.sweeps.quantities import KINDS, NONE, REASONS
from vibsim.sweeps.sweep_file import SweepStore
from vibsim.sweeps.sweep_plan import PlanError, shard

STARTS = {"tip.x": "-4:4/8 mm", "tip.v": "-450:450/8 mm/s"}
STARTS_ON_BELT = {
    "ensemble": 40,
    "spread": {"block.x": "-2:2 m", "block.v": "0:2 m/s"},
    "overrides": {"run.t_end": "300 s"},
    "discard": "200 s",
    "section": 0,
}


def cantilever_plan(axes=STARTS, compute="attractor", **settings):
    case = load_case("gallery/cantilever", {"run.t_end": "40 s"})
    return short_plan(axes, case, compute=compute, section=0, **settings)


@pytest.fixture(scope="module")
def basins(tmp_path_factory):
    """The cantilever's basins, stored, by two workers."""
    path = tmp_path_factory.mktemp("basins") / "basins.h5"
    return path, complete(cantilever_plan(), path)[0]


def strikes(case, t_end=60.0, last=5.0):
    """Whether a long run still meets the stop at its end: no orbit, no section, no Newton."""
    times = vibsim.simulate(case).events["t"]
    return bool((times > t_end - last).sum() > 10)


def test_labels_are_where_long_runs_go(basins):
    """The motion that strikes has two events a period, 130 in 5 s; the other has none."""
    _, result = basins
    labels = result["attractor"][..., 0]
    assert set(np.unique(labels)) == {0, 1}
    word = result.attractors["word"].tolist()
    assert word == ["be", ""]
    for index in np.ndindex(labels.shape):
        case = result.case_at((*index, 0)).with_values({"run.t_end": "60 s", "run.every": "1 s"})
        assert strikes(case) == (labels[index] == 0), index


def test_amplitudes_are_those_of_the_runs(basins):
    """At the end of a run, half of the way between the extremes of its samples in 5 s."""
    _, result = basins
    for i in range(2):
        index = tuple(np.argwhere(result["attractor"] == i)[0])
        run = vibsim.simulate(result.case_at(index))
        late = np.asarray(run["x_tip"])[np.asarray(run["time"]) > 35]
        assert result.attractors["amplitude"][i, 0] == pytest.approx(np.ptp(late) / 2, rel=2e-3)
    assert result.attractors["amplitude"][:, 0] == pytest.approx([4.782e-3, 0.641e-3], rel=1e-3)


def test_the_clear_motion_is_the_linear_oscillator(basins):
    """x = base + relative: closed form of k, c and the base; multipliers exp(-c T / 2 m)."""
    _, result = basins
    m, k, c, w, a = 0.12, 450.0, 0.25, 2 * np.pi * 13, 0.5e-3
    amplitude = a * abs((k + 1j * w * c) / (k - m * w**2 + 1j * w * c))
    assert result.attractors["amplitude"][1, 0] == pytest.approx(amplitude, rel=1e-9)
    multiplier = np.exp(-c / (2 * m) / 13)
    assert result.attractors["largest_multiplier"][1] == pytest.approx(multiplier, rel=1e-9)


def test_shares_count_the_points(basins):
    path, result = basins
    shares = np.array([(result["attractor"] == i).mean() for i in range(2)])
    np.testing.assert_allclose(result.attractors["share"], shares, rtol=1e-15)
    errors = np.sqrt(shares * (1 - shares) / 64)
    np.testing.assert_allclose(result.attractors["share_error"], errors, rtol=1e-12)
    with h5py.File(path) as file:
        np.testing.assert_array_equal(file["attractor"][...], result["attractor"])
        assert file["attractors/period"][...].tolist() == [1, 1]
        np.testing.assert_array_equal(file["attractors/share"][...], result.attractors["share"])
        assert file["attractors/state"].shape == (2, 2)


def test_stopping_early_changes_no_label(basins):
    """Beside another computation every run goes on to its end."""
    _, result = basins
    assert np.isfinite(result["attractor_time"]).mean() > 0.8
    assert np.nanmax(result["attractor_time"]) < 20
    whole = in_memory(cantilever_plan(compute=["attractor", "grazing"]))
    assert np.nanmin(whole.numbers["t_reached"]) == 40
    labels = gather(cantilever_plan(compute=["attractor", "grazing"]), whole).labels
    np.testing.assert_array_equal(labels, result["attractor"])


def test_the_order_of_points_and_the_number_of_workers_change_no_bit(basins):
    _, result = basins
    plan = cantilever_plan()
    points = in_memory(plan)
    assert_same_points(points, result.table)
    for index in [(7, 7, 0), (0, 3, 0), (4, 4, 0)]:  # alone, the last first
        alone = compute_point(plan.point_settings, index, plan.changes(index), None)
        beside = points.point(index)
        np.testing.assert_array_equal(alone.arrays["attractor_state"], beside.arrays["attractor_state"])
        assert alone.values["attractor_multiplier"] == beside.values["attractor_multiplier"]


def test_a_sweep_that_is_stopped_goes_on_to_the_same_file(basins, tmp_path):
    _, result = basins
    plan, path = cantilever_plan(), tmp_path / "stopped.h5"
    with batches_of_one():
        run_stored(SweepStore(plan, path), 2, until(20))
    there = vibsim.open_result(path)
    assert 0 < (there["status"] == 1).sum() < 64
    assert set(np.unique(there["attractor"][there["status"] != 1])) == {NONE}
    again, computed = complete(plan, path)
    assert 0 < len(computed) < 64
    assert_same_points(again.table, result.table)
    np.testing.assert_array_equal(vibsim.open_result(path)["attractor"], result["attractor"])
    for name, column in result.attractors.columns.items():
        np.testing.assert_array_equal(again.attractors[name], column)


def test_shards_have_the_points_of_the_whole(basins, tmp_path):
    _, result = basins
    plan = cantilever_plan()
    paths = [tmp_path / f"{k}.h5" for k in (1, 2)]
    for k, path in enumerate(paths, 1):
        swept(shard(plan, k, 2), path)
    joined = vibsim.join(paths)
    np.testing.assert_array_equal(joined["attractor"], result["attractor"])
    np.testing.assert_array_equal(joined["attractor_state"], result["attractor_state"])


def test_a_damaged_number_of_an_attractor_is_told(basins, tmp_path):
    path, _ = basins
    copy = tmp_path / "copy.h5"
    copy.write_bytes(path.read_bytes())
    with h5py.File(copy, "r+") as file:
        file["attractor"][0, 0, 0] = 7
    with pytest.raises(ResultFileError, match="attractor names attractors that are not there"):
        _ = vibsim.open_result(copy).attractors


def test_rest_and_stick_slip_are_those_of_end_state():
    """Of the belt oscillator, by another rule: whether the friction goes on to change its state."""
    result = vibsim.sweep("gallery/belt-oscillator", {}, compute=["attractor", "end-state"], **STARTS_ON_BELT)
    at_rest = result.verdict("end_state") == "rest"
    assert 0 < at_rest.sum() < 40
    np.testing.assert_array_equal(result["attractor_kind"] == KINDS["rest"], at_rest)
    assert sorted(result.attractors["period"].tolist()) == [0, 1]
    rest = int(np.flatnonzero(result.attractors["period"] == 0)[0])
    mu = 0.5 + 0.5 * np.exp(-1.5 / 0.5)  # x = mu(v_belt) N / k
    left = result["attractor_errors"][result["attractor"] == rest][:, -1]  # half of what still swings
    assert abs(result.attractors["state"][rest][0] - mu) < left[0] < 0.05


def test_shares_over_a_parameter_keep_their_branches():
    belts = {"belt.belt": "1.4, 1.7, 1.9 m/s"}
    result = vibsim.sweep("gallery/belt-oscillator", belts, compute="attractor", **STARTS_ON_BELT)
    found = result.attractors
    branches = {kind: set(found["branch"][found["period"] == kind].tolist()) for kind in (0, 1)}
    assert len(branches[0]) == len(branches[1]) == 1 and branches[0] != branches[1]
    assert found["point"][found["period"] == 1].tolist() == [0, 1]  # the cycle ends at 1.8366 m/s
    assert found["point"][found["period"] == 0].tolist() == [0, 1, 2]


def test_two_periods_of_one_scene():
    """I-A from many starts: its motions of five periods and of one, as the verdict on regimes has them."""
    spread = {"x1": "1 mm", "v1": "50 mm/s"}
    result = vibsim.sweep("I-A", {}, ensemble=32, spread=spread, section=0, compute=["attractor", "regime"])
    periodic = result["regime"] == 1
    assert periodic.sum() > 25
    np.testing.assert_array_equal(result["attractor_period"][periodic], result["regime_period"][periodic])


def test_chaos_is_one_set_and_told_from_orbits():
    case = load_case("gallery/impact-oscillator", {"run.t_end": "3000 s", "drive.omega": "2.8 rad/s"})
    spread = {"mass.x": "-0.5:-0.1 m"}
    result = vibsim.sweep(case, {}, ensemble=6, spread=spread, section=0, compute="attractor")
    assert result.verdict("attractor_kind").ravel().tolist() == ["chaotic"] * 6
    assert result.attractors["period"].tolist() == [-1] and result.attractors["share"].tolist() == [1.0]
    assert np.isnan(result.attractors["largest_multiplier"][0])


def test_means_of_a_set_have_honest_errors():
    """Of independent numbers: 1 in 20 means lies further off than two errors."""
    draws = np.random.default_rng(0).normal(size=(400, 400))
    off = []
    for series in draws:
        means, errors = observables(series[:, None])
        off.append(abs(means[0]) / errors[0])
    assert 0.02 < np.mean(np.array(off) > 2.26) < 0.09  # Student's t with 9 degrees: 0.05


EARLY_OR_NOT = "attractor", ["attractor", "end-state"]


def test_a_limit_cycle_without_events():
    """Van der Pol's oscillator: every start but rest itself ends on its cycle. Known early by where a run
    meets the section, or at its end, at which the peaks of its speed between samples are no fall of energy.
    """
    starts = {"mass.x": "-2:2/7 m", "mass.v": "-2:2/5 m/s"}
    settings = {"overrides": {"run.t_end": "250 s"}, "discard": "60 %", "section": 0, "jobs": 1}
    found = [vibsim.sweep("gallery/van-der-pol", starts, compute=each, **settings) for each in EARLY_OR_NOT]
    for result in found:
        rests = result["attractor_kind"][..., 0] == KINDS["rest"]
        assert np.argwhere(rests).tolist() == [[3, 2]]
        assert result.attractors["period"].tolist() == [1, 0]
    early = [np.isfinite(result["attractor_time"]).sum() for result in found]
    assert early[0] > 3 and early[1] == 0


HELD = """
links: {spring: {between: [block, ground], k: 10 N/m}}
friction: {floor: {between: [block, ground], mu: 0.5, N: 10 N}}
forces: {drive: {on: block, A: 1 N, omega: 1 Hz}}
"""
ROCKET = "forces: {drive: {on: block, A: 1 N, omega: 1 Hz, F0: 0.1 N}}\n"


@pytest.mark.parametrize(
    ("parts", "axes", "kind", "periods"),
    [
        (HELD, {"block.x": "-0.3:0.3/4 m"}, "rest", [0]),  # any place that the friction holds
        (ROCKET, {"block.v": "0, 1 m/s"}, "running away", None),
    ],
)
def test_what_nothing_moves_rests_and_what_nothing_holds_runs_away(parts, axes, kind, periods):
    case = load_case_text(f"bodies: {{block: 1 kg}}\n{parts}run: {{t_end: 60 s}}\n", name="block")
    result = vibsim.sweep(case, axes, section=0, compute="attractor")
    assert {*result.verdict("attractor_kind").ravel()} == {kind}
    assert periods is None or result.attractors["period"].tolist() == periods


def test_what_is_undecided_says_why():
    case = load_case("gallery/cantilever", {"run.t_end": "0.2 s"})
    result = vibsim.sweep(case, {"tip.x": "0, 3 mm"}, section=0, compute="attractor")
    assert set(result["attractor"].ravel().tolist()) == {NONE}
    assert set(result["attractor_reason"].ravel().tolist()) == {float(REASONS["too few cycles"])}


def test_sweeps_without_attractors_have_none():
    result = vibsim.sweep("II-B", {"Omega0": "3, 4 Hz"}, overrides={"run.t_end": "2 s"}, section=0)
    with pytest.raises(ValueError, match=r"this sweep has no attractors \(sweep with compute='attractor'\)"):
        _ = result.attractors
    with pytest.raises(PlanError, match="did you mean attractor"):
        short_plan(compute="atractor")


def test_mirror_images_are_one_orbit_and_counted_apart():
    """Two wells, x'' + 0.15 x' - x + x^3 = 0.2 cos t: in which of them a long run ends, by its sign alone."""
    text = """
    bodies: {mass: 1 kg}
    links:
      spring: {between: [mass, ground], force: "k3*d**3 - k1*d + c*v", k1: 1 N/m, k3: 1 N/m^3, c: 0.15 N s/m}
    forces: {drive: {on: mass, A: 0.2 N, omega: 1 rad/s, phase: 90 deg}}
    run: {t_end: 250 s, every: 100 ms}
    """
    case = load_case_text(text, name="wells")
    spread = {"mass.x": "-1.2:1.2 m", "mass.v": "-0.5:0.5 m/s"}
    result = vibsim.sweep(case, {}, ensemble=8, spread=spread, section=0, compute="attractor")
    known = result["attractor"].ravel() == 0
    assert known.sum() >= 5 and len(result.attractors) == 1
    mirrored = result["attractor_mirrored"].ravel()
    assert result.attractors["share_mirror"][0] == pytest.approx(mirrored.sum() / 8)
    signs = []
    for i in range(8):
        run = vibsim.simulate(result.case_at((i, 0)), trust=False)
        signs.append(np.sign(np.asarray(run["x_mass"])[-628:].mean()))
    first = signs[int(np.flatnonzero(known & (mirrored == 0))[0])]
    np.testing.assert_array_equal(mirrored[known], (np.array(signs) != first)[known])
    assert 0 < mirrored.sum() < known.sum()


def test_a_pendulum_under_a_constant_torque_rests_or_turns_for_ever():
    """x'' + 0.1 x' + sin x = 0.5: rests at asin 0.5 and whole turns from there, or turns for ever.

    M. Stender and N. Hoffmann, Nonlinear Dynamics 107 (2022).
    """
    case = vibsim.load_case(
        """
name: pendulum
bodies: {rod: 1 kg m^2}
links: {weight: {between: [rod, ground], force: "K*sin(d) + c*v", K: 1 N m, c: 0.1 N m s/rad}}
forces: {load: {on: rod, F0: 0.5 N m}}
run: {t_end: 400 s, every: 50 ms}
"""
    )
    speeds = (-8.5, -1, 0, 1, 6)
    values = ",".join(map(str, speeds))
    swept = vibsim.sweep(case, {"initial.rod.v": f"{values} rad/s"}, compute=("attractor",))
    kinds = [swept.attractors.words(i) for i in range(len(swept.attractors))]
    assert sorted(kinds) == ["rest", "turning"]
    at_rest = swept["attractor"].ravel() == kinds.index("rest")
    runs = [vibsim.simulate(case, {"initial.rod.v": f"{v} rad/s"}, trust=False) for v in speeds]
    assert at_rest.tolist() == [abs(run["v_rod"][-1]) < 1e-6 for run in runs]
    angle = runs[int(np.flatnonzero(at_rest)[-1])]["x_rod"][-1]
    assert np.sin(angle) == pytest.approx(0.5, abs=1e-6)


def test_motions_whole_turns_apart_are_one_attractor():
    """A driven pendulum that swings about x = 0 and about x = 2 pi."""
    case = vibsim.load_case(
        """
name: pendulum
bodies: {rod: 1 kg m^2}
links: {weight: {between: [rod, ground], force: "M*sin(d) + c*v", M: 1 N m, c: 0.5 N m s/rad}}
forces: {drive: {on: rod, A: 0.1 N m, omega: 2/3 rad/s}}
run: {t_end: 200 s, every: 50 ms}
"""
    )
    swept = vibsim.sweep(case, {"initial.rod.x": "0,1,6,7,-6.5 rad"}, compute=("attractor",))
    assert swept["attractor"].ravel().tolist() == [0] * 5
    assert swept.attractors["share"].tolist() == [1.0]


# Births and deaths of attractors against closed forms, and against numbers of other solvers.


ESCAPE = """
bodies: {mass: 1 kg}
links:
  spring: {between: [mass, ground], force: "k1*d - k2*d**2 + c0*v", k1: 1 N/m, k2: 1 N/m^2, c0: 0.1 N s/m}
forces:
  drive: {on: mass, A: 0.06 N, omega: 0.85 rad/s}
run: {t_end: 400 s, every: 50 ms}
"""


def changes_of(axes, case, path):
    return attractor_changes(swept(short_plan(axes, case, compute="attractor", section=0), path))


def test_rest_on_a_belt_is_born_in_a_hopf_point_and_its_cycle_dies_in_a_corner(tmp_path):
    """Rest is stable above ln(10) / 2, where damping and the slope of the friction are equal; the cycle is
    there up to 1.836600972207926 m/s.
    """
    case = load_case("gallery/belt-oscillator", {"run.t_end": "400 s"})
    axes = {"belt.belt": "1.1,1.4,1.9 m/s", "block.x": "0.3:1.5/3 m", "block.v": "0:1.5/2 m/s"}
    born, dies = changes_of(axes, case, tmp_path / "belt.h5")
    assert born.birth and born.parameter == pytest.approx(np.log(10) / 2, abs=1e-8)
    assert "Hopf" in born.cause
    assert not dies.birth and dies.parameter == pytest.approx(1.836600972207926, abs=1e-9)


def test_the_resonant_motion_of_an_escape_equation_dies_in_a_fold(tmp_path):
    """At the fold a multiplier is 1; the orbit that DOP853 and Newton's method find just in front of it has
    one near 1, and none is there just behind it.
    """
    from scipy.integrate import solve_ivp
    from scipy.optimize import root

    axes = {"drive.A": "0.06,0.07 N", "mass.x": "-0.4:0.4/4 m", "mass.v": "-0.3:0.3/4 m/s"}
    changes = changes_of(axes, load_case_text(ESCAPE), tmp_path / "escape.h5")
    (fold,) = [change for change in changes if change.cause == "a fold"]
    assert not fold.birth and 0.06 < fold.parameter < 0.07

    def mapped(y, A):
        def rates(t, y):
            x, v, *D = y
            D = np.array(D).reshape(2, 2)
            slopes = np.array([[0, 1], [-1 + 2 * x, -0.1]]) @ D
            return [v, A * np.sin(0.85 * t) - x + x * x - 0.1 * v, *slopes.ravel()]

        tight = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-13}
        end = solve_ivp(rates, (0, 2 * np.pi / 0.85), [*y, 1, 0, 0, 1], **tight).y[:, -1]
        return end[:2], end[2:].reshape(2, 2)

    def at_fold(unknowns):
        """A fixed point one of whose multipliers is 1: det(D - 1) = 0."""
        *y, A = unknowns
        image, D = mapped(y, A)
        return [*(image - y), np.linalg.det(D - np.eye(2))]

    start = [*_orbit_near(fold, axes, tmp_path), fold.parameter]
    solution = root(at_fold, start, tol=1e-11)
    assert solution.success
    assert fold.parameter == pytest.approx(solution.x[2], abs=1e-8)


def _orbit_near(fold, axes, tmp_path):
    """Where the dying orbit meets the section at the last point that has it."""
    plan = short_plan(axes, load_case_text(ESCAPE), compute="attractor", section=0)
    return swept(plan, tmp_path / "escape.h5").attractors["state"][fold.attractor]


@pytest.mark.slow
def test_chaos_between_two_wells_dies_in_a_boundary_crisis(tmp_path):
    """x'' = x - x^3 - 0.25 x' + A sin t: of 60 starts run on in fixed steps of the fourth order, all stay on
    the set 0.01 N below, and most leave it 0.03 N above.
    """
    case = load_case("gallery/duffing-two-well", {"run.t_end": "3000 s"})
    axes = {"drive.A": "0.4,0.5 N", "mass.x": "-1:1/3 m", "mass.v": "0,0.5 m/s"}
    changes = changes_of(axes, case, tmp_path / "wells.h5")
    (crisis,) = [change for change in changes if "crisis" in change.cause]
    assert not crisis.birth and 0.4 < crisis.parameter < 0.5

    def large(A, periods):
        """Share of starts on the motion of one period, by its distance from itself a period before."""

        def rates(t, y):
            return np.array([y[1], A * np.sin(t) + y[0] - y[0] ** 3 - 0.25 * y[1]])

        y, h, before = np.array([np.linspace(-0.4, 0.4, 60), np.zeros(60)]), 2 * np.pi / 120, None
        for step in range(periods * 120):
            if step == (periods - 1) * 120:
                before = y
            k1 = rates(step * h, y)
            k2 = rates((step + 0.5) * h, y + h / 2 * k1)
            k3 = rates((step + 0.5) * h, y + h / 2 * k2)
            k4 = rates((step + 1) * h, y + h * k3)
            y = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        return (np.abs(y - before).max(axis=0) < 1e-6).mean()

    assert large(crisis.parameter - 0.01, 400) == 0
    assert large(crisis.parameter + 0.03, 400) > 0.5


def test_births_are_those_of_a_parameter(tmp_path):
    plan = short_plan({"tip.x": "-4:4/4 mm"}, load_case("gallery/cantilever"), compute="attractor", section=0)
    with pytest.raises(PlanError, match="are those of a sweep over one parameter"):
        attractor_changes(swept(plan, tmp_path / "plane.h5"))
