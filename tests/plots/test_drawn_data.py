"""What is drawn is what is on file."""

import math
import shutil

import numpy as np
import pytest

import vibsim
from tests.plots.artists import figure_of, lines, patches, points
from vibsim.physics.parts import EVENT_KINDS, columns_of
from vibsim.plots import samples, time_histories, traces
from vibsim.plots.poincare_sections import _bins
from vibsim.plots.subject import PlotError, open_subjects
from vibsim.plots.traces import dense


def within(result, name, span):
    inside = (result.time >= span[0]) & (result.time <= span[1])
    return result.time[inside], result[name][inside]


def impacts(result, span):
    t, kind = result.events["t"], result.events["kind"]
    return np.count_nonzero((kind == EVENT_KINDS["contact_begin"]) & (t >= span[0]) & (t <= span[1]))


def rows_of(t, all_t):
    return np.flatnonzero(np.isin(all_t, t))


@pytest.mark.parametrize(("kind", "columns"), [("displacement", ("x1", "x2")), ("velocity", ("v1", "v2"))])
def test_short_windows_hold_every_sample(subject, kind, columns):
    one, span = subject("motor"), (12.0, 14.0)
    figure = figure_of(kind, [one], window=span)
    assert len(figure.axes) == 1
    assert figure.axes[0].get_xlim() == span
    factor = 1000 if "(mm" in figure.axes[0].get_ylabel() else 1
    for column in columns:
        t, values = points(lines(figure, column)[0])
        stored_t, stored = within(one.result, column, span)
        assert set(stored_t) <= set(t)
        np.testing.assert_allclose(values[np.searchsorted(t, stored_t)] / factor, stored, rtol=1e-14)
        np.testing.assert_allclose(values / factor, one.result.at(t)[column], atol=1e-12)
        assert len(t) > len(stored_t)


def test_long_windows_keep_the_extremes(subject, monkeypatch):
    monkeypatch.setattr(time_histories, "pixel_columns", lambda axes: 50)
    one = subject("ideal")
    figure = figure_of("displacement", [one])
    assert len(figure.axes) == 2
    for column in ("x1", "x2"):
        t, values = points(lines(figure, column)[0])
        assert len(t) <= 200
        assert values.min() == pytest.approx(one.result[column].min() * 1000, rel=1e-14)
        assert values.max() == pytest.approx(one.result[column].max() * 1000, rel=1e-14)


def test_long_files_are_read_in_blocks(subject, monkeypatch):
    whole = points(lines(figure_of("displacement", [subject("ideal")]), "x1")[0])
    monkeypatch.setattr(samples, "BLOCK", 100)
    monkeypatch.setattr(samples, "POINTS_PER_COLUMN", 0)
    blockwise = points(lines(figure_of("displacement", [subject("ideal")]), "x1")[0])
    assert whole[1].max() == blockwise[1].max()
    assert whole[1].min() == blockwise[1].min()


def test_impacts_are_marked(subject):
    one, detail = subject("motor"), (15.0, 16.0)
    figure = figure_of("displacement", [one], detail=detail)
    whole, *marks = lines(figure, "impacts")
    count = impacts(one.result, (0.0, 20.0))
    assert count > 100
    assert f"{count} impacts" in figure.axes[0].get_title(loc="right")
    assert len(points(whole)[0]) <= count
    assert [len(points(mark)[0]) for mark in marks] == [impacts(one.result, detail)] * 2


def test_contact_is_shaded(subject):
    one = subject("motor")
    spans = samples.contact_spans(one, (15.0, 16.0))
    inside = np.zeros(len(one.result.time), dtype=bool)
    for begin, end in spans:
        inside |= (one.result.time > begin) & (one.result.time < end)
    shown = (one.result.time > 15.0) & (one.result.time < 16.0)
    np.testing.assert_array_equal(inside[shown], one.result["contact"][shown] == 1)


def test_detail_is_chosen_where_there_are_impacts(subject):
    one = subject("motor")
    detail = figure_of("displacement", [one]).axes[1].get_xlim()
    assert detail[1] - detail[0] < 5
    assert impacts(one.result, detail) > 0


def test_detail_outside_the_window(subject):
    with pytest.raises(PlotError, match=r"detail 30:31 lies outside what is shown, 0–20 s"):
        figure_of("displacement", [subject("motor")], detail=(30.0, 31.0))


def test_window_outside_the_run(subject):
    with pytest.raises(PlotError, match=r"window 400:410 lies outside .*motor\.h5, which covers 0 to 20 s"):
        figure_of("phase", [subject("motor")], window=(400.0, 410.0))


def test_window_is_cut_to_the_run(subject):
    figure = figure_of("displacement", [subject("motor")], window=(19.0, math.inf))
    assert figure.axes[0].get_xlim() == (19.0, 20.0)


