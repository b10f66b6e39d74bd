"""What is shipped covers every validation case and every hard topic, by both flows where both exist."""

from pathlib import Path

import pytest

from vibsim.cases import hard_case_names, load_case
from vibsim.evidence.verification.catalogue import UnknownCheckError, all_checks, selected, spellings
from vibsim.evidence.verification.checks import flows_of
from vibsim.evidence.verification.hard_cases import REPORTED

NAMES = [check.name for check in all_checks()]

# each topic that is hard for its numerics -> the case that shows it, and what in it shows it
TOPICS = {
    "k2 = 1e9 N/m": ("stiff-stop", lambda s: s.k2 == 1e9),
    "k2 = 1e9 N/m with a motor": ("stiff-stop-motor", lambda s: s.k2 == 1e9 and s.has_motor),
    "c critical": ("critical-damping", lambda s: s.c**2 == 4 * s.k1 * s.m1 * s.m2 / (s.m1 + s.m2)),
    "c 1e-12 below": ("just-below-critical-damping", lambda s: abs(s.c / 20 - 1 + 1e-12) < 1e-15),
    "c 1e-12 above": ("just-above-critical-damping", lambda s: abs(s.c / 20 - 1 - 1e-12) < 1e-15),
    "c far above": ("overdamped", lambda s: s.c / (2 * (s.k1 / 2) ** 0.5) > 0.99e5),
    "k1 = 0": ("no-coupling-spring", lambda s: s.k1 == 0),
    "k1 -> 0": ("vanishing-coupling-spring", lambda s: 0 < s.k1 <= 1e-12),
    "c = 0 at resonance": ("undamped-resonance", lambda s: s.c == 0 and s.omega**2 == s.k1 * 2 / s.m1),
    "1e-3 Hz": ("slow-source", lambda s: s.cycles == 1e-3),
    "1e3 Hz": ("fast-source", lambda s: s.cycles == 1e3),
    "mass ratio 1e-6": ("light-block-1", lambda s: s.m1 / s.m2 == 1e-6),
    "mass ratio 1e6": ("heavy-block-1", lambda s: s.m1 / s.m2 == 1e6),
    "sticks most of the time": ("mostly-stuck", lambda s: s.has_friction),
    "released at the peak": ("release-at-the-peak", lambda s: s.k1 * s.v1 * (s.m1 / s.k1) ** 0.5 == s.N),
    "released beside the peak": ("release-beside-the-peak", lambda s: s.v1 == 0.1000000001),
    "contact lost while sticking": ("contact-lost-while-stuck", lambda s: s.has_stop and s.has_friction),
    "contact lost as it sticks": ("contact-lost-as-it-sticks", lambda s: s.has_stop and s.has_friction),
    "preloaded": ("preloaded-stop", lambda s: s.G < 0),
    "chatter": ("chatter", lambda s: abs(s.F0) < s.N),
    "J = 1e-6": ("light-rotor", lambda s: s.J == 1e-6),
    "captured": ("separatrix-capture", lambda s: s.has_motor),
    "passed": ("separatrix-passage", lambda s: s.has_motor),
    "1e6 s with impacts": ("a-million-seconds", lambda s: s.t_end == 1e6 and s.has_stop),
    "1e6 s": ("a-million-seconds-linear", lambda s: s.t_end == 1e6),
    "subnormal": ("tiny-amplitude", lambda s: s.x1 == 1e-307),
    "1e5 cycles": ("conservative", lambda s: s.c == 0 and not s.has_friction and s.source == "none"),
}


@pytest.mark.parametrize("number", range(1, 33))
def test_every_validation_case_is_checked(number):
    assert any(name.startswith(f"V{number}/") for name in NAMES)


@pytest.mark.parametrize("topic", TOPICS)
def test_every_hard_topic_is_checked(topic):
    name, shows = TOPICS[topic]
    case = load_case(f"hard/{name}")
    assert shows(case.two_blocks())
    assert [f"hard/{name}/{flow}" for flow in flows_of(case)] == [
        n for n in NAMES if n.startswith(f"hard/{name}/")
    ]


def test_every_hard_case_stands_for_a_topic():
    assert set(hard_case_names()) == {f"hard/{name}" for name, _ in TOPICS.values()} | set(REPORTED)


@pytest.mark.parametrize("name", REPORTED)
def test_what_others_report_is_checked_by_both_methods_and_told_in_the_docs(name):
    assert [n for n in NAMES if n.startswith(f"{name}/")] == [f"{name}/auto", f"{name}/taylor"]
    told = Path(__file__).parents[3] / "docs/what-others-do.md"
    assert name in told.read_text(encoding="utf-8")


@pytest.mark.parametrize("name", hard_case_names())
def test_every_hard_case_says_what_makes_it_hard(name):
    case = load_case(name)
    assert case.name == name.removeprefix("hard/")
    assert case.title
    header = case.text.partition("\nname:")[0]
    assert "Hard" in header and all(line.startswith("#") or not line for line in header.splitlines())
    assert Path(case.source).parent.name == "hard"


def test_names_are_unique():
    assert len(set(NAMES)) == len(NAMES)


@pytest.mark.parametrize(
    ("asked", "first", "count"),
    [
        (["V1/I-A"], "V1/I-A/closed_form", 2),
        (["v3"], "V3/closed_form", 2),
        (["V1"], "V1/I-A/closed_form", 16),
        (["V9", "V2/taylor"], "V2/taylor", 2),
        (["hard/stiff"], "hard/stiff-stop/closed_form", 3),
        (["hard/stiff-stop"], "hard/stiff-stop/closed_form", 2),
        (["hard/"], None, 60),
        ([], "V1/I-A/closed_form", len(NAMES)),
    ],
)
def test_selection(asked, first, count):
    found = [check.name for check in selected(all_checks(), asked)]
    assert len(found) == count
    assert first is None or found[0] == first


@pytest.mark.parametrize(
    ("name", "hint"),
    [("V99", "did you mean V9?"), ("hard/stif-stop", "did you mean hard/stiff-stop?"), ("", "see --list")],
)
def test_an_unknown_check_gets_a_hint(name, hint):
    with pytest.raises(UnknownCheckError) as error:
        selected(all_checks(), [name])
    assert hint in str(error.value)


def test_spellings_name_groups_too():
    assert {"V1", "V1/I-A", "V1/I-A/taylor", "hard", "hard/chatter"} <= set(spellings(all_checks()))
