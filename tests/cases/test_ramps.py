"""Ramps of numbers over time, against formulas that are written out and against numpy."""

import numpy as np
import pytest

import vibsim
from vibsim.cases import CaseError, load_case
from vibsim.cases.case import load_case_text
from vibsim.cases.ramps import drive_frequency, drive_turns, end_of, no_load_speed, ramped, read_ramp

MACHINE = """
bodies: {table: 0.3 kg}
parameters: {U: 6 V, Kt: 0.05 N m/A, K: 3 N/V}
links: {spring: {between: [table, ground], k: 400 N/m, c: 0.2 N s/m}}
stops: {wall: {between: [table, ground], gap: 2 mm, acts: compression, k: 20 kN/m}}
states: {i: {rate: "(U - R*i - Kt*w)/L", start: 0 A, R: 2 ohm, L: 1 mH}}
motor: {on: table, m3: 0.03 kg, e: 0.02 m, J: 1e-4 kg m^2, torque: "Kt*i - b*w", b: 1e-5 N m s/rad}
friction: {guide: {between: [table, ground], mu: 0.1, N: 1 N}}
forces: {push: {on: table, force: "K*U"}, pull: {on: table, force: "-K*U", K: 1 N/V}}
run: {t_end: 1 s, every: 2 ms}
"""


def ramp(case, text, over):
    key, _, values = text.partition("=")
    return ramped(case, [read_ramp(key, values)], over)


@pytest.mark.parametrize(
    ("values", "course"),
    [
        ("3:7Hz", [3, 4, 5, 7, 7, 7]),
        ("7:3Hz", [7, 6, 5, 3, 3, 3]),
        ("3 Hz : 420 rpm", [3, 4, 5, 7, 7, 7]),
        ("3:7:5Hz", [3, 4, 5, 7, 6, 5]),
    ],
)
def test_the_no_load_speed_goes_there_and_is_held(values, course):
    case = ramp(load_case("II-B"), f"Omega0={values}", "4 s")
    times = np.array([0, 1, 2, 4, 6, 9.0])
    assert no_load_speed(case, times) == pytest.approx(course, rel=1e-15)


def test_no_load_speed_of_a_number_and_of_a_torque():
    assert no_load_speed(load_case("II-B"), np.zeros(2)) == pytest.approx([5.5, 5.5])
    assert no_load_speed(load_case("I-B"), np.zeros(2)) is None
    assert no_load_speed(load_case_text(MACHINE), np.zeros(2)) is None


@pytest.mark.parametrize(
    ("values", "by_hand", "rate"),
    [
        ("3:3.5Hz", "min(3 Hz + r*t, 3.5 Hz)", "0.125 Hz/s"),
        ("6:5.5Hz", "max(6 Hz + r*t, 5.5 Hz)", "-0.125 Hz/s"),
    ],
)
def test_a_run_is_that_of_the_formula_written_out(values, by_hand, rate):
    case = load_case("II-B", {"run.t_end": "6 s"})
    one = vibsim.simulate(ramp(case, f"Omega0={values}", "4 s"), trust=False)
    other = vibsim.simulate(case.with_values({"Omega0": by_hand, "r": rate}), trust=False)
    constant = vibsim.simulate(case.with_values({"Omega0": values.partition(":")[0] + " Hz"}), trust=False)
    for name in ("x1", "v2", "phi", "phidot"):
        assert one[name][-1] == pytest.approx(other[name][-1], rel=1e-7, abs=1e-9)
    assert abs(one["phi"][-1] - constant["phi"][-1]) > 0.01


def test_every_number_of_a_ramp_has_a_path():
    case = ramp(load_case("II-B"), "Omega0=3:7Hz", "400 s")
    assert str(case.quantity("Omega0_to")) == "7 Hz"
    shorter = case.with_values({"Omega0_over": "8 s"})
    assert no_load_speed(shorter, np.array([4.0])) == pytest.approx([5.0])


