"""Pictures of basins: every point in the colour of its attractor, shares where they were counted."""

import h5py
import numpy as np
import pytest

from tests.plots.artists import BLANK, assert_cells, collections, laid_out, legend, lines
from vibsim.cases import load_case
from vibsim.plots.registry import choose, fitting
from vibsim.plots.subject import PlotError, open_subject
from vibsim.plots.sweep_responses import UNDECIDED
from vibsim.sweeps import sweep
from vibsim.sweeps.points import quantile

STARTS = {"tip.x": "-4, 0, 4 mm", "tip.v": "-400, -100, 200 mm/s"}
BELT = {"block.x": "-2:2 m", "block.v": "0:2 m/s"}


@pytest.fixture
def counted(tmp_path):
    """Sweeps a case of the gallery and counts its attractors: the result, and the path of its file."""

    def make(name, axes, t_end=None, compute="attractor", **settings):
        case = load_case(f"gallery/{name}", {"run.t_end": t_end} if t_end else {})
        path = str(tmp_path / "a.h5")
        return sweep(case, axes, section=0, compute=compute, out=path, **settings), path

    return make


def test_a_plane_of_starts(counted):
    result, path = counted("cantilever", STARTS, "20 s")
    assert [kind.name for kind in choose(None, [open_subject(path)])] == ["basins"]
    figure = laid_out("basins", path)
    (mesh,) = collections(figure.axes[0], "attractor")
    assert_cells(mesh, result["attractor"][..., 0].T.astype(float))
    assert legend(figure) == ["period 1, multiplier 0.806: 77.8 %", "period 1, multiplier 0.923: 22.2 %"]


def test_undecided_points_are_marked(counted):
    figure = laid_out("basins", counted("cantilever", STARTS, "0.3 s")[1])
    assert legend(figure) == ["undecided (9)"]
    (patch,) = figure.axes[0].patches
    assert patch.get_gid() == "hatch undecided" and patch.get_hatch() == UNDECIDED.hatch


def test_two_parameters_are_coloured_by_period(counted):
    """One impact in one, two and three periods (Shaw and Holmes 1983), at two restitutions each."""
    ranges = {"drive.omega": "2, 4, 6 rad/s", "wall.e": "0.5, 0.6"}
    figure = laid_out("basins", counted("impact-oscillator", ranges, "100 s", jobs=1)[1])
    (mesh,) = collections(figure.axes[0], "attractor")
    assert set(np.ma.masked_invalid(mesh.get_array()).compressed()) == {0, 1, 2}
    assert legend(figure) == ["period 1", "period 2", "period 3"]


def test_starts_of_an_ensemble(counted):
    result, path = counted("belt-oscillator", {}, ensemble=24, spread=BELT, discard="150 s")
    axes = laid_out("basins", path).axes[0]
    drawn = result.members.drawn
    starts = np.column_stack([drawn["initial.block.x"], drawn["initial.block.v"]])
    labels = result["attractor"].ravel()
    drawn_starts = [line for line in axes.get_lines() if len(line.get_xdata())]
    assert len(drawn_starts) == len({line.get_gid() for line in drawn_starts}) == 2
    for label, line in enumerate(drawn_starts):
        np.testing.assert_array_equal(line.get_xydata(), starts[labels == label])


def test_shares_over_a_parameter(counted):
    belts = {"belt.belt": "1.4, 1.9 m/s"}
    result, path = counted("belt-oscillator", belts, ensemble=20, spread=BELT, discard="150 s")
    axes = laid_out("basins", path).axes[0]
    shares = [line.get_xydata() for line in lines_of(axes).values()]
    rest = result["attractor_kind"][..., 0] == 1
    values = [rest[0].mean(), rest[1].mean()]
    at_rest = next(xy for xy in shares if len(xy) == 2)
    np.testing.assert_allclose(at_rest, [[1.4, values[0]], [1.9, values[1]]])
    cycle = next(xy for xy in shares if len(xy) == 1)
    np.testing.assert_allclose(cycle, [[1.4, 1 - values[0]]])


@pytest.mark.parametrize("compute", [(), "attractor"])
def test_what_has_no_basins_has_no_such_picture(counted, compute):
    _, path = counted("cantilever", {"tip.x": "0, 1 mm"}, "2 s", compute)
    assert "basins" not in {kind.name for kind in fitting([open_subject(path)])}


# Pictures of ensembles: median and quantiles of the members, counted here by numpy.


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


