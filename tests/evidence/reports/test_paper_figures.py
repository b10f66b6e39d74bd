"""The figures show what the paper's show, from the right runs, each with words for it."""

import re

import numpy as np
import pytest
from matplotlib.image import imread, imsave

from tests.branches.made import CAPTURED, branch_of, parameter
from tests.evidence.reports.made import numbers
from tests.plots.artists import lines
from vibsim.analysis import judge_capture
from vibsim.cases import load_case
from vibsim.evidence.reports import figures
from vibsim.evidence.reports.figures import draw_capture, draw_drift, draw_regimes, write_figures, write_page
from vibsim.evidence.reports.measurements import MeasurementInterrupted
from vibsim.evidence.reports.pages import Picture
from vibsim.evidence.reports.paper_figures import (
    PAGE_ROWS,
    draw_load_curves,
    growth_figure,
    load_words,
    paper_figures,
    powers_figure,
)
from vibsim.evidence.reports.readings import followed_cases, measure_ends
from vibsim.physics.rates import bilinear_frequencies
from vibsim.plots.style import BLUE
from vibsim.plots.subject import subject_of

pytestmark = pytest.mark.usefixtures("house_style")

# figure of the paper -> the cases that it is of
SHOWN = {
    "fig-01": ["I-A"],
    "fig-02": ["I-A"],
    "fig-03": ["II-A"],
    "fig-04": ["II-A", "II-B", "II-C"],
    **{f"fig-{5 + i:02}": [f"I-{x}", f"I-{x}-eq211"] for i, x in enumerate("ABC")},
    **{f"fig-{8 + i:02}": [f"II-{x}"] for i, x in enumerate("ABC")},
    **{f"fig-{11 + i}": [f"I-{x}", f"I-{x}-eq211", f"II-{x}"] for i, x in enumerate("ABC")},
    **{f"fig-{14 + i}": [f"II-{x}"] for i, x in enumerate("ABC")},
    "fig-09-reading": ["II-B-captured"],
    "fig-10-reading": ["II-C-escape"],
    "fig-15-reading": ["II-B-captured"],
    "fig-16-reading": ["II-C-escape"],
}
FIGURES = {figure.key: figure for figure in [*paper_figures(), growth_figure()]}


def test_every_figure_is_of_its_cases():
    assert {figure.key: list(figure.runs) for figure in paper_figures()} == SHOWN


def test_the_page_has_every_figure_once():
    assert sorted(key for row in PAGE_ROWS for key in row if key) == sorted(SHOWN)


@pytest.mark.parametrize("key", FIGURES)
def test_every_figure_has_words(key):
    figure = FIGURES[key]
    assert len(figure.alt) > 40
    assert figure.caption.endswith(".")
    if match := re.fullmatch(r"fig-(\d+)(-reading)?", key):
        assert figure.heading == f"Fig. {int(match[1])}" + (", reading" if match[2] else "")


def test_displacements_are_those_of_the_runs(subjects):
    """Fig. 6: above Table 1's amplitude, below that of Eq. (2.11), each with a detail; x1 in mm."""
    drawn = lines(FIGURES["fig-06"].figure(subjects), "x1")
    runs = [subjects[name].result for name in ("I-B", "I-B-eq211")]
    assert len(drawn) == 4
    for whole, detail, run in zip(drawn[::2], drawn[1::2], runs, strict=True):
        assert np.max(np.abs(whole.get_ydata())) == pytest.approx(1e3 * np.max(np.abs(run["x1"])), rel=1e-6)
        assert np.ptp(detail.get_xdata()) < np.ptp(whole.get_xdata()) / 3
    assert drawn[0].get_color() == BLUE


def test_details_mark_impacts(subjects):
    marks = lines(FIGURES["fig-07"].figure(subjects), "impacts")
    assert any(len(line.get_xdata()) for line in marks if line.get_marker() == "o")


def test_portraits_set_the_ideal_source_beside_the_motor(subjects):
    figure = FIGURES["fig-12"].figure(subjects)
    assert len(lines(figure, "x1")) == len(lines(figure, "x2")) == len(lines(figure, "relative")) == 3
    titles = [sub.get_suptitle().split(":")[0] for sub in figure.subfigs]
    assert titles == ["(a) I-B", "(a) I-B-eq211", "(b) II-B"]


