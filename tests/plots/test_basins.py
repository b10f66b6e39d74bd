"""Pictures of basins: every point in the colour of its attractor, shares where they were counted."""

import numpy as np
import pytest

from tests.plots.artists import assert_cells, clipped_texts
from vibsim.cases import load_case
from vibsim.plots.registry import fitting, kind_named
from vibsim.plots.subject import View, open_subject
from vibsim.plots.sweep_responses import UNDECIDED
from vibsim.sweeps import sweep

STARTS = {"tip.x": "-4, 0, 4 mm", "tip.v": "-400, -100, 200 mm/s"}
BELT = {"block.x": "-2:2 m", "block.v": "0:2 m/s"}


def draw(path):
    figure = kind_named("basins").draw([open_subject(str(path))], View())
    figure.draw_without_rendering()
    assert clipped_texts(figure) == []
    return figure


def test_a_plane_of_starts(tmp_path):
    case = load_case("gallery/cantilever", {"run.t_end": "20 s"})
    result = sweep(case, STARTS, section=0, compute="attractor", out=tmp_path / "a.h5")
    figure = draw(tmp_path / "a.h5")
    (mesh,) = [each for each in figure.axes[0].collections if each.get_gid() == "attractor"]
    assert_cells(mesh, result["attractor"][..., 0].T.astype(float))
    texts = [text.get_text() for text in figure.legends[0].get_texts()]
    assert texts == ["period 1, multiplier 0.806: 77.8 %", "period 1, multiplier 0.923: 22.2 %"]


def test_undecided_points_are_marked(tmp_path):
    case = load_case("gallery/cantilever", {"run.t_end": "0.3 s"})
    sweep(case, STARTS, section=0, compute="attractor", out=tmp_path / "a.h5")
    figure = draw(tmp_path / "a.h5")
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["undecided (9)"]
    (patch,) = figure.axes[0].patches
    assert patch.get_gid() == "hatch undecided" and patch.get_hatch() == UNDECIDED.hatch


def test_two_parameters_are_coloured_by_period(tmp_path):
    """One impact in one, two and three periods (Shaw and Holmes 1983), at two restitutions each."""
    case = load_case("gallery/impact-oscillator", {"run.t_end": "100 s"})
    ranges = {"drive.omega": "2, 4, 6 rad/s", "wall.e": "0.5, 0.6"}
    sweep(case, ranges, section=0, compute="attractor", out=tmp_path / "a.h5", jobs=1)
    figure = draw(tmp_path / "a.h5")
    (mesh,) = [each for each in figure.axes[0].collections if each.get_gid() == "attractor"]
    assert set(np.ma.masked_invalid(mesh.get_array()).compressed()) == {0, 1, 2}
    texts = [text.get_text() for text in figure.legends[0].get_texts()]
    assert texts == ["period 1", "period 2", "period 3"]


def test_starts_of_an_ensemble(tmp_path):
    result = sweep(
        "gallery/belt-oscillator",
        {},
        ensemble=24,
        spread=BELT,
        section=0,
        compute="attractor",
        discard="150 s",
        out=tmp_path / "a.h5",
    )
    axes = draw(tmp_path / "a.h5").axes[0]
    drawn = result.members.drawn
    starts = np.column_stack([drawn["initial.block.x"], drawn["initial.block.v"]])
    labels = result["attractor"].ravel()
    lines = [line for line in axes.get_lines() if len(line.get_xdata())]
    assert len(lines) == 2
    for line in lines:
        label = 0 if line.get_gid() == lines[0].get_gid() else 1
        np.testing.assert_array_equal(line.get_xydata(), starts[labels == label])


def test_shares_over_a_parameter(tmp_path):
    result = sweep(
        "gallery/belt-oscillator",
        {"belt.belt": "1.4, 1.9 m/s"},
        ensemble=20,
        spread=BELT,
        section=0,
        compute="attractor",
        discard="150 s",
        out=tmp_path / "a.h5",
    )
    axes = draw(tmp_path / "a.h5").axes[0]
    lines = {line.get_gid(): line.get_xydata() for line in axes.get_lines() if line.get_gid()}
    rest = result["attractor_kind"][..., 0] == 1
    values = [rest[0].mean(), rest[1].mean()]
    at_rest = next(xy for xy in lines.values() if len(xy) == 2)
    np.testing.assert_allclose(at_rest, [[1.4, values[0]], [1.9, values[1]]])
    cycle = next(xy for xy in lines.values() if len(xy) == 1)
    np.testing.assert_allclose(cycle, [[1.4, 1 - values[0]]])


@pytest.mark.parametrize("compute", [(), "attractor"])
def test_what_has_no_basins_has_no_such_picture(tmp_path, compute):
    case = load_case("gallery/cantilever", {"run.t_end": "2 s"})
    sweep(case, {"tip.x": "0, 1 mm"}, section=0, compute=compute, out=tmp_path / "a.h5")
    assert "basins" not in {kind.name for kind in fitting([open_subject(str(tmp_path / "a.h5"))])}
