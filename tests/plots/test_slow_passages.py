"""Pictures of slow passages and of powers over time: what is drawn, against the samples of the runs."""

import numpy as np
import pytest

import vibsim
from tests.plots.artists import lines, on_paper
from vibsim.cases import load_case
from vibsim.cases.case import load_case_text
from vibsim.cases.ramps import no_load_speed, ramped, read_ramp
from vibsim.plots.registry import fitting, kind_named
from vibsim.plots.slow_passages import power_history
from vibsim.plots.subject import PlotError, View, subject_of
from vibsim.sweeps import sweep

OMEGA0 = read_ramp("Omega0", "3:5:3Hz")


def run_of(ramp, over, changes=None):
    case = load_case("II-B", {"run.t_end": "16 s", "c": "0.03", "phidot": "3 Hz", **(changes or {})})
    return subject_of(vibsim.simulate(ramped(case, [ramp], over), trust=False))


@pytest.fixture(scope="module")
def passage():
    return run_of(OMEGA0, "8 s")


@pytest.fixture(scope="module")
def under():
    case = load_case("II-B", {"run.t_end": "4 s"})
    return subject_of(sweep(case, {"Omega0": "3:5:1 Hz"}, carry_state=True, direction="both"))


def drawn(name, subjects, view=None):
    return on_paper(kind_named(name).draw(subjects, view or View()))


def test_motors_with_formulas_have_the_pictures_of_motors(passage):
    names = {kind.name for kind in fitting([passage])}
    assert {"motor-speed", "displacement-frequency", "run-up", "power"} <= names
    assert "motor" not in names  # whose torque is a line


def test_up_and_down_in_two_colours(passage):
    figure = drawn("run-up", [passage])
    amplitude, speed = figure.axes[:2]
    up, down = lines(speed, "speed")
    assert [line.get_label() for line in (up, down)] == ["run up", "run down"]
    assert up.get_color() != down.get_color()
    assert np.all(np.diff(up.get_xdata()) > 0)
    assert np.all(np.diff(down.get_xdata()) < 0)
    single = np.concatenate([line.get_xdata() for line in lines(speed, "speed-of-turn")])
    passages = np.floor(passage.result["phi"][-1] / (2 * np.pi))  # of multiples of 2 pi, the start left out
    assert len(single) == passages - 1
    assert 3 < single.min() < 3.1
    assert 4.9 < single.max() < 5
    assert len(lines(amplitude, "amplitude")) == 2


def test_speeds_and_amplitudes_are_those_of_the_samples(passage):
    figure = drawn("run-up", [passage])
    amplitude, speed = (lines(figure, f"{name}-of-turn")[0] for name in ("amplitude", "speed"))
    result, k = passage.result, 7
    x = (speed.get_xdata()[k] - 3) * 8 / 2  # the time at which the ramp is there
    turn = np.floor(np.interp(x, result["time"], result["phi"]) / (2 * np.pi))
    ends = np.interp([turn, turn + 1], result["phi"] / (2 * np.pi), result["time"])
    assert speed.get_ydata()[k] == pytest.approx(1 / np.ptp(ends), rel=1e-3)
    inside = (result["time"] >= ends[0]) & (result["time"] < ends[1])
    motion = (result["x1"] - result["x2"])[inside] * 1000
    assert amplitude.get_ydata()[k] == pytest.approx(np.ptp(motion) / 2, rel=1e-9)


def test_a_sweep_lies_under_the_run(passage, under):
    figure = drawn("run-up", [passage, under])
    named = [text.get_text() for text in figure.axes[0].get_legend().get_texts()]
    assert named == ["sweep, up", "sweep, down", "run up", "run down"]
    curves = lines(figure.axes[1], "sweep-speed")
    assert curves[0].get_ydata() == pytest.approx(under.result["mean_speed"][:, 0])
    assert curves[0].get_xdata() == pytest.approx([3, 4, 5])
    means = lines(figure.axes[0], "sweep-amplitude")[0].get_ydata()
    assert means == pytest.approx(1000 * under.result["amplitude_relative"][:, 0])


def test_over_time_where_the_no_load_speed_stays(under):
    run = run_of(read_ramp("M0", "0.003:0.006 N m"), "8 s")
    figure = drawn("run-up", [run])
    assert figure.axes[1].get_xlabel() == "Time (s)"
    assert len(lines(figure.axes[1], "speed")) == 1
    with pytest.raises(PlotError, match="a sweep lies under runs whose no-load speed changes"):
        drawn("run-up", [run, under])


