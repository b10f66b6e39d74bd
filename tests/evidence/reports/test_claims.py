"""Verdicts follow from the table of numbers, and turn when a number is wrong."""

import pytest

from tests.evidence.reports.made import (
    CAPTURED,
    ESCAPED,
    PASSED,
    capture,
    drift,
    held,
    motion,
    nearby,
    numbers,
    outcome,
    regime,
)
from vibsim.evidence.reports.claims import (
    EXAMPLE,
    FAILS,
    HOLDS,
    IN_KIND,
    ONLY_IF,
    OPEN,
    OUR_MARGIN,
    OURS,
    PAPERS,
    ClaimVerdict,
    is_brief_hold,
    is_held_for_100,
    is_released_at_100,
)
from vibsim.evidence.reports.paper_document import judge_claims, paper_claims, trust_of

EXPECTED = {
    "no-impacts": (HOLDS,),
    "natural-frequency": (HOLDS,),
    "amplitude": (FAILS,),
    "voltage": (FAILS,),
    "chaotic": (HOLDS, HOLDS),
    "three-regimes": (FAILS, FAILS),
    "more-regular": (FAILS, ONLY_IF),
    "period-1-ideal": (HOLDS, HOLDS),
    "period-1-motor": (HOLDS, FAILS),
    "impacts": (HOLDS, HOLDS),
    "impacts-of-motor": (HOLDS, HOLDS),
    "impacts-differ": (ONLY_IF, ONLY_IF),
    "non-ideal-larger": (ONLY_IF, ONLY_IF),
    "drift-grows": (HOLDS, HOLDS),
    "impacts-cause": (HOLDS, HOLDS),
    "rates-higher": (HOLDS, ONLY_IF),
    "motor-drift-grows": (FAILS, HOLDS),
    "drift-B-above-C": (HOLDS, FAILS),
    "equilibria": (HOLDS, HOLDS),
    "one-speed": (HOLDS, HOLDS),
    "power": (HOLDS,),
    "II-A-speed": (HOLDS, HOLDS),
    "sommerfeld": (EXAMPLE, HOLDS),
    "II-B-captured": (EXAMPLE, EXAMPLE),
    "capture-frequency": (FAILS, FAILS),
    "II-C-escapes": (EXAMPLE, EXAMPLE),
    "II-C-speed": (HOLDS, FAILS),
    "II-C-displacement": (IN_KIND, EXAMPLE),
}

RISING = {**ESCAPED, "peak": {"time": 170.0, "height": 0.08, "end": 0.079}}
SINGLE = motion(3e-4, single=True)
LATE = {**outcome("passed", 90.0, 100.0, 3.69, 6.2, peak=170.0)}

