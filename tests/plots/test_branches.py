"""Pictures of branches: what is drawn lies where the branch is."""

import numpy as np
import pytest

from tests.branches.made import CAPTURED, RESONANT, branch_of
from tests.branches.test_backbone import trace, twins
from tests.branches.test_families import STUCK
from tests.plots.artists import legend, lines, notes, on_paper, points, words
from vibsim import orbit
from vibsim.analysis import judge_capture, judge_regime
from vibsim.cases import load_case
from vibsim.orbits import find_orbit
from vibsim.orbits.branches.continuing import continue_branch
from vibsim.orbits.coordinates import case_on_orbit
from vibsim.plots.branch_curves import MARKS, amplitude_of, mean_speed_of, parameter_of, pieces
from vibsim.plots.branches_over_sweeps import belongs
from vibsim.plots.load_curves import LEAVES, NEAR, STAYS, LoadCurve, crossings, dead_ends, leaps_of, torque_of
from vibsim.plots.registry import choose, kind_named
from vibsim.plots.sheet import Scale
from vibsim.plots.subject import PlotError, Subject, View, subject_of
from vibsim.plots.sweep_curves import curves, families
from vibsim.results import simulate
from vibsim.sweeps.sweep_file import SweepStore
from vibsim.sweeps.sweeping import complete, make_plan
from vibsim.sweeps.workers import LocalWorkers


@pytest.fixture
def captured():
    return subject_of(branch_of(CAPTURED, "4.9:6 Hz"))


@pytest.fixture
def resonant():
    return subject_of(branch_of(RESONANT, "3.8:6.6 Hz"))


@pytest.mark.parametrize("kind", ["branch", "multipliers", "load-curve"])
def test_kinds_fit_and_nothing_is_cut_off(captured, kind):
    (chosen,) = choose([kind], [captured])
    on_paper(chosen.draw([captured], View(width=chosen.width)))


def test_multipliers_of_a_backbone_curve_are_drawn_as_pairs():
    """mu + 1 / mu against the frequency, by Hill's equation; magnitudes are 1, and tell nothing."""
    branch = continue_branch(twins(0.75, 5.8), energy="3.6:6.4 J")
    (line,) = lines(kind_named("multipliers").draw([subject_of(branch)], View(width="page")), "trace")
    x, y = np.array(line.get_data())[:, np.argsort(line.get_xdata())]
    exact = [(1 / p.orbit.period, trace(p.orbit.parameter, 0.75)) for p in branch.points]
    for frequency, tau in exact:
        assert np.interp(frequency, x, y) == pytest.approx(tau, abs=1e-8)
    assert min(y) < -2 < max(y) < -1.9


def test_multipliers_that_are_all_one_are_refused():
    overrides = {"excitation": "none", "c": "0", "friction": "none", "x1": "5 mm"}
    branch = continue_branch(load_case("I-A", overrides), energy="1e-4:0.01 J")
    with pytest.raises(PlotError, match="backbone curve of one body: its multipliers are those of energy"):
        kind_named("multipliers").draw([subject_of(branch)], View(width="page"))


@pytest.mark.parametrize("kind", ["branch", "load-curve"])
def test_several_are_told_apart_in_grey_print(kind):
    """By a number beside each where it is apart from the others, and in the legend."""
    subjects = []
    for name, c in (("one", "0.03"), ("other", "0.05")):
        branch = continue_branch(orbit("II-B", overrides={"c": c, "Omega0": "3.8 Hz"}), "Omega0", "3.7:6 Hz")
        subjects.append(Subject(f"{name}.h5", name, "branch", branch.case, branch))
    (chosen,) = choose([kind], subjects)
    (axes,) = on_paper(chosen.draw(subjects, View(width=chosen.width))).axes
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["1: one", "2: other"]
    numbers, to_paper = notes(axes, "number of a branch"), axes.transData.transform
    assert [text.get_text() for text in numbers] == ["1", "2"]
    colours = [line.get_color() for line in axes.get_legend().get_lines()]
    assert [text.get_color() for text in numbers] == colours
    for text, colour in zip(numbers, colours, strict=True):
        gaps = [
            (np.linalg.norm(to_paper(line.get_xydata()) - to_paper(text.xy), axis=1).min(), line.get_color())
            for line in lines(axes, "stable") + lines(axes, "unstable")
        ]
        gap, nearest = min(gaps)
        assert nearest == colour and gap < 0.01


def test_one_alone_has_no_number(captured):
    figure = kind_named("branch").draw([captured], View(width="page"))
    assert {text.get_gid() for text in figure.axes[0].texts} == {"special label"}


