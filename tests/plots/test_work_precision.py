"""The work-precision diagram: what is drawn is what the file holds, and nothing is clipped or covered."""

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

from tests.evidence.benchmark.made import planted
from tests.plots.artists import lines, notes, on_paper, points, words
from vibsim.evidence.benchmark import make_plan, open_bench
from vibsim.evidence.benchmark.bench_result import DONE, FAILED, SLOWER, BenchRow, EventCount, write_bench
from vibsim.evidence.benchmark.plan import FAMILIES
from vibsim.evidence.benchmark.running import origin
from vibsim.plots import style
from vibsim.plots.registry import choose, fitting, kind_named
from vibsim.plots.subject import PlotError, View, open_subject

TIMES = np.linspace(0, 10.0, 101)
MISSED = {("dop853", "rtol 1e-3"): 2}  # events
# method: processor times [s] and errors [m] of its rows
ROWS = {
    "taylor": ([5e-4, 6e-4], [1e-6, 1e-14]),
    "heyoka": ([2e-3, 2.4e-3], [1e-7, 1e-12]),
    "dop853": ([0.2, 0.6], [1e-5, 1e-12]),
    "rk4": ([0.1, 1.0], [1e-2, 1e-4]),
}


def rows():
    for method, measured in ROWS.items():
        ladder = [setting for setting, _ in next(f for f in FAMILIES if f.name == method).ladder]
        for setting, cpu_time, error in zip(ladder, *measured, strict=False):
            yield BenchRow(
                method, setting, DONE, wall_time=5 * cpu_time, cpu_time=cpu_time, t_reached=10.0,
                error=np.full(101, error), faithful_time=10.0 if error < 1e-3 else 2.0,
                events={"contact_begin": EventCount(9, MISSED.get((method, setting), 0), 0)},
            )  # fmt: skip
    yield BenchRow("rk45", "rtol 1e-9", SLOWER, wall_time=20.0, t_reached=0.5, error=np.full(101, np.nan))
    yield BenchRow("radau", "rtol 1e-3", FAILED, "too stiff", error=np.full(101, np.nan))


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    """A bench file with rows made up."""
    file = tmp_path_factory.mktemp("bench") / "II-B-bench.h5"
    truth = {"truth_sha256": "0" * 64, "truth_library": "none", "truth_digits": 40, "truth_digits_right": 30}
    plan = make_plan("II-B", "10 s")
    attrs = {**origin(plan), **truth, "truth_wall_time_s": 1.0, "complete": 1}
    rest = dict.fromkeys(("v1", "v2", "phi", "phidot"), 0 * TIMES)
    planned = planted(TIMES, 0 * TIMES)
    made = replace(planned, samples={**planned.samples, **rest})
    write_bench(file, attrs, plan.case.scene(), made, list(rows()))
    return str(file)


@pytest.fixture(scope="module", params=["page", "column"])
def figure(path, request):
    with style.applied():
        return kind_named("work-precision").draw([open_subject(path)], View(width=request.param))


def test_every_row_is_where_the_file_has_it(figure, path):
    bench = open_bench(path)
    for method in ROWS:
        (line,) = lines(figure, method)
        mine = [row for row in bench.rows if row.method == method]
        x, y = points(line)
        np.testing.assert_array_equal(x, [row.cpu_time / 10 for row in mine])
        np.testing.assert_array_equal(y, [row.error[-1] for row in mine])
    faithful = [points(line)[0].tolist() for line in lines(figure, "faithful")]
    assert faithful == [[10, 10], [10, 10], [10, 10], [2, 10]]


def test_what_did_not_come_so_far_is_not_drawn(figure):
    assert lines(figure, "rk45") == lines(figure, "radau") == []


def test_every_family_is_named_beside_its_curve(figure):
    names, boxes = words(figure, "name"), [text.get_window_extent() for text in notes(figure, "name")]
    assert sorted(names) == ["DOP853", "RK4, sgn", "heyoka", "vibsim, Taylor"]
    assert not any(one.overlaps(other) for one, other in combinations(boxes, 2))
    frame = figure.axes[0].bbox
    assert all(frame.x0 <= box.x0 and box.x1 <= frame.x1 for box in boxes)
    assert [label.get_text() for label in figure.axes[1].get_yticklabels()] == names


def test_the_lead_is_that_at_no_larger_error(figure):
    assert words(figure.axes[0], "lead") == [
        "4 x faster",
        "1000 x faster",
    ]  # heyoka and DOP853 beside the row of 6e-4 s


def test_rows_that_missed_events_are_ringed_and_signs_are_explained(figure, path):
    (rings,) = lines(figure, "missed")
    assert points(rings)[1].tolist() == [1e-5]
    said = "II-B; dashed: events not located; ringed: events missed; arrows: vibsim at no larger error"
    assert figure.axes[0].get_title(loc="right").replace("\n", "; ") == said


def test_vibsim_stands_out(figure):
    (own,), (peer,) = lines(figure, "taylor"), lines(figure, "dop853")
    assert own.get_linewidth() >= 2 * peer.get_linewidth() and own.get_color() != peer.get_color()


def test_nothing_is_clipped_and_axes_have_units(figure):
    on_paper(figure)
    assert figure.axes[0].get_xlabel().endswith("(s)") and figure.axes[1].get_xlabel().endswith("(s)")
    assert figure.axes[0].get_ylabel() == "Largest error of the displacements until 10 s (m)"


def test_it_is_what_a_bench_file_is_drawn_as(path):
    subject = open_subject(path)
    assert [kind.name for kind in choose(None, [subject])] == ["work-precision"]
    assert {kind.name for kind in fitting([subject])} == {"work-precision", "stiffness", "motor"}
    message = r"it shows a trajectory, and .*II-B-bench\.h5 is a bench; kinds that fit"
    with pytest.raises(PlotError, match=message):
        choose(["overview"], [subject])


def test_one_bench_at_a_time(path):
    with pytest.raises(PlotError, match="one bench at a time, not 2"):
        kind_named("work-precision").draw([open_subject(path)] * 2, View())
