"""Every command that reads or judges one run, on scenes of named parts."""

import csv
import json
from types import SimpleNamespace

import numpy as np
import pytest

import vibsim
from tests.command_line.made import call, told
from tests.formula_cases import CURRENT, DRIVE, MACHINE, case_of, machine_file
from vibsim.command_line.text import case_lines, happened, metres
from vibsim.evidence.benchmark.plan import FAMILIES
from vibsim.fitting.plan import number_of
from vibsim.results import simulate_to_file

CASE = "gallery/impact-damper"
MOTOR = """
name: shaker
bodies: {cart: 2 kg, rider: 0.5 kg}
links:
  spring: {between: [cart, ground], k: 800 N/m, c: 3 N s/m}
  tie: {between: [rider, cart], k: 300 N/m, c: 0.5 N s/m}
stops: {lid: {between: [rider, cart], gap: 1 mm, acts: compression, k: 20 kN/m}}
motor: {on: cart, m3: 0.03 kg, e: 0.05 m, J: 0.001 kg m^2, M0: 0.05 N m, Omega0: 6 Hz}
run: {t_end: 20 s, every: 5 ms}
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("parts")
    (folder / "shaker.yaml").write_text(MOTOR)
    told("run", CASE, "--t-end", "60 s", "--lyapunov", "all", "-o", folder / "damper.h5")
    told("run", CASE, "--t-end", "60 s", "--method", "taylor", "-o", folder / "again.h5")
    told("run", folder / "shaker.yaml", "-o", folder / "shaker.h5")
    return folder


def test_analyse_tells_bodies_and_parts_by_name(folder):
    text = call("analyse", folder / "damper.h5", "--no-exponent", "-v").stdout
    lines = [line.strip() for line in text.splitlines()]
    assert any(line.startswith("impacts") and "left: every cycle: 1 per cycle" in line for line in lines)
    assert any(line.startswith("right: every cycle: 1 per cycle") for line in lines)
    assert any(line.startswith("words co 30; 1 in all") for line in lines)
    found = json.loads(call("--json", "analyse", folder / "damper.h5", "--no-exponent").stdout)
    assert found["impacts"].keys() == {"left", "right"}
    assert found["frequencies"].keys() == {"spring", "left"}
    assert found["frequencies"]["spring"]["lines"][0]["hz"] == pytest.approx(1.0, abs=1e-3)
    assert (found["capture"], found["drift"]) == (None, None)


def test_a_motor_among_named_parts_is_judged_like_the_paper_s(folder):
    found = json.loads(call("--json", "analyse", folder / "shaker.yaml", "--what", "capture").stdout)
    assert found["capture"]["no_load_speed_hz"] == pytest.approx(6.0)
    assert found["capture"]["verdict"] in ("captured", "escaped", "passed", "not met")
    names = {one["resonance"]["name"] for one in found["capture"]["passages"]}
    assert names <= {f"{kind} {i}" for kind in ("free", "bilinear", "half bilinear") for i in (1, 2)}


def test_compare_names_what_differs(folder):
    found = json.loads(call("--json", "compare", folder / "damper.h5", folder / "again.h5").stdout)
    assert found["verdict"] == "agree"
    assert "run.method" in {difference["key"] for difference in found["differences"]}


def test_exponents_and_counts_are_in_the_file(folder):
    found = json.loads(call("--json", "info", folder / "damper.h5").stdout)
    assert len(found["lyapunov_exponents"]) == 4
    # Liouville: away from the stops volumes shrink at c / m, and the balls' dampers add to that
    assert sum(found["lyapunov_exponents"]) < -1.26 / 10
    assert found["parts"]["left"]["impacts"] > 20
    assert "exponents" in call("info", folder / "damper.h5").stdout


def test_digits(folder):
    words = ("--t-end", "2 s", "--every", "0.1 s", "--digits", "30", "-o", folder / "digits.h5")
    found = json.loads(call("--json", "run", CASE, *words).stdout)
    assert found["digits_right"] >= 20


def test_export_has_a_column_for_every_body_and_part(folder):
    out = folder / "damper.csv"
    assert call("export", folder / "damper.h5", "-o", out, "--window", "59:60").exit_code == 0
    with open(out, encoding="utf-8", newline="") as file:
        head, *rows = csv.reader(file)
    assert [name.split(" ")[0] for name in head][:5] == ["time", "x_body", "v_body", "x_ball", "v_ball"]
    assert len(rows) == 501
    assert np.isfinite([float(row[3]) for row in rows]).all()


@pytest.mark.parametrize("name", ["damper.h5", "shaker.h5", "shaker.yaml"])
def test_kinds_of_pictures_that_fit_are_listed(folder, name):
    listed = json.loads(call("--json", "plot", folder / name, "--list").stdout)
    kinds = {kind["name"] for kind in listed}
    if name == "shaker.yaml":
        assert kinds == {"stiffness", "motor"}
    else:
        assert {"overview", "stroboscopic", "impact-velocity", "stiffness"} <= kinds
        assert "phase-drift-free" not in kinds  # springs hold every body
        assert ({"motor-speed", "displacement-frequency", "motor"} <= kinds) == (name == "shaker.h5")


def test_check_tells_what_the_numbers_imply(folder):
    text = call("check", "-v", folder / "shaker.yaml").stdout
    for name in ("open 1", "open 2", "closed 2", "bilinear 1", "run-up time constant", "full force"):
        assert f"  {name} " in text


# What commands say of scenes with formulas, rotors and further states.


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
    told("cases", machine_file[1], "--draw", "-o", out)
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


def test_a_number_without_unit_has_the_unit_1():
    lines = lines_of(call("orbit", "gallery/relief-valve").stdout)
    assert lines["state"][1] == "in m, 1, on the section v_disc = 0, at the greatest displacement of disc"


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
