"""Overrides and with_values: checked as if the file said so, under full and short keys."""

from pathlib import Path

import pytest

from vibsim.cases import Case, CaseError, UnknownKeyError, load_case

HAMMER = Path(__file__).parent / "parts/valid/hammer.yaml"
CLOSED_FORM = (
    "run.method: a motor has no closed form; with one, run.method must be auto or taylor, got closed_form"
)


def problems_of(overrides, source="II-B"):
    with pytest.raises(CaseError) as caught:
        load_case(source, overrides)
    lines = [str(problem) for problem in caught.value.problems]
    with pytest.raises(CaseError) as caught:
        load_case(source).with_values(overrides)
    assert [str(problem) for problem in caught.value.problems] == lines
    return lines


@pytest.mark.parametrize(
    ("overrides", "key", "number"),
    [({"excitation.Omega0": "390 rpm"}, "excitation.Omega0", 40.840704496667314),
     ({"Omega0": "6.5 Hz"}, "excitation.Omega0", 40.840704496667314), ({" c ": 0.03}, "coupling.c", 0.03),
     ({"c": 1e-7}, "coupling.c", 1e-7), ({"m1": 1}, "blocks.m1", 1.0),
     ({"m3": "0.04 kg"}, "excitation.m3", 0.04), ({"G": "-1 mm"}, "stop.G", -0.001),
     ({"t_end": "20s"}, "run.t_end", 20.0), ({"stop": "none"}, "coupling.k1", 200.0),
     ({"rest_distance.value": "80 mm"}, "rest_distance.value", 0.08),
     ({"value": "80 mm"}, "rest_distance.value", 0.08),
     ({"excitation.kind": "harmonic", "A": "1 N", "omega": "2 rad/s"}, "omega", 2.0)],
)  # fmt: skip
def test_override_sets_the_value(overrides, key, number):
    case = load_case("II-B", overrides)
    assert case.number(key) == number
    assert load_case("II-B").with_values(overrides).two_blocks() == case.two_blocks()
    assert case.text == load_case("II-B").text


def test_short_keys_mean_what_the_case_has():
    """m3 is the motor's in II-B and the rule's in I-A-eq211; I-A has none, so it stays unclear there."""
    assert load_case("II-B", {"m3": "1 kg"}).number("excitation.m3") == 1.0
    assert load_case("I-A-eq211", {"m3": "1 kg"}).number("excitation.A.m3") == 1.0
    [line] = problems_of({"m3": "1 kg"}, "I-A")
    assert line == "overrides m3: is short for several keys: excitation.m3, excitation.A.m3"


@pytest.mark.parametrize(
    ("source", "like", "hints"),
    [
        ("II-B", "excitation.Omega0", {
            "excitation.Omgea0": " (did you mean excitation.Omega0?)",
            "omega0": " (did you mean excitation.Omega0?)",
            "friction.nu": " (did you mean friction.mu?)",
        }),
        (HAMMER, "stops.wall.k", {
            "stops.anvli.k": " (did you mean stops.anvil.k?)",
            "anvil.kk": " (did you mean stops.anvil.k?)",
            "anvil.g": " (did you mean stops.anvil.gap?)",
            "anvil.x": "; stops.anvil takes between, gap, acts, law, k, c, release, e, force",
            "excitation.omega": " (did you mean forces.drive.omega?)",
            "forces.chord.terms.3.A": " (did you mean forces.chord.terms.2.A?)",
        }),
    ],
)  # fmt: skip
def test_unknown_keys_are_told_with_a_hint(source, like, hints):
    for key, hint in hints.items():
        told = f"overrides {key}: unknown key{hint}; a key is written like {like} or run.t_end"
        assert problems_of({key: "1 Hz"}, source) == [told]


@pytest.mark.parametrize(
    ("overrides", "told"),
    [
        ({"excitation.Omega0": "-5.5 Hz"}, "excitation.Omega0: must be > 0, got -5.5 Hz"),
        ({"Omega0": 6.5}, "excitation.Omega0: needs a unit (Hz, rpm, rev/s, deg/s, rad/s), got 6.5"),
        ({"c": float("nan")}, "coupling.c: must be finite, got nan"),
        ({"c": None}, "coupling.c: must be a damping in N s/m, N s/mm, kN s/m or kg/s, got None"),
        ({"c": ""}, "coupling.c: must be a damping in N s/m, N s/mm, kN s/m or kg/s, got nothing"),
        ({"stop": "off"}, "stop: must be a mapping of k2, G, acts, or none; got off"),
        ({"extends": "I-A"}, "extends: works in a case file only"),
        ({"m2": "fixed"}, "blocks.m2: block 2 is fixed and cannot slide; leave friction out, or write none"),
        ({"run.method": "closed_form"}, CLOSED_FORM),
        ({"every": "1e-9 s"}, "run.every: 300 s every 1e-9 s makes 3e+11 samples; at most 1e10 are allowed"),
        ({"kind": "none", "phi": "1 rad"},
         "initial.phi: there is no motor, so initial.phi must be left out, got 1 rad"),
    ],
)  # fmt: skip
def test_problems_of_overrides(overrides, told):
    assert problems_of(overrides) == [f"overrides {told}"]