@pytest.mark.parametrize("kind", COLUMNS)
def test_median_and_bands(paths, kind):
    gid, column = COLUMNS[kind]
    result = open_subject(paths["range"]).result
    figure = laid_out(kind, paths["range"])
    (line,) = lines(figure, gid)
    axes = line.axes
    factor = FACTOR[axes.get_ylabel().rpartition("(")[2][:-1]]
    members = factor * result[column][..., 0]
    np.testing.assert_allclose(line.get_ydata(), np.median(members, axis=1))
    for area, q in zip(collections(axes, "quantiles"), (0.05, 0.25), strict=True):
        corners = area.get_paths()[0].vertices
        for x, values in zip(result["omega0"], members, strict=True):
            at = corners[corners[:, 0] == x][:, 1]
            assert (at.min(), at.max()) == pytest.approx(tuple(np.quantile(values, (q, 1 - q))))
    title = figure.axes[0].get_title(loc="right")
    assert title.replace("\n", " ").startswith("median and 5–95 %, 25–75 % of 5 members")


def test_exponents_of_an_ensemble(paths):
    axes = laid_out("lyapunov", paths["range"]).axes[0]
    (line,) = lines(axes.figure, "exponent")
    values = open_subject(paths["range"]).result["lyapunov"][..., 0]
    np.testing.assert_allclose(line.get_ydata(), np.median(values, axis=1))
    assert len(collections(axes, "quantiles")) == 2 and not collections(axes, "interval")


def test_powers_of_an_ensemble_add_up(paths):
    (axes,) = laid_out("power", paths["range"]).axes
    (line,) = lines(axes.figure, "power_source")
    tops = collections(axes, "power_stored")[0].get_paths()[0].vertices
    for x, source in zip(*line.get_data(), strict=True):
        assert np.abs(tops[tops[:, 0] == x][:, 1] - source).min() == pytest.approx(0, abs=1e-9)  # first law


def test_orbits_hold_the_points_of_all_members(paths):
    result = open_subject(paths["range"]).result
    (dots,) = lines(laid_out("orbit", paths["range"]), "section_speed")
    np.testing.assert_array_equal(np.sort(dots.get_ydata()), np.sort(result["section_speed"].ravel()))


@pytest.mark.parametrize("kind", ["amplitude", "lyapunov", "power", "orbit"])
def test_an_ensemble_alone_is_drawn_over_its_start_values(paths, kind):
    figure = laid_out(kind, paths["alone"])
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


# End states and capture over ensembles: shares counted by hand, starts where they were drawn.


MOTOR = {"phi": "0:360 deg", "phidot": "0:5 Hz"}
CASES = {"end-state": "gallery/belt-oscillator", "capture": "II-B"}
REST, VIBRATION = 1, 2
ESCAPED, CAPTURED = 3, 4
Z = 1.959964  # 95 % of a normal distribution


@pytest.fixture
def swept(tmp_path):
    """Sweeps a case over some axes with four members and gives the points these verdicts."""

    def make(kind, axes, verdicts, **settings):
        case, path = load_case(CASES[kind], {"run.t_end": "2 s"}), tmp_path / "e.h5"
        sweep(case, axes, out=path, compute=[kind], **{"jobs": 1, "ensemble": 4, **settings})
        with h5py.File(path, "r+") as file:
            file[kind.replace("-", "_")][..., 0] = verdicts
        return str(path)

    return make


def lines_of(axes):
    return {line.get_gid(): line for line in axes.get_lines() if line.get_gid()}


def test_shares_along_a_range(swept):
    verdicts = np.array([[VIBRATION] * 4, [REST, VIBRATION, VIBRATION, VIBRATION], [REST] * 4])
    path = swept("end-state", {"belt.belt": "1, 1.5, 2 m/s"}, verdicts, spread=BELT)
    axes = laid_out("end-state", path).axes[0]
    np.testing.assert_allclose(lines_of(axes)["rest"].get_xydata(), [[1, 0], [1.5, 0.25], [2, 1]])
    np.testing.assert_allclose(lines_of(axes)["vibration"].get_xydata(), [[1, 1], [1.5, 0.75], [2, 0]])
    bars = axes.containers[0].lines[2][0].get_segments()
    # Wilson (1927) for 0 of 4, upper end: z^2 / (n + z^2)
    assert bars[0][:, 1] == pytest.approx([0, Z**2 / (4 + Z**2)], abs=1e-6)


