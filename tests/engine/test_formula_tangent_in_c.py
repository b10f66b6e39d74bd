"""Small disturbances through formulas and rotors on bodies in the C engine: equal to the Python engine."""

from array import array
from dataclasses import replace
from math import exp

import numpy as np
import pytest

from tests.engine.random_formulas import formula_scene
from tests.engine.runs import scene_of
from vibsim.engine import _engine
from vibsim.engine.c_engine import CRun
from vibsim.engine.errors import EngineError
from vibsim.engine.flows.closed.modal import pitches
from vibsim.engine.modes.packing import pack_scene, packed_mode
from vibsim.engine.tangent.monodromy import Carrier
from vibsim.engine.tangent.packing_tangent import pack_slopes
from vibsim.engine.tangent.tangent_space import dimension
from vibsim.engine.trajectory import open_trajectory
from vibsim.physics.parts import BASE, GROUND

OF_CARRIED = ("state", "rate", "vectors", "happened", "table")


def start_of(scene):
    """Components of the start of a scene."""
    rotor = (scene.motor.phi, scene.motor.phidot) if scene.motor is not None else ()
    return [*(b.x for b in scene.bodies), *(b.v for b in scene.bodies), *rotor]


def carried(carrier, start, end):
    """What a motion with all unit disturbances comes to, or the sentence with which it fails."""
    try:
        return carrier.carry(start, end)
    except EngineError as error:
        return str(error)


def carried_alike(scene, carriers=None, start=None):
    """What the C engine comes to, which is what Python does."""
    start = start_of(scene) if start is None else start
    carriers = carriers or (Carrier(scene, "c"), Carrier(scene, "python"))
    assert [one.engine for one in carriers] == ["c", "python"]
    fast, slow = (carried(one, start, scene.t_end) for one in carriers)
    if isinstance(fast, str) or isinstance(slow, str):
        assert fast == slow
        return fast
    for name in OF_CARRIED:
        assert getattr(fast, name).tobytes() == getattr(slow, name).tobytes(), name
    assert (fast.events, fast.uncertified, fast.margin) == (slow.events, slow.uncertified, slow.margin)
    return fast


def grown(scene, engine):
    """Totals of a run with all exponents, or the sentence with which it fails."""
    trajectory = open_trajectory(scene, engine, tangent=dimension(scene))
    assert trajectory.engine == engine
    try:
        for _ in trajectory.blocks():
            pass
    except EngineError as error:
        return str(error)
    return trajectory.totals


def grown_alike(scene):
    """Totals of the C engine, which are those of Python."""
    fast, slow = grown(scene, "c"), grown(scene, "python")
    if isinstance(fast, str) or isinstance(slow, str):
        assert fast == slow
        return fast
    assert fast.keys() == slow.keys()
    for name, value in fast.items():
        assert np.asarray(value).tobytes() == np.asarray(slow[name]).tobytes(), name
    return fast


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


@pytest.mark.parametrize("name", SCENES)
def test_disturbances_are_carried_as_in_python(name):
    told = carried_alike(SCENES[name])
    assert np.isfinite(told.vectors).all() and np.isfinite(told.rate).all()


@pytest.mark.parametrize("name", SCENES)
def test_exponents_are_those_of_python(name):
    totals = grown_alike(SCENES[name])
    assert np.isfinite(totals["exponents"]).any()


def test_what_happens_on_the_way_is_met():
    """The scenes are not empty: contacts, turns of switches, ends of sticking, pieces within steps."""
    assert len(carried_alike(SCENES["hertz"]).events) > 3
    assert {"stick_begin", "stick_end"} <= {kind for kind, _ in carried_alike(SCENES["belt"]).events}
    for scene in (SCENES["mathieu"], SCENES["steep"]):
        totals = grown_alike(scene)
        assert totals["tangent_pieces"] > totals["steps"]


# the first of them always, all by `make verify`
FIRSTS = [pytest.param(first, marks=pytest.mark.slow if first >= 10 else ()) for first in range(0, 60, 10)]


@pytest.mark.parametrize("first", FIRSTS)
def test_random_scenes_are_those_of_python(first):
    compared = 0
    for seed in range(first, first + 10):
        scene = replace(formula_scene(seed), t_end=0.1)
        if scene.rotors and scene.rigid_stops:
            continue
        told = carried_alike(scene)
        compared += not isinstance(told, str)
        if seed % 5 == 0:
            grown_alike(scene)
    assert compared > 2


def test_one_run_carries_disturbances_of_scenes_that_differ_in_numbers():
    """The frequency of a force, and the gap of a stop beside a formula."""
    walled = DUFFING + WALL
    for text, changes in ((DUFFING, {"f.omega": "1.7 rad/s"}), (walled, {"wall.gap": "0.25 m"})):
        first, other = scene_of(text), scene_of(text, changes)
        of_first = Carrier(first, "c")
        carried_alike(first, (of_first, Carrier(first, "python")))
        carried_alike(other, (of_first.of(other), Carrier(other, "python")))
        carried_alike(first, (of_first, Carrier(first, "python")), [0.4, -0.3])


