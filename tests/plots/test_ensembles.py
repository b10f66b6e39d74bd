"""Pictures of ensembles: median and quantiles of the members, counted here by numpy."""

import numpy as np
import pytest

from tests.plots.artists import clipped_texts, lines
from vibsim.cases import load_case
from vibsim.plots.registry import kind_named
from vibsim.plots.subject import View, open_subject
from vibsim.sweeps import sweep
from vibsim.sweeps.points import quantile

COLUMNS = {"sommerfeld": ("mean", "mean_speed"), "amplitude": ("relative", "amplitude_relative")}
FACTOR = {"Hz": 1.0, "mm": 1e3, "µm": 1e6}


@pytest.fixture(scope="module")
def paths(tmp_path_factory):
    folder = tmp_path_factory.mktemp("ensembles")
    case = load_case("II-B", {"run.t_end": "4 s"})
    settings = {"compute": ["power", "lyapunov"], "ensemble": 5, "section": 7}
    sweep(case, {"Omega0": "3, 4, 5 Hz"}, out=folder / "range.h5", **settings)
    sweep(case, {}, out=folder / "alone.h5", **settings)
    return {name: str(folder / f"{name}.h5") for name in ("range", "alone")}


def draw(kind, path):
    figure = kind_named(kind).draw([open_subject(path)], View())
    figure.draw_without_rendering()
    assert clipped_texts(figure) == []
    return figure


def quantile_areas(axes):
    return [area for area in axes.collections if area.get_gid() == "quantiles"]


@pytest.mark.parametrize("kind", COLUMNS)
def test_median_and_bands(paths, kind):
    gid, column = COLUMNS[kind]
    result = open_subject(paths["range"]).result
    figure = draw(kind, paths["range"])
    (line,) = lines(figure, gid)
    axes = line.axes
    factor = FACTOR[axes.get_ylabel().rpartition("(")[2][:-1]]
    members = factor * result[column][..., 0]
    np.testing.assert_allclose(line.get_ydata(), np.median(members, axis=1))
    for area, q in zip(quantile_areas(axes), (0.05, 0.25), strict=True):
        corners = area.get_paths()[0].vertices
        for x, values in zip(result["omega0"], members, strict=True):
            at = corners[corners[:, 0] == x][:, 1]
            assert (at.min(), at.max()) == pytest.approx(tuple(np.quantile(values, (q, 1 - q))))
    title = figure.axes[0].get_title(loc="right")
    assert title.replace("\n", " ").startswith("median and 5–95 %, 25–75 % of 5 members")


def test_exponents_of_an_ensemble(paths):
    axes = draw("lyapunov", paths["range"]).axes[0]
    (line,) = lines(axes.figure, "exponent")
    values = open_subject(paths["range"]).result["lyapunov"][..., 0]
    np.testing.assert_allclose(line.get_ydata(), np.median(values, axis=1))
    assert len(quantile_areas(axes)) == 2
    assert not [bar for bar in axes.collections if bar.get_gid() == "interval"]


def test_powers_of_an_ensemble_add_up(paths):
    (axes,) = draw("power", paths["range"]).axes
    (line,) = lines(axes.figure, "power_source")
    tops = next(area for area in axes.collections if area.get_gid() == "power_stored").get_paths()[0].vertices
    for x, source in zip(*line.get_data(), strict=True):
        assert np.abs(tops[tops[:, 0] == x][:, 1] - source).min() == pytest.approx(0, abs=1e-9)  # first law


def test_orbits_hold_the_points_of_all_members(paths):
    result = open_subject(paths["range"]).result
    (dots,) = lines(draw("orbit", paths["range"]), "section_speed")
    np.testing.assert_array_equal(np.sort(dots.get_ydata()), np.sort(result["section_speed"].ravel()))


@pytest.mark.parametrize("kind", ["amplitude", "lyapunov", "power", "orbit"])
def test_an_ensemble_alone_is_drawn_over_its_start_values(paths, kind):
    figure = draw(kind, paths["alone"])
    phases = open_subject(paths["alone"]).result.members.drawn["initial.phi"]
    gid = {"amplitude": "x1", "lyapunov": "exponent", "power": "power_source", "orbit": "section_speed"}[kind]
    (line,) = lines(figure, gid)
    np.testing.assert_array_equal(np.unique(line.get_xdata()), np.sort(phases))
    assert line.get_linestyle() == "None"
    assert "at the start" in figure.axes[-1].get_xlabel()
    assert "band" not in figure.axes[0].get_title(loc="right") or kind == "power"


def test_quantiles_leave_out_what_is_missing():
    values = np.array([[1.0, np.nan, 3.0, 2.0], [np.nan] * 4])
    np.testing.assert_array_equal(quantile(values, 1, 0.5), [2.0, np.nan])
