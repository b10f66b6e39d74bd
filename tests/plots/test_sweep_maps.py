"""Maps of sweeps over two ranges: every cell shows its point, and what has no value stays blank."""

import shutil

import h5py
import numpy as np
import pytest

from tests.plots.artists import collections, laid_out, legend, lines
from vibsim.cases import load_case
from vibsim.plots.registry import choose, kind_named
from vibsim.plots.subject import PlotError, View, open_subject
from vibsim.sweeps import sweep

NOT_MET, PASSED, ESCAPED, CAPTURED = 1, 2, 3, 4
VERDICTS = np.array([[NOT_MET, PASSED], [CAPTURED, ESCAPED], [CAPTURED, CAPTURED]], float)  # Omega0, c
SPEEDS = np.array([[np.nan, 3.5], [3.6, 3.7], [3.8, 3.9]])
PERIODIC, TRANSIENT, CHAOTIC = 1, 2, 4
REGIMES = np.array([[PERIODIC, PERIODIC], [PERIODIC, CHAOTIC], [TRANSIENT, PERIODIC]], float)
PERIODS = np.array([[1, 2], [7, np.nan], [np.nan, 4]])


@pytest.fixture(scope="module")
def grid(tmp_path_factory):
    """Omega0 by c, with verdicts that differ from cell to cell."""
    path = tmp_path_factory.mktemp("maps") / "grid.h5"
    case = load_case("II-B", {"run.t_end": "2 s"})
    sweep(case, {"Omega0": "3, 4, 6 Hz", "c": "0.01, 0.02"}, out=path, compute=["capture", "regime"])
    values = {"capture": VERDICTS, "capture_speed": SPEEDS, "regime": REGIMES, "regime_period": PERIODS}
    with h5py.File(path, "r+") as file:
        for name, plane in values.items():
            file[name][..., 0] = plane
    return str(path)


def cells(axes, gid, across=(3, 4, 6), up=(0.01, 0.02)):
    """What a map shows at the points of the grid, as rows of the picture."""
    (mesh,) = collections(axes, gid)
    corners = mesh.get_coordinates()
    x, y = corners[0, :, 0], corners[:, 0, 1]
    return mesh.get_array()[np.ix_(np.searchsorted(y, up) - 1, np.searchsorted(x, across) - 1)]


@pytest.fixture
def none_held(grid, tmp_path):
    """The grid, where every motor passed."""
    path = shutil.copy(grid, tmp_path / "none.h5")
    with h5py.File(path, "r+") as file:
        file["capture"][..., 0] = PASSED
    return str(path)


def test_a_map_without_capture_says_so(grid, none_held):
    for path, said in ((none_held, True), (grid, False)):
        texts = laid_out("capture", path, "page").axes[1].texts
        assert ("no motor was captured" in [text.get_text() for text in texts]) == said


@pytest.mark.parametrize("width", ["column", "page"])
def test_verdicts_on_capture(grid, width):
    figure = laid_out("capture", grid, width)
    np.testing.assert_array_equal(cells(figure.axes[0], "capture"), VERDICTS.T)
    assert legend(figure) == ["not met (1)", "passed (1)", "escaped (1)", "captured (3)"]


def test_cells_claim_no_area_between_values_that_are_far_apart(grid):
    """3, 4 and 6 Hz, and two dampings: cells of a tenth of the whole, and nothing in between or beyond."""
    axes = laid_out("capture", grid, "page").axes[0]
    (mesh,) = collections(axes, "capture")
    corners = mesh.get_coordinates()
    np.testing.assert_allclose(corners[0, :, 0], [2.85, 3.15, 3.85, 4.15, 5.85, 6.15])
    np.testing.assert_allclose(corners[:, 0, 1], [0.0095, 0.0105, 0.0195, 0.0205])
    blank = np.ma.getmaskarray(mesh.get_array())
    assert blank[1].all() and blank[:, [1, 3]].all() and blank.sum() == 9
    assert (axes.get_xlim(), axes.get_ylim()) == ((2.85, 6.15), pytest.approx((0.0095, 0.0205)))
    assert "Omega_0" in axes.get_xlabel() and axes.get_ylabel() == "Damping $c$ (N s/m)"


