"""Frequencies and amplitudes of signals that are known."""

import numpy as np
import pytest

from tests.results.made import short_run
from vibsim.analysis.analysis import find_frequencies, lines_of, order_of

T = np.arange(0, 30_001) * 5e-3


def test_two_lines_on_a_drift():
    x = 3.0 + 0.2 * T + 2e-3 * np.sin(2 * np.pi * 5.4321 * T + 1) + 5e-4 * np.cos(2 * np.pi * 1.2345 * T)
    lines, resolution = lines_of(x, 5e-3)
    assert resolution == pytest.approx(4 / 150, rel=1e-3)
    assert [line.hz for line in lines] == pytest.approx([5.4321, 1.2345], abs=2e-4)
    assert [line.amplitude for line in lines] == pytest.approx([2e-3, 5e-4], rel=2e-3)


@pytest.mark.parametrize(("apart", "count"), [(0.5, 1), (0.8, 1), (1.5, 2)])
def test_lines_are_told_apart_beyond_the_resolution(apart, count):
    resolution = 4 / 150
    x = np.sin(2 * np.pi * 5 * T) + np.sin(2 * np.pi * (5 + apart * resolution) * T)
    assert len(lines_of(x, 5e-3)[0]) == count


def test_weak_lines_beside_strong_ones_are_found_down_to_the_floor():
    x = np.sin(2 * np.pi * 5 * T) + 0.02 * np.sin(2 * np.pi * 5.1 * T) + 0.005 * np.sin(2 * np.pi * 9 * T)
    lines, _ = lines_of(x, 5e-3)
    assert [line.amplitude for line in lines] == pytest.approx([1, 0.02], rel=0.01)


def test_orders_of_the_source():
    assert [order_of(hz, 5.5, 0.03) for hz in (5.5, 11.001, 5.5 * 7 / 5, 5.5 / 3, 7.0)] == [
        "1",
        "2",
        "7/5",
        "1/3",
        None,
    ]
    assert order_of(5.5, 5.5, 0.5) is None  # 5/6 and 1 lie closer than that
    assert order_of(5.5, None, 0.03) is None


SPANS = [*np.arange(0.5, 12, 0.25).tolist(), 15.3, 20.0, 47.7, 99.9, 150.0, 300.0]  # periods
UNTIL = 4.0  # periods that the main lobe of the window is wide


@pytest.mark.parametrize("periods", SPANS)
def test_one_line_is_found_right_or_not_at_all_whatever_the_span(periods):
    """Half the main lobe of the window is 4/T: of fewer than four periods nothing can be told from a drift.

    A parabola through the logarithm of the main lobe, sampled four to its 1/T, misses its top by 1e-4 of
    4/T; the mirror image at -f, 2f away, adds less where 2f is more than 8/T.
    """
    draws = np.random.default_rng(round(100 * periods))
    for per_period in (4.6, 17.3, 40.0):
        count = max(64, round(periods * per_period))
        t = np.arange(count) * (periods / 5 / count)
        x = 1e-3 * np.sin(2 * np.pi * 5 * t + draws.uniform(0, 7)) + draws.choice([0.0, 0.3, -1.0])
        x = x + draws.choice([0.0, 1e-3, 0.1]) * t
        lines, resolution = lines_of(x, float(t[1]))
        assert resolution == pytest.approx(4 * 5 / periods)
        assert len(lines) == (periods > UNTIL + 0.5) or (len(lines) < 2 and periods > UNTIL - 0.1)
        for line in lines:
            assert line.hz == pytest.approx(5.0, abs=5e-4 * resolution)
            assert line.amplitude == pytest.approx(1e-3, rel=1e-3)


@pytest.mark.parametrize("periods", [6.0, 12.5, 40.0, 300.0])
def test_three_lines_on_a_curved_drift(periods):
    """A run-up that dies out leaves slow motion of any shape; it is no line, and shifts none by its lobes."""
    t = np.arange(round(60 * periods)) * (1 / 300)
    x = np.exp(-3 * t / t[-1]) * 4e-3 + 2e-3 * np.cos(2 * np.pi * 5 * t + 1)
    x = x + 5e-4 * np.sin(2 * np.pi * 10 * t) + 1e-4 * np.sin(2 * np.pi * 20 * t + 2)
    lines, resolution = lines_of(x, 1 / 300)
    assert [line.hz for line in lines] == pytest.approx([5, 10, 20], abs=5e-3 * resolution)
    assert [line.amplitude for line in lines] == pytest.approx([2e-3, 5e-4, 1e-4], rel=0.03)


