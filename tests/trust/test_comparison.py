"""Verdicts on two runs."""

import json

import numpy as np
import pytest

import vibsim
from tests.command_line.made import call, told
from tests.results.made import short_case, short_run
from vibsim.analysis import comparison
from vibsim.analysis.comparison import (
    FEWEST_BLOCKS,
    Average,
    ComparedStatistic,
    average,
    averages,
    block_values,
    blocks_of,
    compare,
)

TOLERANCE = 1e-6


def keys(found):
    return [difference.key for difference in found.differences]


def test_a_run_and_itself_again_are_identical():
    found = compare(short_run("II-B"), vibsim.simulate(short_case("II-B")), TOLERANCE)
    assert (found.verdict, found.agree_until, found.differences) == ("identical", 5.0, [])


def test_the_error_estimate_is_no_part_of_the_motion():
    found = compare(short_run("II-B"), vibsim.simulate(short_case("II-B"), trust=False), TOLERANCE)
    assert found.verdict == "identical"


def test_one_bit_is_a_difference():
    one, other = short_run("II-B"), vibsim.simulate(short_case("II-B"))
    other["v2"][700] = np.nextafter(other["v2"][700], 1)
    assert compare(one, other, TOLERANCE).verdict == "agree"
    other = vibsim.simulate(short_case("II-B"))
    other.events["friction"][3] += 1
    assert compare(one, other, TOLERANCE).verdict == "agree"


def test_another_method_agrees_to_the_end():
    found = compare(short_run("I-B"), short_run("I-B", run__method="taylor"), 1e-12)
    assert (found.verdict, found.agree_until, found.span) == ("agree", 5.0, 5.0)
    assert keys(found) == ["run.method", "method"]
    assert (found.differences[0].a, found.differences[0].b) == ("auto", "taylor")
    assert compare(short_run("I-B"), short_run("I-B", run__method="taylor"), 0.0).verdict != "agree"


@pytest.mark.parametrize("every", ["1 ms", "2 s", "7 ms", "1/60 s"])
def test_other_samples_are_of_the_same_motion(every):
    for pair in [("5 ms", every), (every, "5 ms")]:
        runs = [short_run("II-B", run__every=one) for one in pair]
        assert compare(*runs, 1e-13).verdict == "agree"


def test_a_run_of_another_length_agrees_as_far_as_both_go():
    found = compare(short_run("II-B"), short_run("II-B", "3 s"), 0.0)
    assert (found.verdict, found.span, found.agree_until, keys(found)) == ("agree", 3.0, 3.0, ["run.t_end"])


def test_the_end_of_the_agreement_is_the_last_sample_within():
    one, other = short_run("I-A"), vibsim.simulate(short_case("I-A"))
    other["x2"][600:] += 1e-5
    found = compare(one, other, TOLERANCE)
    assert found.agree_until == one.time[599]
    assert (found.verdict, found.statistics) == ("agree_until", [])  # the rest is shorter than 8 x 5 periods


@pytest.mark.parametrize("rows", [3, 100, 1000])
def test_pieces_of_any_size_give_the_same(rows, monkeypatch):
    monkeypatch.setattr(comparison, "ROWS", rows)
    test_the_end_of_the_agreement_is_the_last_sample_within()
    test_a_run_and_itself_again_are_identical()
    test_one_bit_is_a_difference()


def test_runs_that_differ_from_the_start():
    found = compare(short_run("I-A"), short_run("I-A", initial__x1="1 mm"), TOLERANCE)
    assert (found.verdict, found.agree_until, keys(found)) == ("differ", None, ["initial.x1"])


def test_chaotic_runs_of_one_case_agree_in_statistics():
    """A wall struck hard: 1e-6 m are lost within a minute, and the rest holds hundreds of impacts."""
    changes = {"blocks__m2": "fixed", "friction": "none", "coupling__c": "0.05 N s/m"}
    changes |= {"excitation__A": "1 N", "excitation__omega": "8 Hz"}
    one = short_run("I-C", "200 s", **changes)
    found = compare(one, short_run("I-C", "200 s", run__method="taylor", **changes), TOLERANCE)
    assert found.verdict == "agree_in_statistics"
    assert one.trust_horizon <= found.agree_until < 60
    assert [statistic.name for statistic in found.statistics] == ["amplitude", "impact rate"]
    assert found.statistics_from == pytest.approx((found.agree_until + 200) / 2)


def test_runs_part_between_samples_that_are_far_apart():
    """Both of one minute's samples agree, and the runs part at 80 s."""
    dense, sparse = (
        [short_run("II-B", "119 s", run__every=every, run__order=order) for order in ("20", "24")]
        for every in ("5 ms", "60 s")
    )
    expected, found = compare(*dense, TOLERANCE), compare(*sparse, TOLERANCE)
    assert 70 < expected.agree_until < 100
    assert found.agree_until == pytest.approx(expected.agree_until, abs=0.05)
    assert found.verdict == expected.verdict
    assert "amplitude" not in [statistic.name for statistic in found.statistics]  # no samples to take it from


def test_other_cases_differ_and_it_is_said_in_what():
    found = compare(short_run("I-A", "60 s"), short_run("II-B", "60 s"), TOLERANCE)
    assert found.verdict == "differ"
    assert {"excitation.kind", "excitation.A", "excitation.m3", "method"} <= set(keys(found))
    assert next(one for one in found.differences if one.key == "excitation.A").b == "-"
    assert "impact rate" in [statistic.name for statistic in found.statistics if statistic.differs]


def test_the_same_value_in_another_spelling_is_no_difference():
    one, other = short_run("II-B"), short_run("II-B", excitation__Omega0="330 rpm")
    assert compare(one, other, TOLERANCE).differences == []