def test_marks_are_told_apart_in_black_and_white(captured):
    """By shape and filling: those of special points and of operating points."""
    figure = kind_named("load-curve").draw([captured], View(width="page"))
    places = lines(figure, "operating point")
    looks = [(marker, filled) for marker, _, filled, _ in MARKS.values()]
    ours = {(one.get_marker(), one.get_markerfacecolor() != "white") for one in places}
    assert ours == {("o", True), ("o", False)}
    assert len({(mark.fill, mark.face) for mark in (STAYS, NEAR, LEAVES)}) == 3
    assert len({*looks, *ours}) == len(MARKS) + 2 and len({marker for marker, _ in looks}) == len(MARKS)
    (fold,) = lines(figure, "fold")
    assert fold.get_marker() == MARKS["fold"][0]


def test_a_load_curve_needs_a_motor(resonant):
    with pytest.raises(PlotError, match="it needs a motor"):
        choose(["load-curve"], [resonant])


def test_pieces_meet_at_the_neimark_sacker_point(captured):
    branch = captured.result
    found = pieces(branch, parameter_of(branch), mean_speed_of(branch))
    assert [piece.stable for piece in found] == [True, False]
    assert found[0].x[-1] == found[1].x[0] == branch.special("NS1").parameter
    assert found[0].y[-1] == pytest.approx(1 / branch.special("NS1").period, rel=1e-15)
    drawn = {*found[0].x, *found[1].x}
    assert {*branch["parameter"], branch.special("F1").parameter} <= drawn


def test_a_family_of_orbits_is_not_drawn_as_stable():
    """A body that rests anywhere on its friction: one multiplier is exactly 1, none is outside."""
    branch = continue_branch(load_case(STUCK), "A", "0.9:1.1 N", max_points=5)
    assert not branch["index"].any()
    assert not any(piece.stable for piece in pieces(branch, parameter_of(branch), amplitude_of(branch)))


def test_stable_orbits_are_drawn_solid(captured):
    figure = kind_named("branch").draw([captured], View())
    (solid,), (dashed,) = lines(figure, "stable"), lines(figure, "unstable")
    assert solid.get_linestyle() == "-" and dashed.get_linestyle() == "--"
    x, _ = points(solid)
    assert x.max() == pytest.approx(5.794011290201556, rel=1e-12)
    (mark,) = lines(figure, "fold")
    assert points(mark)[0] == pytest.approx([5.794093157256641], rel=1e-12)


def test_the_motor_gives_what_vibration_takes(captured):
    """(J + m3 e^2) w' = m3 e x1'' sin phi + M, Eqs. (2.9), (2.10): over a period the two terms cancel.

    By the trapezoidal rule over 400 samples, x1'' by central differences: 1 in 400 and impacts.
    """
    branch = captured.result
    record, run = run_of(branch, 5)
    motor = captured.scene.motor
    taken = -motor.m3 * motor.e * np.gradient(run["v1"], run["time"]) * np.sin(run["phi"])
    time = run["time"]
    mean = (taken[1:] + taken[:-1]) / 2 @ np.diff(time) / (time[-1] - time[0])
    assert torque_of(branch)(record) == pytest.approx(mean, rel=1e-2)


def run_of(branch, number):
    """An orbit of a branch, and its run."""
    record = branch.points[number].orbit
    state = branch.map.coordinates.state(np.array(record.state))
    return record, simulate(case_on_orbit(branch.plan.family().at(record.parameter), state, record.period))


def test_operating_points_lie_on_the_lines_of_the_motor(captured):
    figure = kind_named("load-curve").draw([captured], View(width="page"))
    motor = captured.scene.motor
    texts = [float(text) for text in words(figure.axes[0], "no-load speed")]
    drawn = lines(figure, "operating point")
    assert len(drawn) >= 4 and len(lines(figure, "motor line")) >= len(texts) >= 2
    for one in drawn:
        (speed,), (torque,) = points(one)
        no_load = speed / (1 - torque * 1e-3 / motor.M0)
        steps = np.arange(49, 60) / 10
        assert abs(steps - no_load).min() < 1e-12
    faces = {one.get_markerfacecolor() for one in drawn}
    assert len(faces) == 2  # stable and unstable ones


def test_amplitudes_are_those_of_a_run(resonant):
    record, run = run_of(resonant.result, 3)
    sampled = np.ptp(run["x1"] - run["x2"]) / 2
    exact = amplitude_of(resonant.result)(record)
    assert sampled <= exact == pytest.approx(sampled, rel=1e-3)


