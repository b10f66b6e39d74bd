"""What commands say of scenes with formulas, rotors and further states."""

import json
from types import SimpleNamespace

import pytest

import vibsim
from tests.command_line.made import call
from tests.formula_cases import CURRENT, DRIVE, MACHINE, case_of, machine_file
from vibsim.command_line.text import case_lines, happened, metres
from vibsim.evidence.benchmark.plan import FAMILIES
from vibsim.fitting.plan import number_of
from vibsim.results import simulate_to_file

__all__ = ["machine_file"]


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """Runs of the machine and of the drive, and a drive beside it."""
    folder = tmp_path_factory.mktemp("runs")
    cases = {"machine": case_of(MACHINE), "drive": case_of(DRIVE)}
    cases["other"] = case_of(DRIVE, {"forces.push.T0": "2.1 N m"})
    for name, case in cases.items():
        simulate_to_file(case, folder / f"{name}.h5")
    return {name: folder / f"{name}.h5" for name in cases}


def lines_of(text):
    """Lines by their labels; those without one behind the label above."""
    lines, label = {}, ""
    for line in text.splitlines():
        label = line[2:18].strip() or label
        lines.setdefault(label, []).append(line[18:])
    return lines


def test_info_says_what_a_machine_is(files):
    lines = lines_of(call("info", files["machine"]).stdout)
    assert lines["bodies"] == ["cart 1 kg"]  # without the rotor, as the case has it
    assert lines["rotors"] == ["left 0.002 kg m^2"] and lines["states"] == ["i A"]
    assert lines["source"] == ["force push on cart: a formula", "torque on left: a formula"]
    assert "links.spring.force = k*d + k3*d**3 + c*v" in lines["formulas"]
    assert "states.i.rate = -i/T" in lines["formulas"]
    assert lines["by part"] == ["wall: 3 impacts", "push: 1 jump"]
    assert lines["samples"][0].startswith("201 x time, x_cart, v_cart, phi_left, w_left, i, wall")


def test_info_of_a_torsional_scene_is_in_radians(files):
    lines = lines_of(call("info", files["drive"]).stdout)
    assert lines["bodies"] == ["disc 0.3 kg m^2, load 0.5 kg m^2"]
    assert lines["trust horizon"][0].startswith("right to 1e-6 rad over the whole run")
    assert lines["trust horizon"][0].endswith(" rad")


def test_a_case_without_formulas_has_no_such_lines():
    labels = {label for label, _ in case_lines(vibsim.load_case("gallery/impact-pair"))}
    assert not {"rotors", "states", "formulas"} & labels


def test_runs_are_compared_in_radians(files):
    text = call("compare", files["drive"], files["other"]).stdout
    assert "within 1e-6 rad until" in text or "not within 1e-6 rad" in text
    data = json.loads(call("--json", "compare", files["drive"], files["other"]).stdout)
    units = {one["name"].partition(" of ")[0]: one["unit"] for one in data["statistics"]}
    assert units.get("amplitude", "rad") == "rad" and units.get("drift rate", "rad/s") == "rad/s"


def test_analyse_says_drift_in_radians(files):
    text = call("analyse", files["drive"], "--what", "drift").stdout
    assert " rad/s (" in text or "too short" in text


def test_a_machine_is_drawn(machine_file, tmp_path):
    out = tmp_path / "machine.png"
    assert call("cases", machine_file[1], "--draw", "-o", out).exit_code == 0
    assert out.stat().st_size > 1000


def test_columns_are_exported_by_name(files, tmp_path):
    out = tmp_path / "machine.csv"
    assert call("export", files["machine"], "-o", out).exit_code == 0
    head = out.read_text(encoding="ascii").splitlines()[0]
    assert head == "time,x_cart,v_cart,phi_left,w_left,i,wall,error_estimate"


def test_an_orbit_by_turns_of_a_rotor_is_told(tmp_path):
    case, out = tmp_path / "current.yaml", tmp_path / "orbit.h5"
    case.write_text(CURRENT.replace("t_end: 1 s", "t_end: 3 s"), encoding="utf-8")
    lines = lines_of(call("orbit", case, "-o", out).stdout)
    assert lines["period"][0].endswith(": 1 turn of left")
    assert lines["state"][1] == "in m, m/s, rad/s, A, on the section phi_left = 0"
    held = lines_of(call("info", out).stdout)
    assert held["orbit"][0].startswith("1 turn, 0.10529671")


def test_of_the_peers_only_the_closed_form_takes_no_formulas():
    scene = case_of(MACHINE).scene()
    refusals = {family.name: family.refusal(scene) for family in FAMILIES}
    assert "needs laws that are linear" in refusals.pop("closed-form")
    assert set(refusals.values()) == {None}
    plain = vibsim.load_case("gallery/impact-oscillator").scene()
    assert all(family.refusal(plain) is None for family in FAMILIES if family.rigid_stops)


def test_a_free_parameter_may_have_any_unit():
    candidate = SimpleNamespace(changes={"states.i.U": "8460 mV"})
    free = SimpleNamespace(key="states.i.U", unit="V")
    assert number_of(candidate, free) == 8.46


@pytest.mark.parametrize(
    ("number", "word", "text"), ((1, "jumps", "1 jump"), (2, "jumps", "2 jumps"), (2, "impacts", "2 impacts"))
)
def test_jumps_are_counted(number, word, text):
    assert happened(number, word) == text


def test_angles_have_no_prefix_of_lengths():
    assert metres(0.00205, "rad") == "0.00205 rad" and metres(0.00205) == "2.05 mm"
