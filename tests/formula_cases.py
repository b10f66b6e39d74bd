"""Cases with rotors, further states and formulas, for the tests of what shows them."""

from math import exp

import pytest

from vibsim.cases import load_case
from vibsim.cases.case import load_case_text

# A cart on a spring that strikes a wall; a rotor without unbalance under a steady torque and a state that
# fades, which have closed forms. The push jumps at 0.3 s.
MACHINE = """\
name: machine
bodies: {cart: 1 kg}
links:
  spring: {between: [cart, ground], force: "k*d + k3*d**3 + c*v", k: 400 N/m, k3: 1e5 N/m^3, c: 2 N s/m}
stops: {wall: {between: [cart, ground], gap: 2 mm, acts: compression, k: 1e4 N/m}}
forces: {push: {on: cart, force: "A*sin(w1*t)*where(t < t1, 1, 2)", A: 3 N, w1: 3 Hz, t1: 0.3 s}}
states: {i: {rate: "-i/T", start: 500 mA, T: 0.5 s}}
rotors: {left: {on: cart, m: 0.1 kg, e: 0 m, J: 0.002 kg m^2, torque: "T0", T0: 0.01 N m}}
initial: {left: {phi: 90 deg, w: 5 rad/s}}
run: {t_end: 1 s, every: 5 ms}
"""
STATES = ("x_cart", "v_cart", "phi_left", "w_left", "i")
QUARTER = 1.5707963267948966

# A motor with its current, by turns of whose rotor the cart vibrates.
CURRENT = """\
name: current
bodies: {cart: 1 kg}
links: {spring: {between: [cart, ground], k: 400 N/m, c: 5 N s/m}}
states: {i: {rate: "(U - R*i - Kt*w_left)/L", start: 0 A, U: 12 V, R: 2 ohm, Kt: 0.2 V s/rad, L: 10 mH}}
rotors:
  left: {on: cart, m: 0.1 kg, e: 0.02 m, J: 0.001 kg m^2,
         torque: "Kt*i - b*w", Kt: 0.2 N m/A, b: 1e-4 N m s/rad}
run: {t_end: 1 s, every: 5 ms}
"""

# Two discs on a shaft.
DRIVE = """\
name: drive
bodies: {disc: 0.3 kg m^2, load: 0.5 kg m^2}
links: {shaft: {between: [disc, load], k: 300 N m/rad, c: 0.2 N m s/rad}}
stops: {tooth: {between: [disc, load], gap: 2 mrad, acts: compression, k: 4000 N m/rad}}
forces: {push: {on: disc, force: "T0*sin(w*t) - b*v_disc", T0: 2 N m, w: 3 Hz, b: 0.1 N m s/rad}}
run: {t_end: 2 s, every: 5 ms}
"""

# Every place of a formula at once.
EVERYWHERE = """\
name: everywhere
parameters: {g: 9.81 m/s^2}
bodies: {cart: 1 kg, tip: 0.2 kg}
links:
  spring: {between: [cart, ground],
           force: "k*d + k3*d**3 + c*v*abs(v)", k: 200 N/m, k3: 1e6 N/m^3, c: 2 N s^2/m^2}
  arm: {between: [tip, cart], k: 900 N/m, c: 0.5 N s/m}
  anchor: {between: [tip, base], k: 50 N/m}
stops:
  wall: {between: [tip, ground], gap: 1 mm, acts: compression,
         force: "K*p*(1 + lam*pv)", K: 1e5 N/m, lam: 0.3 s/m}
friction:
  floor: {between: [cart, ground], N: "m*g", mu: "mu_d + (mu_s - mu_d)*exp(-(s/vs)**2)", m: 0.1 kg,
          mu_s: 0.3, mu_d: 0.2, vs: 0.1 m/s}
forces: {push: {on: cart, force: "A*sin(w1*t)", A: 2 N, w1: 3 Hz}}
states: {i: {rate: "(U - R*i - Ke*w_left)/L", start: 0 A, U: 12 V, R: 2 ohm, Ke: 0.05 V s/rad, L: 1 mH}}
rotors:
  left: {on: cart, m: 0.03 kg, e: 0.11 m, J: 0.001 kg m^2,
         torque: "Kt*i - b*w", Kt: 0.05 N m/A, b: 1e-5 N m s/rad}
  right: {on: cart, m: 0.03 kg, e: 0.11 m, J: 0.001 kg m^2, M0: 0.1 N m, Omega0: 5 Hz}
  pendulum: {on: tip, m: 0.1 kg, e: 0.2 m, J: 0 kg m^2, torque: "-m*g*e*cos(phi)"}
base: {x: "a*sin(w0*t)", a: 1 mm, w0: 5 Hz}
run: {t_end: 0.3 s, every: 2 ms}
"""


def fading(t):
    """The state i of MACHINE [A]."""
    return 0.5 * exp(-2 * t)


def turned(t):
    """Angle [rad] and speed [rad/s] of the rotor of MACHINE."""
    return QUARTER + 5 * t + 2.5 * t * t, 5 + 5 * t


def case_of(text, changes=None):
    """The case of a text."""
    return load_case_text(text, changes or {})


@pytest.fixture(scope="module")
def machine():
    return case_of(MACHINE)


@pytest.fixture(scope="module")
def machine_file(tmp_path_factory):
    """A case file of MACHINE."""
    path = tmp_path_factory.mktemp("machine") / "machine.yaml"
    path.write_text(MACHINE, encoding="utf-8")
    return load_case(path), path