def test_branches_lie_over_a_sweep_of_their_values(captured):
    plan = make_plan(load_case("II-B"), [("Omega0", "5:6:0.5 Hz", "", ""), ("c", "0.01, 0.03", "", "")])
    with LocalWorkers(plan.point_settings, 1) as workers:
        swept, _ = complete(SweepStore(plan), workers, lambda table: False)
    groups = families(curves([subject_of(swept)]))
    assert [[belongs(captured, curve) for curve in group] for group in groups] == [[False], [True]]
    figure = kind_named("sommerfeld").draw([subject_of(swept), captured], View(width="page"))
    assert legend(figure)[-4:] == ["stable", "unstable", "fold", "Neimark–Sacker"]


PASSED = {"x1": 0.01999, "x2": 0.0, "v1": 0.001247, "v2": -0.0001133, "phi": 0.0, "phidot": 35.55}


def passed_with(changes, span):
    """The orbits at the right of the resonance, near the no-load speed at which the captured ones end."""
    case = load_case("II-B", {"c": "0.03", "excitation.Omega0": "5.76 Hz", **changes})
    orbit = find_orbit(case.scene(), PASSED, 1, case=case)
    return subject_of(continue_branch(orbit, "excitation.Omega0", span))


def test_an_operating_point_stays_up_to_the_neimark_sacker_point_and_no_further(captured):
    """5.794011 Hz, and the fold at 5.794093: nearer to either than the points of the branch are."""
    curve = LoadCurve(captured.result, Scale(1e3, "mN m"))
    assert [place.stable for place in crossings(curve, 5.79400)] == [True, False]
    assert [place.stable for place in crossings(curve, 5.79405)] == [False, False]
    assert crossings(curve, 5.79410) == []


@pytest.fixture(scope="module")
def slow():
    """Orbits of one turn about a no-load speed of 3 Hz, which double at 3.067 Hz."""
    case = load_case("II-B", {"c": "0.03", "excitation.Omega0": "3.1 Hz"})
    return continue_branch(orbit(case), "excitation.Omega0", "2.95:3.15 Hz")


def test_a_motor_stays_where_its_orbit_is_only_doubled(slow):
    """At 3 Hz the run settles on an orbit of two turns, with the mean speed of the unstable one to 1e-3."""
    (place,) = crossings(LoadCurve(slow, Scale(1e3, "mN m")), 3.0)
    assert (place.stable, place.stays) == (False, True)
    settled = simulate(load_case("II-B", {"c": "0.03", "excitation.Omega0": "3 Hz"}), trust=False)
    regime, capture = judge_regime(settled), judge_capture(settled)
    assert (regime.verdict, regime.period) == ("periodic", 2)
    assert capture.final_speed_hz == pytest.approx(place.speed, rel=1e-3)
    places = lines(kind_named("load-curve").draw([subject_of(slow)], View()), "operating point")
    assert NEAR.fill in {one.get_fillstyle() for one in places} <= {STAYS.fill, NEAR.fill}
    assert LEAVES.face not in {one.get_markerfacecolor() for one in places}


def test_a_motor_leaves_behind_a_fold_and_behind_the_loss_to_a_growing_beat(captured):
    """5.5 Hz on the two sides of the fold; 5.79405 Hz between the Neimark-Sacker point and the fold."""
    curve = LoadCurve(captured.result, Scale(1e3, "mN m"))
    held, folded = crossings(curve, 5.5)
    assert (held.stays, folded.stays) == (True, False)
    assert [place.stays for place in crossings(curve, 5.79405)] == [False, False]


def test_the_motor_leaps_along_its_line_from_where_captures_end(captured):
    passed = passed_with({}, "5.7:5.9 Hz")
    figure = kind_named("load-curve").draw([captured, passed], View(width="page"))
    (line,) = lines(figure, "line of the leap")
    speed, torque = points(line)
    end = captured.result.special("NS1")
    assert speed[0] == pytest.approx(1 / end.period, rel=1e-12)
    no_load = speed / (1 - torque * 1e-3 / captured.scene.motor.M0)
    assert no_load == pytest.approx([end.parameter] * 2, rel=1e-12)
    beyond = np.interp(end.parameter, passed.result["parameter"], 1 / passed.result["period"])
    assert speed[1] == pytest.approx(beyond, rel=1e-4)
    on_paper(figure)


def test_a_motor_does_not_leap_to_orbits_of_another_machine(captured):
    other = passed_with({"J": "0.0011"}, "5.7:5.9 Hz")
    curves = [LoadCurve(subject.result, Scale(1e3, "mN m")) for subject in (captured, other)]
    assert len(crossings(curves[1], 5.794)) == 1 and leaps_of(curves, (3, 6)) == []


def test_orbits_end_where_the_branch_turns_back_as_the_no_load_speed_rises(captured):
    """The Neimark-Sacker point 8e-5 Hz before the fold; behind the fold nothing was stable before."""
    branch = captured.result
    assert dead_ends(branch) == [branch.special("NS1").orbit]
