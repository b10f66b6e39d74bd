"""The search: it finds what was planted, judges fairly, and comes to the same bits in any way."""

import numpy as np
import pytest

from tests.fitting.made import done, light_motor, numbers_of, plan_of, run_up, small_plan
from vibsim.cases import CaseError, load_case
from vibsim.fitting import FitError, fit
from vibsim.fitting.search import best_of, sobol, subsets
from vibsim.sweeps.points import share


@pytest.mark.parametrize("method", ["quasi-random", "evolution"])
def test_a_planted_inertia_is_found(method):
    """A free motor passes 3 Hz after T ln(W/(W - w)): the time tells J, whatever the search."""
    when = run_up(3.0, J=0.0007)
    wanted, free = [f"passes 3 Hz between {when - 0.1} and {when + 0.1} s"], {"J": "0.2:5 g m^2"}
    search = {"leave": {"J": 0.0}, "method": method, "candidates": 120}
    found = done(plan_of([light_motor(run__t_end="15 s")], free, wanted, **search))
    assert found.best.price == 0.0 and found.best.explained == 1
    inertia = found.case_of(found.best.candidate).number("J")
    assert inertia == pytest.approx(0.0007, rel=0.1)  # within 0.1 s and a lag of 0.12 s in 3.8 s


def test_leaving_the_printed_value_has_its_price():
    """With a wide range of times many inertias fit; the cheapest is the one next to the printed value."""
    wanted = [f"passes 3 Hz between {run_up(3.0, J=0.002)} and {run_up(3.0, J=0.003) + 1} s"]
    plan = plan_of([light_motor()], {"J": "0.2:5 g m^2"}, wanted, leave={"J": 0.3}, candidates=48)
    best = done(plan).best
    assert best.results[0].holds
    apart = 0.3 * np.log10(5 / 0.2) * 2 / 48  # of neighbours among 48 Sobol points, at most
    assert best.price == best.candidate.leaving == pytest.approx(0.3 * np.log10(2), abs=apart)


def test_more_workers_come_to_the_same_bits():
    plan = small_plan()
    assert numbers_of(done(plan, jobs=1)) == numbers_of(done(plan, jobs=4))


def test_evolution_goes_on_where_all_are_equally_bad():
    """No inertia lets the motor pass what is far beyond its no-load speed: all of the budget is tried."""
    motor, wanted = light_motor(run__t_end="1 s"), ["passes 1000 Hz between 0.2 and 0.4 s"]
    plan = plan_of([motor], {"J": "0.2:5 g m^2"}, wanted, method="evolution", candidates=40)
    assert len(done(plan).candidates) >= 40


def test_evolution_repeats_itself():
    plan = small_plan(method="evolution", candidates=24)
    assert numbers_of(done(plan, jobs=1)) == numbers_of(done(plan, jobs=3))


def test_another_seed_tries_something_else():
    changes = [[one.changes for one in done(small_plan(seed=seed)).candidates] for seed in (1, 2)]
    assert changes[0][:2] == changes[1][:2] and changes[0][2:] != changes[1][2:]


def test_screened_candidates_go_on_by_price():
    """Of 16 candidates 4 are judged from all starts; each of them did no worse from the first two."""
    found = done(small_plan(screen=2, confirm=0))
    searched = [one.number for one in found.candidates if one.origin == "search"]
    counts = [sum(i == number and start >= 0 for i, _, start in found.runs) for number in searched]
    assert sorted(counts) == [2] * 12 + [4] * 4
    assert len(found.ranking) == 4 + 2


def test_the_best_are_judged_again_from_starts_that_the_search_has_not_seen():
    found = done(small_plan(confirm=2, fresh=5))
    plan = found.plan
    assert list(plan.fresh_starts) == [4, 5, 6, 7, 8]
    drawn = [plan.start(position) for position in range(plan.all_starts)]
    assert drawn[0] == {} and len({str(each) for each in drawn}) == 9
    again = [each for each in found.ranking if each.starts == tuple(plan.fresh_starts)]
    assert {each.candidate.origin for each in again[:2]} <= {"search", "reading", "as given"}
    assert len(again) >= 3  # the printed values, the reading, and the two best, which may be these
    assert all(found.is_confirmed(each) for each in again)
    confirmed = [found.is_confirmed(each) for each in found.ranking]
    assert confirmed == sorted(confirmed, reverse=True)


