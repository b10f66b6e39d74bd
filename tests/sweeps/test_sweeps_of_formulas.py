"""Sweeps over numbers of formulas, of scenes with rotors and further states."""

import numpy as np
import pytest

import vibsim
from tests.formula_cases import DRIVE, MACHINE, case_of
from vibsim.sweeps.axes import read_members, rotor_angles
from vibsim.sweeps.sweep_plan import PlanError

# A rotor that settles at w = T0/b, and a state that settles at z0; an unbalance shakes the cart a little.
STEADY = """\
name: steady
bodies: {cart: 0.9 kg}
links: {spring: {between: [cart, ground], k: 400 N/m, c: 9 N s/m}}
stops: {wall: {between: [cart, ground], gap: 1 m, acts: compression, k: 1e4 N/m}}
states: {z: {rate: "(z0 - z)/T", start: 0 A, z0: 3 A, T: 50 ms}}
rotors:
  left: {on: cart, m: 0.1 kg, e: 0 m, J: 0.002 kg m^2, torque: "T0 - b*w", T0: 0.1 N m, b: 0.005 N m s/rad}
initial: {left: {w: 20 rad/s}, cart: {x: 5 mm}}
run: {t_end: 4 s, every: 5 ms}
"""


@pytest.fixture(scope="module")
def sweep():
    axes = {"rotors.left.T0": "0.1:0.2:0.05 N m"}
    return vibsim.sweep(case_of(STEADY), axes, section=4, jobs=1, compute=["power"])


def test_rotors_have_mean_speeds(sweep):
    """T0/b over 2 pi, but for what is left of the run-up after two seconds: exp(-b t/J) = exp(-5)."""
    torques = np.array([0.1, 0.15, 0.2])
    expected = torques / 0.005 / (2 * np.pi)
    assert sweep["mean_speed_left"].ravel() == pytest.approx(expected, rel=3e-3)
    assert sweep.arrays().datasets["mean_speed_left"].column.units == "Hz"
    assert sweep["left_T0"].tolist() == torques.tolist()


def test_sections_have_speeds_and_states(sweep):
    columns = sweep.arrays().datasets
    assert columns["section_z"].column.units == "A" and columns["section_w_left"].column.units == "Hz"
    assert sweep["section_z"][..., -1].ravel() == pytest.approx([3.0] * 3, rel=1e-12)
    speeds = sweep["section_w_left"][..., -1].ravel() * 2 * np.pi
    assert speeds == pytest.approx(np.array([20, 30, 40]), rel=1e-3)


def test_the_torque_gives_what_its_drag_takes(sweep):
    """The power of the whole torque, drag in it, is what the stored energy grows by: 0 in the end."""
    assert "power_rotor_left" in sweep and "power_force_left" not in sweep
    grown = sweep["power_rotor_left"] - sweep["power_damper_spring"] - sweep["power_stored"]
    assert np.abs(grown).max() < 1e-12


def test_a_state_is_carried_with_rotors_and_states():
    """What the first point ends with is where the second begins, the angle within one turn."""
    axes = {"rotors.left.T0": "0.1:0.15:0.05 N m"}
    sweep = vibsim.sweep(case_of(STEADY), axes, section=1, jobs=1, carry_state=True)
    ends = {name: sweep[f"end_{name}"].ravel()[0] for name in ("x_cart", "v_cart", "phi_left", "w_left", "z")}
    units = {name: sweep.arrays().datasets[f"end_{name}"].column.units for name in ends}
    assert units == {
        "x_cart": "m", "v_cart": "m s-1", "phi_left": "rad", "w_left": "rad s-1", "z": "A",
    }  # fmt: skip
    assert 0 <= ends["phi_left"] < 2 * np.pi
    second = sweep.case_at((1, 0)).scene()
    cart, left, z = second.bodies
    assert (cart.x, cart.v, left.x, left.v, z.v) == tuple(ends.values())


def test_a_formula_of_time_without_a_period_leaves_no_state_to_carry():
    with pytest.raises(PlanError, match="has no period in it leaves no state to carry"):
        vibsim.sweep(case_of(MACHINE), {"forces.push.A": "1:2:1 N"}, jobs=1, carry_state=True)


def test_an_ensemble_is_over_the_angles_of_rotors():
    case = case_of(STEADY)
    assert rotor_angles(case) == ["initial.left.phi"]
    members = read_members(case, 3, 1, {})
    assert members.keys == ("initial.left.phi",)
    assert rotor_angles(vibsim.load_case("II-B")) == ["initial.phi"]


def test_torsional_scenes_have_units_of_angles():
    sweep = vibsim.sweep(
        case_of(DRIVE), {"forces.push.T0": "1:2:1 N m"}, section=2, jobs=1, compute=["impact-velocity"]
    )
    units = {name: data.column.units for name, data in sweep.arrays().datasets.items()}
    assert units["amplitude_x_disc"] == "rad" and units["section_v_load"] == "rad s-1"
    assert units["grazing_margin"] == "rad" and units["impact_velocity_mean"] == "rad s-1"


def test_contacts_have_the_phase_of_the_rotor_that_turns_the_scene():
    """The wall at the rest position is struck by the shaking of the unbalance; phases are parts of a turn."""
    text = STEADY.replace("e: 0 m", "e: 0.05 m").replace("gap: 1 m,", "gap: 0 mm,")
    sweep = vibsim.sweep(
        case_of(text, {"run.t_end": "2 s"}), {"rotors.left.T0": "0.1:0.15:0.05 N m"},
        section=3, jobs=1, compute=["contact-section"],
    )  # fmt: skip
    phases = sweep["contact_phase_wall"]
    assert np.isfinite(phases).all() and (phases >= 0).all() and (phases < 1).all()
    assert "contact_speed_wall" not in sweep
