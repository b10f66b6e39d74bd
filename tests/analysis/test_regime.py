"""The regime of runs: linear oscillators, the paper's cases, and what has no section."""

import numpy as np
import pytest

import vibsim
from tests.results.made import short_case, short_run
from tests.trust.random_cases import driven_hard
from vibsim.analysis.cycles import Span
from vibsim.analysis.regime import judge_regime, word_period
from vibsim.analysis.sections import section_of
from vibsim.engine.trajectory import open_trajectory

LINEAR = {"blocks__m2": "fixed", "friction": "none", "stop": "none"}


@pytest.mark.parametrize(
    ("name", "changes"),
    [("I-B", {}), ("I-B-eq211", {}), ("II-B", {}), ("II-B", {"stop": "none", "friction": "none"})],
)
def test_the_section_is_the_one_of_the_engine(name, changes):
    run = short_run(name, "30 s", **changes)
    section = section_of(run, Span(5.0, 30.0))
    blocks = [block.section for block in open_trajectory(run.case.scene(), section=True).blocks()]
    exact = {key: np.concatenate([block[key] for block in blocks]) for key in blocks[0]}
    rows = (exact["time"] >= 5) & (exact["time"] <= 30)
    exact = {key: column[rows] for key, column in exact.items()}
    late = run.time >= 5
    lengths, speeds = (np.ptp((run[f"{kind}1"] - run[f"{kind}2"])[late]) / 2 for kind in "xv")
    np.testing.assert_allclose(section.times, exact["time"], atol=1e-11)
    y, u = exact["x1"] - exact["x2"], exact["v1"] - exact["v2"]
    np.testing.assert_allclose(section.points[:, 0], y / lengths, atol=1e-9)
    np.testing.assert_allclose(section.points[:, 1], u / speeds, atol=1e-9)
    np.testing.assert_allclose(section.points[:, 2], exact["v2"] / speeds, atol=1e-9)
    assert section.points.shape[1] == (4 if name == "II-B" else 3)


def test_a_linear_oscillator_settles_to_period_1():
    """V4: transients fall as exp(-c t/2m): to 1e-3 after 6.9 x 0.594 s / 0.2."""
    run = short_run("I-B", "100 s", **LINEAR, coupling__c="0.2 N s/m")
    found = judge_regime(run, (0.0, 100.0))
    assert (found.verdict, found.period, found.word_period) == ("periodic", 1, 1)
    assert found.since == pytest.approx(np.log(1e3) * 2 * 0.297 / 0.2, rel=0.2)
    early = judge_regime(run, (0.0, 15.0))
    assert (early.verdict, early.period, early.since) == ("periodic", 1, None)  # 6e-3 away, and on its way
    np.testing.assert_allclose(early.exponents, [-0.2 / (2 * 0.297)] * 2, rtol=1e-9)
    np.testing.assert_allclose(found.exponents, early.exponents, rtol=1e-9)


def test_an_undamped_oscillator_is_quasi_periodic():
    """Two frequencies, of the source and its own, incommensurable and never settling."""
    found = judge_regime(short_run("I-B", "300 s", **LINEAR, coupling__c="0"))
    assert found.verdict == "quasi-periodic"


@pytest.mark.parametrize(("name", "period"), [("I-A", 5), ("I-B", 18)])
def test_the_periodic_cases_of_the_paper(name, period):
    """The states repeat themselves to rounding after so many cycles, see their section at 3000 s."""
    found = judge_regime(short_run(name, "300 s"))
    assert (found.verdict, found.period, found.word_period) == ("periodic", period, period)
    run = short_run(name, "300 s")
    times = 300 - np.array([0, period]) / run.case.two_blocks().cycles
    v1 = run.at(times)["v1"]
    assert abs(v1[0] - v1[1]) < 1e-7


def test_i_c_is_on_its_way_to_period_1():
    """The multipliers in 16 digits: tests/orbits/truths.json."""
    found = judge_regime(short_run("I-C", "300 s"))
    assert (found.verdict, found.period) == ("periodic", 1)
    assert found.step < 1e-3 and found.since > 200
    multipliers = np.array([complex(*pair) for pair in found.multipliers])
    exact = [0.8486435858373631 - 0.5215168804985694j, 0.8486435858373631 + 0.5215168804985694j]
    np.testing.assert_allclose(multipliers, [*exact, 0.9303994608203476], rtol=0, atol=1e-12)


def test_a_stable_orbit_beside_the_run_is_none_it_goes_to():
    """I-C-eq211 goes to an orbit of 6 periods; the stable one of 1 that Newton's method meets is another."""
    found = judge_regime(short_run("I-C-eq211", "300 s"))
    assert (found.verdict, found.multipliers) == ("undecided", None)


@pytest.mark.parametrize("seed", [9, 19, 4, 7, 12, 31])  # 6 is periodic after a chaotic transient
def test_chaos_and_the_trust_horizon_agree(seed):
    """Driven hard against a stop, chaotic motion loses 1e-16 to 1e-6 m early, regular motion never."""
    run = vibsim.simulate(driven_hard(seed).with_values({"run.t_end": "200 s"}))
    found = judge_regime(run)
    assert found.verdict == ("chaotic" if run.trust_horizon < 30 else "periodic")
    assert found.span.trusted == (found.verdict == "periodic")


def test_nothing_moves():
    found = judge_regime(short_run("I-A", excitation="none"))
    assert (found.verdict, found.period) == ("at rest", None)


def test_what_has_no_section_is_undecided():
    found = judge_regime(short_run("I-A", excitation="none", initial__x1="5 mm"))
    assert (found.verdict, found.reason) == ("undecided", "no source, so no stroboscopic section")
    assert judge_regime(short_run("I-A")).verdict == "undecided"
    assert judge_regime(short_run("I-A"), (1.0, 1.1)).cycles == 0


def test_files_are_judged_as_runs_in_memory_are(tmp_path):
    run = vibsim.simulate(short_case("I-A", "60 s"))
    run.save(tmp_path / "run.h5")
    assert judge_regime(vibsim.open_result(tmp_path / "run.h5")) == judge_regime(run)


def test_periods_of_words():
    assert word_period(["c", "cr", "c", "cr"]) == 2
    assert word_period(["c", "cr", "c"]) is None
    assert word_period(["c", "c", "c", "cr"]) is None
    assert word_period([]) is None