def test_portraits_of_relative_motion_are_free_of_drift(subjects):
    """x1 - x2 of the samples (between them the curve rises a little higher): no drift of both is in it."""
    figure = FIGURES["fig-12"].figure(subjects)
    run = subjects["I-B"].result
    drawn = lines(figure, "relative")[0].get_xdata()
    y = 1e3 * (run["x1"] - run["x2"])
    assert (drawn.min(), drawn.max()) == pytest.approx((y.min(), y.max()), rel=0.01)


def test_motors_have_their_operating_points_on_their_lines(subjects):
    """Fig. 4: mean torque is M0 (1 - w/Omega0) at the mean speed, as the paper's Eq. (2.8) has it."""
    figure = FIGURES["fig-04"].figure(subjects)
    points = lines(figure, "final")
    known = [judge_capture(subjects[name].result).final_speed_hz for name in SHOWN["fig-04"]]
    assert [point.get_xdata()[0] for point in points] == [speed for speed in known if speed is not None]
    assert points
    for point, no_load in zip(points, (3.5, 5.5, 6.5), strict=False):
        (speed,), (torque,) = point.get_xdata(), point.get_ydata()
        assert torque == pytest.approx(5 * (1 - speed / no_load), abs=1e-9)


def test_pictures_of_the_evidence_show_every_start():
    """The clouds have a point for each start, the regimes a cell for each frequency."""
    table = numbers()
    drift = draw_drift(table)
    assert [len(line.get_ydata()) for line in lines(drift, "II-B")] == [4, 4]
    assert sorted(lines(drift, "II-B")[0].get_ydata()) == pytest.approx([0.01, 0.03, 0.2, 1.0])
    capture = draw_capture(table)
    held, ends = lines(capture, "II-C-escape")
    assert len(held.get_ydata()) == len(ends.get_xdata()) == 11
    assert set(ends.get_xdata()) == {134.0}
    (mesh,) = draw_regimes(table).axes[0].collections
    assert np.sum(~np.isnan(mesh.get_array().astype(float).filled(np.nan))) == len(table["nearby"])


def test_passages_show_speed_and_displacement(subjects):
    figure = FIGURES["fig-16"].figure(subjects)
    (speed,) = lines(figure, "phidot")
    greatest = subjects["II-C"].result["phidot"].max() / (2 * np.pi)
    assert np.max(speed.get_ydata()) == pytest.approx(greatest, rel=1e-6)
    assert len(lines(figure, "x1")) == len(lines(figure, "x2")) == 1


def test_figures_are_written_one_by_one(subjects, tmp_path, monkeypatch):
    """One of each layout; the whole report draws them all."""
    monkeypatch.setattr(figures, "PNG_DPI", 40)
    keys, told = ["fig-04", "fig-05", "fig-08", "fig-11", "fig-14", "growth"], []
    chosen = [FIGURES[key] for key in keys]
    pictures = write_figures(chosen, subjects, tmp_path, [], lambda *done: told.append(done) or True)
    assert sorted(path.stem for path in tmp_path.iterdir()) == keys
    assert [picture.path.stem for picture in pictures] == keys
    assert told == [("drawing", i, len(keys)) for i in range(1, len(keys) + 1)]


def test_the_page_gathers_the_pictures(tmp_path):
    """Each picture in its colour: A, B and C side by side, nothing left out."""
    shade = {key: (i + 1) / 32 for i, key in enumerate(SHOWN)}
    for key, value in shade.items():
        imsave(tmp_path / f"{key}.png", np.full((60, 140, 3), value))
    pictures = [Picture(tmp_path / f"{key}.png", "", "", "") for key in SHOWN]
    path = write_page(pictures, tmp_path, [])
    seen = {round(float(value) * 32) for value in np.unique(imread(path)[..., 0].round(3))}
    assert seen >= set(range(1, len(SHOWN) + 1))


def test_a_figure_is_written_in_every_format(subjects, tmp_path):
    (picture,) = write_figures([FIGURES["fig-02"]], subjects, tmp_path, ["svg", "pdf"], lambda *done: True)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["fig-02.pdf", "fig-02.png", "fig-02.svg"]
    assert picture.path == tmp_path / "fig-02.png"


def test_drawing_stops_when_told(subjects, tmp_path):
    with pytest.raises(MeasurementInterrupted):
        write_figures(paper_figures(), subjects, tmp_path, [], lambda step, done, total: done < 1)
    assert [path.name for path in tmp_path.iterdir()] == ["fig-01.png"]


