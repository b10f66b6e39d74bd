"""The case object: canonical text, fingerprint, exact scenes, pickling."""

import json
import pickle
import subprocess
import sys
from fractions import Fraction

import mpmath
import pytest

from vibsim.cases import Case, CaseError, load_case, shipped_case_names


@pytest.mark.parametrize("name", shipped_case_names())
def test_resolved_text_is_canonical_and_complete(name):
    case = load_case(name)
    again = Case.from_resolved_json(case.resolved_json())
    assert again.resolved_json() == case.resolved_json()
    assert (again.two_blocks(), again.sha256, again.name, again.title) == (
        case.two_blocks(), case.sha256, case.name, case.title,
    )  # fmt: skip
    assert json.loads(case.resolved_json())["run"]["order"] == 20


def test_resolved_text_keeps_the_spelling_and_fills_in_units():
    case = load_case("II-B", {"Omega0": "330rpm", "G": 0.001})
    resolved = json.loads(case.resolved_json())
    assert resolved["excitation"]["Omega0"] == "330 rpm"
    assert resolved["stop"] == {"k2": "12400 N/m", "G": "0.001 m", "acts": "extension"}
    assert "extends" not in resolved


@pytest.mark.parametrize(
    "same",
    [{"Omega0": "330 rpm"}, {"Omega0": "5.50 Hz"}, {"G": "0.001"}, {"name": "other", "title": "Another"}],
)
def test_fingerprint_is_of_the_physics(same):
    assert load_case("II-B", same).sha256 == load_case("II-B").sha256


@pytest.mark.parametrize(
    "other",
    [
        {"Omega0": "34.55751918948772 rad/s"},
        {"G": "1.0000000000000000000001 mm"},
        {"t_end": "301 s"},
        {"order": "21"},
        {"stop": "none"},
        {"acts": "compression"},
    ],
)
def test_fingerprint_changes_with_what_is_simulated(other):
    assert load_case("II-B", other).sha256 != load_case("II-B").sha256


@pytest.mark.parametrize("text", ["", "{}", "[]", "3", "null", "{", "[" * 100_000, '{"vibsim_case": 2}'])
def test_other_json_is_refused(text):
    with pytest.raises(CaseError) as caught:
        Case.from_resolved_json(text)
    assert len(caught.value.problems) == 1


def test_a_damaged_resolved_text_gives_problems():
    text = load_case("II-B").resolved_json().replace("0.297 kg", "0.297 s").replace('"G": "1 mm"', '"G": NaN')
    with pytest.raises(CaseError) as caught:
        Case.from_resolved_json(text, source="run.h5")
    assert [(problem.file, problem.key) for problem in caught.value.problems] == [
        ("run.h5", "blocks.m1"),
        ("run.h5", "stop.G"),
    ]


def test_case_and_error_pickle():
    case = load_case("I-A-eq211")
    assert case.values and case.sha256
    again = pickle.loads(pickle.dumps(case))
    assert again == case
    assert (
        again.with_values({"omega": "4 Hz"}).two_blocks() == case.with_values({"omega": "4 Hz"}).two_blocks()
    )
    with pytest.raises(CaseError) as caught:
        load_case("nothing")
    assert pickle.loads(pickle.dumps(caught.value)).problems == caught.value.problems


def test_a_case_does_not_change():
    case = load_case("II-B")
    for target, name in [(case, "text"), (case.model, "name"), (case.model.blocks, "m1")]:
        with pytest.raises((AttributeError, ValueError)):
            setattr(target, name, None)


def test_rates_in_radians_give_cycles_as_a_double_double():
    scene = load_case("I-A", {"omega": "22 rad/s"}).two_blocks()
    with mpmath.workdps(60):
        exact = 22 / (2 * mpmath.pi)
        assert scene.omega == 22.0
        assert scene.cycles == float(exact)
        assert abs(exact - scene.cycles - scene.cycles_lo) < exact * mpmath.mpf(2) ** -105


def test_rates_in_hertz_that_are_no_double_give_the_rest():
    scene = load_case("I-A", {"omega": "3.7 Hz"}).two_blocks()
    assert scene.cycles == 3.7
    assert scene.cycles_lo == float(Fraction("3.7") - Fraction(3.7))