# claim, where in the table, what is planted there, and the verdict that must come of it
PLANTED = [
    ("no-impacts", ("without_stop", "II-B", "regime"), regime("chaotic", None), (FAILS,)),
    ("no-impacts", ("without_stop", "II-B", "impacts"), 3, (FAILS,)),
    ("natural-frequency", ("facts", "free_hz_II"), 4.334, (ONLY_IF,)),
    ("natural-frequency", ("facts",), {"held_hz": 4.3, "free_hz_II": 4.0}, (FAILS,)),
    ("amplitude", ("facts", "amplitudes"), "equal", (HOLDS,)),
    ("chaotic", ("nearby", 1, "regime"), "periodic", (HOLDS, HOLDS)),
    ("three-regimes", ("runs", "I-B", "regime"), regime("chaotic", None), (FAILS, FAILS)),
    ("more-regular", ("ensembles", "I-B", "outcomes"), 4 * [motion(period=2)], (FAILS, ONLY_IF)),
    ("more-regular", ("ensembles", "I-C", "outcomes"), 4 * [motion(period=2)], (FAILS, FAILS)),
    ("period-1-ideal", ("long_runs", "I-C", "regime"), regime("periodic", 2, 3000.0), (FAILS, HOLDS)),
    ("period-1-ideal", ("long_runs", "I-C", "regime"), regime("undecided", None, 3000.0), (OPEN, HOLDS)),
    ("period-1-ideal", ("ensembles", "I-C", "outcomes"), [motion(), SINGLE], (HOLDS, FAILS)),
    ("period-1-motor", ("ensembles", "II-C", "outcomes"), 4 * [SINGLE] + [motion()], (HOLDS, HOLDS)),
    ("impacts", ("runs", "I-C", "cycles", "verdict"), "some cycles", (FAILS, HOLDS)),
    ("impacts", ("runs", "I-C", "cycles", "verdict"), "undecided", (OPEN, HOLDS)),
    ("impacts", ("runs", "I-B", "impacts"), 600, (FAILS, HOLDS)),
    ("impacts-of-motor", ("runs", "II-C", "impacts"), 1500, (FAILS, HOLDS)),
    ("impacts-of-motor", ("ensembles", "II-C", "outcomes"), [motion(impacts=3000)], (HOLDS, FAILS)),
    ("impacts-differ", ("ensembles", "II-A", "outcomes"), [motion(8e-5, 700)], (ONLY_IF, FAILS)),
    ("non-ideal-larger", ("runs", "II-B", "steady", "v2"), 1e-9, (FAILS, ONLY_IF)),
    ("non-ideal-larger", ("ensembles", "II-B", "outcomes"), [motion(vibration=1e-9)], (ONLY_IF, FAILS)),
    ("drift-grows", ("runs", "I-B", "overall"), -1e-5, (ONLY_IF, HOLDS)),
    ("drift-grows", ("runs", "I-A", "overall"), 1e-3, (ONLY_IF, HOLDS)),
    ("impacts-cause", ("without_stop", "I-B", "overall"), 3e-5, (FAILS, HOLDS)),
    ("impacts-cause", ("without_stop", "I-B", "drift"), drift(1e-3), (FAILS, HOLDS)),
    ("rates-higher", ("ensembles", "II-A", "outcomes"), [motion(1e-6)], (HOLDS, FAILS)),
    ("motor-drift-grows", ("ensembles", "II-A", "outcomes"), [motion(3e-4)], (FAILS, FAILS)),
    ("drift-B-above-C", ("ensembles", "II-B", "outcomes"), [motion(2e-3), {"failed": "why"}], (HOLDS, HOLDS)),
    ("drift-B-above-C", ("ensembles", "II-B-captured", "outcomes"), [motion(2e-3)], (HOLDS, EXAMPLE)),
    ("equilibria", ("runs", "II-C", "capture", "final_speed_hz"), 5.45, (FAILS, HOLDS)),
    ("equilibria", ("ensembles", "II-C", "outcomes"), [outcome("undecided")], (HOLDS, FAILS)),
    ("II-A-speed", ("runs", "II-A", "capture"), capture(final=3.3, no_load=3.5), (FAILS, HOLDS)),
    ("sommerfeld", ("runs", "II-C"), {"capture": capture(None, 9.0, 20.0, 3.7), "held": held(3.7)},
     (HOLDS, HOLDS)),
    ("sommerfeld", ("ensembles", "II-C-escape", "outcomes"), [PASSED], (EXAMPLE, HOLDS)),
    ("II-B-captured", ("runs", "II-B-captured", "capture"), capture(), (FAILS, EXAMPLE)),
    ("II-B-captured", ("ensembles", "II-B-captured", "outcomes"), [CAPTURED, PASSED], (EXAMPLE, FAILS)),
    ("II-C-escapes", ("runs", "II-C-escape", "capture", "until"), 200.0, (FAILS, EXAMPLE)),
    ("II-C-escapes", ("ensembles", "II-C-escape", "outcomes"), 3 * [{**ESCAPED, "final_hz": 5.9}],
     (EXAMPLE, FAILS)),
    ("II-C-escapes", ("ensembles", "II-C-escape", "outcomes"), [ESCAPED, PASSED], (EXAMPLE, FAILS)),
    ("II-C-speed", ("ensembles", "II-C", "outcomes"), 4 * [outcome(final=6.45)] + [{"failed": "why"}],
     (HOLDS, HOLDS)),
    ("II-C-displacement", ("ensembles", "II-C-escape", "outcomes"), 9 * [PASSED], (IN_KIND, FAILS)),
    ("II-C-displacement", ("ensembles", "II-C-escape", "outcomes"), [RISING], (IN_KIND, FAILS)),
    ("II-C-displacement", ("ensembles", "II-C", "outcomes"), 4 * [LATE] + [PASSED], (IN_KIND, HOLDS)),
    ("voltage", ("facts", "characteristics"),
     [{"no_load_hz": hz, "M0": hz, "slope": 1.0} for hz in (3.5, 5.5)], (HOLDS,)),
    ("one-speed", ("ensembles", "II-B", "outcomes"), [outcome(final=speed) for speed in (4.99, 5.47)],
     (HOLDS, FAILS)),
    ("one-speed", ("runs", "II-B", "capture"), capture("undecided"), (FAILS, HOLDS)),
    ("power", ("ends", "as printed", "half", "amplitude"), 0.049, (FAILS,)),
    ("power", ("ends", "the reading", "half", "speed_hz"), 3.0, (FAILS,)),
    ("chaotic", ("nearby",), [nearby("Table 1", 0.001, 3.8, "periodic", at_rest="chaotic")], (HOLDS, HOLDS)),
    ("II-C-displacement", ("runs", "II-C", "peak"), {"time": 170.0, "height": 0.1, "end": 0.05},
     (HOLDS, EXAMPLE)),
    ("II-C-displacement", ("runs", "II-C", "peak"), {"time": 299.0, "height": 0.1, "end": 0.1},
     (EXAMPLE, EXAMPLE)),
    ("motor-drift-grows", ("runs", "II-C"), {"overall": 3e-3, "drift": drift(3e-3)}, (HOLDS, HOLDS)),
    ("drift-B-above-C", ("runs", "II-C"), {"overall": 3e-3, "drift": drift(3e-3)}, (FAILS, FAILS)),
    ("rates-higher", ("runs", "II-A"), {"overall": 1e-6, "drift": drift(1e-6)}, (ONLY_IF, ONLY_IF)),
    ("period-1-motor", ("runs", "II-C", "cycles", "impact_counts"), {"1": 8, "2": 1}, (FAILS, FAILS)),
    ("impacts-cause", ("without_stop", "I-B", "starts_overall"), 1.0, (HOLDS, FAILS)),
    ("impacts-cause", ("without_stop", "I-B", "starts_drifting"), 3, (HOLDS, FAILS)),
]  # fmt: skip


