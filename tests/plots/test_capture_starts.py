"""Capture over ensembles: shares counted by hand, starts where they were drawn."""

import h5py
import numpy as np
import pytest

from tests.plots.artists import BLANK, assert_cells, clipped_texts
from vibsim.cases import load_case
from vibsim.plots.registry import choose, fitting, kind_named
from vibsim.plots.subject import PlotError, View, open_subject
from vibsim.sweeps import sweep

ESCAPED, CAPTURED = 3, 4


@pytest.fixture
def ensemble(tmp_path):
    """Sweeps II-B over some axes with four members and gives them these verdicts."""

    def make(axes, verdicts, **settings):
        case = load_case("II-B", {"run.t_end": "2 s"})
        sweep(case, axes, out=tmp_path / "e.h5", compute=["capture"], ensemble=4, **settings)
        with h5py.File(tmp_path / "e.h5", "r+") as file:
            file["capture"][..., 0] = verdicts
        return str(tmp_path / "e.h5")

    return make


def draw(path):
    figure = kind_named("capture").draw([open_subject(path)], View())
    figure.draw_without_rendering()
    assert clipped_texts(figure) == []
    return figure


def test_probability_along_a_range(ensemble):
    verdicts = np.array([[CAPTURED] * 4, [CAPTURED, ESCAPED, CAPTURED, CAPTURED], [ESCAPED] * 4])
    axes = draw(ensemble({"Omega0": "3, 4, 5 Hz"}, verdicts)).axes[0]
    (line,) = [line for line in axes.get_lines() if line.get_gid() == "probability"]
    np.testing.assert_allclose(line.get_xydata(), [[3, 1], [4, 0.75], [5, 0]])
    band = axes.collections[0].get_paths()[0].vertices
    assert band[:, 1].max() == pytest.approx(1) and band[:, 1].min() == pytest.approx(0)
    # Wilson (1927) for 4 of 4, lower end: n / (n + z^2)
    assert band[(band[:, 0] == 3)][:, 1].min() == pytest.approx(4 / (4 + 1.959964**2), rel=1e-6)


def test_probability_over_two_ranges(ensemble):
    verdicts = np.full((2, 3, 4), ESCAPED)
    verdicts[1, 2] = CAPTURED
    verdicts[0, 1, :1] = CAPTURED
    figure = draw(ensemble({"Omega0": "3, 4 Hz", "c": "0.01:0.03/3"}, verdicts))
    (mesh,) = [artist for artist in figure.axes[0].collections if artist.get_gid() == "share"]
    assert_cells(mesh, [[0, BLANK, 0], [0.25, BLANK, 0], [0, BLANK, 1]])


def test_starts_by_their_verdict(ensemble):
    verdicts = np.array([CAPTURED, ESCAPED, CAPTURED, ESCAPED])
    path = ensemble({}, verdicts, spread={"phi": "0:360 deg", "phidot": "0:5 Hz"})
    axes = draw(path).axes[0]
    drawn = open_subject(path).result.members.drawn
    starts = np.column_stack([drawn["initial.phi"], drawn["initial.phidot"]])
    for code, name in {CAPTURED: "captured", ESCAPED: "escaped"}.items():
        (points,) = [line for line in axes.get_lines() if line.get_gid() == name]
        np.testing.assert_array_equal(points.get_xydata(), starts[verdicts == code])
    assert axes.get_title(loc="right").startswith("captured: 50 %")
    assert (axes.get_xlabel()[-5:], axes.get_ylabel()[-4:]) == ("(deg)", "(Hz)")


def test_one_start_value_against_the_last_speed(ensemble):
    path = ensemble({}, np.full(4, CAPTURED))
    (points,) = [line for line in draw(path).axes[0].get_lines() if line.get_gid() == "captured"]
    np.testing.assert_array_equal(points.get_ydata(), open_subject(path).result["final_speed"].ravel())


def test_a_direction_makes_no_difference(ensemble):
    path = ensemble({}, np.full(4, CAPTURED), direction="both")
    (points,) = [line for line in draw(path).axes[0].get_lines() if line.get_gid() == "captured"]
    assert len(points.get_xdata()) == 4


def test_three_start_values_are_too_many(ensemble):
    path = ensemble({}, np.full(4, CAPTURED), spread={"phi": "0:1 turn", "x1": "1 mm", "x2": "1 mm"})
    assert "capture" not in {kind.name for kind in fitting([open_subject(path)])}
    with pytest.raises(PlotError, match="an ensemble of at most two start values"):
        choose(["capture"], [open_subject(path)])
