"""What pictures of runs say of themselves: coordinates on axes, walls, belts, Poincare points, marks."""

import shutil
import xml.etree.ElementTree as ElementTree
from itertools import combinations

import matplotlib.pyplot as plt
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.cbook import is_math_text
from matplotlib.figure import Figure
from matplotlib.text import Text

from tests.formula_cases import MACHINE, case_of
from tests.plots.artists import lines, points, words
from vibsim.cases import load_case
from vibsim.cases.case import load_case_text
from vibsim.plots import capture_pictures, sweep_pictures, sweep_responses
from vibsim.plots.capture_pictures import grey_of, lay_classes
from vibsim.plots.picture import chosen_kinds, draw_files
from vibsim.plots.registry import kind_named
from vibsim.plots.sheet import NamedQuantity, Scale, spread, write_names
from vibsim.plots.subject import PlotError, View, as_text, open_subject, open_subjects, subject_of
from vibsim.plots.sweep_axes import plane_of
from vibsim.results import simulate, simulate_to_file
from vibsim.sweeps import sweep


def run_of(name, t_end):
    return subject_of(simulate(load_case(name, {"run.t_end": t_end})))


def drawn(kind, subject, **view):
    return kind_named(kind).draw([subject], View(**view))


@pytest.mark.parametrize(
    ("name", "across", "up"),
    [
        ("gallery/duffing-hardening", "Displacement", "Velocity"),
        ("gallery/impact-damper", "Relative displacement", "Relative velocity"),
        ("gallery/cantilever", "Relative displacement", "Relative velocity"),
    ],
)
def test_only_two_ends_that_move_have_a_relative_motion(name, across, up):
    axes = drawn("relative", run_of(name, "5 s"), width="page").axes[0]
    assert axes.get_xlabel().replace("\n", " ").startswith(f"{across} $x_")
    assert axes.get_ylabel().replace("\n", " ").startswith(f"{up} $v_")


def test_the_wall_of_the_ground_stands_where_it_is_struck():
    """The gap of the stop is 0; of the others walls nothing is drawn."""
    figure = drawn("displacement", run_of("gallery/impact-oscillator", "20 s"))
    (wall,) = lines(figure, "wall")
    assert np.all(wall.get_ydata() == 0)
    assert words(figure, "wall name") == ["wall"]


def test_walls_of_the_base_move_with_it():
    """The box of the impact pair: 10 mm either way of 5 mm sin(2 pi 5 t); every impact lies on a wall."""
    figure = drawn("displacement", run_of("gallery/impact-pair", "1 s"))
    walls = lines(figure, "wall")
    assert len(walls) == 2
    for wall, side in zip(sorted(walls, key=lambda line: line.get_ydata()[0]), (-10, 10), strict=True):
        t, x = wall.get_data()
        np.testing.assert_allclose(x, side + 5 * np.sin(2 * np.pi * 5 * t), atol=1e-9)
    (marks,) = lines(figure, "impacts")
    gaps = [np.abs(np.interp(marks.get_xdata(), *wall.get_data()) - marks.get_ydata()) for wall in walls]
    assert np.min(gaps, axis=0).max() < 1e-3


FAR = """
bodies: {a: 1 kg}
links: {s: {between: [a, ground], k: 100 N/m}}
stops: {w: {between: [a, ground], gap: 1 m, acts: compression, k: 1 kN/m}}
initial: {a: {x: 1 mm}}
run: {t_end: 5 s, every: 10 ms}
"""


def test_a_wall_that_is_not_struck_is_not_drawn():
    assert lines(drawn("displacement", subject_of(simulate(load_case_text(FAR)))), "wall") == []


def test_the_velocity_of_a_belt_is_marked_where_the_block_rides_on_it():
    figure = drawn("relative", run_of("gallery/block-on-belt", "20 s"))
    axes = figure.axes[0]
    (belt,) = lines(figure, "belt")
    (curve,) = lines(figure, "relative")
    unit = 1e3 if "mm/s" in axes.get_ylabel() else 1.0
    assert belt.get_ydata()[0] == pytest.approx(0.2 * unit)
    assert np.count_nonzero(np.abs(curve.get_ydata() - 0.2 * unit) < 1e-9 * unit) > 10  # it sticks
    assert "velocity of belt" in {text.get_text() for text in axes.texts}


@pytest.mark.parametrize("kind", ["relative", "phase"])
def test_portraits_carry_poincare_points_when_asked(kind):
    """Once per period of the force, 3.7 rad/s: where a run of the engine is at those instants."""
    subject = run_of("gallery/impact-oscillator", "60 s")
    figure = drawn(kind, subject, window=(20.0, 60.0), poincare=True)
    (dots,) = lines(figure, "poincare")
    period = 2 * np.pi / 3.7
    times = period * np.arange(np.ceil(20 / period), np.floor(60 / period) + 1)
    state = subject.result.at(times)
    scale = Scale(1e3, "mm") if "(mm)" in figure.axes[0].get_xlabel() else Scale(1.0, "m")
    np.testing.assert_allclose(dots.get_xdata(), scale(state["x_mass"]), atol=1e-9)
    assert "dots: once per period" in figure.axes[0].get_title(loc="right")
    assert lines(drawn(kind, subject), "poincare") == []


