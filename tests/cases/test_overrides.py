"""Overrides and with_values: checked as if the file said so, under full and short keys."""

from pathlib import Path

import pytest

from vibsim.cases import Case, CaseError, UnknownKeyError, load_case


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
    ("overrides", "lines"),
    [
        ({"excitation.Omega0": "-5.5 Hz"}, ["overrides excitation.Omega0: must be > 0, got -5.5 Hz"]),
        (
            {"Omega0": 6.5},
            ["overrides excitation.Omega0: needs a unit (Hz, rpm, rev/s, deg/s, rad/s), got 6.5"],
        ),
        ({"c": float("nan")}, ["overrides coupling.c: must be finite, got nan"]),
        ({"c": None}, ["overrides coupling.c: must be a damping in N s/m, N s/mm, kN s/m or kg/s, got None"]),
        (
            {"c": ""},
            ["overrides coupling.c: must be a damping in N s/m, N s/mm, kN s/m or kg/s, got nothing"],
        ),
        (
            {"excitation.Omgea0": "1 Hz"},
            ["overrides excitation.Omgea0: unknown key (did you mean excitation.Omega0?); "
             "a key is written like excitation.Omega0 or run.t_end"],
        ),
        (
            {"omega0": "1 Hz"},
            ["overrides omega0: unknown key (did you mean excitation.Omega0?); "
             "a key is written like excitation.Omega0 or run.t_end"],
        ),
        (
            {"friction.nu": "1"},
            ["overrides friction.nu: unknown key (did you mean friction.mu?); "
             "a key is written like excitation.Omega0 or run.t_end"],
        ),
        ({"stop": "off"}, ["overrides stop: must be a mapping of k2, G, acts, or none; got off"]),
        ({"extends": "I-A"}, ["overrides extends: works in a case file only"]),
        (
            {"m2": "fixed"},
            ["overrides blocks.m2: block 2 is fixed and cannot slide; leave friction out, or write none"],
        ),
        (
            {"run.method": "closed_form"},
            ["overrides run.method: a motor has no closed form; with one, run.method must be auto or taylor, "
             "got closed_form"],
        ),
        (
            {"every": "1e-9 s"},
            ["overrides run.every: 300 s every 1e-9 s makes 3e+11 samples; at most 1e10 are allowed"],
        ),
        (
            {"kind": "none", "phi": "1 rad"},
            ["overrides initial.phi: there is no motor, so initial.phi must be left out, got 1 rad"],
        ),
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
)  # fmt: skip
def test_problems_of_overrides(overrides, lines):
    assert problems_of(overrides) == lines


@pytest.mark.parametrize(
    ("overrides", "lines"),
    [
        ({"stops.anvil.k": "0 N/m"}, ["overrides stops.anvil.k: must be > 0, got 0 N/m"]),
        (
            {"stops.anvli.k": "1 N/m"},
            ["overrides stops.anvli.k: unknown key (did you mean stops.anvil.k?); "
             "a key is written like stops.wall.k or run.t_end"],
        ),
        (
            {"anvil.kk": "1 N/m"},
            ["overrides anvil.kk: unknown key (did you mean stops.anvil.k?); "
             "a key is written like stops.wall.k or run.t_end"],
        ),
        (
            {"anvil.g": "1 mm"},
            ["overrides anvil.g: unknown key (did you mean stops.anvil.gap?); "
             "a key is written like stops.wall.k or run.t_end"],
        ),
        (
            {"anvil.x": "1 mm"},
            ["overrides anvil.x: unknown key; stops.anvil takes between, gap, acts, law, k, c, release, e, "
             "force; a key is written like stops.wall.k or run.t_end"],
        ),
        (
            {"excitation.omega": "1 Hz"},
            ["overrides excitation.omega: unknown key (did you mean forces.drive.omega?); "
             "a key is written like stops.wall.k or run.t_end"],
        ),
        (
            {"forces.chord.terms.3.A": "1 N"},
            ["overrides forces.chord.terms.3.A: unknown key (did you mean forces.chord.terms.2.A?); "
             "a key is written like stops.wall.k or run.t_end"],
        ),
        (
            {"mu": "0.3"},
            ["overrides mu: is short for several keys: friction.guide.mu, friction.weight.mu, "
             "friction.moon.plus.mu, friction.moon.minus.mu, friction.smooth.mu"],
        ),
        (
            {"links.spring.between": "[ram, tol]"},
            ["overrides links.spring.between: no body tol (did you mean tool?); "
             "allowed: ram, tool, ground, base"],
        ),
        ({"stops.anvil": "off"}, ["overrides stops.anvil: must be a mapping of between, gap, acts, law, "
                                  "k, c, release, e, force, or none; got off"]),
        ({"stops.anvil.e": "0.5"}, ["overrides stops.anvil.e: belongs to law: rigid; "
                                    "this stop has law: elastic"]),
        ({"run.method": "closed_form"}, ["overrides run.method: a motor has no closed form; with one, "
                                         "run.method must be auto or taylor, got closed_form"]),
    ],
)  # fmt: skip
def test_problems_of_overrides_of_parts(overrides, lines):
    assert problems_of(overrides, Path(__file__).parent / "parts/valid/hammer.yaml") == lines


def test_an_override_hides_a_mistake_of_the_file(tmp_path):
    path = tmp_path / "trial.yaml"
    path.write_text("blocks: {m1: heavy, m2: 1 kg}\ncoupling: {k1: 1 N/m}\n")
    assert load_case(path, {"m1": "1 kg"}).number("m1") == 1.0


def test_problems_of_file_and_overrides_come_together(tmp_path):
    path = tmp_path / "trial.yaml"
    path.write_text("blocks: {m1: heavy, m2: 1 kg}\ncoupling: {k1: 1 N/m}\n")
    with pytest.raises(CaseError) as caught:
        load_case(path, {"c": "-1", "nothing": "1"})
    assert [(problem.file, problem.key) for problem in caught.value.problems] == [
        (str(path), "blocks.m1"),
        ("overrides", "nothing"),
        ("overrides", "coupling.c"),
    ]


def test_the_amplitude_by_rule_follows_omega():
    case = load_case("I-A-eq211")
    assert (
        pytest.approx(4 * case.two_blocks().A, rel=1e-15)
        == case.with_values({"omega": "7 Hz"}).two_blocks().A
    )
    assert (
        case.with_values({"omega": "7 Hz"}).number("excitation.A")
        == case.with_values({"omega": "7 Hz"}).two_blocks().A
    )


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