def test_a_window_without_a_turn(passage):
    figure = drawn("run-up", [passage], View(window=(10.0, 10.012)))
    assert any("no whole turn" in text.get_text() for text in figure.axes[0].texts)


def test_the_course_of_the_no_load_speed_beside_the_motor_speed(passage):
    (course,) = lines(drawn("motor-speed", [passage]).axes[0], "no-load")
    assert course.get_ydata() == pytest.approx(no_load_speed(passage.case, course.get_xdata()))
    assert course.get_ydata().max() == pytest.approx(5)


# Powers.


def test_powers_are_those_of_the_laws(passage):
    history = power_history(passage, (0.0, 16.0))
    time, w = passage.result["time"], passage.result["phidot"]
    torque = 0.005 * (1 - w / (2 * np.pi * no_load_speed(passage.case, time)))
    work = np.concatenate(
        [[0], np.cumsum(np.diff(time) * (torque * w)[1:] + np.diff(torque * w) * np.diff(time) / -2)]
    )
    means = np.diff(np.interp(history.edges, time, work)) / np.diff(history.edges)
    (motor,) = history.given.values()
    assert motor == pytest.approx(means, abs=2e-4 * np.abs(means).max())
    loss = 0.03 * np.cumsum((passage.result["v1"] - passage.result["v2"]) ** 2) * 0.005
    losses = np.diff(np.interp(history.edges, time, loss)) / np.diff(history.edges)
    damper = history.taken["loss", "links", "coupling"]
    assert damper == pytest.approx(losses, abs=0.05 * damper.max())


def test_the_first_law_holds_in_every_span(passage):
    history = power_history(passage, (3.0, 16.0))
    given, taken = sum(history.given.values()), sum(history.taken.values())
    assert given == pytest.approx(taken + history.stored, abs=1e-9 * np.abs(given).max())
    assert len(history.middles) > 40
    assert np.abs(history.stored).max() > 0.1 * np.abs(given).max()


def test_the_work_of_all_spans_is_that_of_the_run():
    ideal = subject_of(vibsim.simulate(load_case("I-B", {"run.t_end": "5 s"}), trust=False))
    history = power_history(ideal, (0.0, 5.0))
    spans = history, power_history(ideal, (float(history.edges[-1]), 5.0))
    for entry in history.given | history.taken:
        total = sum(np.dot((each.given | each.taken)[entry], np.diff(each.edges)) for each in spans)
        name = ".".join(filter(None, entry))
        assert total == pytest.approx(float(ideal.result.attrs[name]), rel=1e-9)


def test_the_picture_of_powers(passage):
    (axes,) = drawn("power", [passage]).axes
    assert axes.get_ylabel() in ("Mean power (mW)", "Mean power (W)")
    assert axes.get_xlabel() == "Time (s)"
    labels = axes.get_legend_handles_labels()[1]
    assert labels == ["stored", "motor", "damper: coupling", "friction"]
    assert lines(axes, "work-rotors-motor")


def test_a_sweep_has_no_power_over_time(passage, under):
    with pytest.raises(PlotError, match="runs are drawn over time"):
        drawn("power", [passage, under])


FORCED = """
bodies: {mass: 1 kg}
links: {spring: {between: [mass, ground], k: 400 N/m, c: 4 N s/m}}
forces: {drive: {on: mass, A: 2 N, omega: 2 Hz}}
run: {t_end: 60 s, every: 5 ms}
"""


def test_a_drive_whose_frequency_has_a_ramp_beside_its_steady_response():
    """A linear oscillator passed slowly: the closed form at the frequency of the instant, to the slowness."""
    case = ramped(load_case_text(FORCED), [read_ramp("drive.omega", "2:5Hz")], "60 s")
    run = subject_of(vibsim.simulate(case, trust=False))
    steps = sweep(load_case_text(FORCED), {"drive.omega": "2:5:0.5Hz"})
    figure = drawn("run-up", [run, subject_of(steps)])
    (axes,) = figure.axes
    assert axes.get_xlabel().startswith("Frequency of the drive")
    (line,) = lines(axes, "amplitude")
    rate = 2 * np.pi * line.get_xdata()
    steady = 2000 / np.hypot(400 - rate**2, 4 * rate)
    assert np.abs(line.get_ydata() - steady).max() < 0.06 * steady.max()
    (under,) = lines(axes, "sweep-amplitude")
    assert under.get_xdata() == pytest.approx(np.arange(2, 5.1, 0.5))
