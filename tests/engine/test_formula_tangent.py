"""Small disturbances through formulas and rotors on bodies: difference quotients in 40 digits, volumes."""

from contextlib import suppress
from dataclasses import replace

import numpy as np
import pytest

from tests.engine.bundles import PER_PIECE, assert_derivative, start_components, totals
from tests.engine.random_formulas import formula_scene
from tests.engine.runs import scene_of
from tests.engine.test_boundary import opened, packed, refusals
from vibsim.engine.errors import EngineError
from vibsim.engine.tangent.monodromy import Carrier
from vibsim.engine.tangent.packing_tangent import pack_slopes
from vibsim.engine.tangent.tangent_space import components
from vibsim.engine.trajectory import open_trajectory
from vibsim.physics.parts import GROUND

DUFFING = """
bodies: {a: 1 kg}
links: {spring: {between: [a, ground], force: "k*d + k3*d**3 + c*v", k: 1 N/m, k3: 1 N/m^3, c: 0.1 N s/m}}
forces: {f: {on: a, A: 0.3 N, omega: 1.4 rad/s, phase: 0.3 rad}}
initial: {a: {x: 1 m}}
run: {t_end: 5 s, every: 20 ms}
"""
WALL = "stops: {wall: {between: [a, ground], gap: 0.5 m, acts: compression, k: 50 N/m, c: 1 N s/m}}\n"
TEXTS = {
    "duffing": DUFFING,
    # the law varies so fast with time that pieces are halved
    "mathieu": """
bodies: {a: 1 kg}
links:
  spring: {between: [a, ground],
           force: "(k + q*cos(w0*t))*d + c*v", k: 4 N/m, q: 3 N/m, w0: 9 rad/s, c: 0.1 N s/m}
run: {t_end: 3 s, every: 20 ms}
""",
    # a ball falls on a contact with p^1.5 and damping
    "hertz": """
bodies: {ball: 1 kg}
stops:
  wall: {between: [ball, ground], gap: 1 mm, acts: compression,
         force: "K*p**1.5*(1 + lam*pv)", K: 1e5 N/m^1.5, lam: 0.2 s/m}
forces: {g: {on: ball, F0: 9 N}}
initial: {ball: {v: 0.3 m/s}}
run: {t_end: 0.2 s, every: 10 ms}
""",
    "bouc-wen": """
bodies: {a: 1 kg}
links: {spring: {between: [a, ground], force: "k*d + q*z", k: 2 N/m, q: 3 N/m}}
states: {z: {rate: "v_a - b*(abs(v_a)*z*abs(z) + v_a*z**2)", start: 0 m, b: 0.5 1/m^2}}
forces: {f: {on: a, A: 2 N, omega: 1.3 rad/s, phase: 0.3 rad}}
initial: {a: {x: 1 m}}
run: {t_end: 5 s, every: 20 ms}
""",
    # on a belt whose friction falls with the speed: it sticks and slips
    "belt": """
bodies: {a: 1 kg}
links: {spring: {between: [a, ground], k: 4 N/m, c: 0.1 N s/m}}
friction:
  f: {between: [a, ground], belt: 0.5 m/s, N: 5 N, mu: "mu1*(1 + exp(-(r*s)**2))", mu1: 0.2, r: 3 s/m}
initial: {a: {x: 0.1 m}}
run: {t_end: 9 s, every: 20 ms}
""",
    # a force that turns with the sign of v beside one that only bends
    "jump": """
bodies: {a: 1 kg}
links:
  spring: {between: [a, ground], force: "k*d + F*sign(v) + q*abs(d)", k: 9 N/m, F: 0.2 N, q: 0.2 N/m}
initial: {a: {x: 1.3 m}}
run: {t_end: 4 s, every: 20 ms}
""",
    # a link that reads the angle and the speed of a motor
    "motor": """
bodies: {a: 0.9 kg}
links: {spring: {between: [a, ground], force: "k*d + q*sin(phi)*w", k: 30 N/m, q: 0.05 N s/rad}}
motor: {on: a, m3: 0.1 kg, e: 0.02 m, J: 1e-4 kg m^2, M0: 0.001 N m, Omega0: 9 rad/s}
initial: {a: {x: 1 cm}, motor: {phi: 0.5 rad, phidot: 6 rad/s}}
run: {t_end: 3 s, every: 20 ms}
""",
    # rotors of one body that feel each other's speed and its own, and a force on it that reads a rotor's
    "speeds": """
bodies: {frame: 3 kg}
links:
  spring: {between: [frame, ground], force: "k*d + c*v + q*w_left + p*w_right", k: 900 N/m, c: 2 N s/m,
           q: 0.3 N s/rad, p: -0.2 N s/rad}
rotors:
  left: {on: frame, m: 0.1 kg, e: 0.1 m, J: 1e-3 kg m^2, torque: "g*w_right - b*w - h*v_frame",
         g: 4e-3 N m s/rad, b: 2e-3 N m s/rad, h: 0.1 N s}
  right: {on: frame, m: 0.2 kg, e: 0.1 m, J: 1e-3 kg m^2, torque: "h*v_frame*w", h: 0.2 N s^2/rad}
initial: {frame: {x: 1 cm}, left: {phi: 1 rad, w: 20 rad/s}, right: {phi: 2 rad, w: 30 rad/s}}
run: {t_end: 0.3 s, every: 20 ms}
""",
    # derivatives whose series fail before those of the motion do
    "steep": """
bodies: {a: 1 kg}
links: {spring: {between: [a, ground], force: "k*d + F*tanh(d/L)", k: 1 N/m, F: 1 N, L: 0.125 m}}
initial: {a: {x: 2 m, v: 0.5 m/s}}
run: {t_end: 4 s, every: 20 ms}
""",
    "sawtooth": """
bodies: {a: 1 kg}
links: {spring: {between: [a, ground], force: "k*d + q*mod(d, L)", k: 9 N/m, q: 1 N/m, L: 0.5 m}}
initial: {a: {x: 1.2 m}}
run: {t_end: 2 s, every: 20 ms}
""",
    "two bodies": """
bodies: {a: 1 kg, b: 2 kg}
links:
  k: {between: [a, b], force: "k3*d**3 + c3*v**3", k3: 5 N/m^3, c3: 1 N s^3/m^3}
  g: {between: [b, ground], k: 20 N/m, c: 0.3 N s/m}
  e: {between: [a, ground], force: "q*d/(1 + (v/v0)**2)", q: 3 N/m, v0: 1 m/s}
initial: {a: {x: 0.7 m}, b: {v: 0.4 m/s}}
run: {t_end: 4 s, every: 20 ms}
""",
    # two rotors on one body, one of which a circuit drives, and one on another that friction holds
    "rotors": """
bodies: {frame: 3 kg, block: 1 kg}
links:
  spring: {between: [frame, ground], k: 900 N/m, c: 2 N s/m}
  tie: {between: [frame, block], k: 40 N/m, c: 0.1 N s/m}
friction: {f: {between: [block, ground], N: 1.5 N, mu: 1}}
states: {i: {rate: "(U - R*i - Ke*w_left)/L", start: 0 A, U: 12 V, R: 2 ohm, Ke: 0.05 V s/rad, L: 10 mH}}
rotors:
  left: {on: frame, m: 0.1 kg, e: 0.1 m, J: 1e-3 kg m^2,
         torque: "Kt*i - b*w", Kt: 0.05 N m/A, b: 1e-4 N m s/rad}
  right: {on: frame, m: 0.2 kg, e: 0.1 m, J: 0 kg m^2, torque: "-T0*cos(phi)", T0: 0.02 N m}
  other: {on: block, m: 0.05 kg, e: 0.1 m, J: 5e-4 kg m^2}
initial: {block: {v: 0.1 m/s}, left: {phi: 1 rad}, right: {phi: 7 rad, w: 30 rad/s}, other: {w: 20 rad/s}}
run: {t_end: 0.4 s, every: 20 ms}
""",
    # without any formula
    "rotors alone": """
bodies: {frame: 3 kg}
links: {spring: {between: [frame, ground], k: 900 N/m, c: 2 N s/m}}
rotors: {r: {on: frame, m: 0.1 kg, e: 0.1 m, J: 1e-3 kg m^2}}
initial: {frame: {x: 1 cm}, r: {phi: 1 rad, w: 25 rad/s}}
run: {t_end: 1 s, every: 20 ms}
""",
}


