"""Machines with formulas, rotors and states as drawings."""

import numpy as np
import pytest
from matplotlib.patches import Circle

from tests.formula_cases import CURRENT, EVERYWHERE, MACHINE, case_of
from vibsim.plots import style
from vibsim.plots.animated_machine import Recorder, angle_columns, sketch, stage_for
from vibsim.plots.machine import layout, machine_figure
from vibsim.plots.machine_symbols import LONGEST_FORMULA, elements, short

MOTOR = """\
name: ramp
bodies: {cart: 1 kg}
links: {spring: {between: [cart, ground], k: 400 N/m}}
motor: {on: cart, m3: 0.03 kg, e: 0.01 m, J: 0.0001 kg m^2, M0: 0.01 N m, Omega0: "1 Hz + r*t", r: 2 rad/s^2}
run: {t_end: 2 s, every: 5 ms}
"""


def drawn(case):
    with style.applied():
        figure = machine_figure(case.long_values())
        figure.canvas.draw()
    return figure.axes[0]


@pytest.fixture(scope="module")
def axes():
    return drawn(case_of(EVERYWHERE))


def test_a_link_with_a_formula_is_one_element_with_its_name():
    """One element, not the spring and the damper that its numbers k and c would be."""
    spring, *others = elements(case_of(EVERYWHERE).long_values())
    assert (spring.kind, spring.key, spring.title) == ("law", "links.spring", "spring")
    assert spring.value == "k*d + k3*d**3 + c*v*abs(v)"
    assert [(one.kind, one.key) for one in others if one.key == "links.arm"] == [
        ("spring", "links.arm"), ("damper", "links.arm"),
    ]  # fmt: skip


def test_every_part_is_there_and_no_state(axes):
    gids = {artist.get_gid() for artist in axes.get_children()} - {None}
    parts = {"links.spring", "links.arm", "stops.wall", "friction.floor", "forces.push"}
    assert {*parts, "rotors.left", "rotors.right", "rotors.pendulum", "base"} <= gids
    assert not any(gid.startswith("states") for gid in gids)
    assert "i" not in {text.get_text() for text in axes.texts}


def test_rotors_are_circles_on_their_bodies_one_above_the_other(axes):
    """Two on the cart at different heights, one on the tip at the height of the first."""
    circles = {
        one.get_gid(): one.center
        for one in axes.patches
        if isinstance(one, Circle) and (one.get_gid() or "").startswith("rotors.")
    }
    plan = layout(case_of(EVERYWHERE).long_values())
    assert circles["rotors.left"][0] == circles["rotors.right"][0] == pytest.approx(plan.box("cart").centre)
    assert circles["rotors.pendulum"][0] == pytest.approx(plan.box("tip").centre)
    assert circles["rotors.left"][1] == circles["rotors.pendulum"][1] < circles["rotors.right"][1]
    assert max(y for _, y in circles.values()) < plan.roof


def test_labels_say_the_laws(axes):
    texts = {text.get_text() for text in axes.texts}
    assert {"push: A*sin(w1*t)", "left: Kt*i - b*w", "right: 0.1 N m, 5 Hz"} <= texts
    assert "K*p*(1 + lam*pv)" in texts and "base: a*sin(w0*t)" in texts
    assert any(text.startswith("µ = mu_d + (mu_s") and text.endswith("…, N = m*g") for text in texts)


def test_long_formulas_are_cut():
    force = case_of(MACHINE).long_values()["forces"]["push"]["force"]
    assert short(force) == "A*sin(w1*t)*where(t < t1, 1, …" and len(short(force)) == LONGEST_FORMULA


def test_a_motor_with_a_formula_is_drawn_as_one():
    axes = drawn(case_of(MOTOR))
    assert "motor: 0.01 N m, 1 Hz + r*t" in {text.get_text() for text in axes.texts}
    assert "motor" in {patch.get_gid() for patch in axes.patches}
    assert angle_columns(case_of(MOTOR).scene()) == {"": "phi"}


def test_moving_rotors_turn_by_their_own_angles():
    """Unbalanced masses lie at the angles of their channels, every other vertex of the rotor stays."""
    case = case_of(EVERYWHERE)
    angles = angle_columns(case.scene())
    assert angles == {"": "", " left": "phi_left", " right": "phi_right", " pendulum": "phi_pendulum"}
    still = np.zeros(1)
    ends = dict.fromkeys(("cart", "tip", "ground", "base"), still)
    stage = stage_for(case.long_values(), ends, {"stops.wall": 0.001})
    at = dict.fromkeys((*ends, "stops.wall", "floor"), 0.0)
    for i, name in enumerate(angles):
        at |= {f"cosine{name}": np.cos(1.0 + i), f"sine{name}": np.sin(1.0 + i)}
    recorder = Recorder()
    sketch(recorder, stage, at)
    arms = {one.key: one.vertices for one in recorder.shapes if one.key.startswith("rotors.")}
    for i, key in enumerate(("rotors.left", "rotors.right", "rotors.pendulum"), 1):
        (x0, y0), (x1, y1) = arms[key]
        assert np.arctan2(y1 - y0, x1 - x0) == pytest.approx(np.arctan2(np.sin(1 + i), np.cos(1 + i)))


def test_a_machine_without_formulas_has_one_rotor_alone():
    assert angle_columns(case_of(CURRENT).scene()) == {"": "", " left": "phi_left"}
