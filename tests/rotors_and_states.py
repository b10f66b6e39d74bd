"""A machine with a rotor and a state as the engines see it, without the language that a case states them in.

A rotor is a body whose x is its angle, a state one whose v is the state; where a torque and a rate are
numbers and sines, today's engines run them. The case states all three as bodies, and `as_meant` makes the
scene of it.
"""

from dataclasses import replace

import pytest

from vibsim.cases import load_case
from vibsim.cases.case import Case
from vibsim.physics.parts import ROTOR, STATE

TEXT = """\
name: machine
bodies: {cart: 1 kg, left: 0.001 kg, i: 1 kg}
links: {spring: {between: [cart, ground], k: 400 N/m, c: 1 N s/m}}
stops: {wall: {between: [cart, ground], gap: 2 mm, acts: compression, k: 10000 N/m}}
friction: {floor: {between: [cart, ground], N: 1 N, mu: 0.05}}
forces:
  push: {on: cart, A: 2 N, omega: 3 Hz}
  torque: {on: left, F0: 0.002 N}
  rate: {on: i, A: 5 N, omega: 3 Hz, phase: 30 deg}
initial: {left: {v: 5 m/s}, i: {v: 0.5 m/s}}
run: {t_end: 4 s, every: 5 ms}
"""
KINDS = {"left": ROTOR, "i": STATE}
UNITS = (("i", "A"),)


def as_meant(scene):
    """The scene with its rotor and its state."""
    bodies = tuple(replace(body, kind=KINDS.get(body.name, body.kind)) for body in scene.bodies)
    return replace(scene, bodies=bodies, state_units=UNITS)


@pytest.fixture(scope="module")
def meant():
    """While this is asked for, cases make the scenes that are meant."""
    plain, exact = Case.scene, Case.exact_scene
    patch = pytest.MonkeyPatch()
    patch.setattr(Case, "scene", lambda case: as_meant(plain(case)))
    patch.setattr(Case, "exact_scene", lambda case, *number, **pi: as_meant(exact(case, *number, **pi)))
    yield
    patch.undo()


@pytest.fixture(scope="module")
def machine(meant, tmp_path_factory):
    """The case of the machine."""
    path = tmp_path_factory.mktemp("machine") / "machine.yaml"
    path.write_text(TEXT)
    return load_case(path)