def test_readings_alone_are_judged_from_all_starts_at_once():
    motor, readings = light_motor(run__t_end="12 s"), ["J=0.003", "M0=0.01"]
    found = done(plan_of([motor], {}, ["passes 3 Hz before 6 s"], readings, ensemble=3))
    assert [str(one) for one in found.candidates] == ["as given", "J = 0.003", "M0 = 0.01"]
    counts = {str(each.candidate): each.results[0].count for each in found.ranking}
    assert counts == {"as given": 4, "M0 = 0.01": 4, "J = 0.003": 0}
    assert {each.results[0].of for each in found.ranking} == {4}


def test_shares_have_wilsons_interval():
    found = done(small_plan()).ranking[-1].results[0]
    holds = np.arange(found.of) < found.count
    expected = share(holds, np.ones(found.of, bool), 0)
    assert (found.share, found.low, found.high) == (expected.estimate, expected.low, expected.high)


def test_parameters_can_be_changed_one_or_two_at_a_time():
    motor, wanted = light_motor(run__t_end="5 s"), ["final speed at least 3 Hz"]
    free = {"J": "0.5:2 g m^2", "M0": "3:8 mN m", "e": "0.1:0.2"}
    plan = plan_of([motor], free, wanted, at_most=2, candidates=12)
    names = [tuple(each.name for each in subset) for subset in subsets(plan)]
    assert names == [("J",), ("M0",), ("e",), ("J", "M0"), ("J", "e"), ("M0", "e")]
    made = [len(one.changes) for one in done(plan).candidates if one.origin == "search"]
    assert made == [1] * 6 + [2] * 6


def test_a_run_that_fails_fulfils_nothing():
    """A run that breaks down counts as far off, and is counted."""
    plan = plan_of([light_motor(run__t_end="5 s")], {}, ["final speed at least 0 Hz"], ["J=0.002"])
    found = done(plan)
    index = (1, 0, 0)
    point = found.runs[index]
    found.runs[index] = type(point)(index, 2, point.sha256, "why")
    judged = found.judged(found.candidates[1])
    assert (judged.failed, judged.explained, judged.results[0].shortfall) == (1, 0, 1.0)


def test_the_trust_horizon_is_told_beside_what_is_decided():
    """II-B as printed: right until some 80 s. It passes 4 Hz before; its final speed is beyond."""
    wanted = ["passes 4 Hz before 60 s", "final speed at least 5 Hz", "impacts at least 1 over 5 to 50 s"]
    found = done(plan_of([load_case("II-B", {"run.t_end": "150 s"})], {}, wanted, ["c=0.03"]))
    printed, damped = found.candidates
    assert 70 < found.horizon(printed, 0) < 90
    assert [found.within_horizon(printed, each) for each in found.statements] == [True, False, True]
    assert found.horizon(damped, 0) == 150
    assert all(found.within_horizon(damped, each) for each in found.statements)


def test_several_cases_share_what_is_changed():
    other = light_motor(name="other", excitation__Omega0="3 Hz", run__t_end="5 s")
    cases = [light_motor(run__t_end="5 s"), other]
    wanted = ["II-B: mean speed at least 1 Hz", "other: mean speed at most 3 Hz"]
    found = done(plan_of(cases, {}, wanted, ["J=0.002"]))
    for position, case in enumerate(cases):
        expected = case.with_values({"J": "0.002"}).sha256
        assert found.runs[1, position, 0].sha256 == expected
        assert found.case_of(found.candidates[1], position).sha256 == expected


