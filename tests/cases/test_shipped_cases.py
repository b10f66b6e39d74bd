"""The shipped cases against the numbers of the paper, typed here from it: Table 1 and Eq. (2.11)."""

import re
import shlex
from fractions import Fraction
from pathlib import Path

import mpmath
import pytest

from tests.command_line.made import told
from vibsim.cases import CaseError, hard_case_names, load_case, shipped_case_names

COMMON = {
    "m1": 0.297, "m2": 2.94, "k1": 200.0, "c": 0.001, "k2": 12400.0, "G": 0.001, "stop_sign": 1,
    "x1": 0.0, "v1": 0.0, "x2": 0.0, "v2": 0.0, "rest_distance": None,
    "t_end": 300.0, "every_num": 1, "every_den": 200, "method": "auto", "order": 20, "tol": 2.0**-53,
}  # fmt: skip
MOTOR = {"m3": 0.03, "e": 0.11, "J": 0.001, "M0": 0.005, "phi": 0.0, "phidot": 0.0, "A": None, "omega": None}
FREQUENCIES = {"A": "3.5", "B": "5.5", "C": "6.5"}
AMPLITUDES = {"A": 0.0725, "B": 0.1140, "C": 0.1350}


def radians_per_second(hertz):
    with mpmath.workdps(50):
        return float(2 * mpmath.pi * mpmath.mpf(hertz))


def fields(scene, names):
    return {name: getattr(scene, name) for name in names}


READINGS = {"II-B-captured": "II-B", "II-C-escape": "II-C"}


def test_the_paper_s_and_the_readings():
    letters = "ABC"
    expected = {f"I-{x}" for x in letters} | {f"I-{x}-eq211" for x in letters} | {f"II-{x}" for x in letters}
    assert set(shipped_case_names()) == expected | set(READINGS)


@pytest.mark.parametrize(("name", "printed"), READINGS.items())
def test_a_reading_changes_two_numbers_and_says_why(name, printed):
    reading, as_printed = load_case(name), load_case(printed)
    changed = {**vars(as_printed.two_blocks()), "c": 0.0035, "J": 0.0085}
    assert vars(reading.two_blocks()) == changed
    assert "Why these two" in reading.text
    assert "(printed: 0.001)" in reading.text and "(printed: 0.001)" in reading.text


@pytest.mark.parametrize("name", sorted(set(shipped_case_names()) - set(READINGS)))
def test_common_values_name_and_title(name):
    case = load_case(name)
    assert fields(case.two_blocks(), COMMON) == COMMON
    assert case.name == name
    assert f"{FREQUENCIES[name.split('-')[1]]} Hz" in case.title
    assert "Table 1, column" in case.text
    assert float(Fraction("0.001") * Fraction("2.94") * Fraction("9.81")) == case.two_blocks().N


@pytest.mark.parametrize("letter", "ABC")
def test_ideal_source(letter):
    scene = load_case(f"I-{letter}").two_blocks()
    hertz = FREQUENCIES[letter]
    assert (scene.source, scene.F0, scene.A) == ("harmonic", 0.0, AMPLITUDES[letter])
    assert (scene.omega, scene.cycles, scene.cycles_lo) == (radians_per_second(hertz), float(hertz), 0.0)
    assert fields(scene, ["m3", "e", "J", "M0", "Omega0", "phi", "phidot"]) == dict.fromkeys(
        ["m3", "e", "J", "M0", "Omega0", "phi", "phidot"]
    )


@pytest.mark.parametrize("letter", "ABC")
def test_ideal_source_with_the_amplitude_of_eq_2_11(letter):
    """A = m3 e omega^2 with the motor's m3 and e; 22 to 41 times what Table 1 prints."""
    printed, by_rule = load_case(f"I-{letter}").two_blocks(), load_case(f"I-{letter}-eq211").two_blocks()
    with mpmath.workdps(50):
        omega = 2 * mpmath.pi * mpmath.mpf(FREQUENCIES[letter])
        assert float(mpmath.mpf("0.03") * mpmath.mpf("0.11") * omega**2) == by_rule.A
    assert 22 <= round(by_rule.A / printed.A) <= 41
    assert {**vars(by_rule), "A": None} == {**vars(printed), "A": None}


@pytest.mark.parametrize("letter", "ABC")
def test_motor(letter):
    scene = load_case(f"II-{letter}").two_blocks()
    assert scene.source == "motor"
    assert scene.Omega0 == radians_per_second(FREQUENCIES[letter])
    assert fields(scene, MOTOR) == MOTOR


def test_printed_amplitudes_are_m3_e_omega():
    """Table 1's amplitudes have the value of m3 e omega: the departure that the files name."""
    for letter, amplitude in AMPLITUDES.items():
        assert 0.03 * 0.11 * radians_per_second(FREQUENCIES[letter]) == pytest.approx(amplitude, rel=2e-3)


REMARKS = {
    f"gallery/{path.stem}": " ".join(
        line.lstrip("# ") for line in path.read_text(encoding="utf-8").splitlines() if line.startswith("#")
    )
    for path in (Path(__file__).parents[2] / "cases" / "gallery").glob("*.yaml")
}


def settings_in(remarks):
    """Settings of a command in remarks: of each place, KEY=VALUE of all options next to each other."""
    setting = r"(?:--set|-s) [\w.]+=(?:'[^']*'|[^\s.,;:)]+(?:\.\d+)?)"
    for options in re.findall(rf"{setting}(?: {setting})*", remarks):
        yield dict(word.split("=", 1) for word in shlex.split(options) if "=" in word)


@pytest.mark.parametrize("name", [name for name, remarks in REMARKS.items() if list(settings_in(remarks))])
def test_what_remarks_of_the_gallery_set_can_be_set(name):
    for settings in settings_in(REMARKS[name]):
        assert load_case(name, settings).scene()


def test_a_start_is_set_by_the_name_of_its_part_whether_or_not_the_file_gives_it():
    case = load_case("gallery/driven-pendulum", {"pendulum.x": "170 deg"})
    assert case.scene().bodies[0].x == pytest.approx(mpmath.radians(170), rel=1e-15)


# The hard cases are found by name, as the paper's are.


@pytest.mark.parametrize("name", hard_case_names())
def test_a_hard_case_is_found_by_name(name):
    case = load_case(name)
    assert case.source.endswith(f"{name.partition('/')[2]}.yaml")


def test_a_name_that_is_nearly_right_gets_a_hint():
    with pytest.raises(CaseError, match=r"no such file \(did you mean hard/stiff-stop\?\)"):
        load_case("hard/stif-stop")


def test_a_file_of_the_same_name_is_reached_by_its_path(here):
    (here / "hard").mkdir()
    (here / "hard/stiff-stop").write_text("extends: I-A\nname: mine\n")
    assert load_case("./hard/stiff-stop").name == "mine"
    assert load_case("hard/stiff-stop").name == "stiff-stop"


def test_a_hard_case_runs_by_name(tmp_path):
    told("run", "hard/stiff-stop", "--t-end", "0.1s", "-o", tmp_path / "stiff.h5")