def test_poincare_points_of_what_is_no_portrait_are_refused():
    with pytest.raises(PlotError, match="poincare: kind overview has none; kinds that have: phase"):
        chosen_kinds([run_of("gallery/impact-oscillator", "5 s")], ["overview"], View(poincare=True))


def test_marks_are_explained_above_the_panel():
    figure = drawn("displacement", run_of("gallery/impact-damper", "12 s"))
    assert "rings: impacts; grey: contact" in figure.axes[-1].get_title(loc="right")
    portrait = drawn("phase", run_of("gallery/impact-damper", "12 s"))
    assert "rings: impacts" in portrait.axes[0].get_title(loc="right")


@given(st.lists(st.floats(0, 1), min_size=1, max_size=12), st.floats(0.001, 0.2))
def test_labels_keep_their_distance_and_order(heights, gap):
    places = spread(np.sort(heights), gap)
    assert len(places) == len(heights)
    assert np.all(np.diff(places) >= gap * (1 - 1e-9))


def test_labels_with_room_stay_where_they_are():
    heights = np.array([0.1, 0.5, 0.9])
    np.testing.assert_array_equal(spread(heights, 0.2), heights)


def test_a_crowd_is_centred_on_its_levels():
    np.testing.assert_allclose(spread(np.array([0.5, 0.5, 0.5]), 0.1), [0.4, 0.5, 0.6])


@pytest.fixture
def axes():
    figure, axes = plt.subplots(figsize=(4, 3))
    axes.set(xlim=(0, 10), ylim=(0, 10))
    yield axes
    plt.close(figure)


def boxes(axes):
    return {text.get_text(): text.get_window_extent() for text in axes.texts}


def test_names_of_curves_that_end_at_one_point_stand_apart(axes):
    x = np.array([5.0, 2.0])
    write_names(axes, [NamedQuantity(name, x, x) for name in ("one", "two", "three")])
    found = list(boxes(axes).values())
    assert len(found) == 3
    assert not any(a.overlaps(b) for i, a in enumerate(found) for b in found[:i])


def test_no_name_covers_a_curve(axes):
    flat = NamedQuantity("flat", np.array([1.0, 9.0]), np.array([5.0, 5.0]))
    (line,) = axes.plot(flat.x, flat.y)
    write_names(axes, [NamedQuantity("rising", np.array([5.0, 4.0]), np.array([4.9, 1.0])), flat])
    height = axes.transData.transform(np.column_stack(points(line)))[0, 1]
    for box in boxes(axes).values():
        assert box.y1 < height or box.y0 > height or box.x0 > axes.transData.transform((9.0, 5.0))[0]


def test_no_name_leaves_the_axes(axes):
    write_names(axes, [NamedQuantity("corner", np.array([9.9]), np.array([9.9]))])
    (box,) = boxes(axes).values()
    assert box.x1 < axes.bbox.x1 and box.y1 < axes.bbox.y1


def test_where_there_is_no_room_the_first_place_is_taken(axes):
    write_names(axes, [NamedQuantity("x" * 200, np.array([5.0]), np.array([5.0]))])
    (text,) = axes.texts
    assert text.get_ha() == "left" and text.get_va() == "center"


# Areas that share a picture are told apart in grey print, by lightness or by hatches.


APART = 0.09  # of grey, from 0 to 1: a tenth of the range is seen beside each other


def looks(shades):
    return [(shade.name, shade.colour, shade.hatch) for shade in shades]


AREAS = {
    "capture": looks(capture_pictures.CAPTURE_MAP_SHADES),
    "regime": looks(capture_pictures.REGIME_SHADES),
    "end-state": looks(sweep_pictures.SHADES),
    "basins": [(f"attractor {i}", *look) for i, look in enumerate(sweep_responses.COLOURS)]
    + looks([sweep_responses.OTHERS, sweep_responses.UNDECIDED]),
    "power": list(sweep_pictures.TAKERS.values()),
}


def test_greys_are_those_of_the_recommendation():
    assert grey_of("black") == 0 and grey_of("white") == pytest.approx(1)
    assert grey_of("#ff0000") == pytest.approx(0.299) and grey_of("0.5") == pytest.approx(0.5)


@pytest.mark.parametrize("kind", AREAS)
def test_areas_differ_in_grey_or_in_their_hatches(kind):
    for (one, first, hatch), (other, second, other_hatch) in combinations(AREAS[kind], 2):
        apart = abs(grey_of(first) - grey_of(second))
        assert apart >= APART or hatch != other_hatch, (one, other, apart)


