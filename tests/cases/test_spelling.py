"""What a misspelt word most likely stands for, and what it does not."""

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.docs.pages import ROOT
from vibsim.cases import CaseError, load_case
from vibsim.cases.case import load_case_text
from vibsim.cases.problems import BY_FORMULAS, FORMULAS_PAGE, LIMITS, LIMITS_PAGE, TOLD, nearest, slips
from vibsim.cases.quantities import UNITS
from vibsim.cases.schema_keys import LONG, SHORT, all_keys
from vibsim.cases.sources import shipped_case_names
from vibsim.command_line.main import COMMANDS

WORDS = st.text("abc-", max_size=6)


@pytest.mark.parametrize(
    ("typed", "meant"),
    [("rnu", "run"), ("INFO", "info"), ("analyze", "analyse"), ("comapre", "compare"),
     ("sweeep", "sweep"), ("anal", "analyse"), ("benchmark", "bench"), ("nosuch", None),
     ("completion", None), ("help", None), ("c", None), ("", None)],
)  # fmt: skip
def test_commands(typed, meant):
    assert nearest(typed, COMMANDS) == meant


@pytest.mark.parametrize(
    ("typed", "meant"), [("IIB", "II-B"), ("ii-b", "II-B"), ("II_C", "II-C"), ("X", None)]
)
def test_cases(typed, meant):
    assert nearest(typed, shipped_case_names()) == meant


@pytest.mark.parametrize(
    ("typed", "meant"), [("herz", "Hz"), ("mm^2", "mm"), ("rad/sec", "rad/s"), ("qq", None)]
)
def test_units(typed, meant):
    assert nearest(typed, filter(None, UNITS)) == meant


FOREIGN = """
bodies: {tip: 1 kg}
links: {beam: {between: [tip, base], stiffness: 1 N/m}}
base: {amplitude: 1 mm, omega: 1 Hz}
springs: {}
run: {t_end: 1 s, dt: 1 ms}
"""


def test_words_of_other_programs_lead_to_the_keys():
    with pytest.raises(CaseError) as raised:
        load_case_text(FOREIGN)
    for word, key in {
        "links.beam.stiffness": "k",
        "base.amplitude": "a",
        "springs": "links",
        "run.dt": "every",
    }.items():
        assert f"{word}: unknown key (did you mean {key}?)" in str(raised.value)


@pytest.mark.parametrize(
    ("a", "b", "distance"),
    [("", "abc", 3), ("kitten", "sitting", 3), ("ab", "ba", 1), ("ca", "abc", 3), ("run", "run", 0)],
)
def test_published_distances(a, b, distance):
    assert slips(a, b) == distance


@given(WORDS, WORDS, st.sampled_from("abc-"))
def test_the_distance_is_symmetric_and_a_letter_costs_one(a, b, letter):
    assert slips(a, b) == slips(b, a)
    assert slips(a, a + letter) == 1
    assert abs(len(a) - len(b)) <= slips(a, b) <= max(len(a), len(b))


UNSUPPORTED = [word for limit in (*LIMITS, *BY_FORMULAS) for word in limit.words]


@pytest.mark.parametrize("word", UNSUPPORTED)
def test_what_is_not_supported_is_said_in_place_of_a_typo(word):
    """As a key of a part, of a file and of an override, in both forms of case."""
    what, sentence = next(
        (what, f"{limit.instead} ({page})")
        for limits, what, page in TOLD
        for limit in limits
        if word in limit.words
    )
    for text, place in (
        (
            f"bodies: {{a: 1 kg}}\nlinks: {{s: {{between: [a, ground], k: 1 N/m, {word}: 1}}}}",
            f"links.s.{word}",
        ),
        (f"bodies: {{a: 1 kg}}\n{word}: 1", word),
        (f"blocks: {{m1: 1 kg, m2: 2 kg}}\ncoupling: {{k1: 1 N/m, {word}: 1}}", f"coupling.{word}"),
    ):
        with pytest.raises(CaseError) as raised:
            load_case_text(text)
        assert f"{place}: {what}: {sentence}" in str(raised.value)
    with pytest.raises(CaseError, match=rf"{what}: .* \(docs/(?:scenes|limits).md, ") as raised:
        load_case("II-B", {f"excitation.{word}": "1"})
    assert "did you mean" not in str(raised.value)


def test_limits_are_on_their_page_and_no_keys():
    for limits, place in ((LIMITS, LIMITS_PAGE), (BY_FORMULAS, FORMULAS_PAGE)):
        page, title = place.split(", ")
        text = (ROOT / page).read_text(encoding="utf-8")
        section = text.partition(f"## {title}\n")[2].partition("\n## ")[0]
        assert {word for limit in limits for word in limit.words} <= set(re.findall(r"`(\w+)`", section))
        for limit in limits:
            assert limit.instead in section.replace("`", "")
    keys = {part for form in (SHORT, LONG) for key in all_keys(form) for part in key.split(".")}
    assert not keys & set(UNSUPPORTED)