def test_an_ideal_source_can_be_fitted():
    """The frequency at which I-C strikes once in every cycle; one part of the range does, one does not."""
    case = load_case("I-C", {"run.t_end": "60 s"})
    wanted = "impacts per cycle between 0.99 and 1.01 in the last 20 s"
    found = fit(case, {"omega": "3.5:6.5 Hz"}, [wanted], ensemble=0, candidates=8, seed=3)
    assert found.best.explained == 1
    assert {each.explained for each in found.ranking} == {0, 1}
    assert found.attrs["complete"] == 1 and "best" in repr(found)


def test_equal_changes_are_ranked_once():
    judged = done(small_plan()).ranking
    assert len(best_of([*judged, *judged], 3)) == 3


def test_sobol_points_fill_the_cube():
    points = sobol(2, 64, [1, 0])
    counts, _, _ = np.histogram2d(*points.T, bins=[8, 8], range=[[0, 1], [0, 1]])
    assert (counts == 1).all()  # a (0, 2)-net: one point in each of 64 squares


UNITS = {"kg": "m1 m2 m3", "N/m": "k1 k2", "N s/m": "c", "": "mu", "m": "G e x1 x2", "g m^2": "J"}
UNITS |= {"N m": "M0", "Hz": "Omega0", "m/s": "v1 v2", "rad": "phi"}
MANY = {key: f"1:2 {unit}".strip() for unit, keys in UNITS.items() for key in keys.split()}


@pytest.mark.parametrize(
    ("wishes", "message"),
    [
        ({"statements": []}, "give at least one statement"),
        ({"free": {}}, "nothing to judge"),
        ({"free": {"J": "1:2:3"}}, "a range is FROM:TO with a unit at the end"),
        ({"free": {"c": "log 0:0.1"}}, "by ratio must begin above 0"),
        ({"free": {"J": "1:2 g m^2", "excitation.J": "1:3 g m^2"}}, "excitation.J is free twice"),
        ({"leave": {"c": 0.1}}, "leave c: must name a free parameter, and free are J"),
        ({"leave": {"J": -1.0}}, "a penalty is at least 0"),
        ({"readings": ["J"]}, "'J' is not KEY=VALUE"),
        ({"readings": ["Jay=1"]}, "unknown key"),
        ({"readings": ["J=-1"]}, "must be >= 0"),
        ({"readings": ["J=1, excitation.J=2"]}, "is given twice"),
        ({"method": "magic"}, "the method must be quasi-random or evolution, got magic"),
        ({"candidates": -1}, "candidates must be at least 0"),
        ({"at_most": 0}, "at least one parameter"),
        ({"free": MANY, "at_most": 8}, "at most 8 of 17 parameters .* makes 65535 sets"),
        ({"jobs": 0}, "jobs must be at least 1"),
        ({"ensemble": -1}, "must not be negative"),
        ({"ensemble": 2, "spread": {"J": "1 g m^2"}}, "excitation.J is both changed and spread"),
        ({"ensemble": 2, "spread": {"x1": "wide"}}, "a spread is WIDTH"),
        ({"cases": ["II-B", "II-B"], "statements": ["II-B: captured"]}, "two cases are called II-B"),
        ({"cases": ["II-B", "II-C"], "statements": ["II-B: captured"]}, "no statement is on II-C"),
        ({"cases": []}, "a fit needs a case"),
        ({"cases": "I-A", "free": {"c": "0.001:1"}, "statements": ["chaotic"]}, "say what varies over the"),
    ],
)
def test_wishes_that_cannot_be_used_are_refused(wishes, message):
    usual = {"cases": "II-B", "free": {"J": "1:2 g m^2"}, "statements": ["captured"]}
    with pytest.raises(FitError, match=message):
        fit(**{**usual, **wishes})


def test_ends_of_a_range_must_suit_the_case():
    with pytest.raises(CaseError, match=r"free excitation\.J: must be an inertia"):
        fit("II-B", {"J": "1:2 kg"}, ["captured"])