def test_hatches_lie_on_the_cells_of_their_class(tmp_path):
    case = load_case("II-B", {"run.t_end": "1 s"})
    path = str(tmp_path / "a.h5")
    sweep(case, {"Omega0": "5, 5.5, 6 Hz", "c": "0.01, 0.02, 0.03"}, out=path)
    classes = np.array([[0, 2, 6], [2, 5, np.nan], [0, 1, 6]], dtype=float)  # rows are dampings
    axes = Figure().subplots()
    lay_classes(axes, plane_of(open_subject(path)), classes, capture_pictures.REGIME_SHADES, "regime")
    hatched = {patch.get_gid(): patch for patch in axes.patches}
    shades = {code: capture_pictures.REGIME_SHADES[code] for code in (2, 5, 6)}
    assert set(hatched) == {f"hatch {shade.name}" for shade in shades.values()}
    x, y = [4.75, 5.25, 5.75, 6.25], [0.005, 0.015, 0.025, 0.035]
    for code, shade in shades.items():
        patch = hatched[f"hatch {shade.name}"]
        assert patch.get_hatch() == shade.hatch
        boxes = [(*box.min(axis=0), *box.max(axis=0)) for box in patch.get_path().to_polygons()]
        cells = [(x[i], y[k], x[i + 1], y[k + 1]) for k, i in np.argwhere(classes == code)]
        assert np.allclose(sorted(boxes), sorted(cells), rtol=1e-12)


def test_points_whose_cells_are_hatched_have_shapes_of_their_own():
    shades = [capture_pictures.Shade("", *look) for look in sweep_responses.COLOURS]
    shades += [sweep_responses.OTHERS, sweep_responses.UNDECIDED]
    markers = [shade.marker for shade in shades if shade.hatch]
    assert len({*markers}) == len(markers)
    assert all(shade.marker == "o" for shade in shades if not shade.hatch)


# Titles and file names of the user's in pictures: shown letter by letter, whatever they hold.


NASTY = [
    "$x^{2 $", "{brace $\\frac{1}$", "\\$5 and \\\\$6$ \\alpha", "x\x1b[2J\x1b]0;PWN\x07",
    "control \x01\x0b\x7f\x9b", "100 % _under_ ^{up} <b>&amp;", "振動 \U0001f600",
]  # fmt: skip


def drawn_with(text):
    """What matplotlib makes of a text that it takes for no mathematics."""
    assert not is_math_text(text)
    return text.replace(r"\$", "$")


@pytest.mark.parametrize("title", NASTY)
def test_a_title_is_drawn_letter_by_letter(title):
    text = drawn_with(as_text(title))
    assert text.isprintable()
    assert all(ch in text for ch in title if ch.isprintable())


def test_a_name_stays_in_the_legend():
    assert not as_text("_run").startswith("_")
    assert as_text("_run").strip() == "_run"


@pytest.fixture(scope="module", params=[NASTY[0], " ".join(NASTY)], ids=["power", "all"])
def nasty_run(request, tmp_path_factory):
    """A run whose title and file name are hostile."""
    title = request.param
    path = tmp_path_factory.mktemp("nasty") / f"_{title[:40]}.h5"
    simulate_to_file(load_case("II-B", {"title": title, "run.t_end": "0.5 s"}), path)
    return str(path)


def test_pictures_of_hostile_files_can_be_read(nasty_run, tmp_path):
    [svg] = draw_files([nasty_run], None, View(), str(tmp_path / "one.svg"))
    ElementTree.parse(svg)
    other = str(tmp_path / "again.h5")
    shutil.copy(nasty_run, other)
    for kind in ("motor", "stiffness"):
        [svg] = draw_files([nasty_run, other], [kind], View(), str(tmp_path / f"{kind}.svg"))
        ElementTree.parse(svg)


MACHINE_KINDS = ["rotor-speed", "states"]  # of runs with rotors and states; of the others see test_kinds.py


@pytest.fixture(scope="module")
def brief_machine(tmp_path_factory):
    path = tmp_path_factory.mktemp("machine") / "brief.h5"
    simulate_to_file(case_of(MACHINE, {"run.t_end": "0.2 s"}), path)
    return str(path)


@pytest.mark.parametrize("kind", MACHINE_KINDS)
def test_no_kind_lets_matplotlib_read_a_name(kind, brief_machine, tmp_path):
    paths = [str(tmp_path / f"{name}.h5") for name in ("a$\\frac$", "b_{$")]
    for path in paths:
        shutil.copy(brief_machine, path)
    figure = kind_named(kind).draw(open_subjects(paths), View(width="column"))
    figure.draw_without_rendering()  # raises where a name is taken for mathematics and is none
    names = [text.get_text() for text in figure.findobj(Text) if "frac" in text.get_text()]
    assert all(r"\$\frac\$" in name for name in names)


def test_pictures_are_called_after_their_files(runs, here):
    for name in ("II-B.h5", "faster.h5", "killed.h5.partial"):
        shutil.copy(runs["motor"], name)
    for name, stem in (("II-B.h5", "II-B"), ("faster.h5", "faster"), ("killed.h5.partial", "killed")):
        assert draw_files([name], ["motor"], View()) == [f"{stem}-motor.png"]
    assert draw_files(["II-B.h5", "faster.h5"], ["motor"], View()) == ["II-B+faster-motor.png"]
    assert open_subject("II-C").stem == "II-C"