def test_probability_along_a_range(swept):
    verdicts = np.array([[CAPTURED] * 4, [CAPTURED, ESCAPED, CAPTURED, CAPTURED], [ESCAPED] * 4])
    axes = laid_out("capture", swept("capture", {"Omega0": "3, 4, 5 Hz"}, verdicts)).axes[0]
    np.testing.assert_allclose(lines_of(axes)["probability"].get_xydata(), [[3, 1], [4, 0.75], [5, 0]])
    band = axes.collections[0].get_paths()[0].vertices
    assert band[:, 1].max() == pytest.approx(1) and band[:, 1].min() == pytest.approx(0)
    # Wilson (1927) for 4 of 4, lower end: n / (n + z^2)
    assert band[(band[:, 0] == 3)][:, 1].min() == pytest.approx(4 / (4 + Z**2), rel=1e-6)


@pytest.mark.parametrize(
    ("kind", "names", "spread", "across", "up"),
    [
        ("end-state", {REST: "rest", VIBRATION: "vibration"}, BELT, "(m)", "(m/s)"),
        ("capture", {CAPTURED: "captured", ESCAPED: "escaped"}, MOTOR, "(deg)", "(Hz)"),
    ],
)
def test_starts_by_their_verdict(swept, kind, names, spread, across, up):
    verdicts = np.array([*names, *names])
    path = swept(kind, {}, verdicts, spread=spread)
    axes = laid_out(kind, path).axes[0]
    drawn = open_subject(path).result.members.drawn
    starts = np.column_stack([drawn[f"initial.{key}"] for key in spread])
    for code, name in names.items():
        np.testing.assert_array_equal(lines_of(axes)[name].get_xydata(), starts[verdicts == code])
    first, _ = names.values()
    assert axes.get_title(loc="right").startswith(f"{first}: 50 %")
    assert axes.get_xlabel().endswith(across) and axes.get_ylabel().endswith(up)


@pytest.mark.parametrize(
    ("kind", "settings", "column"),
    [("end-state", {"spread": {"block.x": "-2:2 m"}}, "end_x_block"), ("capture", {}, "final_speed")],
)
def test_one_start_value_against_the_last_of_the_run(swept, kind, settings, column):
    name, verdict = {"end-state": ("rest", REST), "capture": ("captured", CAPTURED)}[kind]
    path = swept(kind, {}, np.full(4, verdict), **settings)
    starts = lines_of(laid_out(kind, path).axes[0])[name]
    np.testing.assert_array_equal(starts.get_ydata(), open_subject(path).result[column].ravel())


def test_a_basin_over_two_ranges_of_starts(swept):
    verdicts = np.array([[REST, VIBRATION], [VIBRATION, VIBRATION]])
    path = swept("end-state", {"block.x": "-1, 1 m", "block.v": "0, 1 m/s"}, verdicts, ensemble=0)
    panel = laid_out("end-state", path).axes[0]
    (mesh,) = collections(panel, "end_state")
    assert_cells(mesh, [[REST, BLANK, VIBRATION], [BLANK] * 3, [VIBRATION, BLANK, VIBRATION]])


@pytest.mark.parametrize(
    ("kind", "axes", "counted", "settings"),
    [
        ("end-state", {"belt.belt": "1, 2 m/s", "spring.c": "0.1:0.3/3"}, REST, {"spread": BELT}),
        ("capture", {"Omega0": "3, 4 Hz", "c": "0.01:0.03/3"}, CAPTURED, {}),
    ],
)
def test_shares_over_two_ranges(swept, kind, axes, counted, settings):
    verdicts = np.full((2, 3, 4), {REST: VIBRATION, CAPTURED: ESCAPED}[counted])
    verdicts[1, 2] = counted
    verdicts[0, 1, :1] = counted
    (panel, *_) = laid_out(kind, swept(kind, axes, verdicts, **settings)).axes
    (mesh,) = collections(panel, "share")
    assert_cells(mesh, [[0, BLANK, 0], [0.25, BLANK, 0], [0, BLANK, 1]])


def test_a_direction_makes_no_difference(swept):
    path = swept("capture", {}, np.full(4, CAPTURED), direction="both")
    assert len(lines_of(laid_out("capture", path).axes[0])["captured"].get_xdata()) == 4


def test_three_start_values_are_too_many(swept):
    spread = {"phi": "0:1 turn", "x1": "1 mm", "x2": "1 mm"}
    path = swept("capture", {}, np.full(4, CAPTURED), spread=spread)
    assert "capture" not in {kind.name for kind in fitting([open_subject(path)])}
    with pytest.raises(PlotError, match="an ensemble of at most two start values"):
        choose(["capture"], [open_subject(path)])


def test_sweeps_without_end_states_have_no_such_picture(counted):
    _, path = counted("belt-oscillator", {}, "2 s", (), ensemble=4, spread=BELT, jobs=1)
    assert "end-state" not in {kind.name for kind in fitting([open_subject(path)])}