def test_a_ramp_takes_the_place_of_a_ramp():
    up = ramp(load_case("II-B"), "Omega0=3:7:5Hz", "4 s")
    down = ramp(up, "Omega0=7:3Hz", "2 s")
    assert no_load_speed(down, np.array([0, 1, 2.0])) == pytest.approx([7, 5, 3])
    assert "excitation.Omega0_back" not in down.values


@pytest.mark.parametrize(
    ("text", "path", "formula"),
    [
        ("guide.N=1:0N", "friction.guide.N", "N_from + (N_to - N_from)*min(t/N_over, 1)"),
        ("guide.mu=0.1:0.3", "friction.guide.mu", "mu_from + (mu_to - mu_from)*min(t/mu_over, 1)"),
        (
            "motor.torque=0:1 N m",
            "motor.torque",
            "torque_from + (torque_to - torque_from)*min(t/torque_over, 1)",
        ),
        (
            "states.i.R=2:4ohm",
            "states.i.rate",
            "(U - (R_from + (R_to - R_from)*min(t/R_over, 1))*i - Kt*w)/L",
        ),
    ],
)
def test_keys_that_take_formulas_and_numbers_that_formulas_name(text, path, formula):
    case = ramp(load_case_text(MACHINE), text, "1 s")
    assert str(case.values[path]) == formula
    assert vibsim.simulate(case, trust=False).complete


def test_one_parameter_drives_all_that_read_it():
    case = ramp(load_case_text(MACHINE), "U=1:6V", "1 s")
    course = "(U_from + (U_to - U_from)*min(t/U_over, 1))"
    assert str(case.values["states.i.rate"]) == f"({course} - R*i - Kt*w)/L"
    assert str(case.values["forces.push.force"]) == f"K*{course}"
    assert str(case.quantity("parameters.U_to")) == "6 V"


def test_a_number_beside_a_formula_hides_the_parameter_of_its_name():
    case = ramp(load_case_text(MACHINE), "parameters.K=1:2N/V", "1 s")
    assert str(case.values["forces.push.force"]) == "(K_from + (K_to - K_from)*min(t/K_over, 1))*U"
    assert str(case.values["forces.pull.force"]) == "-K*U"


@pytest.mark.parametrize(
    ("text", "over", "message"),
    [
        ("Omega0=3:7", "4 s", "excitation.Omega0: needs a unit"),
        ("Omega0=3:7N", "4 s", "excitation.Omega0: must be an angular rate"),
        ("Omega0=0:7Hz", "4 s", "excitation.Omega0: must be > 0, got 0 Hz"),
        ("Omega0=3:3000bHz", "4 s", "unit"),
        ("Omega0=3Hz:180rpm", "4 s", "goes from a value to the same"),
        ("Omega0=3", "4 s", "is not FROM:TO or FROM:TO:BACK"),
        ("Omega0=3:4:5:6Hz", "4 s", "is not FROM:TO or FROM:TO:BACK"),
        ("Omega0=3:7Hz", "0 s", "over must be > 0"),
        ("Omega0=3:7Hz", "4 kg", "over must be a time"),
        (
            "m1=1:2kg",
            "4 s",
            "blocks.m1 takes no formula; here these can have a ramp: excitation.M0, excitation.Omega0, "
            "coupling.k1",
        ),
        ("G=1:2mm", "4 s", "stop.G takes no formula"),
        ("Omga0=3:7Hz", "4 s", "Omga0: unknown key"),
    ],
)
def test_what_no_ramp_can_be(text, over, message):
    with pytest.raises(ValueError, match=message.replace("(", r"\(")):
        ramp(load_case("II-B"), text, over)


def test_two_ramps_of_one_key():
    ramps = [read_ramp(key, "3:7Hz") for key in ("Omega0", "excitation.Omega0")]
    with pytest.raises(ValueError, match=r"excitation\.Omega0 is given two ramps"):
        ramped(load_case("II-B"), ramps, "4 s")


