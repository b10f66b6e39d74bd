"""Areas that share a picture are told apart in grey print, by lightness or by hatches."""

from itertools import combinations

import numpy as np
import pytest
from matplotlib.figure import Figure

from vibsim.cases import load_case
from vibsim.plots import capture_pictures, sweep_pictures, sweep_responses
from vibsim.plots.capture_pictures import grey_of, lay_classes
from vibsim.plots.subject import open_subject
from vibsim.plots.sweep_axes import plane_of
from vibsim.sweeps import sweep

APART = 0.09  # of grey, from 0 to 1: a tenth of the range is seen beside each other
AREAS = {
    "capture": [(shade.name, shade.colour, shade.hatch) for shade in capture_pictures.CAPTURE_MAP_SHADES],
    "regime": [(shade.name, shade.colour, shade.hatch) for shade in capture_pictures.REGIME_SHADES],
    "end-state": [(shade.name, shade.colour, shade.hatch) for shade in sweep_pictures.SHADES],
    "basins": [(f"attractor {i}", colour, hatch) for i, (colour, hatch) in enumerate(sweep_responses.COLOURS)]
    + [
        (shade.name, shade.colour, shade.hatch)
        for shade in (sweep_responses.OTHERS, sweep_responses.UNDECIDED)
    ],
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
    expected = {code: f"hatch {capture_pictures.REGIME_SHADES[code].name}" for code in (2, 5, 6)}
    assert set(hatched) == set(expected.values())
    edges = [4.75, 5.25, 5.75, 6.25], [0.005, 0.015, 0.025, 0.035]
    for code, name in expected.items():
        patch = hatched[name]
        assert patch.get_hatch() == capture_pictures.REGIME_SHADES[code].hatch
        boxes = [(*box.min(axis=0), *box.max(axis=0)) for box in patch.get_path().to_polygons()]
        cells = [
            (edges[0][i], edges[1][k], edges[0][i + 1], edges[1][k + 1])
            for k, i in np.argwhere(classes == code)
        ]
        assert np.allclose(sorted(boxes), sorted(cells), rtol=1e-12)


def test_points_whose_cells_are_hatched_have_shapes_of_their_own():
    shades = [capture_pictures.Shade("", *look) for look in sweep_responses.COLOURS]
    shades += [sweep_responses.OTHERS, sweep_responses.UNDECIDED]
    markers = [shade.marker for shade in shades if shade.hatch]
    assert len({*markers}) == len(markers)
    assert all(shade.marker == "o" for shade in shades if not shade.hatch)
