"""Any two columns, and spectra, spectrograms and waterfalls of motions whose frequencies are known."""

import math

import numpy as np
import pytest

import vibsim
from tests.command_line.made import refused
from tests.plots.artists import collections, lines
from vibsim.cases import load_case
from vibsim.plots import frequency_pictures, picture
from vibsim.plots.frequency_pictures import pieces, spectra
from vibsim.plots.samples import fractions, natural_frequencies, shortest_period, source_period
from vibsim.plots.subject import PlotError, View, open_subject, subject_of

# x = A sin(omega t) / (k / m - omega^2) once the free vibration is set off rightly: v(0) makes it a pure sine
HZ, K, A = 2.0, 100.0, 1.0
AMPLITUDE = A / (K - (2 * np.pi * HZ) ** 2)
FORCED = f"""
name: forced
bodies: {{b: 1 kg}}
links: {{s: {{between: [b, ground], k: {K} N/m}}}}
forces: {{f: {{on: b, A: {A} N, omega: {HZ} Hz}}}}
initial: {{b: {{v: {AMPLITUDE * 2 * np.pi * HZ!r} m/s}}}}
run: {{t_end: 50 s, every: 10 ms}}
"""


@pytest.fixture(scope="module")
def forced():
    return subject_of(vibsim.simulate(FORCED))


@pytest.fixture(scope="module")
def sweep():
    case = vibsim.load_case("II-B", {"run.t_end": "4 s"})
    return subject_of(vibsim.sweep(case, {"Omega0": "4:6:0.5 Hz"}, section=3, jobs=1))


def line(axes, gid):
    (found,) = lines(axes, gid)
    return found.get_xydata().T


def columns(subject, x, y, **view):
    """The axes of two columns against each other, and what is drawn there."""
    (axes,) = picture.columns_picture([subject], View(x=x, y=y, **view)).axes
    return axes, line(axes, "columns")


def test_a_spectrum_has_the_amplitude_of_a_sine_at_its_frequency(forced):
    hz, (amplitudes,) = spectra(forced, (0.0, 50.0), ["x_b"])
    top = np.argmax(amplitudes)
    assert abs(hz[top] - HZ) <= hz[1]  # to a step of frequency
    assert amplitudes[top] == pytest.approx(abs(AMPLITUDE), rel=0.01)  # flat to 1 % within half a step
    axes = frequency_pictures.spectrum_picture([forced], View()).axes[0]
    hz, shown = line(axes, "spectrum")
    assert abs(hz[np.argmax(shown)] - HZ) < 0.05 and axes.get_ylabel() == "Amplitude (mm)"


def test_pieces_tell_when_what_vibrates(forced):
    found = pieces(forced, (0.0, 50.0), "x_b")
    assert found.amplitudes.shape == (len(found.times), len(found.hz))
    assert np.all(np.abs(found.hz[found.amplitudes.argmax(axis=1)] - HZ) <= 2 / found.length)
    assert found.times[0] == pytest.approx(found.length / 2, abs=0.02)
    assert found.times[-1] <= 50 - found.length / 2 + 0.02


def test_a_spectrogram_and_a_waterfall_are_drawn(forced):
    axes = frequency_pictures.spectrogram_picture([forced], View()).axes[0]
    (mesh,) = collections(axes, "spectrogram")
    assert axes.figure.axes[1].get_ylabel().startswith("Amplitude of $")  # a coordinate, not a stop
    covered = mesh.get_coordinates()[..., 0]
    assert (covered.min(), covered.max()) == axes.get_xlim() == (0.0, 50.0)  # no white margins
    values = np.asarray(mesh.get_array())
    assert values.max() == pytest.approx(1e3 * abs(AMPLITUDE), rel=0.02)
    (axes,) = frequency_pictures.waterfall_picture([forced], View()).axes
    rows = lines(axes, "spectrum")
    assert max(axes.get_yticks()) <= forced.result.t_reached  # lines reach higher, the run does not
    assert 5 < len(rows) <= 40
    assert len(frequency_pictures.waterfall_picture([forced, forced], View()).axes[0].lines) == 2


def test_two_columns_of_a_run(runs):
    subject = open_subject(runs["motor"])
    axes, (x, y) = columns(subject, "time", "error_estimate", window=(1, 2))
    assert (x[0], x[-1], len(x)) == (1.0, 2.0, 201)
    rows = slice(200, 401)
    assert np.array_equal(y, subject.result["error_estimate"][rows])
    assert axes.get_xlabel() == "time (s)" and axes.get_ylabel() == "error_estimate (m)"
    _, (x1, _) = columns(subject, "x1", "v1", window=(10, 11))
    inside = np.isin(subject.result["x1"][2000:2201], x1)
    assert inside.all() and len(x1) > 400  # the samples, and instants between them