@pytest.mark.parametrize(("name", "columns"), [("motor", ("x1", "x2")), ("fixed", ("x1",))])
def test_phase_portraits(subject, name, columns):
    one, span = subject(name), (5.0, 7.0)
    figure = figure_of("phase", [one], window=span)
    assert len(figure.axes) == len(columns)
    for axes, column in zip(figure.axes, columns, strict=True):
        names, labels = (column, f"v{column[1]}"), (axes.get_xlabel(), axes.get_ylabel())
        factors = [1000 if label.endswith(("(mm)", "(mm/s)")) else 1 for label in labels]
        stored = [
            factor * within(one.result, name, span)[1] for name, factor in zip(names, factors, strict=True)
        ]
        drawn = points(lines(figure, column)[0])
        path, asked = ({*map(tuple, np.round(np.transpose(pair), 9))} for pair in (drawn, stored))
        assert asked <= path
        assert "5–7 s" in axes.get_title(loc="right")


@pytest.mark.parametrize(("name", "side"), [("motor", -1.0), ("fixed", 1.0)])
def test_relative_portrait_has_the_stop(subject, name, side):
    figure = figure_of("relative", [subject(name)])
    (stop,) = lines(figure, "stop")
    assert "(mm)" in figure.axes[0].get_xlabel()
    assert set(points(stop)[0]) == {side}


def test_no_stop_no_stop_line(subject):
    assert lines(figure_of("relative", [subject("bare")]), "stop") == []


def test_relative_data(subject):
    one, span = subject("motor"), (10.0, 12.0)
    y, u = points(lines(figure_of("relative", [one], window=span), "relative")[0])
    expected = (within(one.result, "x1", span)[1] - within(one.result, "x2", span)[1]) * 1000
    assert y.max() >= expected.max()
    assert set(np.round(expected, 9)) <= set(np.round(y, 9))
    assert len(u) == len(y)


def test_long_portraits_are_thinned_and_rasterized(subject, monkeypatch):
    monkeypatch.setattr(traces, "SMOOTH_UP_TO", 0)
    monkeypatch.setattr(traces, "LINE_UP_TO", 100)
    monkeypatch.setattr(traces, "VECTOR_UP_TO", 1000)
    one = subject("motor")
    (line,) = lines(figure_of("relative", [one], window=(0.0, 20.0)), "relative")
    y = (one.result["x1"] - one.result["x2"]) * 1000
    assert line.get_linestyle() == "None"
    assert line.get_rasterized()
    assert set(np.round(points(line)[0], 9)) <= set(np.round(y, 9))


def test_motor_speed(subject):
    one = subject("motor")
    figure = figure_of("motor-speed", [one])
    _, hertz = points(lines(figure, "phidot")[0])
    assert hertz.max() == pytest.approx(one.result["phidot"].max() / (2 * math.pi))
    levels = [points(line)[1][0] for line in lines(figure, "level")]
    low, high = figure.axes[0].get_ylim()
    assert all(low < level < high for level in levels)
    for known in (5.5, 4.130, 4.149):
        assert (low < known < high) == any(level == pytest.approx(known, abs=5e-4) for level in levels)
    assert len(levels) >= 3
    t, mean = points(lines(figure, "mean")[0])
    assert mean[-1] == pytest.approx(np.mean(hertz[-200:]), rel=0.05)
    assert t[-1] < 20


def test_levels_far_from_the_data_are_left_out(subject):
    figure = figure_of("motor-speed", [subject("motor")], window=(0.0, 3.0))
    assert len(lines(figure, "level")) < len(lines(figure_of("motor-speed", [subject("motor")]), "level"))


def test_displacement_against_frequency(subject):
    one = subject("motor")
    hertz, x = points(lines(figure_of("displacement-frequency", [one]), "x1")[0])
    inside = rows_of(one.result["x1"] * 1000, x)
    assert len(inside) >= len(one.result.time)
    assert hertz.max() >= one.result["phidot"].max() / (2 * math.pi) * (1 - 1e-15)


def test_impact_velocities(subject):
    one = subject("motor")
    figure = figure_of("impact-velocity", [one])
    over_time, over_phase = lines(figure, "impacts")
    rows = one.result.events["kind"] == EVENT_KINDS["contact_begin"]
    closing = (one.result.events["v2"] - one.result.events["v1"])[rows]
    assert closing.min() > 0
    factor = 1000 if "(mm/s)" in figure.axes[0].get_ylabel() else 1
    np.testing.assert_allclose(points(over_time)[1], closing * factor)
    np.testing.assert_array_equal(points(over_time)[0], one.result.events["t"][rows])
    late = rows & (one.result.events["t"] >= 10.0)  # the transient has no place among the phases
    phase = np.mod(one.result.events["phi"][late], 2 * math.pi) * 180 / math.pi
    np.testing.assert_allclose(points(over_phase)[0], phase, atol=1e-9)


def test_impacts_on_the_other_side_close_too(subject):
    over_time, _ = lines(figure_of("impact-velocity", [subject("fixed")]), "impacts")
    assert len(points(over_time)[1]) > 5
    assert points(over_time)[1].min() >= 0