def test_cells_of_even_values_touch(tmp_path):
    case = load_case("II-B", {"run.t_end": "1 s"})
    sweep(case, {"Omega0": "3:5:1 Hz", "c": "0.001:0.003/3"}, out=tmp_path / "even.h5", compute=["regime"])
    (mesh,) = collections(laid_out("regime", tmp_path / "even.h5", "page").axes[0], "regime")
    corners = mesh.get_coordinates()
    np.testing.assert_allclose(corners[0, :, 0], [2.5, 3.5, 4.5, 5.5])  # between and beyond
    np.testing.assert_allclose(corners[:, 0, 1], [0.0005, 0.0015, 0.0025, 0.0035])


def test_speed_only_where_the_motor_was_held(grid):
    speeds = cells(laid_out("capture", grid, "page").axes[1], "capture_speed")
    held = np.isin(VERDICTS, [CAPTURED, ESCAPED]).T
    np.testing.assert_array_equal(~np.ma.getmaskarray(speeds), held)
    np.testing.assert_array_equal(speeds[held], SPEEDS.T[held])


def test_regimes_by_their_period(grid):
    classes = cells(laid_out("regime", grid).axes[0], "regime")
    names = ["period 1", "period 2", "period 3", "period 4", "longer period", "quasi-periodic", "chaotic"]
    shown = [[[*names, "transient"][int(code)] for code in row] for row in classes]
    assert shown == [["period 1", "longer period", "transient"], ["period 2", "chaotic", "period 4"]]


def test_what_is_missing_stays_blank_and_is_said(grid, tmp_path):
    path = tmp_path / "part.h5"
    shutil.copy(grid, path)
    with h5py.File(path, "r+") as file:
        file["status"][0, 0, 0], file["status"][2, 1, 0] = 0, 2
        for name in ("capture", "capture_speed"):
            file[name][0, 0, 0] = file[name][2, 1, 0] = np.nan
    figure = laid_out("capture", str(path), "page")
    blank = np.ma.getmaskarray(cells(figure.axes[0], "capture"))
    np.testing.assert_array_equal(blank, [[True, False, False], [False, False, True]])
    assert figure.axes[1].get_title(loc="right") == "1 not computed yet, 1 failed"


def test_maps_say_what_to_sweep_with(grid, tmp_path):
    case = load_case("II-B", {"run.t_end": "2 s"})
    paths = {"grid": grid, **{name: str(tmp_path / f"{name}.h5") for name in ("regime", "capture")}}
    for name in ("regime", "capture"):
        sweep(case, {"Omega0": "3, 4 Hz"}, out=paths[name], compute=[name])
    for name, kind, message in (
        ("regime", "capture", r"needs verdicts on capture \(sweep with compute='capture'\)"),
        ("regime", "regime", r"it needs two ranges without .* \(sweep with axes=\{KEY: RANGE\}\)"),
        ("capture", "capture", "it needs two ranges, or an ensemble of at most two start values"),
        ("grid", "power", r"it needs powers \(sweep with compute='power'\)"),
        ("grid", "lyapunov", r"Lyapunov exponents \(sweep with compute='lyapunov'\)"),
    ):
        with pytest.raises(PlotError, match=message):
            choose([kind], [open_subject(paths[name])])


def test_a_window_in_the_unit_of_the_axis(grid):
    for kind in ("capture", "regime"):
        figure = kind_named(kind).draw([open_subject(grid)], View(window=(3.5, 5)))
        assert figure.axes[0].get_xlim() == (3.5, 5)
        with pytest.raises(PlotError, match=r"the window 8:9 lies outside the sweep, 2\.85 to 6\.15"):
            kind_named(kind).draw([open_subject(grid)], View(window=(8, 9)))


def test_a_map_shows_one_sweep(grid):
    for kind in ("capture", "regime"):
        with pytest.raises(PlotError, match=f"kind {kind}: it shows one file at a time; kinds that fit: som"):
            choose([kind], [open_subject(grid)] * 2)
    assert {kind.name for kind in choose(["all"], [open_subject(grid)] * 2)} == {
        "sommerfeld", "amplitude", "orbit",
    }  # fmt: skip


def test_up_and_down_have_a_map_each(tmp_path):
    case = load_case("II-B", {"run.t_end": "2 s"})
    axes = {"Omega0": "3, 4 Hz", "c": "0.01, 0.02, 0.03"}
    settings = {"compute": ["regime"], "direction": "both", "carry_state": True}
    sweep(case, axes, out=tmp_path / "both.h5", **settings)
    with h5py.File(tmp_path / "both.h5", "r+") as file:
        file["regime"][..., 0], file["regime"][..., 1] = CHAOTIC, TRANSIENT
    up, down = laid_out("regime", str(tmp_path / "both.h5"), "page").axes
    assert (up.get_title(loc="left"), down.get_title(loc="left")) == ("up", "down")
    shown = [cells(axes, "regime", (3, 4), (0.01, 0.02, 0.03)) for axes in (up, down)]
    assert len({int(code) for each in shown for code in each.ravel()}) == 2


