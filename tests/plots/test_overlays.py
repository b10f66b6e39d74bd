"""Branches over frequency responses and bifurcation diagrams: right values, and labels that can be read."""

import math
from itertools import combinations

import numpy as np
import pytest
from matplotlib.figure import Figure

from tests.branches.made import CAPTURED, branch_of
from tests.plots.artists import legend, lines, notes, on_paper, words
from vibsim import orbit
from vibsim.cases import load_case
from vibsim.cases.case import load_case_text
from vibsim.orbits.branches.continuing import continue_branch
from vibsim.plots.branch_curves import LabelledPoint, label_points
from vibsim.plots.registry import choose, kind_named
from vibsim.plots.subject import PlotError, Subject, View, subject_of
from vibsim.plots.sweep_curves import leaps
from vibsim.sweeps import sweep

M, K, C, A = 2.0, 300.0, 4.0, 1.5
LINEAR = f"""
bodies: {{mass: {M} kg}}
links: {{spring: {{between: [mass, ground], k: {K} N/m, c: {C} N s/m}}}}
forces: {{drive: {{on: mass, A: {A} N, omega: 1.5 Hz}}}}
run: {{t_end: 40 s, every: 10 ms}}
"""


@pytest.fixture(scope="module")
def linear():
    """A linear oscillator swept over its resonance, and the branch of its orbits."""
    case = load_case_text(LINEAR)
    return sweep(case, {"omega": "1:3/9 Hz"}), continue_branch(case, "omega", "1:3 Hz")


@pytest.fixture(scope="module")
def impacts():
    """An oscillator with one impact in two periods."""
    case = load_case("gallery/impact-oscillator")
    swept = sweep(case.with_values({"run.t_end": "300 s"}), {"omega": "0.56:0.6:0.01 Hz"}, section=40)
    return swept, continue_branch(case, "omega", "0.55:0.61 Hz")


def test_a_frequency_response_of_any_source_has_its_branch(linear):
    """The amplitude in the steady state is A / |k - m w^2 + i c w|."""
    swept, branch = linear
    figure = kind_named("amplitude").draw([subject_of(swept), subject_of(branch)], View())
    (line,) = lines(figure, "stable")
    hertz, drawn = line.get_data()
    w = 2 * math.pi * hertz
    exact = 1e3 * A / np.hypot(K - M * w**2, C * w)  # mm
    np.testing.assert_allclose(drawn, exact, rtol=1e-4)
    assert hertz.min() == pytest.approx(1) and hertz.max() == pytest.approx(3)
    assert "stable" in legend(figure)


def test_a_bifurcation_diagram_has_a_line_for_each_period_of_an_orbit(impacts):
    """At every frequency that was swept too, the lines lie where the settled run has its points."""
    swept, branch = impacts
    assert branch.plan.n == 2
    figure = kind_named("bifurcation").draw([subject_of(swept), subject_of(branch)], View())
    axes = figure.axes[0]
    own = [np.array(line.get_data())[:, np.argsort(line.get_xdata())] for line in lines(axes, "stable")]
    assert len(own) == 2
    (dots,) = [line for line in axes.get_lines() if line.get_gid().startswith("section")]
    x, y = dots.get_data()
    for hertz, value in zip(x, y, strict=True):
        assert min(abs(np.interp(hertz, *curve) - value) for curve in own) < 1e-3 * np.ptp(y)


def test_a_branch_over_something_else_is_refused(linear):
    swept, _ = linear
    case = load_case_text(LINEAR)
    branch = continue_branch(case, "links.spring.k", "250:350 N/m")
    with pytest.raises(PlotError, match=r"a branch over links.spring.k does not lie over a sweep along"):
        kind_named("amplitude").draw([subject_of(swept), subject_of(branch)], View())


def test_a_branch_of_another_machine_is_named(linear):
    swept, _ = linear
    other = continue_branch(load_case_text(LINEAR.replace("c: 4.0", "c: 9")), "omega", "1:3 Hz")
    figure = kind_named("amplitude").draw([subject_of(swept), subject_of(other)], View())
    assert "another value of: Damping $c$ of spring" in figure.axes[0].get_title(loc="right")


def test_kinds_go_by_the_names_of_the_field(linear):
    swept, branch = linear
    both = run, curve = [subject_of(swept), subject_of(branch)]
    assert [kind.name for kind in choose(["bifurcation"], [run])] == ["orbit"]
    assert [kind.name for kind in choose(["bifurcation"], [curve])] == ["branch"]
    names = ["frequency-response", "bifurcation"]
    assert [kind.name for kind in choose(names, both)] == ["amplitude", "orbit"]
    assert kind_named("poincare").name == "stroboscopic"
    with pytest.raises(PlotError, match="did you mean poincare"):
        kind_named("poincar")