def test_nothing_in_common():
    empty = short_run("II-B")
    with pytest.raises(ValueError, match="no instant"):
        comparison.agreement(Empty(empty), empty, TOLERANCE)


class Empty:
    """A run of no samples."""

    t_reached = 0.0

    def __init__(self, run):
        self.run = run
        self.time = run.time[:0]

    def __len__(self):
        return 0

    def __contains__(self, name):
        return name in self.run


def test_means_differ_when_their_intervals_are_left():
    near, far = Average(1.05, 0.04), Average(1.051, 0.04)
    assert not ComparedStatistic("", "", Average(1.0, 0.03), near).differs
    assert ComparedStatistic("", "", Average(1.0, 0.03), far).differs
    assert not ComparedStatistic("", "", Average(1.0, 0.0), Average(1.0 + 1e-12, 0.0)).differs


@pytest.mark.parametrize(("correlation", "least"), [(0.0, 0.97), (0.5, 0.93)])
def test_intervals_hold_as_often_as_they_say(correlation, least):
    """99 % intervals of 20 blocks, independent or with correlated neighbours; 2000 trials."""
    rng = np.random.default_rng(1)
    held = 0
    for _ in range(2000):
        noise = rng.normal(size=70)
        for i in range(1, 70):
            noise[i] = correlation * noise[i - 1] + np.sqrt(1 - correlation**2) * noise[i]
        found = average(noise[50:] + 3, 0.01)
        held += abs(found.mean - 3) <= found.half_width
    assert least <= held / 2000


def test_the_interval_of_independent_blocks_is_students():
    blocks = np.array([1.0, -1.0] * 10)  # neighbours against each other count as independent
    found = average(blocks, 0.01)
    assert found.mean == 0
    assert found.half_width == pytest.approx(2.8609 * np.sqrt(20 / 19 / 20), rel=1e-4)  # t at 19, 0.5 %
    assert average(np.full(20, 7.0), 0.01) == Average(7.0, 0.0)


def test_blocks_are_long_enough_or_there_are_none():
    assert len(blocks_of((0, 1000), 1.0)) == 20
    assert len(blocks_of((0, 50), 1.0)) == 10
    assert blocks_of((0, 5 * FEWEST_BLOCKS - 0.1), 1.0) == []
    assert blocks_of((0, 1000), float("inf")) == []
    assert blocks_of((3, 103), 1.0)[-1][1] == 103


def test_statistics_of_a_known_motion():
    """Block 2 slides evenly at 2 m/s and block 1 swings 3 m about it."""
    run = vibsim.simulate(short_case("II-B"))
    t = run.time
    run["x2"][:] = 2 * t
    run["x1"][:] = 2 * t + 3 * np.sin(2 * np.pi * 2 * t)
    run["phidot"][:] = 2 * np.pi * 4
    values = block_values(run, [(0.0, 2.0), (2.0, 4.0)])
    found = averages(values, 0.01)
    assert found["amplitude"].mean == pytest.approx(3, rel=0.005)
    assert found["drift rate"].mean == pytest.approx(2)
    assert found["motor speed"].mean == pytest.approx(4)
    begun = run.events["t"][run.events["kind"] == 1]
    assert found["impact rate"].mean == np.count_nonzero(begun <= 4) / 4


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("compare")
    short_run("II-B").save(folder / "a.h5")
    short_run("II-B", run__order="24").save(folder / "b.h5")
    short_run("I-A", "60 s").save(folder / "c.h5")
    short_run("II-B", "60 s").save(folder / "d.h5")
    return folder


def test_the_command_gives_the_verdict_last(files):
    found = call("compare", files / "a.h5", files / "a.h5")
    assert (found.exit_code, found.stdout.splitlines()[-1].split()) == (0, ["verdict", "identical"])
    found = call("compare", files / "a.h5", files / "b.h5")
    assert "differences     run.order: 20  |  24" in found.stdout
    assert "within 1e-6 m to the end, 5 s" in found.stdout
    assert found.stdout.splitlines()[-1].split() == ["verdict", "agree"]
    found = told("compare", files / "c.h5", files / "d.h5")
    assert found.splitlines()[-1].split(maxsplit=1)[1].startswith("differ: ")
    assert " +- " in found


def test_the_command_in_json(files):
    found = json.loads(call("compare", files / "c.h5", files / "d.h5", "--json").stdout)
    assert found["verdict"] == "differ"
    assert "impact rate" in found["statistics_that_differ"]
    assert found["statistics"][0]["a"].keys() == {"mean", "half_width"}
    assert found["differences"][0].keys() == {"key", "a", "b"}
    assert found["tolerance"] == 1e-6


def test_the_tolerance_of_the_command(files):
    found = json.loads(
        call("compare", files / "a.h5", files / "b.h5", "--tolerance", "1e-20", "--json").stdout
    )
    assert found["tolerance"] == 1e-20
    assert found["verdict"] == "agree_until"
    assert call("compare", files / "a.h5", files / "b.h5", "--tolerance", "-1").exit_code == 2


def test_file_trouble(files, tmp_path):
    (tmp_path / "no.h5").write_text("no HDF5")
    for other in ("missing.h5", "no.h5"):
        found = call("compare", files / "a.h5", tmp_path / other)
        assert (found.exit_code, found.stdout) == (6, "")
        assert other in found.stderr


@pytest.mark.parametrize("size", [1e200, 1e308])
def test_means_that_are_no_numbers_do_not_agree(size):
    """Of displacements so large the squares overflow, and the interval of their mean is not a number."""
    one, other = short_run("II-B", "20 s"), vibsim.simulate(short_case("II-B", "20 s"))
    other["x1"][:] = size
    assert compare(one, other, TOLERANCE).verdict == "differ"
