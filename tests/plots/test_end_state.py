"""End states over ensembles: shares counted by hand, starts where they were drawn."""

import h5py
import numpy as np
import pytest

from tests.plots.artists import BLANK, assert_cells, clipped_texts
from vibsim.cases import load_case
from vibsim.plots.registry import fitting, kind_named
from vibsim.plots.subject import View, open_subject
from vibsim.sweeps import sweep

REST, VIBRATION = 1, 2
BOTH = {"block.x": "-2:2 m", "block.v": "0:2 m/s"}


@pytest.fixture
def swept(tmp_path):
    """Sweeps the belt oscillator over some axes and gives the points these verdicts."""

    def make(axes, verdicts, **settings):
        case = load_case("gallery/belt-oscillator", {"run.t_end": "2 s"})
        sweep(case, axes, out=tmp_path / "e.h5", compute=["end-state"], jobs=1, **settings)
        with h5py.File(tmp_path / "e.h5", "r+") as file:
            file["end_state"][..., 0] = verdicts
        return str(tmp_path / "e.h5")

    return make


def draw(path):
    figure = kind_named("end-state").draw([open_subject(path)], View())
    figure.draw_without_rendering()
    assert clipped_texts(figure) == []
    return figure


def test_shares_along_a_range(swept):
    verdicts = np.array([[VIBRATION] * 4, [REST, VIBRATION, VIBRATION, VIBRATION], [REST] * 4])
    axes = draw(swept({"belt.belt": "1, 1.5, 2 m/s"}, verdicts, ensemble=4, spread=BOTH)).axes[0]
    lines = {line.get_gid(): line for line in axes.get_lines() if line.get_gid()}
    np.testing.assert_allclose(lines["rest"].get_xydata(), [[1, 0], [1.5, 0.25], [2, 1]])
    np.testing.assert_allclose(lines["vibration"].get_xydata(), [[1, 1], [1.5, 0.75], [2, 0]])
    bars = axes.containers[0].lines[2][0].get_segments()
    # Wilson (1927) for 0 of 4, upper end: z^2 / (n + z^2)
    assert bars[0][:, 1] == pytest.approx([0, 1.959964**2 / (4 + 1.959964**2)], abs=1e-6)


def test_starts_by_their_verdict(swept):
    verdicts = np.array([REST, VIBRATION, REST, VIBRATION])
    path = swept({}, verdicts, ensemble=4, spread=BOTH)
    axes = draw(path).axes[0]
    drawn = open_subject(path).result.members.drawn
    starts = np.column_stack([drawn["initial.block.x"], drawn["initial.block.v"]])
    for code, name in {REST: "rest", VIBRATION: "vibration"}.items():
        (points,) = [line for line in axes.get_lines() if line.get_gid() == name]
        np.testing.assert_array_equal(points.get_xydata(), starts[verdicts == code])
    assert axes.get_title(loc="right").startswith("rest: 50 %")


def test_one_start_value_against_the_displacement_at_the_end(swept):
    path = swept({}, np.full(4, REST), ensemble=4, spread={"block.x": "-2:2 m"})
    (points,) = [line for line in draw(path).axes[0].get_lines() if line.get_gid() == "rest"]
    np.testing.assert_array_equal(points.get_ydata(), open_subject(path).result["end_x_block"].ravel())


def test_a_basin_over_two_ranges_of_starts(swept):
    verdicts = np.array([[REST, VIBRATION], [VIBRATION, VIBRATION]])
    figure = draw(swept({"block.x": "-1, 1 m", "block.v": "0, 1 m/s"}, verdicts))
    (mesh,) = [artist for artist in figure.axes[0].collections if artist.get_gid() == "end_state"]
    assert_cells(mesh, [[REST, BLANK, VIBRATION], [BLANK] * 3, [VIBRATION, BLANK, VIBRATION]])


def test_shares_over_two_ranges(swept):
    verdicts = np.full((2, 2, 4), VIBRATION)
    verdicts[1, 1, :2] = REST
    axes = {"belt.belt": "1, 2 m/s", "spring.c": "0.1, 0.2 N s/m"}
    figure = draw(swept(axes, verdicts, ensemble=4, spread=BOTH))
    (mesh,) = [artist for artist in figure.axes[0].collections if artist.get_gid() == "share"]
    assert_cells(mesh, [[0, BLANK, 0], [BLANK] * 3, [0, BLANK, 0.5]])


def test_sweeps_without_end_states_have_no_such_picture(tmp_path):
    case = load_case("gallery/belt-oscillator", {"run.t_end": "2 s"})
    sweep(case, {}, out=tmp_path / "e.h5", ensemble=4, spread=BOTH, jobs=1)
    assert "end-state" not in {kind.name for kind in fitting([open_subject(str(tmp_path / "e.h5"))])}
