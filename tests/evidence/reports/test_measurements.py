"""What is measured of a run, against motions whose numbers are known."""

import json

import numpy as np
import pytest

from tests.evidence.reports.made import CHANGES
from vibsim.analysis import Capture, Span
from vibsim.cases import load_case
from vibsim.evidence.reports.measurements import (
    EQUAL_FORCE,
    PAPER_RUNS,
    PRINTED,
    changes_of,
    displacement_peak,
    least_hold,
    measure_facts,
    measure_run,
    member_outcome,
    overall_rate,
    plain,
    reach_at_end,
    starts,
    steady_amplitudes,
)
from vibsim.evidence.reports.paper_figures import reach_by_second
from vibsim.evidence.reports.readings import LAWS, at_point, followed, measure_without_stop, most_common

TIME = np.linspace(0, 300, 6001)


class Run:
    """Stands in for a Result: columns by name over 300 s."""

    t_reached = 300.0
    time = TIME

    def __init__(self, **columns):
        self.columns = {"time": TIME, **columns}

    def __getitem__(self, name):
        return self.columns[name]


def test_the_peak_is_that_of_the_mean_motion():
    """A hump of 0.1 m at 170 s under a vibration that is larger at 50 s."""
    hump = 0.1 * np.exp(-(((TIME - 170) / 40) ** 2))
    vibration = 0.5 * np.exp(-(((TIME - 50) / 9) ** 2)) * np.sin(2 * np.pi * 4 * TIME)
    peak = displacement_peak(TIME, hump + vibration)
    assert peak["time"] == pytest.approx(170, abs=0.1)
    assert peak["height"] == pytest.approx(0.1, rel=2e-3)
    assert peak["end"] == pytest.approx(0.1 * np.exp(-((127.5 / 40) ** 2)), rel=0.05)  # mean of 295 to 300 s


def test_steady_amplitudes_leave_out_drift_and_transient():
    """x1 - x2 = 5 mm cos t about 1 mm, both blocks drifting; larger in the first half."""
    drift, size = 1e-3 * TIME, np.where(TIME < 149, 0.5, 0.005)
    x1, v1 = drift + 0.001 + size * np.cos(7 * TIME), np.where(TIME < 149, 9.0, 0.3)
    found = steady_amplitudes(Run(x1=x1, x2=drift, v1=v1, v2=np.full(6001, -0.2)))
    assert found["relative"] == pytest.approx(0.005, rel=0.01)
    assert (found["v1"], found["v2"]) == (0.3, 0.2)


def test_the_reach_of_a_hold_is_that_of_its_end():
    run = Run(x1=1e-3 * TIME, x2=np.zeros(6001))
    found = reach_at_end(run, (10.0, 200.0))
    assert found == {"last": pytest.approx(0.2), "before": pytest.approx(0.15)}
    assert reach_at_end(run, (10.0, 40.0)) == {"last": pytest.approx(0.04), "before": None}


def test_the_reach_of_every_second():
    run = Run(x1=np.floor(np.minimum(TIME, 299.9)), x2=np.zeros(6001))
    t, reach = reach_by_second(run)
    assert t.tolist() == [k + 0.5 for k in range(300)]
    assert reach.tolist() == list(range(300))


def test_numbers_are_plain():
    given = Capture("passed", "why", Span(0.0, 1.0), np.float64(5.5))
    found = plain({"a": given, "b": (np.int64(3), np.nan), 4: np.array([np.inf, 1.0])})
    assert json.loads(json.dumps(found, allow_nan=False)) == found
    assert found["a"]["no_load_speed_hz"] == 5.5
    assert (found["b"], found["4"]) == ([3, None], [None, 1.0])


@pytest.mark.parametrize("name", ["I-C", "II-B"])
def test_a_run_is_measured_whole(short_runs, name):
    run = short_runs[name]
    found = measure_run(run)
    json.dumps(found, allow_nan=False)
    assert found["impacts"] == run.attrs["impacts"]
    assert found["greatest"]["x1"] == abs(run["x1"]).max()
    assert ("capture" in found) == name.startswith("II")
    assert found["cycles"]["cycles"] > 0


def test_the_facts_are_those_of_the_paper():
    """physics: sqrt(k1/m1)/2 pi = 4.130 Hz, free-free 4.334 and 4.149, bilinear 7.70 and 7.37 Hz."""
    facts = measure_facts({name: load_case(name) for name in PAPER_RUNS})
    assert facts["held_hz"] == pytest.approx(4.130, abs=5e-4)
    assert (facts["free_hz_I"], facts["free_hz_II"]) == pytest.approx((4.334, 4.149), abs=5e-4)
    assert (facts["bilinear_hz_I"], facts["bilinear_hz_II"]) == pytest.approx((7.70, 7.37), abs=5e-3)
    assert [row["eq211"] for row in facts["amplitudes"]] == pytest.approx([1.596, 3.941, 5.504], abs=5e-4)
    assert [row["printed"] for row in facts["amplitudes"]] == [0.0725, 0.1140, 0.1350]


