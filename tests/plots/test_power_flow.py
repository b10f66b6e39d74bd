"""Power flow and Lyapunov diagram: what is drawn is what the sweep stored."""

import numpy as np
import pytest

from tests.plots.artists import laid_out
from vibsim.cases import load_case
from vibsim.plots.subject import open_subject
from vibsim.sweeps import sweep


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    out = tmp_path_factory.mktemp("power") / "power.h5"
    case = load_case("II-B", {"run.t_end": "10 s"})
    computed = ["power", "lyapunov", "lyapunov-spectrum"]
    sweep(case, {"Omega0": "3:5:1 Hz", "c": "0.01, 0.02"}, out=out, compute=computed)
    return str(out)


def heights(axes, gid, x):
    """Ordinates of the corners of an area at x."""
    (area,) = [area for area in axes.collections if area.get_gid() == gid]
    corners = area.get_paths()[0].vertices
    return corners[corners[:, 0] == x][:, 1]


@pytest.mark.parametrize("width", ["column", "page"])
def test_areas_add_up_to_the_power_of_the_source(path, width):
    result = open_subject(path).result
    panels = laid_out("power", path, width).axes
    factor = {"W": 1, "mW": 1e3, "µW": 1e6}[panels[0].get_ylabel().rpartition("(")[2][:-1]]
    for j, axes in enumerate(panels):
        (line,) = [line for line in axes.get_lines() if line.get_gid() == "power_source"]
        np.testing.assert_allclose(line.get_ydata(), factor * result["power_source"][:, j, 0])
        for i, x in enumerate(result["omega0"]):
            damper, friction = (factor * result[f"power_{name}"][i, j, 0] for name in ("damper", "friction"))
            assert heights(axes, "power_damper", x).max() == pytest.approx(damper)
            assert heights(axes, "power_friction", x).max() == pytest.approx(damper + friction)
            top = heights(axes, "power_stored", x)
            assert np.abs(top - line.get_ydata()[i]).min() == pytest.approx(0, abs=1e-9)  # first law


def test_some_of_too_many_curves(tmp_path):
    case = load_case("II-B", {"run.t_end": "1 s"})
    axes = {"Omega0": "3, 4 Hz", "c": "0.01:0.13/13"}
    sweep(case, axes, out=tmp_path / "many.h5", compute=["power"])
    panels = laid_out("power", str(tmp_path / "many.h5"), "page").axes
    names = [axes.get_title(loc="left") for axes in panels]
    assert (len(names), names[0], names[-1]) == (12, "$c$ = 0.01 N s/m", "$c$ = 0.13 N s/m")
    assert panels[2].get_title(loc="right").strip() == "12 of 13 curves"
    assert not any(text.get_bbox_patch() for axes in panels for text in axes.texts)  # nothing over the data
    column = laid_out("power", str(tmp_path / "many.h5"))
    assert column.get_figheight() * 2.54 <= 24 and len(column.axes) == 4


@pytest.mark.parametrize("kind", ["lyapunov", "orbit"])
def test_exponents_with_their_intervals(path, kind):
    result = open_subject(path).result
    figure = laid_out(kind, path)
    panels = figure.axes[2::3] if kind == "orbit" else figure.axes
    assert len(figure.axes) == (6 if kind == "orbit" else 2)
    for j, axes in enumerate(panels):
        (line,) = [line for line in axes.get_lines() if line.get_gid() == "exponent"]
        np.testing.assert_array_equal(line.get_xdata(), result["omega0"])
        np.testing.assert_array_equal(line.get_ydata(), result["lyapunov"][:, j, 0])
        (bars,) = [bar for bar in axes.collections if bar.get_gid() == "interval"]
        ends = np.array([segment[:, 1] for segment in bars.get_segments()])
        np.testing.assert_allclose(ends.mean(axis=1), result["lyapunov"][:, j, 0])
        np.testing.assert_allclose(np.diff(ends)[:, 0] / 2, result["lyapunov_half_width"][:, j, 0])
        further = [line for line in axes.get_lines() if line.get_gid() == "further exponent"]
        for i, other in enumerate(further):
            np.testing.assert_array_equal(other.get_ydata(), result["lyapunov_spectrum"][:, j, 0, i + 1])
        assert len(further) == result["lyapunov_spectrum"].shape[-1] - 1
        looks = {(other.get_color(), other.get_marker()) for other in (line, *further)}
        assert len(looks) == len(further) + 1  # told apart
        assert axes.get_ylabel().endswith("(1/s)")
    names = [text.get_text() for text in figure.legends[0].get_texts()]
    assert names[:2] == [r"$\lambda_1$", r"$\lambda_{2}$"] and len(names) == len(further) + 1