def test_ends_of_captures_are_those_of_the_branch():
    """c = 0.03 N s/m: the Neimark-Sacker point, known to 22 digits, and M0 (1 - n / (T Omega0)) there."""
    (end,) = measure_ends({"c": branch_of(CAPTURED, "4.9:6 Hz")}).values()
    no_load = parameter("II-B c=0.03 captured branch NS")
    assert end["kind"] == "neimark-sacker" and end["no_load_hz"] == pytest.approx(no_load, rel=1e-11)
    assert end["torque"] == pytest.approx(0.005 * (1 - end["speed_hz"] / no_load), rel=1e-12)


def test_the_words_on_load_curves_follow_from_the_numbers():
    ends = numbers()["ends"]
    told = load_words(ends)
    assert "hold neither the motor of 5.5 Hz nor that of 6.5 Hz" in told
    assert "they can hold the motor of 5.5 Hz, not that of 6.5 Hz" in told
    ends["the reading"]["no_load_hz"] = 6.6
    assert "they can hold the motor of 5.5 Hz and 6.5 Hz." in load_words(ends)


def test_the_motors_followed_are_the_printed_one_and_the_readings():
    scenes = {name: case.two_blocks() for name, case in followed_cases().items()}
    assert [(scene.c, scene.J) for scene in scenes.values()] == [
        (0.001, 0.001), (0.0035, 0.001), (0.001, 0.0085), (0.0035, 0.0085),
    ]  # fmt: skip


@pytest.mark.parametrize(("key", "name"), [("fig-01", "I-A"), ("fig-03", "II-A")])
def test_the_sketches_are_drawn_from_the_cases(key, name):
    """Every part of the case is there: the source is a force in Fig. 1, a rotor in Fig. 3."""
    (axes,) = FIGURES[key].figure({name: subject_of(load_case(name))}).axes
    gids = {artist.get_gid() for artist in axes.get_children()}
    assert {"bodies.1", "bodies.2", "links.coupling", "stops.stop", "friction.friction"} <= gids
    assert ("motor" in gids) == (key == "fig-03")
    assert any("force" in str(gid) for gid in gids) == (key == "fig-01")


def test_the_sommerfeld_diagram_has_both_ways_with_and_without_the_stop(tmp_path, monkeypatch):
    monkeypatch.setattr(figures, "SPEEDS", "3.6:4.2:0.1 Hz")
    monkeypatch.setattr(figures, "SETTLING", {"run.t_end": "40 s"})
    sweeps = figures.obtain_sweeps(tmp_path, lambda *_: True)
    assert [bool(result.case.scene().stops) for result in sweeps.values()] == [True, False]
    drawn = figures.draw_sommerfeld(sweeps)
    for column, result in enumerate(sweeps.values()):
        for row, (name, factor) in enumerate((("mean_speed", 1), ("amplitude_relative", 1e3))):
            axes = drawn.axes[2 * row + column]
            for way, number in (("up", 0), ("down", 1)):
                (line,) = lines(axes, f"{name} {way}")
                np.testing.assert_allclose(line.get_ydata(), factor * result[name][:, number])
    stamps = [path.stat().st_mtime_ns for path in sorted(tmp_path.glob("*.h5"))]
    figures.obtain_sweeps(tmp_path, lambda *_: True)  # taken over
    assert [path.stat().st_mtime_ns for path in sorted(tmp_path.glob("*.h5"))] == stamps


def test_load_curves_are_enlarged_about_half_the_bilinear_frequency():
    """3.68 Hz of the printed motor, from its scene."""
    branch = branch_of(CAPTURED, "4.9:6 Hz")
    drawn = draw_load_curves({"as printed": branch, "the reading": branch})
    (inset,) = drawn.axes[0].child_axes
    half = bilinear_frequencies(branch.map.scene)[0] / 2
    assert half == pytest.approx(3.685, abs=0.005)
    assert sum(inset.get_xlim()) / 2 == pytest.approx(half)
    (level,) = lines(inset, "half bilinear")
    assert level.get_xdata()[0] == half
    assert lines(inset, "stable") + lines(inset, "unstable")


def test_what_is_given_over_time_is_taken_or_stored(subjects):
    motors = {name: subjects.get(name) or subjects["II-B"] for name in powers_figure().runs}
    axes = powers_figure().figure(motors).axes[0]
    values = {line.get_gid(): line.get_ydata() for line in axes.get_lines() if line.get_gid()}
    given = sum(value for gid, value in values.items() if gid.startswith("work"))
    rest = sum(value for gid, value in values.items() if not gid.startswith(("work", "trust")))
    np.testing.assert_allclose(given, rest, atol=1e-6 * np.abs(given).max())