def test_what_the_readings_change():
    for name in ("II-B-captured", "II-C-escape"):
        assert changes_of(load_case(name)) == CHANGES


def test_the_least_hold_that_counts():
    """15 T ln((Omega0 - w1)/(Omega0 - w2)), T = Omega0 (J + m3 e^2)/M0, about 3.69 Hz: worked out by hand."""
    case = load_case("II-C")
    assert least_hold(case, 0.001) == pytest.approx(15 * 11.133 * np.log(2.9207 / 2.6993), rel=1e-3)
    assert least_hold(case, 0.010) / least_hold(case, 0.001) == pytest.approx(10.363 / 1.363, rel=1e-9)


def test_the_overall_rate_counts_from_the_start():
    assert overall_rate(Run(x2=0.01 + 1e-4 * TIME)) == pytest.approx(1e-4)


def test_a_member_of_an_ensemble_is_measured():
    """I-C for 40 s from rest: an impact in each cycle, drifting backward; II-A is also judged as a motor."""
    found = member_outcome(load_case("I-C", {"run.t_end": "40 s"}))
    assert found["cycles"] == "every cycle" and found["overall"] < 0
    assert "verdict" not in found
    assert member_outcome(load_case("II-A", {"run.t_end": "40 s"}))["verdict"] == "not met"


def test_without_the_stop_nothing_drifts():
    """Linear but for friction: no impacts, no drift, and period 1 once the free vibration has died out."""
    found = measure_without_stop([load_case("I-A")], lambda *done: True)["I-A"]
    assert found["impacts"] == 0
    assert found["drift"]["verdict"] == "none"
    assert (found["regime"]["verdict"], found["regime"]["period"]) == ("periodic", 1)


def test_neighbours_follow_the_law_of_the_amplitude():
    """m3 e omega as Table 1 has it, m3 e omega^2 as Eq. (2.11) has it."""
    table, equation = (at_point([load_case("I-B")], 0.0033, law, 5.4, 0.0) for law in LAWS)
    omega = 2 * np.pi * 5.4
    assert table.number("A") == pytest.approx(0.0033 * omega, rel=1e-15)  # to all digits
    assert equation.number("A") == pytest.approx(0.0033 * omega**2, rel=1e-15)
    assert table.number("coupling.c") == 0.0


@pytest.mark.parametrize(("law", "names"), [*zip(LAWS, (PRINTED, EQUAL_FORCE), strict=True)])
def test_at_the_frequencies_of_table_1_the_shipped_cases_are_run(law, names):
    """An amplitude rounded to six digits selects another of the motions that coexist there."""
    shipped = [load_case(name) for name in names]
    for case, hz in zip(shipped, (3.5, 5.5, 6.5), strict=True):
        assert at_point(shipped, 0.0033, law, hz, 0.001) is case
        undamped = at_point(shipped, 0.0033, law, hz, 0.0)
        assert undamped.two_blocks().A == case.two_blocks().A
        assert undamped.number("coupling.c") == 0.0


def test_a_point_has_the_regime_of_most_starts():
    """And the period that most of those have; the starts are kept, rest first."""
    kinds = [("chaotic", None), ("periodic", 6), ("periodic", 1), ("transient", 2), ("periodic", 1)]
    starts = [{"regime": regime, "period": period} for regime, period in kinds]
    assert most_common(starts) == {"regime": "periodic", "period": 1, "starts": starts}
    assert most_common(starts[:2])["regime"] == "chaotic"  # as common: that of the earlier start


def test_the_first_irregular_neighbours_are_followed():
    """Two of each regime, law and damping: 300 s can be a transient."""
    kinds = ["chaotic", "periodic", "chaotic", "chaotic", "quasi-periodic"]
    rows = [{"law": "Table 1", "c": 0.0, "regime": kind} for kind in kinds]
    assert followed([*rows, {"law": "Eq. (2.11)", "c": 0.0, "regime": "chaotic"}]) == [0, 2, 4, 5]


def test_starts_are_on_both_sides_of_rest():
    assert sum(starts()) == pytest.approx(0) and max(starts()) == pytest.approx(1.2e-3)
    assert 0 not in starts()
