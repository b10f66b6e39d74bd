import pytest

from tests.evidence.benchmark.made import plan
from vibsim.cases import CaseError, load_case
from vibsim.evidence.benchmark.plan import FAMILIES, BenchError, family_of, make_plan


@pytest.mark.parametrize(
    ("t_end", "samples", "last"), [(None, 2001, 100.0), ("2 s", 401, 2.0), ("30 s", 2001, 30.0)]
)
def test_about_2000_instants_of_the_case(t_end, samples, last):
    times = plan(t_end=t_end).times
    assert len(times) == samples and times[-1] == last
    whole = load_case("II-B").two_blocks()
    assert set(times.tolist()) <= {whole.sample_time(i) for i in range(whole.sample_count)}


def test_errors_are_told_at_four_instants():
    assert plan(t_end="100 s").check_times == [10.0, 20.0, 50.0, 100.0]


def test_a_short_case_is_run_to_its_own_end():
    assert make_plan(load_case("II-B", {"run.t_end": "7 s"})).times[-1] == 7.0


def test_methods_are_taken_in_the_order_of_the_table():
    names = [family.name for family in plan(methods=["rk4", "taylor"]).families]
    assert names == ["taylor", "rk4"]
    assert len(plan(methods=()).families) == len(FAMILIES)


def test_an_unknown_method_gets_a_hint():
    with pytest.raises(BenchError, match=r"unknown method 'DOP_853': did you mean dop853\? The methods are "):
        plan(methods=["DOP_853"])


def test_a_span_of_a_few_samples_is_refused():
    with pytest.raises(BenchError, match=r"0\.02 s is too short: a bench needs 10 samples, one every 5 ms"):
        plan(t_end="0.02 s")
    with pytest.raises(CaseError):
        plan(t_end="-1 s")


def test_the_fingerprint_knows_what_the_truth_depends_on():
    print_of = plan().fingerprint
    assert plan(methods=()).fingerprint == print_of == plan(limit=1.0).fingerprint
    assert plan(run__method="taylor", run__order=12, run__tol="1e-9").fingerprint == print_of
    assert plan(coupling__c="0.01").fingerprint != print_of
    assert plan(t_end="3 s").fingerprint != print_of


def test_the_closed_form_needs_an_ideal_source():
    def methods(name):
        return {family.name for family, _ in plan(name, methods=()).rows()}

    assert "closed-form" in methods("I-A") and "closed-form" not in methods("II-B")


def test_methods_without_events_cannot_take_rigid_stops():
    def methods(name):
        return {family.name for family, _ in plan(name, "1 s", methods=()).rows()}

    assert methods("gallery/chain-with-gaps") - methods("gallery/bouncing-ball") == {"rk45", "tanh", "rk4"}
    assert "rigid stops, which need located events" in family_of("rk4").refusal(
        load_case("hard/zeno-ball").scene()
    )


def test_a_clearance_stops_no_run():
    found = plan("gallery/chain-with-gaps", "1 s", run__on_violation="stop")
    assert not found.case.scene().stop_on_violation


def test_a_rest_distance_stops_no_run():
    found = plan(rest_distance__value="1 mm", rest_distance__on_violation="stop")
    assert not found.case.scene().stop_on_violation


def test_what_is_not_installed_is_left_out(monkeypatch):
    monkeypatch.setattr("vibsim.evidence.benchmark.plan.find_spec", lambda name: None)
    found = plan(methods=())
    assert [family.name for family in found.absent()] == ["taylor", "orders", "heyoka"]
    assert {family.name for family, _ in found.rows()}.isdisjoint({"heyoka", "taylor"})
    assert family_of("heyoka").remedy == "not installed: pip install 'vibsim[bench]'"


@pytest.mark.parametrize("family", FAMILIES, ids=lambda family: family.name)
def test_settings_of_a_family_are_told_apart(family):
    names = [setting for setting, _ in family.ladder]
    assert len(set(names)) == len(names)