@pytest.mark.parametrize(
    ("overrides", "lines"),
    [
        (
            {"title": "a\0b", "c": "\udcff"},
            [
                "overrides title: holds \\x00, which no file can",
                "overrides coupling.c: holds \\udcff, which no file can",
            ],
        ),
        (
            {"m1": "0 kg", "m2": "0 kg"},
            ["overrides blocks.m1: must be > 0, got 0 kg", "overrides blocks.m2: must be > 0, got 0 kg"],
        ),
    ],
)
def test_every_problem_of_overrides_is_told(overrides, lines):
    assert problems_of(overrides) == lines


@pytest.mark.parametrize(
    ("overrides", "told"),
    [
        ({"stops.anvil.k": "0 N/m"}, "stops.anvil.k: must be > 0, got 0 N/m"),
        ({"mu": "0.3"}, "mu: is short for several keys: friction.guide.mu, friction.weight.mu, "
                        "friction.moon.plus.mu, friction.moon.minus.mu, friction.smooth.mu"),
        ({"links.spring.between": "[ram, tol]"},
         "links.spring.between: no body tol (did you mean tool?); allowed: ram, tool, ground, base"),
        ({"stops.anvil": "off"}, "stops.anvil: must be a mapping of between, gap, acts, law, k, c, release, "
                                 "e, force, or none; got off"),
        ({"stops.anvil.e": "0.5"}, "stops.anvil.e: belongs to law: rigid; this stop has law: elastic"),
        ({"run.method": "closed_form"}, CLOSED_FORM),
    ],
)  # fmt: skip
def test_problems_of_overrides_of_parts(overrides, told):
    assert problems_of(overrides, HAMMER) == [f"overrides {told}"]


def test_an_override_hides_a_mistake_of_the_file(tmp_path):
    """And what both have of them is told together."""
    path = tmp_path / "trial.yaml"
    path.write_text("blocks: {m1: heavy, m2: 1 kg}\ncoupling: {k1: 1 N/m}\n")
    assert load_case(path, {"m1": "1 kg"}).number("m1") == 1.0
    with pytest.raises(CaseError) as caught:
        load_case(path, {"c": "-1", "nothing": "1"})
    assert [(problem.file, problem.key) for problem in caught.value.problems] == [
        (str(path), "blocks.m1"),
        ("overrides", "nothing"),
        ("overrides", "coupling.c"),
    ]


def test_the_amplitude_by_rule_follows_omega():
    case = load_case("I-A-eq211")
    faster = case.with_values({"omega": "7 Hz"})
    assert pytest.approx(4 * case.two_blocks().A, rel=1e-15) == faster.two_blocks().A
    assert faster.number("excitation.A") == faster.two_blocks().A


def test_with_values_leaves_the_case_alone():
    case = load_case("II-B")
    before = case.two_blocks(), case.resolved_json(), dict(case.values)
    case.with_values({"c": "0.03 N s/m", "stop": "none"})
    assert (case.two_blocks(), case.resolved_json(), dict(case.values)) == before


def test_a_reloaded_case_takes_the_same_overrides():
    case = load_case("II-B")
    again = Case.from_resolved_json(case.resolved_json())
    changes = {"m2": "fixed", "friction": "none", "excitation.kind": "none"}
    assert again.with_values(changes).two_blocks() == case.with_values(changes).two_blocks()


def test_number_and_numeric_keys():
    case = load_case("I-A")
    assert case.numeric_keys() == [
        "blocks.m1", "blocks.m2", "coupling.k1", "coupling.c",
        "stop.k2", "stop.G", "friction.mu", "friction.g",
        "excitation.A", "excitation.omega", "excitation.F0",
        "initial.x1", "initial.v1", "initial.x2", "initial.v2",
        "run.t_end", "run.every", "run.tol", "run.trust_tolerance",
    ]  # fmt: skip
    assert all(isinstance(case.number(key), float) for key in case.numeric_keys())
    assert str(case.frequency()) == "3.5 Hz"
    assert load_case("II-B", {"excitation": "none"}).frequency() is None
    for key, message in [
        ("Omega0", "Omega0 is no number of case I-A; its numbers are blocks.m1, "),
        ("nothing", "unknown key"),
        ("run.method", "run.method is no number"),
    ]:
        with pytest.raises(UnknownKeyError) as caught:
            case.number(key)
        assert str(caught.value).startswith(message)


def test_an_empty_name_is_no_name():
    with pytest.raises(CaseError, match=r"overrides name: may hold letters, digits"):
        load_case("II-B", {"name": ""})


def test_a_very_long_run_is_told_by_its_samples():
    with pytest.raises(
        CaseError, match=r"overrides run.t_end: 1e15 s every 5 ms makes 2e\+17 samples; at most 1e10"
    ):
        load_case("II-B", {"run.t_end": "1e15s"})


@pytest.mark.parametrize(
    ("overrides", "told"),
    [
        ({"run": "5", "run.t_end": "1 s"}, "run.t_end: is part of run"),  # took the rest of run away
        ({"k2": "5 N/m", "stop": "none"}, "stop.k2: is part of stop"),  # was lost
    ],
)
def test_a_section_and_what_is_in_it_are_not_both_given(overrides, told):
    assert [line for line in problems_of(overrides) if f"{told}, which is given too; choose one" in line]
