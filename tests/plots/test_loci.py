"""Loci of bifurcations, by themselves and over the map of a sweep."""

import numpy as np
import pytest

from tests.branches.made import CAPTURED, branch_of
from tests.command_line.made import call
from tests.plots.artists import legend, lines, on_paper, points
from tests.plots.html_data import data_of, numbers
from vibsim.cases import load_case
from vibsim.orbits.branches.curve import complete
from vibsim.orbits.branches.locus_result import LocusStore, locus_plan
from vibsim.orbits.branches.plan import read_span
from vibsim.orbits.branches.tracing import curve_of
from vibsim.plots.registry import kind_named
from vibsim.plots.subject import PlotError, View, subject_of
from vibsim.results import simulate
from vibsim.sweeps import sweep

POINTS = 3


@pytest.fixture(scope="module")
def loci():
    """Folds and Neimark-Sacker points of captured orbits, a few of each, over Omega0 and c."""
    branch = branch_of(CAPTURED, "4.9:6 Hz")
    plans = [locus_plan(branch, label, *read_span(branch.case, "c", "0.02:0.04")) for label in ("F1", "NS1")]
    return [subject_of(complete(LocusStore(plan), POINTS)[0]) for plan in plans]


@pytest.fixture(scope="module")
def mapped():
    """Capture over Omega0 and c, and over Omega0 and mu."""
    case = load_case("II-B", {"run.t_end": "1 s"})
    axes = [{"Omega0": "5, 6 Hz", key: text} for key, text in (("c", "0.02, 0.04"), ("mu", "0.001, 0.002"))]
    return [subject_of(sweep(case, each, compute=["capture"])) for each in axes]


def test_both_kinds_are_seen_where_they_lie_on_each_other(loci):
    figure = kind_named("locus").draw(loci, View())
    (folds,), (tori,) = lines(figure, "fold"), lines(figure, "neimark-sacker")
    assert folds.get_color() != tori.get_color() and tori.get_zorder() > folds.get_zorder()
    x, y = points(folds)
    np.testing.assert_allclose(x[np.abs(y - 0.03).argmin()], 5.794093157256641, rtol=1e-11)
    assert legend(figure) == ["folds", "Neimark–Sacker points"]


def test_loci_over_a_map_are_named_beside_its_verdicts(loci, mapped):
    plain = kind_named("capture").draw(mapped[:1], View(width="page"))
    figure = kind_named("capture").draw([mapped[0], *loci], View(width="page"))
    assert legend(figure) == [*legend(plain), "folds", "Neimark–Sacker points"]
    assert len(lines(figure, "fold")) == 2  # in both panels
    assert figure.axes[0].get_xlim() == plain.axes[0].get_xlim()
    on_paper(figure)


def test_a_locus_over_something_else_is_refused(loci, mapped):
    message = r"over .*Omega0 and .*c does not lie in a map over .*Omega0 and .*mu"
    with pytest.raises(PlotError, match=message):
        kind_named("capture").draw([mapped[1], *loci], View(width="page"))


def test_as_tables_and_as_a_page(loci, tmp_path):
    folds = loci[0].result
    path, page = folds.save(tmp_path / "l.h5"), tmp_path / "l.html"
    assert repr(folds).startswith("<Locus II-B: fold F1 in excitation.Omega0 and coupling.c, 3 points>")
    table, data = folds.to_dataframe(), folds.to_xarray()
    assert table.attrs["units"]["second"] == data["second"].attrs["units"] == "N s/m"
    assert table["second"].tolist() == data["second"].values.tolist() == folds["second"].tolist()
    assert call("export", str(path), "-o", str(tmp_path / "l.csv")).exit_code == 0
    assert call("plot", str(path), "-o", str(page)).exit_code == 0
    lit = data_of(page)["lines"]
    along = [numbers(one["data"], "f8") for one in lit["columns"].values()]
    assert lit["words"][1] == "folds" and list(lit["columns"]) == ["parameter", "second"]
    np.testing.assert_array_equal(np.transpose(along), curve_of(folds))


def test_the_orbit_of_a_point_runs(loci):
    folds = loci[0].result
    case, point = folds.case_at(2), folds.points[2]
    assert case.number("coupling.c") == point.second and case.number("run.t_end") == point.orbit.period
    done = simulate(case)
    for name in ("v1", "v2", "phidot"):
        assert done[name][0] == pytest.approx(done.events[name][-1], rel=1e-9)
