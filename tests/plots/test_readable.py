"""What makes a picture readable: ticks, legends, spans, areas, angles, words of torques and angles."""

import math

import numpy as np
import pytest
from matplotlib.figure import Figure

from tests.plots.artists import lines, points
from vibsim.cases.case import load_case_text
from vibsim.cases.ramps import Ramp, ramped
from vibsim.plots.overview import stiffness_panel
from vibsim.plots.poincare_sections import impact_velocity_picture, stroboscopic_picture
from vibsim.plots.portraits import phase_picture, relative_picture
from vibsim.plots.registry import choose
from vibsim.plots.samples import Frequency
from vibsim.plots.sheet import FewTicks, Scale, columns_of, scale_for, seconds, signed
from vibsim.plots.slow_passages import run_up_picture
from vibsim.plots.subject import View, subject_of
from vibsim.plots.sweep_curves import fill, leaps
from vibsim.plots.sweep_pictures import sommerfeld_picture
from vibsim.plots.time_histories import displacement_picture
from vibsim.plots.traces import Trace, draw_trace, folded
from vibsim.results.simulation import simulate
from vibsim.sweeps import sweep

COLUMN = View(width="column")
PENDULUM = """
name: turning
bodies: {rod: 1 kg m^2}
links: {weight: {between: [rod, ground], force: "M*sin(d)", M: 1 N m}}
initial: {rod: {v: 3 rad/s}}
run: {t_end: 10 s, every: 50 ms}
"""
FED = """
name: fed
bodies: {table: 20 kg}
links: {spring: {between: [table, ground], k: 20 kN/m, c: 20 N s/m}}
motor: {on: table, m3: 0.2 kg, e: 50 mm, J: 2 g m^2, M0: a*U, Omega0: b*U, U: 4 V, a: 25 mN m/V, b: 2 Hz/V}
run: {t_end: 3 s, every: 10 ms}
"""


@pytest.fixture(scope="module")
def turning():
    return subject_of(simulate(load_case_text(PENDULUM)))


def characteristic(subject):
    """The panel of the force over the motion, and the places of its line."""
    axes = Figure().subplots()
    stiffness_panel(axes, [subject])
    return axes, points(lines(axes, "stiffness")[0])[0]


def test_ticks_of_long_numbers_are_few():
    """Numbers and the room between them go into the width, in characters."""
    assert len(FewTicks(40).tick_values(0.0, 1.0)) == 6
    assert len(FewTicks(28).tick_values(0.0, 1.0)) == 3
    low, high = 999.999981, 1000.000019
    ticks = FewTicks(45).tick_values(low, high)
    assert len(ticks[(ticks > low) & (ticks < high)]) == 3  # such as 1000.00001: 10 characters and 2 between


def test_a_legend_has_as_many_columns_as_its_names_allow():
    short, one_long = ["ab"] * 10, ["a name of twenty chrs", *["ab"] * 9]
    assert columns_of(short, 45) == 5 and columns_of(short, 12) == 1
    assert columns_of(one_long, 45) == 2  # that of the long name, and one beside it
    assert columns_of(["a"], 1) == 1


@pytest.mark.parametrize(
    ("span", "text"),
    [((290.0, 300.0), "290–300 s"), ((0.0, 0.270123), "0–0.27 s"), ((0.0, 1.42857), "0–1.43 s"),
     ((1e6, 1e6 + 50), "1000000–1000050 s"), ((9.7, 9.75), "9.7–9.75 s"), ((2.0, 2.0), "2–2 s")],
)  # fmt: skip
def test_a_span_has_three_digits_of_its_length(span, text):
    assert seconds(span) == text


def test_numbers_beside_lines():
    assert [Frequency("f", "f", hz).text for hz in (22.508, 0.15915)] == ["f  22.51", "f  0.159"]
    assert signed(-2.1834) == "\N{MINUS SIGN}2.18"
    assert scale_for("W", [3e-16]).unit == "aW" and scale_for("W", [3e13]).unit == "TW"
    assert scale_for("m", [5e-12]).unit == "pm" and scale_for("m", [5e9]).unit == "km"


def test_no_area_lies_between_far_values():
    """Values that leap between 2 and 3: an area on either side, none across."""
    x, low = np.arange(6.0), np.array([0.0, 0.1, 0.2, 9.0, 9.1, 9.2])
    axes = Figure().subplots()
    fill(axes, x, low, low + 1, leaps(low))
    (area,) = axes.collections
    spans = sorted((path.vertices[:, 0].min(), path.vertices[:, 0].max()) for path in area.get_paths())
    assert spans == [(0, 2), (3, 5)]


def test_an_angle_is_drawn_up_to_whole_turns(turning):
    folded_x = folded(Trace(np.array([3.0, 3.2, 9.5]), np.array([1.0, 2.0, 3.0]), joined=True)).x
    assert folded_x[[0, 2, 4]] == pytest.approx([3.0, 3.2 - 2 * math.pi, 9.5 - 4 * math.pi])
    assert np.isnan(folded_x[[1, 3]]).all()  # the line is broken from turn to turn
    assert turning.result.column("x_rod")[-1] > 2 * math.pi
    for picture, gid in ((phase_picture, "x_rod"), (relative_picture, "relative")):
        figure = picture([turning], COLUMN)
        x, _ = points(lines(figure, gid)[0])
        assert np.nanmax(np.abs(x)) <= math.pi and np.isnan(x).any()
        assert "angle up to whole turns" in figure.axes[0].get_title(loc="right")