SCENES = {name: scene_of(text) for name, text in TEXTS.items()}


KINDS = {"hertz": {"contact_begin", "contact_end"}, "belt": {"stick_begin", "stick_end"}}


@pytest.mark.parametrize("name", SCENES)
def test_disturbances_are_difference_quotients(name):
    columns, kinds = assert_derivative(SCENES[name], doubles=1e-9)
    assert columns > 0 and kinds >= KINDS.get(name, set())


@pytest.mark.parametrize("name", SCENES)
def test_a_bundle_grows_as_the_disturbances_that_are_carried(name):
    """Its volume is their determinant, where nothing sticks; and as Liouville says, from the equations."""
    scene = SCENES[name]
    found, end = totals(scene), Carrier(scene).carry(start_components(scene), scene.t_end)
    assert abs(found["volume_residual"]) < PER_PIECE * (found["tangent_pieces"] + 1)
    if found["rank_losses"]:
        return
    inside = components(scene)
    volume = np.linalg.slogdet(end.matrix[np.ix_(inside, inside)])[1]
    assert sum(found["growth"][-1, 1:]) == pytest.approx(volume, abs=1e-9)


@pytest.mark.parametrize("name", ("mathieu", "steep"))
def test_steps_of_laws_that_vary_fast_are_taken_in_pieces(name):
    found = totals(SCENES[name])
    assert found["tangent_pieces"] > found["steps"]