def test_values_by_ratio_have_cells_by_ratio(tmp_path):
    """Edges lie at the geometric means, on a logarithmic axis; the axis in equal steps stays as it is."""
    path, case = tmp_path / "ratios.h5", load_case("II-B", {"run.t_end": "1 s"})
    sweep(case, {"k2": "log 1:100/3 kN/m", "Omega0": "3, 4 Hz"}, out=path, compute=["capture"], jobs=1)
    (panel, *_) = laid_out("capture", str(path), "page").axes
    assert (panel.get_xscale(), panel.get_yscale()) == ("linear", "log")
    edges = np.exp((np.arange(4) - 0.5) * np.log(10.0))
    np.testing.assert_allclose(panel.collections[0].get_coordinates()[:, 0, 1], edges, rtol=1e-12)


def test_curves_over_values_by_ratio_have_a_logarithmic_axis(tmp_path):
    for name, text, scale in (("ratio", "log 1:100/3 kN/m", "log"), ("steps", "1:100/3 kN/m", "linear")):
        path = tmp_path / f"{name}.h5"
        sweep(load_case("II-B", {"run.t_end": "1 s"}), {"k2": text}, out=path, jobs=1)
        (panel, *_) = laid_out("amplitude", str(path), "page").axes
        low, high = panel.get_xlim()
        assert panel.get_xscale() == scale and low < 1 and high > 100


# Power flow and Lyapunov diagram: what is drawn is what the sweep stored.


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    out = tmp_path_factory.mktemp("power") / "power.h5"
    case = load_case("II-B", {"run.t_end": "10 s"})
    computed = ["power", "lyapunov", "lyapunov-spectrum"]
    sweep(case, {"Omega0": "3:5:1 Hz", "c": "0.01, 0.02"}, out=out, compute=computed)
    return str(out)


@pytest.mark.parametrize("width", ["column", "page"])
def test_areas_add_up_to_the_power_of_the_source(path, width):
    result = open_subject(path).result
    panels = laid_out("power", path, width).axes
    factor = {"W": 1, "mW": 1e3, "µW": 1e6}[panels[0].get_ylabel().rpartition("(")[2][:-1]]
    for j, axes in enumerate(panels):
        (line,) = lines(axes, "power_source")
        corners = {
            name: collections(axes, f"power_{name}")[0].get_paths()[0].vertices
            for name in ("damper", "friction", "stored")
        }
        np.testing.assert_allclose(line.get_ydata(), factor * result["power_source"][:, j, 0])
        for i, x in enumerate(result["omega0"]):
            damper, friction = (factor * result[f"power_{name}"][i, j, 0] for name in ("damper", "friction"))
            at = {name: each[each[:, 0] == x][:, 1] for name, each in corners.items()}
            assert at["damper"].max() == pytest.approx(damper)
            assert at["friction"].max() == pytest.approx(damper + friction)
            assert np.abs(at["stored"] - line.get_ydata()[i]).min() == pytest.approx(0, abs=1e-9)  # first law


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
        (line,) = lines(axes, "exponent")
        np.testing.assert_array_equal(line.get_xdata(), result["omega0"])
        np.testing.assert_array_equal(line.get_ydata(), result["lyapunov"][:, j, 0])
        (bars,) = collections(axes, "interval")
        ends = np.array([segment[:, 1] for segment in bars.get_segments()])
        np.testing.assert_allclose(ends.mean(axis=1), result["lyapunov"][:, j, 0])
        np.testing.assert_allclose(np.diff(ends)[:, 0] / 2, result["lyapunov_half_width"][:, j, 0])
        further = lines(axes, "further exponent")
        for i, other in enumerate(further):
            np.testing.assert_array_equal(other.get_ydata(), result["lyapunov_spectrum"][:, j, 0, i + 1])
        assert len(further) == result["lyapunov_spectrum"].shape[-1] - 1
        looks = {(other.get_color(), other.get_marker()) for other in (line, *further)}
        assert len(looks) == len(further) + 1  # told apart
        assert axes.get_ylabel().endswith("(1/s)")
    names = legend(figure)
    assert names[:2] == [r"$\lambda_1$", r"$\lambda_{2}$"] and len(names) == len(further) + 1
