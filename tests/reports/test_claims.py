"""Verdicts follow from the table of numbers, and turn when a number is wrong."""

import pytest

from tests.reports.made import CAPTURED, ESCAPED, PASSED, capture, drift, held, numbers, regime
from vibsim.reports.claim import FAILS, HOLDS, ONLY_IF, OPEN
from vibsim.reports.claims import judge_claims, paper_claims, trust_of

EXPECTED = {
    "natural-frequency": ONLY_IF,
    "amplitude": FAILS,
    "validity": ONLY_IF,
    "drift-grows": ONLY_IF,
    "impacts": HOLDS,
    "period-1": ONLY_IF,
    "non-ideal-larger": ONLY_IF,
    "drift-B-above-C": ONLY_IF,
    "II-A-speed": HOLDS,
    "II-B-captured": ONLY_IF,
    "II-C-escapes": ONLY_IF,
    "capture-frequency": FAILS,
    "II-C-displacement": ONLY_IF,
}

RISING = {**ESCAPED, "peak": {"time": 170.0, "height": 0.08, "end": 0.079}}

# claim, where in the table, what is planted there, and the verdict that must come of it
PLANTED = [
    ("natural-frequency", ("facts", "free_hz_I"), 4.12, HOLDS),
    ("natural-frequency", ("facts",), {"held_hz": 4.3, "free_hz_I": 4.3, "free_hz_II": 4.0}, FAILS),
    ("amplitude", ("facts", "amplitudes"), "equal", HOLDS),
    ("validity", ("runs", "II-A", "rest_distance_needed"), None, OPEN),
    ("drift-grows", ("runs", "I-B", "drift"), drift(-1e-5), FAILS),
    ("drift-grows", ("runs", "I-B", "drift"), drift(-7.6e-5, 3e-4), FAILS),
    ("drift-grows", ("runs", "I-B", "drift"), {"verdict": "undecided", "rate": None}, FAILS),
    ("impacts", ("runs", "I-C", "cycles", "verdict"), "some cycles", FAILS),
    ("impacts", ("runs", "I-C", "cycles", "verdict"), "undecided", OPEN),
    ("period-1", ("runs", "I-C", "regime"), regime("periodic", 1), HOLDS),
    ("period-1", ("long_runs", "I-C", "regime"), regime("periodic", 2, 3000.0), FAILS),
    ("period-1", ("long_runs", "I-C", "regime"), regime("undecided", None, 3000.0), OPEN),
    ("non-ideal-larger", ("runs", "II-B", "steady", "v2"), 1e-9, FAILS),
    ("drift-B-above-C", ("ensembles", "II-B", "outcomes"), [{"drift": 1e-6}, {"failed": "why"}], FAILS),
    ("drift-B-above-C", ("ensembles", "II-C", "outcomes"), [{"drift": 1e-6}], HOLDS),
    ("II-A-speed", ("runs", "II-A", "capture"), capture(final=3.3, no_load=3.5), FAILS),
    ("II-B-captured", ("runs", "II-B-captured", "capture"), capture(), FAILS),
    ("II-B-captured", ("ensembles", "II-B-captured", "outcomes"), [CAPTURED, PASSED], FAILS),
    ("II-C-escapes", ("runs", "II-C-escape", "capture", "until"), 200.0, FAILS),
    ("II-C-escapes", ("ensembles", "II-C-escape", "outcomes"), 3 * [{**ESCAPED, "final_hz": 5.9}], FAILS),
    ("II-C-escapes", ("ensembles", "II-C-escape", "outcomes"), [ESCAPED, PASSED], FAILS),
    ("II-C-displacement", ("ensembles", "II-C-escape", "outcomes"), 9 * [PASSED], FAILS),
    ("II-C-displacement", ("ensembles", "II-C-escape", "outcomes"), [RISING], FAILS),
    ("II-C-displacement", ("ensembles", "II-C", "outcomes"), 4 * [ESCAPED] + [PASSED], HOLDS),
]


def findings(table):
    return {claim.key: finding for claim, finding in judge_claims(table)}


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
    assert {key: finding.verdict for key, finding in findings(numbers()).items()} == EXPECTED


@pytest.mark.parametrize(("key", "path", "value", "verdict"), PLANTED)
def test_a_wrong_number_turns_the_verdict(key, path, value, verdict):
    table = planted(path, value)
    assert EXPECTED[key] != verdict
    assert findings(table)[key].verdict == verdict


def test_motors_held_at_the_natural_frequency_are_captured_there():
    table = numbers()
    for name in ("II-B", "II-C", "II-B-captured", "II-C-escape"):
        table["runs"][name]["capture"] = capture("captured", 10.0, None, 4.08, 4.08)
        table["runs"][name]["held"] = held(4.08)
    assert findings(table)["capture-frequency"].verdict == HOLDS


def test_captured_as_printed_needs_no_condition():
    table = numbers()
    table["runs"]["II-B"]["capture"] = capture("captured", 11.0, None, 3.69, 3.69)
    table["ensembles"]["II-B"]["outcomes"] = [CAPTURED]
    found = findings(table)["II-B-captured"]
    assert (found.verdict, found.condition) == (HOLDS, "")


@pytest.mark.parametrize("finding", findings(numbers()).values(), ids=EXPECTED)
def test_what_holds_only_under_a_condition_says_which(finding):
    assert bool(finding.condition) == (finding.verdict == ONLY_IF)
    assert finding.measured


def test_conditions_carry_the_numbers():
    found = findings(numbers())
    assert "m3 is 0.062 kg (printed: 0.03 kg)" in found["II-B-captured"].condition
    assert "c = 0.03" in found["II-B-captured"].condition
    assert "70.3 mm" in found["validity"].condition
    assert "22 to 41 times" in found["amplitude"].remark
    assert "within the trust horizon" in found["II-C-escapes"].remark


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
    assert all(claim.statement and claim.where and claim.criterion for claim in claims)