def test_a_formula_that_does_not_come_to_its_unit():
    with pytest.raises(CaseError, match="comes to kg, must be N"):
        ramp(load_case_text(MACHINE), "push.force=0:1kg", "1 s")


def test_the_end_is_that_of_the_longest_ramp():
    there, back = read_ramp("Omega0", "3:7Hz"), read_ramp("M0", "1:2:1 N m")
    assert end_of([there], "2.5 min") == "2.5 min"
    assert end_of([there, back], "2.5 min") == "5 min"


FORCED = """
bodies: {table: 1 kg}
links:
  spring: {between: [table, ground], k: 400 N/m, c: 4 N s/m}
  tie: {between: [table, base], k: 100 N/m}
forces: {drive: {on: table, A: 2 N, omega: 2 Hz, phase: 30 deg, F0: 1 N}}
base: {a: 1 mm, omega: 3 Hz}
run: {t_end: 6 s, every: 2 ms}
"""
BY_HAND = {
    "drive.omega=2:5Hz": {
        "drive.force": "F0 + A*sin(omega*t + where(t < T, r*t**2/2, r*T*(t - T/2)) + phase)",
        "drive.r": "0.75 Hz/s",
        "drive.T": "4 s",
    },
    "drive.A=2:3N": {
        "drive.force": "F0 + (A + r*min(t, T))*sin(omega*t + phase)",
        "drive.r": "0.25 N/s",
        "drive.T": "4 s",
    },
    "base.a=1:9mm": {"base.x": "(a + r*min(t, T))*sin(omega*t + phase)", "base.r": "2 mm/s", "base.T": "4 s"},
    "spring.k=400:500N/m": {
        "spring.force": "(k + r*min(t, T))*d + c*v",
        "spring.r": "25 N/m/s",
        "spring.T": "4 s",
    },
}


@pytest.mark.parametrize("text", BY_HAND)
def test_a_number_of_a_built_in_law(text):
    case = load_case_text(FORCED)
    one = vibsim.simulate(ramp(case, text, "4 s"), trust=False)
    other = vibsim.simulate(case.with_values(BY_HAND[text]), trust=False)
    steady = vibsim.simulate(case, trust=False)
    assert one["x_table"] == pytest.approx(other["x_table"], abs=1e-12)
    assert np.abs(one["x_table"] - steady["x_table"]).max() > 1e-4


def test_a_stop_by_its_stiffness_and_a_rule_of_the_amplitude():
    stiffer = ramp(load_case("II-B"), "k2=10:20kN/m", "4 s")
    assert str(stiffer.values["stops.stop.force"]) == "(k_from + (k_to - k_from)*min(t/k_over, 1))*p + c*pv"
    rule = {"excitation.A.rule": "m3 e omega^2", "excitation.A.m3": "30 g", "excitation.A.e": "1 mm"}
    case = ramp(load_case("I-B", rule), "omega=3:6Hz", "4 s")
    assert str(case.values["forces.excitation.force"]).startswith("F0 + m3*e*(omega_from + ")
    run = vibsim.simulate(case.with_values({"run.t_end": "5 s"}), trust=False)
    assert run.complete and run.case.quantity("m3").text == "30 g"


@pytest.mark.parametrize("values, steps", [("2:5Hz", [2, 3.5, 5, 5, 5]), ("2:5:1Hz", [2, 3.5, 5, 3, 1])])
def test_frequency_and_periods_of_a_drive(values, steps):
    case, times = ramp(load_case_text(FORCED), f"drive.omega={values}", "4 s"), np.array([0, 2, 4, 6, 8.0])
    assert drive_frequency(case, times) == pytest.approx(steps)
    fine = np.linspace(0, 9, 100_001)
    integral = np.concatenate(
        [[0], np.cumsum(drive_frequency(case, fine)[:-1] + np.diff(drive_frequency(case, fine)) / 2)]
    )
    assert drive_turns(case, fine) == pytest.approx(integral * 9e-5, abs=1e-6)
    assert drive_frequency(load_case_text(FORCED), times) is None