def test_stroboscopic_section_of_the_ideal_source(subject):
    one, span = subject("ideal"), (10.0, 20.0)
    y, u = points(lines(figure_of("stroboscopic", [one], window=span), "section")[0])
    states = one.result.at(np.arange(65, 131) / 6.5)
    np.testing.assert_allclose(y, (states["x1"] - states["x2"]) * 1000, atol=1e-9)
    np.testing.assert_allclose(u, (states["v1"] - states["v2"]) * 1000, atol=1e-6)


def test_stiffness_is_the_two_stage_characteristic(subject):
    figure = figure_of("stiffness", [subject("motor")])
    y, force = points(lines(figure, "stiffness")[0])
    assert (figure.axes[0].get_xlabel()[-4:], figure.axes[0].get_ylabel()[-3:]) == ("(mm)", "(N)")
    slopes = np.diff(force) / np.diff(y) * 1000
    np.testing.assert_allclose(slopes, [12600, 200])
    np.testing.assert_allclose([y[1], force[1]], [-1, -0.2])


def test_stiffness_mirrored_and_without_stop(subject):
    y, force = points(lines(figure_of("stiffness", [subject("fixed")]), "stiffness")[0])
    np.testing.assert_allclose(np.diff(force) / np.diff(y) * 1000, [200, 12600])
    y, force = points(lines(figure_of("stiffness", [subject("bare")]), "stiffness")[0])
    assert len(y) == 2


def test_motor_characteristic(subject):
    speed, torque = points(lines(figure_of("motor", [subject("motor"), subject("motor2")]), "motor")[1])
    assert (speed[0], torque[0]) == (0.0, pytest.approx(5.0))
    assert np.interp(6.5, speed, torque) == pytest.approx(0.0, abs=1e-12)


def test_trust_horizon_is_drawn(subject):
    one = subject("motor")
    del one.result.attrs["trust_horizon_s"]
    assert lines(figure_of("displacement", [one]), "trust-horizon") == []
    one.result.attrs["trust_horizon_s"] = 7.5
    figure = figure_of("displacement", [one])
    assert points(lines(figure, "trust-horizon")[0])[0][0] == 7.5
    assert "trust horizon 7.5 s" in figure.axes[0].get_title(loc="right")
    [beyond] = patches(figure.axes[0], "beyond-trust")
    assert (beyond.get_x(), beyond.get_x() + beyond.get_width()) == (7.5, figure.axes[0].get_xlim()[1])
    signs = "rings: impacts; grey: contact\nbeyond the trust horizon, 7.5 s"
    assert figure.axes[1].get_title(loc="right") == signs


def test_a_run_that_is_right_to_the_end_is_not_marked(subject):
    one = subject("motor")
    one.result.attrs["trust_horizon_s"] = one.result.t_reached
    figure = figure_of("displacement", [one])
    assert lines(figure, "trust-horizon") == []
    assert "trust" not in "".join(axes.get_title(loc="right") for axes in figure.axes)


def test_repeated_names_become_file_names(runs, tmp_path):
    copy = tmp_path / "again.h5"
    shutil.copy(runs["motor"], copy)
    assert [one.name for one in open_subjects([runs["motor"], str(copy)])] == ["motor", "again"]
    assert [one.name for one in open_subjects([runs["motor"], runs["ideal"]])] == ["II-B", "I-C"]


def test_equal_impacts_have_a_bar_that_can_be_seen():
    """Bins over the range of the velocities had no height where these differ by rounding alone."""
    count, (low, high) = _bins(np.array([0.35, 0.35 + 1e-15]))
    assert count == 1 and high - low == pytest.approx(0.012 * 0.35) and low < 0.35 < high
    assert _bins(np.linspace(0.0, 1.0, 1000)) == (40, (0.0, 1.0))
    assert _bins(np.linspace(0.0, 1.0, 27)) == (12, (0.0, 1.0))  # of few impacts few bins
    count, (low, high) = _bins(np.array([0.95, 1.0]))
    assert count == 4 and (low, high) == (0.95, 1.0)


def test_long_portraits_keep_the_blows(monkeypatch):
    """Where a span needed too many instants it was joined through samples: no blow came to the stop."""
    run = vibsim.simulate("gallery/impact-oscillator", overrides={"run.t_end": "60 s", "run.every": "0.5 s"})
    body = run.case.scene().bodies[0].name
    x, v = columns_of(body)
    monkeypatch.setattr("vibsim.plots.traces.AT_MOST", 300)
    drawn = dense(run, (x, v), (0.0, 60.0))
    blows = run.events["kind"] == EVENT_KINDS["impact"]
    assert blows.sum() > 10 and len(drawn["time"]) < 300 + 121 + 2 * len(run.events["t"])
    path = set(zip(drawn["time"].tolist(), drawn[v].tolist(), strict=True))
    for side in (v, f"before_{v}"):
        struck = zip(run.events["t"][blows].tolist(), run.events[side][blows].tolist(), strict=True)
        assert set(struck) <= path
    steps = np.diff(np.unique(drawn["time"]))
    assert steps.max() < 0.3  # of samples 0.5 s apart, were there nothing between them