def test_what_turns_has_angles_and_torques(turning):
    assert displacement_picture([turning], COLUMN).axes[0].get_ylabel() == "Angle (rad)"
    axes = relative_picture([turning], COLUMN).axes[0]
    assert axes.get_ylabel().startswith("Angular velocity")
    axes, angles = characteristic(turning)
    assert "torque" in axes.get_ylabel() and axes.get_xlabel().startswith("Angle")
    assert np.abs(angles).max() == pytest.approx(2 * math.pi)


def test_a_characteristic_reaches_as_far_as_the_run():
    text = """
bodies: {m: 1 kg}
links: {s: {between: [m, ground], k: 1 N/m}}
initial: {m: {v: 2 m/s}}
run: {t_end: 7 s, every: 10 ms}
"""
    run = subject_of(simulate(load_case_text(text)))
    _, x = characteristic(run)
    assert x.max() == pytest.approx(2.4, rel=1e-3)  # 1.2 times the amplitude v sqrt(m/k)
    driven = text.replace("initial: {m: {v: 2 m/s}}", "forces: {f: {on: m, A: 3 N, omega: 2 rad/s}}")
    _, x = characteristic(subject_of(load_case_text(driven)))
    assert x.max() == pytest.approx(3.0)  # A/k


def test_a_motion_at_rest_is_a_point():
    axes = Figure().subplots()
    draw_trace(axes, Trace(np.full(5, 2.0), np.zeros(5), joined=True), (Scale(1, "m"), Scale(1, "m/s")))
    (line,) = axes.get_lines()
    assert line.get_marker() == "o" and line.get_xdata().tolist() == [2.0]


def test_panels_without_impacts_and_periods_say_so(subject):
    figure = impact_velocity_picture([subject("quiet")], COLUMN)
    assert [text.get_text() for text in figure.axes[0].texts if text.get_gid() != "letter"] == ["no impacts"]
    assert not any(len(axes.get_yticks()) for axes in figure.axes)
    short = subject_of(simulate(load_case_text(FED), {"run.t_end": "0.05 s"}))
    axes = stroboscopic_picture([short], COLUMN).axes[0]
    assert not len(axes.get_xticks()) and axes.texts[0].get_text() == "no period of the source ends here"


def test_speeds_over_a_voltage():
    """M0 and Omega0 are proportional to U: the no-load speed is 2 Hz per volt, and runs go over the sweep."""
    case = load_case_text(FED)
    steady = subject_of(sweep(case, {"U": "2:4:1 V"}, carry_state=True, direction="both", jobs=1))
    assert [kind.name for kind in choose(None, [steady])] == ["sommerfeld"]
    figure = sommerfeld_picture([steady], COLUMN)
    x, hertz = points(lines(figure, "no-load")[0])
    assert (x.tolist(), hertz.tolist()) == ([2, 3, 4], pytest.approx([4, 6, 8]))
    assert figure.axes[0].get_xlabel() == "U (V)"
    np.testing.assert_array_equal(points(lines(figure, "mean")[0])[1], steady.result["mean_speed"][:, 0])
    run = simulate(ramped(case, [Ramp("U", ("2 V", "4 V"))], "3 s"))
    figure = run_up_picture([subject_of(run), steady], COLUMN)
    assert points(lines(figure, "sweep-speed")[0])[0].tolist() == pytest.approx([4, 6, 8])


def test_the_angle_of_a_shaft_grows():
    """No force feels it: it is not drawn up to whole turns."""
    weight = 'links: {weight: {between: [rod, ground], force: "M*sin(d)", M: 1 N m}}'
    shaft = PENDULUM.replace(weight, 'forces: {drive: {on: rod, force: "T*cos(t/s)", T: 1 N m, s: 1 s}}')
    figure = phase_picture([subject_of(simulate(load_case_text(shaft)))], COLUMN)
    assert points(lines(figure, "x_rod")[0])[0].max() > 20


def test_speeds_of_a_rotor_whose_torque_has_no_straight_line():
    """There is no M0 and Omega0: the speeds are drawn over U without a line of the no-load speed."""
    text = FED.replace("M0: a*U, Omega0: b*U", 'torque: "a*U*(1 - (w/(b*U))**3)"')
    swept = subject_of(sweep(load_case_text(text, {"run.t_end": "2 s"}), {"U": "3, 4 V"}, jobs=1))
    assert [kind.name for kind in choose(None, [swept])] == ["sommerfeld"]
    figure = sommerfeld_picture([swept], COLUMN)
    np.testing.assert_array_equal(points(lines(figure, "mean")[0])[1], swept.result["mean_speed_motor"][:, 0])
    assert not lines(figure, "no-load")