def test_friction_force_is_rounded_once():
    case = load_case("II-B", {"mu": "0.1", "m2": "0.3 kg", "g": "9.81 m/s^2"})
    assert float(Fraction("0.1") * Fraction("0.3") * Fraction("9.81")) == case.two_blocks().N


@pytest.mark.parametrize("omega", ["3.7 Hz", "22.1 rad/s"])
def test_exact_scene_in_mpmath(omega):
    case = load_case("I-A-eq211", {"omega": omega})
    with mpmath.workdps(60):
        exact = case.exact_two_blocks(
            lambda value: mpmath.mpf(value.numerator) / value.denominator, mpmath.pi
        )
        per_second = mpmath.mpf(omega.split()[0]) * (2 * mpmath.pi if "Hz" in omega else 1)
        assert abs(exact.omega - per_second) < mpmath.mpf(10) ** -57
        assert abs(exact.A - mpmath.mpf("0.0033") * per_second**2) < mpmath.mpf(10) ** -57
        if "Hz" in omega:
            assert exact.cycles == Fraction("3.7")
        else:
            assert abs(exact.cycles * 2 * mpmath.pi - 22.1) < 1e-14
    double = case.two_blocks()
    assert (float(exact.omega), float(exact.A), float(exact.N)) == (double.omega, double.A, double.N)
    assert (exact.every_num, exact.every_den, exact.source, exact.k2) == (1, 200, "harmonic", 12400)


def test_exact_scene_without_pi_takes_enough_digits():
    scene = load_case("II-B").exact_two_blocks(Fraction)
    with mpmath.workdps(1050):
        exact = 11 * mpmath.pi
        given_value = mpmath.mpf(scene.Omega0.numerator) / scene.Omega0.denominator
        assert abs(given_value - exact) < mpmath.mpf(10) ** -1000
    assert scene.m1 == Fraction("0.297")


def test_cases_import_nothing_heavy():
    heavy = ("numpy", "scipy", "matplotlib", "h5py")
    code = f"import sys, vibsim.cases; print([name for name in {heavy} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


FINGERPRINTS = {  # of version 0.1.0, as result files hold them
    "I-A-eq211": "ffbca380cd28dafd5fb91df9f7b4cec817287e529969c406b68a9a30c3478818",
    "II-B": "c2fde79c42d85fb8ffe7e0691cb6863a014bb904dfbc0862a9fd211683856022",
}


@pytest.mark.parametrize("name", FINGERPRINTS)
def test_fingerprints_of_stored_files_stay(name):
    assert load_case(name).sha256 == FINGERPRINTS[name]


def test_a_case_of_two_blocks_does_not_load_the_long_form():
    code = (
        "import sys; from vibsim import load_case; load_case('II-B').scene(); "
        "print('vibsim.cases.part_schema' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"


@pytest.mark.parametrize(
    ("name", "starts"),
    [
        ("II-B", {"initial.x1": "2 mm", "initial.phi": "30 deg"}),
        ("gallery/impact-oscillator", {"initial.mass.x": "-1 mm"}),
        ("gallery/driven-pendulum", {"initial.pendulum.x": "170 deg", "initial.pendulum.v": "0.5 rad/s"}),
    ],
)
def test_another_start_is_the_case_with_these_values(name, starts):
    case = load_case(name)
    known = {key: value for key, value in starts.items() if key in case.values}
    assert known
    whole, quick = case.with_values(known), case.with_start(known)
    assert quick.values == whole.values and quick.sha256 == whole.sha256 and quick.scene() == whole.scene()


def test_another_start_is_refused_as_any_value():
    case = load_case("gallery/impact-oscillator")
    (gap,) = (key for key in case.values if key.endswith(".gap"))
    for starts in (
        {"initial.mass.x": "3 kg"},
        {"initial.nobody.x": "1 m"},
        {"initial.mass.x": "1e6 m"},
        {gap: "1 kg"},
    ):
        with pytest.raises(CaseError) as quick:
            case.with_start(starts)
        with pytest.raises(CaseError) as whole:
            case.with_values(starts)
        assert str(quick.value) == str(whole.value)
