"""End states and capture over ensembles: shares counted by hand, starts where they were drawn."""

import h5py
import numpy as np
import pytest

from tests.plots.artists import BLANK, assert_cells, laid_out
from vibsim.cases import load_case
from vibsim.plots.registry import choose, fitting
from vibsim.plots.subject import PlotError, open_subject
from vibsim.sweeps import sweep

BELT = {"block.x": "-2:2 m", "block.v": "0:2 m/s"}
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
    (mesh,) = [artist for artist in panel.collections if artist.get_gid() == "end_state"]
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
    (mesh,) = [artist for artist in panel.collections if artist.get_gid() == "share"]
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


def test_sweeps_without_end_states_have_no_such_picture(tmp_path):
    case = load_case("gallery/belt-oscillator", {"run.t_end": "2 s"})
    sweep(case, {}, out=tmp_path / "e.h5", ensemble=4, spread=BELT, jobs=1)
    assert "end-state" not in {kind.name for kind in fitting([open_subject(str(tmp_path / "e.h5"))])}