@pytest.mark.parametrize("first", (0, pytest.param(10, marks=pytest.mark.slow)))
def test_random_scenes(first):
    columns = 0
    for seed in range(first, first + 10):
        with suppress(EngineError):  # at a singular formula, say
            columns += assert_derivative(replace(formula_scene(seed), t_end=0.1))[0]
    assert columns > 10


def test_one_run_carries_disturbances_of_scenes_that_differ_in_numbers():
    """The frequency of a force, and the gap of a stop beside a formula."""
    walled = DUFFING + WALL
    for text, changes in ((DUFFING, {"f.omega": "1.7 rad/s"}), (walled, {"wall.gap": "0.25 m"})):
        first, other = scene_of(text), scene_of(text, changes)
        of_first = Carrier(first)
        assert_same(of_first, Carrier(first), start_components(first), first.t_end)
        assert_same(of_first.of(other), Carrier(other), start_components(other), other.t_end)
        assert_same(of_first, Carrier(first), [0.4, -0.3], first.t_end)


def assert_same(one, other, start, end):
    """Two carriers come to the same, bit for bit."""
    one, other = one.carry(start, end), other.carry(start, end)
    for name in ("state", "rate", "vectors", "happened", "table"):
        assert getattr(one, name).tobytes() == getattr(other, name).tobytes(), name
    assert (one.events, one.uncertified, one.margin) == (other.events, other.uncertified, other.margin)


KINKED = 'base: {x: "a*abs(sin(w0*t))", a: 1/30 m, w0: 11 rad/s}\nrun: {t_end: 2 s, every: 20 ms}\n'
ON_SPRING = "bodies: {a: 1 kg}\nlinks: {spring: {between: [a, ground], k: 90 N/m}}\n"
RUBBED = "friction: {f: {between: [a, base], N: 0.4 N, mu: 1}}\n"
STRUCK = """
bodies: {a: 1 kg}
links: {spring: {between: [a, base], force: "k*d + k3*d**3", k: 90 N/m, k3: 1 N/m^3}}
stops: {s: {between: [a, base], gap: 4 mm, acts: compression, k: 900 N/m, c: 2 N s/m, release: force}}
initial: {a: {x: 1 m}}
"""
PLASTIC = "stops: {s: {between: [a, base], gap: 4 mm, acts: compression, law: rigid, e: 0}}\n"
DAMPED = ON_SPRING.replace("}}", "}, damper: {between: [a, base], c: 2 N s/m}}")
ON_KINKED_BASES = {
    "struck": STRUCK + KINKED,
    "struck as it rests": ON_SPRING + PLASTIC + KINKED,
    "rubbed from the start": ON_SPRING
    + RUBBED
    + KINKED.replace("abs(sin(w0*t))", "(sin(w0*t) + sin(w0*t)**2)"),
    "rubbed, the formula is the velocity": DAMPED + RUBBED + KINKED.replace("1/30 m", "1/3 m"),
}