def test_a_volume_shrinks_as_liouville_says():
    """det M = exp(-c T) for any law of displacement and time."""
    for scene, factor in ((SCENES["duffing"], exp(-0.1 * 5.0)), (SCENES["mathieu"], exp(-0.1 * 3.0))):
        matrix = Carrier(scene, "c").carry(start_of(scene), scene.t_end).matrix
        assert np.linalg.det(matrix) == pytest.approx(factor, rel=1e-13)


KINKED = 'base: {x: "a*abs(sin(w0*t))", a: 1/30 m, w0: 11 rad/s}\nrun: {t_end: 2 s, every: 20 ms}\n'
ON_SPRING = "bodies: {a: 1 kg}\nlinks: {spring: {between: [a, ground], k: 90 N/m}}\n"
RUBBED = "friction: {f: {between: [a, base], N: 0.4 N, mu: 1}}\n"
ON_KINKED_BASES = {
    "struck": scene_of(
        """
bodies: {a: 1 kg}
links: {spring: {between: [a, base], force: "k*d + k3*d**3", k: 90 N/m, k3: 1 N/m^3}}
stops: {s: {between: [a, base], gap: 4 mm, acts: compression, k: 900 N/m, c: 2 N s/m, release: force}}
initial: {a: {x: 1 m}}
"""
        + KINKED
    ),
    "struck as it rests": scene_of(
        ON_SPRING
        + "stops: {s: {between: [a, base], gap: 4 mm, acts: compression, law: rigid, e: 0}}\n"
        + KINKED
    ),
    "rubbed from the start": scene_of(
        ON_SPRING + RUBBED + KINKED.replace("abs(sin(w0*t))", "(sin(w0*t) + sin(w0*t)**2)")
    ),
    # the formula is the velocity of the base
    "rubbed, of a base whose velocity is given": replace(
        scene_of(
            ON_SPRING.replace("}}", "}, damper: {between: [a, base], c: 2 N s/m}}")
            + RUBBED
            + KINKED.replace("1/30 m", "1/3 m")
        ),
        base_is_rate=True,
    ),
}


@pytest.mark.parametrize("name", ON_KINKED_BASES)
def test_a_base_by_a_formula_is_that_of_python(name):
    scene = ON_KINKED_BASES[name]
    assert len(carried_alike(scene).events) > 3
    grown_alike(scene)
    pairs = [(0, GROUND if scene.base_is_rate else BASE)], 0.5
    fast, slow = (open_trajectory(scene, engine, ledger=True, extremes=pairs) for engine in ("c", "python"))
    for one in (fast, slow):
        assert len(list(one.blocks())) > 0
    assert fast.extremes == slow.extremes
    assert fast.totals == slow.totals
    assert abs(fast.totals["energy_residual"]) < 1e-12


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
    one, other = (Carrier(scene, "c").carry(start_of(scene), 3.0) for scene in (one, other))
    assert len(one.events) == len(other.events) > 5
    assert other.matrix == pytest.approx(one.matrix, abs=1e-12)


def derivatives():
    """A run that waits for the derivatives of a mode, and these, packed."""
    scene = scene_of("""
bodies: {a: 1 kg}
links:
  spring: {between: [a, ground], force: "F*(sin(d*t/q) + tanh(v/v0)*d*v/r + abs(d/L - v/v0))",
           F: 1 N, q: 1 m s, v0: 1 m/s, r: 1 m^2/s, L: 1 m}
initial: {a: {x: 1 m}}
run: {t_end: 3 s, every: 20 ms}
""")
    of = CRun(scene)
    packed = pack_scene(scene, pitches(scene)), packed_mode(of.rows_of(0), dict(of.keys)).packed
    run = _engine.Run(*packed[0])
    run.add_mode(*packed[1])
    return run, pack_slopes(of.rows_of(0))


def test_no_index_of_a_derivative_reaches_beyond_its_table():
    """Each whole number in turn is far out: it is refused, or what it says does no harm."""
    _, (ints, doubles) = derivatives()
    refused = 0
    for place in range(len(ints) // 4):
        for value in (2**31 - 1, 10**6, -(10**6), -(2**31)):
            values = array("i", ints)
            values[place] = value
            run, _ = derivatives()
            try:
                run.set_slopes(0, values.tobytes(), doubles)
            except (ValueError, MemoryError):
                refused += 1
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
    assert carried_alike(scene).matrix.tolist() == [[1.0, 3.0], [0.0, 1.0]]