def findings(table):
    return {claim.key: finding for claim, finding in judge_claims(table)}


def words(finding):
    """Its verdicts without their conditions."""
    return tuple(verdict.word for verdict in finding.verdicts)


def planted(path, value):
    """The table with a value planted at a path; a mapping is laid over the one that is there."""
    table = numbers()
    place = table
    for key in path[:-1]:
        place = place[key]
    if value == "equal":
        for row in place[path[-1]]:
            row["printed"] = row["eq211"]
    elif isinstance(value, dict):
        place[path[-1]].update(value)
    else:
        place[path[-1]] = value
    return table


def test_every_claim_has_its_verdict():
    assert {key: words(finding) for key, finding in findings(numbers()).items()} == EXPECTED


@pytest.mark.parametrize(("key", "path", "value", "verdicts"), PLANTED)
def test_a_wrong_number_turns_the_verdict(key, path, value, verdicts):
    table = planted(path, value)
    assert words(findings(table)[key]) == verdicts


def test_motors_held_at_the_natural_frequency_are_captured_there():
    table = numbers()
    for name in ("II-B", "II-C", "II-B-captured", "II-C-escape"):
        table["runs"][name]["capture"] = capture("captured", 10.0, None, 4.08, 4.08)
        table["runs"][name]["held"] = held(4.08)
    assert findings(table)["capture-frequency"].rest.word == HOLDS


def test_captured_as_printed_needs_no_condition():
    table = planted(("runs", "II-B", "capture"), capture("captured", 11.0, None, 3.69, 3.69))
    table["ensembles"]["II-B"]["outcomes"] = [CAPTURED]
    assert findings(table)["II-B-captured"].verdicts == (ClaimVerdict(HOLDS), ClaimVerdict(HOLDS))


@pytest.mark.parametrize("finding", findings(numbers()).values(), ids=EXPECTED)
def test_what_holds_only_under_a_condition_says_which(finding):
    for verdict in finding.verdicts:
        assert bool(verdict.condition) == (verdict.word in (ONLY_IF, IN_KIND, EXAMPLE))
    assert finding.measured


def test_other_numbers_are_an_example_and_not_the_only_ones():
    """c = 0.03 alone captures II-B from 25 of 25 starts: nothing may say "only if" of the two cases."""
    finding = findings(numbers())["II-B-captured"]
    assert str(finding.rest).startswith("holds, for example, with c = 0.0035 N s/m")
    assert "c = 0.03 N s/m (25 of 25 starts)" in finding.measured[-1]
    verdicts = [str(verdict) for each in findings(numbers()).values() for verdict in each.verdicts]
    assert not any("only if c" in verdict for verdict in verdicts)


def test_gaps_are_among_the_readings_tried():
    lines = " ".join(findings(numbers())["capture-frequency"].measured)
    assert "gaps from 1 to 400 mm, 4 values" in lines
    assert "from 252 mm on, at 4.02 Hz with no impacts in the end" in lines
    assert "the widest that is struck in the end has 200 mm" in lines


def test_the_voltage_is_followed_to_what_the_motor_then_does():
    lines = " ".join(findings(numbers())["voltage"].measured)
    assert "M0 = 7.86 mN m" in lines and "M0 = 9.29 mN m" in lines
    assert "II-B with that M0: captured from 47 of 48 perturbed starts, as printed from 0" in lines