@pytest.mark.parametrize("name", ON_KINKED_BASES)
def test_kinked_bases(name):
    """Disturbances, the ledger, and extremes, within which all samples are."""
    scene = replace(scene_of(ON_KINKED_BASES[name]), base_is_rate="velocity" in name)
    assert len(Carrier(scene).carry(start_components(scene), scene.t_end).events) > 3
    assert assert_derivative(scene, doubles=1e-9)[0] > 0
    trajectory = open_trajectory(replace(scene, every_den=5000), ledger=True, extremes=([(0, GROUND)], 0.0))
    x = np.concatenate([block.samples["x_a"] for block in trajectory.blocks()])
    (least,), (greatest,), _ = trajectory.extremes
    assert least <= x.min() < least + 1e-4 and greatest - 1e-4 < x.max() <= greatest
    assert abs(trajectory.totals["energy_residual"]) < 1e-12


def test_disturbances_over_a_base_by_a_formula_are_those_of_harmonics():
    """The same motion of the base, said in two ways."""
    text = """
bodies: {m: 1 kg}
links: {k: {between: [m, base], k: 90 N/m, c: 0.5 N s/m}}
stops: {s: {between: [m, base], gap: 4 mm, acts: compression, k: 900 N/m, c: 2 N s/m}}
initial: {m: {x: 2 mm, v: 0.1 m/s}}
run: {t_end: 3 s, every: 20 ms}
"""
    said = "base: {a: 1 cm, omega: 1 Hz}", 'base: {x: "2*a*sin(w0*t/2)*cos(w0*t/2)", a: 1 cm, w0: 1 Hz}'
    one, other = (scene_of(text + base) for base in said)
    assert one.base and other.base_formula
    one, other = (Carrier(scene).carry(start_components(scene), 3.0) for scene in (one, other))
    assert len(one.events) == len(other.events) > 5
    assert other.matrix == pytest.approx(one.matrix, abs=1e-12)


def derivatives():
    """A run that waits for the derivatives of its first mode, and these, packed."""
    scene, mode, run = packed(READ)
    return opened(scene, mode), pack_slopes(run.rows_of(0))


READ = scene_of("""
bodies: {a: 1 kg}
links:
  spring: {between: [a, ground], force: "F*(sin(d*t/q) + tanh(v/v0)*d*v/r + abs(d/L - v/v0))",
           F: 1 N, q: 1 m s, v0: 1 m/s, r: 1 m^2/s, L: 1 m}
initial: {a: {x: 1 m}}
run: {t_end: 3 s, every: 20 ms}
""")


def test_no_index_of_a_derivative_reaches_beyond_its_table():
    _, (ints, doubles) = derivatives()
    scene, mode, _ = packed(READ)
    refused = refusals(lambda changed: opened(scene, mode).set_slopes(0, changed, doubles), ints)
    assert refused > 2 * len(ints) // 4


def test_derivatives_are_told_once_and_whole():
    run, (ints, doubles) = derivatives()
    for short in ((ints[:-4], doubles), (ints, doubles[:-8])):
        with pytest.raises(ValueError, match="no derivatives"):
            run.set_slopes(0, *short)
    with pytest.raises(ValueError, match="waits"):
        run.set_slopes(1, ints, doubles)
    run.set_slopes(0, ints, doubles)
    with pytest.raises(ValueError, match="waits"):
        run.set_slopes(0, ints, doubles)


def test_a_law_without_motion_in_it_carries_nothing():
    scene = scene_of("""
bodies: {a: 1 kg}
forces: {f: {on: a, force: "F*atan(t/T)", F: 1 N, T: 1 s}}
run: {t_end: 3 s, every: 20 ms}
""")
    assert Carrier(scene).carry([0.0, 0.0], 3.0).matrix.tolist() == [[1.0, 3.0], [0.0, 1.0]]