@pytest.fixture(scope="module")
def held():
    """The branch of a motor that is held."""
    return continue_branch(orbit("II-B", overrides={"c": "0.03", "Omega0": "3.8 Hz"}), "Omega0", "3:6 Hz")


@pytest.mark.parametrize("kind", ["branch", "load-curve"])
@pytest.mark.parametrize("width", ["column", "page"])
def test_special_points_carry_the_labels_of_the_list_and_none_hides_another(held, kind, width):
    (axes,) = on_paper(kind_named(kind).draw([subject_of(held)], View(width=width))).axes
    listed = {special.label for special in held.specials}
    assert {"F1", "PD1"} <= {*words(axes, "special label")} <= listed
    boxes = [text.get_window_extent() for text in notes(axes, "special label")]
    assert not any(one.overlaps(other) for one, other in combinations(boxes, 2))
    assert all(axes.bbox.x0 < box.x0 and box.x1 < axes.bbox.x1 for box in boxes)


def test_labels_crowded_at_a_point_spread_and_what_has_no_room_is_counted():
    axes = Figure(figsize=(3, 2)).subplots()
    axes.plot([0, 1], [0, 1])
    assert label_points(axes, [LabelledPoint(0.5, 0.5, f"PD{i}") for i in range(12)]) == 0
    boxes = [text.get_window_extent() for text in axes.texts]
    assert len(boxes) == 12 and not any(a.overlaps(b) for a, b in combinations(boxes, 2))
    assert label_points(axes, [LabelledPoint(0.5, 0.5, f"a long label {i}") for i in range(60)]) > 0
    assert label_points(axes, [LabelledPoint(5, 5, "outside")]) == 0


@pytest.fixture(scope="module")
def speeds():
    """A short sweep over the motor constant, and a branch over it."""
    branch = branch_of(CAPTURED, "4.9:6 Hz")
    return sweep(branch.case, {"Omega0": "5, 6 Hz"}, overrides={"run.t_end": "20 s"}), branch


def test_one_branch_labels_its_points_over_a_sweep_of_speeds(speeds):
    swept, branch = speeds
    for kind in ("sommerfeld", "amplitude"):
        figure = on_paper(kind_named(kind).draw([subject_of(swept), subject_of(branch)], View(width="page")))
        assert {*words(figure, "special label")} & {special.label for special in branch.specials}


def test_labels_of_several_branches_say_whose_they_are(speeds):
    swept, branch = speeds
    several = [Subject(f"{name}.h5", name, "branch", branch.case, branch) for name in "ab"]
    figure = on_paper(kind_named("sommerfeld").draw([subject_of(swept), *several], View(width="page")))
    assert {text.partition(":")[0] for text in words(figure, "special label")} == {"1", "2"}
    assert {"1: a", "2: b"} <= {*legend(figure)}
    crowd = kind_named("sommerfeld").draw([subject_of(swept), *several * 3], View(width="page"))
    assert not words(crowd, "special label")


def test_no_line_is_drawn_where_values_leap():
    steady = np.array([1, 1.1, 1.2, 1.3, 5.0, 5.1, 5.2])
    assert leaps(steady).tolist() == [3]
    assert leaps(np.array([1.0, 4, 2, 5, 1, 4])).tolist() == []  # scatter is no leap
    assert leaps(np.sin(np.linspace(0, 6, 40))).tolist() == []
    assert leaps(np.full(5, np.nan)).tolist() == []
    with np.errstate(all="raise"):
        assert leaps(np.array([-np.inf, -np.inf, 1.0, 2.0, 3.0])).tolist() == []  # a motion at rest


def test_a_sweep_that_leaps_has_all_its_points_and_a_gap_in_its_line():
    """Up the stop holds the motion long: it falls off between two frequencies."""
    case = load_case("I-A", {"c": "0.05", "run.t_end": "40 s"})
    swept = sweep(case, {"omega": "2:8:0.1 Hz"}, carry_state=True)
    axes = kind_named("amplitude").draw([subject_of(swept)], View()).axes[0]
    (points,), (joined,) = lines(axes, "relative"), lines(axes, "joined")
    assert points.get_linestyle() == "None" and len(points.get_xdata()) == 61
    assert np.isnan(joined.get_ydata()).sum() >= 1