def test_two_columns_of_events_and_of_a_sweep(runs, sweep):
    subject = open_subject(runs["motor"])
    axes, (_, kinds) = columns(subject, "events/t", "events/kind")
    assert np.array_equal(kinds, subject.result.events["kind"])
    assert "contact_begin" in [text.get_text() for text in axes.get_yticklabels()]
    _, points = columns(sweep, "omega0", "mean_speed")
    assert np.array_equal(points, [sweep.result["omega0"], sweep.result["mean_speed"][:, 0]])
    _, (_, section) = columns(sweep, "omega0", "section_speed")
    known = sweep.result["section_speed"].ravel()
    assert np.array_equal(section, known[~np.isnan(known)])


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--x", "x1"], "give both of them, x and y"),
        (["--x", "x1", "--y", "x9"], "has no column 'x9' (did you mean x1?)"),
        (["--x", "x1", "--y", "events/t"], "one is of events and one is not"),
        (["--x", "x1", "--y", "v1", "--kind", "phase"], "two columns are drawn in the place of a kind"),
        (["--size", "12"], "write WIDTHxHEIGHT in cm"),
        (["--size", "1x999"], "each 3 to 120 cm"),
        (["--size", "9x9", "--width", "page"], "--size and --width say the same"),
        (["--font-size", "nan"], "is no finite number"),
        (["--style", "no.mplstyle"], "no.mplstyle: must be a file, or a style of matplotlib"),
    ],
)
def test_what_cannot_be_drawn_is_named(runs, words, message, here):
    assert message in refused("plot", runs["motor"], *words)
    assert not list(here.iterdir())


def test_a_case_has_no_columns_and_a_short_run_no_spectrum(forced):
    with pytest.raises(PlotError, match="has no columns to draw"):
        picture.columns_picture([subject_of(forced.case)], View(x="x1", y="v1"))
    with pytest.raises(PlotError, match="a spectrum needs 64 samples"):
        frequency_pictures.spectrum_picture([forced], View(window=(0, 0.3)))


def test_without_springs_a_spectrum_goes_as_far_as_the_source_tells():
    """Blocks on a table that shakes at 4 Hz: six times that, and not half the rate of samples, 500 Hz."""
    stack = subject_of(vibsim.simulate("gallery/stack-of-blocks"))
    hz, _ = spectra(stack, (5.0, 10.0), ["x_lower"])
    assert hz[-1] == pytest.approx(24.0, abs=0.5)


def test_without_springs_and_source_a_spectrum_ends_where_it_is_faint():
    """A ball that bounces has no frequency: samples reach 250 Hz, a hundredth of the greatest line not 50."""
    ball = subject_of(vibsim.simulate("gallery/bouncing-ball"))
    hz, (amplitudes,) = spectra(ball, (2.5, 5.0), ["x_ball"])
    whole = np.abs(np.fft.rfft(ball.result["x_ball"][1250:]))  # without the window: no lower beyond
    assert 10 < hz[-1] < 50 < 250
    assert amplitudes[hz > hz[-1] / 1.49].max() < 0.01 * amplitudes.max()
    assert whole[-100:].max() < 0.01 * whole.max()


def test_bodies_of_one_run_end_at_one_frequency_and_straight_motions_say_so():
    driver = subject_of(vibsim.simulate("gallery/pile-driver"))
    ram, pile = (each for each in frequency_pictures.spectrum_picture([driver], View()).axes[0].lines)
    assert ram.get_xdata()[-1] == pile.get_xdata()[-1]
    assert ram.get_linestyle() != pile.get_linestyle()
    balls = subject_of(vibsim.simulate("gallery/three-balls"))  # uniform motion after 0.1 s
    kinds = ("spectrum", "spectrogram", "waterfall")
    for draw in (getattr(frequency_pictures, f"{kind}_picture") for kind in kinds):
        axes = draw([balls], View(window=(0.15, 0.3))).axes[0]
        assert "nothing vibrates here" in [text.get_text() for text in axes.texts]
        for each in axes.lines:
            assert not np.ptp(each.get_ydata())


# Frequencies against the figures of the paper's parameters (common values, closed forms).


def named(case):
    return {frequency.name: frequency.hz for frequency in natural_frequencies(case.scene())}


def test_ideal_source():
    found = named(load_case("I-C"))
    assert found["held"] == pytest.approx(4.130, abs=5e-4)
    assert found["free-free"] == pytest.approx(4.3337, abs=5e-5)
    assert found["bilinear"] == pytest.approx(7.6975, abs=5e-5)


def test_motor_counts_m3_to_block_1():
    found = named(load_case("II-B"))
    assert found["free-free"] == pytest.approx(4.149, abs=5e-4)
    assert found["bilinear"] == pytest.approx(7.37, abs=5e-3)
    assert found["half bilinear"] == pytest.approx(3.69, abs=6e-3)


def test_without_stop_there_is_no_bilinear_frequency(subject):
    assert set(named(subject("bare").case)) == {"held", "free-free"}


def test_fractions_are_those_of_a_motion_with_impacts(subject):
    found = {frequency.name: frequency.hz for frequency in fractions(load_case("II-B").scene())}
    assert found["⅔ bilinear"] == pytest.approx(2 / 3 * 7.37, abs=4e-3)
    assert found["½ free-free"] == pytest.approx(4.149 / 2, abs=3e-4)
    assert fractions(subject("bare").scene) == []


def test_fixed_block(subject):
    found = named(subject("fixed").case)
    assert found["held"] == pytest.approx(4.130, abs=5e-4)
    assert "free-free" not in found


def test_periods():
    scene = load_case("I-C").scene()
    assert source_period(scene) == pytest.approx(1 / 6.5)
    assert shortest_period(scene) == pytest.approx(1 / 34.397, rel=1e-4)
    motor = load_case("II-B").scene()
    assert source_period(motor) == pytest.approx(1 / 5.5)
    assert source_period(motor, phidot=2 * math.pi * 4) == pytest.approx(0.25)