@pytest.mark.parametrize("t_end", ["1 s", "2 s", "3 s", "4 s", "15 s"])
def test_short_runs_have_no_lines_beyond_what_moves(t_end):
    run = short_run("II-B", t_end)
    found = find_frequencies(run)
    half_range = np.ptp(run["x1"] - run["x2"]) / 2
    assert all(line.amplitude <= half_range and line.hz > 0.99 * found.resolution_hz for line in found.lines)
    assert found.verdict == ("lines" if found.lines else "undecided")


def test_where_the_span_holds_no_four_periods_it_says_so():
    changes = {"excitation": "none", "friction": "none", "stop": "none", "initial__x1": "1 mm"}
    found = find_frequencies(short_run("I-A", "60 s", **changes), (50.0, 50.7))  # 3 periods
    assert (found.verdict, found.lines) == ("undecided", ())
    assert "no vibration above 5.67 Hz, of which 0.7 s hold four periods" in found.reason


def test_nothing_vibrates():
    assert lines_of(0.3 * T, 5e-3)[0] == ()
    assert lines_of(np.zeros(1000), 5e-3)[0] == ()


def test_a_linear_oscillator_answers_with_the_frequency_and_amplitude_of_theory():
    """V4: fixed block 2, no stop: A / sqrt((k1 - m1 w^2)^2 + (c w)^2)."""
    changes = {"blocks__m2": "fixed", "friction": "none", "stop": "none", "coupling__c": "2 N s/m"}
    run = short_run("I-B", "60 s", **changes)
    (line,) = find_frequencies(run, (20.0, 60.0)).lines
    w = 2 * np.pi * 5.5
    expected = 0.114 / np.hypot(200 - 0.297 * w**2, 2 * w)
    assert line.hz == pytest.approx(5.5, abs=1e-4)
    assert line.amplitude == pytest.approx(expected, rel=1e-3)
    assert line.order == "1"


def test_a_free_vibration_has_its_natural_frequency():
    """V2: 4.3337 Hz, amplitude x1 m2/(m1 + m2) of the relative motion about its centre: here x1 itself."""
    run = short_run(
        "I-A", "60 s", excitation="none", friction="none", stop="none", coupling__c="0", initial__x1="1 mm"
    )
    found = find_frequencies(run)
    assert found.source_hz is None
    assert found.lines[0].hz == pytest.approx(4.3337, abs=1e-4)
    assert found.lines[0].amplitude == pytest.approx(1e-3, rel=1e-3)


def test_the_captured_motor_makes_the_blocks_vibrate_at_twice_its_speed():
    found = find_frequencies(short_run("II-B", "300 s", coupling__c="0.03 N s/m"))
    assert [line.order for line in found.lines[:2]] == ["2", "1"]
    assert found.lines[0].hz == pytest.approx(7.37, abs=0.03)  # the bilinear frequency
    assert found.lines[1].hz == pytest.approx(found.source_hz, abs=1e-3)


def test_samples_too_far_apart_show_no_false_frequencies():
    run = short_run("I-B", "300 s", run__every="100 ms")
    found = find_frequencies(run)
    assert (found.verdict, found.lines) == ("undecided", ())
    assert "0.1 s apart miss vibrations at 5.5 Hz" in found.reason
    assert find_frequencies(short_run("I-B", "300 s", run__every="45 ms")).verdict == "lines"


def test_too_short_a_window_is_undecided():
    found = find_frequencies(short_run("I-A"), (1.0, 1.2))
    assert (found.verdict, found.lines) == ("undecided", ())
    with pytest.raises(ValueError, match="relative, x1, x2"):
        find_frequencies(short_run("I-A"), of="y")