def test_conditions_carry_the_numbers():
    found = findings(numbers())
    assert "J = 0.0085 kg m² (printed: 0.001 kg m²)" in found["II-B-captured"].rest.condition
    assert "II-C captured at 4.02 Hz" in " ".join(found["capture-frequency"].measured)
    assert found["rates-higher"].starts.condition == "the frequency is 3.5 Hz"
    assert found["impacts-differ"].rest.condition == "the frequency is 3.5 Hz"
    assert "22 to 41 times" in found["amplitude"].remark
    assert "within the trust horizon" in found["II-C-escapes"].remark


def test_both_measures_of_drift_are_told():
    """Overall, as the paper says, equal forces drift ever faster; in the second half nothing says so."""
    finding = findings(numbers())["drift-grows"]
    assert "I-A 5.1 mm, I-B 22.8 mm, I-C 87 mm" in finding.measured[0]
    assert "I-C-eq211 750 mm" in finding.measured[1]
    assert "second half no growth" in finding.remark


def test_both_readings_of_100_seconds_are_judged():
    """Let go at 100 s of clock time after a hold of 10 s, or at 200 s after one of 100 s: either will do."""
    assert is_brief_hold(LATE) and is_released_at_100(LATE) and not is_held_for_100(LATE)
    late = {**LATE, "since": 100.0, "until": 200.0}
    assert is_brief_hold(late) and is_held_for_100(late) and not is_released_at_100(late)
    assert not is_brief_hold({**LATE, "since": 10.0, "until": 40.0})
    assert not is_brief_hold(CAPTURED)
    # the speed may still be changing at the end
    assert is_brief_hold({**LATE, "verdict": "undecided"})


def test_missing_regimes_are_placed():
    finding = findings(numbers())["three-regimes"]
    remark = " ".join([*finding.measured, finding.remark])
    assert "chaotic motion: with the amplitude by Table 1 and c = 0.001 N s/m at 3.8 Hz" in remark
    assert "quasi-periodic motion: with the amplitude by Eq. (2.11) and c = 0 N s/m at 6.3 Hz" in remark
    assert "6.3 Hz (followed to 3000 s: 6.3 Hz periodic with period 10)" in remark
    assert "None of those that were followed lasts" in remark
    assert "at 3.8 Hz (followed to 3000 s: 3.8 Hz chaotic)." in remark
    assert "All three strike from rest." in remark


def test_regimes_are_found_where_they_are():
    table = numbers()
    for name, kind in zip(("I-A", "I-B"), ("quasi-periodic", "chaotic"), strict=True):
        table["runs"][name]["regime"] = regime(kind, None)
    assert findings(table)["three-regimes"].rest.word == FAILS  # all of them strike
    table["runs"]["I-A"]["impacts"] = 0
    assert findings(table)["three-regimes"].rest.word == HOLDS


def test_without_chaos_the_claim_of_chaos_fails():
    table = planted(("nearby", 1), nearby("Table 1", 0.001, 3.8, "periodic"))
    table["runs"]["I-B-eq211"]["regime"] = regime("periodic", 3)
    assert words(findings(table)["chaotic"]) == (FAILS, HOLDS)  # most starts of the eq211 cases are
    for name in ("I-B-eq211", "I-C-eq211"):
        table["ensembles"][name]["outcomes"] = [motion()]
    assert words(findings(table)["chaotic"]) == (FAILS, FAILS)


def test_the_explanation_of_the_capture_frequency_needs_its_evidence():
    assert "superharmonic" in findings(numbers())["capture-frequency"].remark
    table = planted(("runs", "II-B", "held"), held(1.5 * 3.69))
    assert findings(table)["capture-frequency"].remark == ""


def test_the_trust_of_a_finding_names_its_runs():
    table = numbers()
    found = findings(table)
    assert trust_of(table, found["amplitude"]).startswith("exact")
    assert trust_of(table, found["impacts"]) == "I-A, I-B, I-C: right over the whole run"
    assert "II-C until 85 s" in trust_of(table, found["II-C-escapes"])
    table["runs"]["II-C"]["trust_horizon"] = None
    assert "II-C: not known" in trust_of(table, found["II-C-escapes"])


def test_claims_have_distinct_keys_and_say_everything():
    claims = paper_claims()
    assert len({claim.key for claim in claims}) == len(claims)
    assert all(claim.statement and claim.quotes and claim.criterion for claim in claims)
    assert {claim.whose for claim in claims} == {PAPERS, OURS, OUR_MARGIN}
