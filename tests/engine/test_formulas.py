"""Scenes with formulas against closed forms, other solvers, difference quotients and their own ledgers."""

from math import cos, pi

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import vibsim
from tests.engine.many_digits import exact_parts, truth
from tests.engine.runs import run, same_bits, scene_of, whole
from tests.engine.test_operations import judged
from vibsim.engine.errors import EngineError
from vibsim.engine.trajectory import open_trajectory
from vibsim.physics.parts import EVENT_NAMES
from vibsim.results.columns import states_at

HYSTERETIC = """
bodies: {a: 1 kg}
links: {s: {between: [a, ground], force: "k*d + k*z", k: 200 N/m}}
states: {z: {rate: "v_a - (be*abs(v_a)*z + ga*v_a*abs(z))/u", start: 0 m, be: 0.6, ga: 0.4, u: 10 mm}}
forces: {f: {on: a, force: "A*sin(w*t)", A: 8 N, w: 2.2 Hz}}
initial: {a: {x: 1 mm}}
run: {t_end: 2 s, every: 10 ms}
"""


def test_a_state_in_a_link_is_in_the_ledgers_and_as_in_forty_digits():
    judged(scene_of(HYSTERETIC), 1e-11)


def solved(rates, end, start, **options):
    """The motion by another solver, from zero to `end` [s]."""
    return solve_ivp(rates, (0, end), start, "DOP853", **{"rtol": 1e-12, "atol": 1e-14, **options})


def test_a_contact_that_fits_into_one_step_is_felt():
    events = run(
        scene_of("""
bodies: {a: 1 kg}
stops: {s: {between: [a, ground], gap: 1 mm, acts: compression, force: "K*p**1.5", K: 9e4 N/m^1.5}}
forces: {w: {on: a, F0: -7 N}}
initial: {a: {x: 0.9865 mm, v: 0.017 m/s}}
run: {t_end: 10 ms, every: 1 ms}
""")
    ).events

    def rates(_t, y):
        return [y[1], -7 - 9e4 * max(y[0], 0.0) ** 1.5]

    def depth(_t, y):
        return y[0]

    depth.terminal, depth.direction = True, -1
    one = solved(rates, 0.01, [0.0, 0.01], events=depth, atol=1e-16, max_step=1e-5)
    assert abs(events["t"][2] - events["t"][1] - one.t[-1]) < 1e-10


def test_a_dead_zone_that_ends_where_a_stop_begins_is_felt_at_once():
    """The switch of the spring and the contact come at one instant; the stop keeps the depth above zero."""
    scene = scene_of("""
bodies: {a: 0.75 kg}
links: {l: {between: [a, ground], force: "k*max(d - d0, 0)", k: 500 N/m, d0: 10.3 mm}}
stops: {s: {between: [a, ground], gap: 10.3 mm, acts: compression, force: "K*p", K: 15700 N/m}}
initial: {a: {v: 0.2 m/s}}
run: {t_end: 0.2 s, every: 1 ms}
""")
    result = run(scene)
    samples, events = result.samples, result.events
    duration = pi * (0.75 / 16200) ** 0.5  # of half a vibration on both springs
    assert np.abs(events["t"][1:3] - [0.0515, 0.0515 + duration]).max() < 1e-14
    assert abs(samples["v_a"][-1] + 0.2) < 1e-14


@pytest.mark.parametrize("gap", [0, 1])
def test_a_stop_lets_go_where_what_all_terms_beside_the_depth_say(gap):
    """K p^2 + c p p' is p (K p + c p'): contact ends at K p + c p' = 0, and not at depth 0 a second time."""
    text = """
name: sum
bodies: {a: 1 kg}
stops: {s: {between: [a, ground], gap: GAP mm, acts: compression, release: force, force: "FORCE",
  K: 1.5e6 N/m^2, c: 60 N s/m^2}}
forces: {f: {on: a, A: 20 N, omega: 4 Hz, F0: 6 N}}
run: {t_end: 2 s, every: 10 ms}
""".replace("GAP", str(gap))
    told, product = (
        vibsim.simulate(text.replace("FORCE", force), trust=False)
        for force in ("K*p**2 + c*p*pv", "p*(K*p + c*pv)")
    )
    assert list(told.events.words("kind")) == list(product.events.words("kind"))
    np.testing.assert_allclose(told.events["t"], product.events["t"], rtol=0, atol=1e-12)
    assert told.attrs["uncertified"] == 0 < (told.events.words("kind") == "contact_end").sum()


@pytest.mark.parametrize("gap", [1.9375, 2.0, 2.9])
@pytest.mark.parametrize(
    ("force", "numbers"),
    [
        ("K*p**1.5 + c*p*pv", "K: 3e5 N/m^1.5, c: 2 kN s/m^2"),
        ("K*p*sqrt(p) + c*sqrt(p)*pv + k*p", "K: 3e5 N/m^1.5, c: 50 N s/m^1.5, k: 1e3 N/m"),
        ("K*p**1.5 + c*p**0.25*pv", "K: 3e5 N/m^1.5, c: 20 N s/m^1.25"),
    ],
)
def test_a_contact_of_powers_lets_go_by_force_whatever_rounding_makes_of_its_depth(force, numbers, gap):
    """What is left of the force beside the depth has a root."""
    text = f"""
name: pad
bodies: {{a: 8 g}}
links: {{l: {{between: [a, ground], k: 300 N/m}}}}
stops:
  s: {{between: [a, ground], gap: {gap} mm, acts: compression, release: force, force: "{force}", {numbers}}}
initial: {{a: {{v: 2 m/s}}}}
run: {{t_end: 6 ms, every: 0.1 ms}}
"""
    result = vibsim.simulate(text)
    code = compile(force.replace("K", "3e5").replace("k*", "1e3*"), "force", "eval")
    c = 2e3 if "c*p*pv" in force else 50.0 if "sqrt" in force else 20.0

    def rates(t, y):
        p, pv = max(y[0] - gap / 1e3, 0.0), y[1]
        return [pv, (-300 * y[0] - max(eval(code, {"p": p, "pv": pv, "c": c, "sqrt": np.sqrt}), 0.0)) / 8e-3]

    one = solved(rates, 6e-3, [0, 2], rtol=1e-10, atol=1e-13, max_step=1e-5)
    assert abs(result["x_a"][-1] - one.y[0, -1]) < 1e-9
    assert result.attrs["uncertified"] == 0 and result.trust_horizon == 6e-3


@pytest.mark.parametrize(
    "nothing",
    ["(1 N)*max(0, -t/(1 s))", "(1 N)*tanh(max(0, v_a/(1 m/s) - 1))", "(1 N)*where(t < 1 s, 0, 1)"],
)
@pytest.mark.parametrize("force", ["K*p**1.5 + NOTHING", "NOTHING - (-K*p**1.5)"])
def test_a_stop_lets_go_with_its_depth_where_a_term_is_zero_throughout(force, nothing):
    """On its side of a switch the term is 0, and the force is what it is without it."""
    text = """
name: pad
bodies: {a: 1 kg}
links: {l: {between: [a, ground], k: 100 N/m}}
stops: {s: {between: [a, ground], gap: 5.59 mm, acts: compression, release: force, force: "FORCE",
  K: 1000 N/m^1.5}}
initial: {a: {v: 0.3 m/s}}
run: {t_end: 0.3 s, every: 10 ms}
"""
    alone = vibsim.simulate(text.replace("FORCE", "K*p**1.5"), trust=False)
    summed = text.replace("FORCE", force.replace("NOTHING", nothing))
    for digits in (None, 20, 40):
        result = vibsim.simulate(summed, trust=False, digits=digits)
        assert result.attrs["uncertified"] == 0
        assert list(result.events.words("kind")) == list(alone.events.words("kind"))
        np.testing.assert_allclose(result.events["t"], alone.events["t"], rtol=0, atol=1e-15)


@pytest.mark.parametrize("digits", [None, 30])
@pytest.mark.parametrize(
    ("force", "load", "plain"),
    [
        ("A*max(0, max(0, cos(w*t)))", "sin((5 1/s)*t)", "A*max(0, cos(w*t))"),
        ("A*abs(max(cos(w*t), 0))", "sin((5 1/s)*t)", "A*max(0, cos(w*t))"),
        ("A*abs(mod(w*t, 1))", "sin((5 1/s)*t)", "A*mod(w*t, 1)"),
        ("A*max(0, 2*abs(cos(w*t)))", "sin((5 1/s)*t)", "A*2*abs(cos(w*t))"),
        ("A*cos(w*t)", "max(0, sin((5 1/s)*t))", "A*cos(w*t)"),
    ],
)
def test_nobody_asks_for_the_sign_of_what_is_never_negative(force, load, plain, digits):
    """N of a friction is max(0, N) in any case."""
    text = """
name: twice
bodies: {a: 1 kg}
links: {l: {between: [a, ground], k: 100 N/m}}
friction: {f: {between: [a, ground], N: "(1 N)*LOAD", mu: 0.2}}
forces: {f1: {on: a, force: "FORCE", A: 1 N, w: 1.1 Hz}}
initial: {a: {v: 0.1 m/s}}
run: {t_end: 2 s, every: 10 ms}
"""
    twice, once = (
        vibsim.simulate(text.replace("LOAD", N).replace("FORCE", F), trust=False, digits=digits)
        for F, N in ((force, load), (plain, "sin((5 1/s)*t)"))
    )
    assert twice.attrs["uncertified"] == 0 < twice.attrs["events"]
    np.testing.assert_allclose(twice.events["t"], once.events["t"], rtol=0, atol=1e-14)
    np.testing.assert_allclose(twice["x_a"], once["x_a"], rtol=0, atol=1e-15)


def test_in_many_digits_a_contact_of_powers_ends_behind_the_force_that_let_go():
    """The force that has let go is no force until depth 0: nobody asks for its series there."""
    text = """
name: beads
bodies: {a: 10 g, b: 20 g}
stops: {s: {between: [a, b], gap: 0 mm, acts: compression, release: force,
  force: "K*p**1.5 + D*p**0.5*pv", K: 5e7 N/m^1.5, D: 400 N s/m^1.5}}
initial: {a: {x: -0.1 mm, v: 1 m/s}}
run: {t_end: 2 ms, every: 20 us}
"""
    doubles, words = (vibsim.simulate(text, digits=digits, trust=False) for digits in (None, 30))
    assert list(words.events.words("kind")) == list(doubles.events.words("kind"))
    np.testing.assert_allclose(words.events["t"], doubles.events["t"], rtol=0, atol=1e-16)
    np.testing.assert_allclose(words["v_a"] + 2 * words["v_b"], 1, rtol=0, atol=4e-16)
    assert abs(words["v_a"][-1] - doubles["v_a"][-1]) < 1e-13


SLIDERS = """
name: sliders
bodies: {m: 1 kg}
links: {s: {between: [m, ground], force: "k0*d + k1*z1 + k2*z2", k0: 50 N/m, k1: 200 N/m, k2: 300 N/m}}
states:
  z1: {rate: "where(abs(z1) < d1, v_m, where(v_m*z1 < 0, v_m, 0*v_m))", d1: 5 mm, start: 0 m}
  z2: {rate: "where(abs(z2) < d2, v_m, where(v_m*z2 < 0, v_m, 0*v_m))", d2: 12 mm, start: 0 m}
forces: {f: {on: m, A: AMPLITUDE N, omega: FREQUENCY Hz}}
run: {t_end: 2.8 s, every: 0.5 ms}
"""


@pytest.mark.parametrize(
    ("A", "f"), [(11.841789979433328, 2.6810194135920047), (8.606115254007317, 2.3544674731518236)]
)
def test_elements_that_rest_at_their_limits_leave_each_other_there(A, f):
    """Iwan's model: each element is a play; the body's momentum is the sum of the forces on it."""
    result = vibsim.simulate(SLIDERS.replace("AMPLITUDE", repr(A)).replace("FREQUENCY", repr(f)))
    t, x, v, z1, z2 = (result[name] for name in ("time", "x_m", "v_m", "z1", "z2"))
    for z, limit in ((z1, 0.005), (z2, 0.012)):
        play = 0.0
        for n in range(1, len(t)):
            play = min(max(play + x[n] - x[n - 1], -limit), limit)
            assert abs(z[n] - play) < 2e-6  # of a reversal between two samples
        assert np.abs(z).max() < limit + 1e-14
    force = A * np.sin(2 * pi * f * t) - 50 * x - 200 * z1 - 300 * z2
    assert abs(np.sum(force[1:] + force[:-1]) * (t[1] - t[0]) / 2 - v[-1]) < 1e-4  # of trapezia
    assert result.doubts
    for doubt in result.doubts:  # where both leave at one reversal; none of an element that rests
        assert abs(result.at(doubt.time)["v_m"]) < 1e-12


CHOSEN = """
name: chosen
bodies: {a: 1 kg, c: 1 kg}
links: {s: {between: [a, ground], k: 100 N/m, c: 0.3 N s/m}}
forces: {f: {on: a, force: "A*(FORMULA)", A: 2 N, d: 20 mm}}
initial: {a: {v: 1 m/s}, c: {x: START}}
run: {t_end: 3 s, every: 10 ms}
"""


@pytest.mark.parametrize(
    ("formula", "start", "certain"),
    [
        ("step(where(x_a < d, x_c, -x_a))", "0 mm", True),
        ("step(-3*step(x_a - d))", "0 mm", True),
        ("step(where(x_a < d, x_c - 1 mm, -x_a))", "1 mm", False),
    ],
)
@pytest.mark.parametrize("digits", [None, 30])
def test_a_choice_that_comes_to_zero_by_another_one_is_on_its_upper_side(formula, start, certain, digits):
    """Behind d the inner choice is below zero, before it zero for good: the outer one stayed below."""
    text = CHOSEN.replace("START", start)
    result, plain = (
        vibsim.simulate(text.replace("FORMULA", one), digits=digits)
        for one in (formula, "where(x_a < d, 1, 0)")
    )
    assert np.abs(result["x_a"] - plain["x_a"]).max() < 1e-13
    assert len(result.events["t"]) == len(plain.events["t"]) > 10
    assert (result.attrs["uncertified"] == 0) == certain


@pytest.mark.parametrize(
    ("rest", "digits", "certain", "pushed"),
    [
        ("1", None, False, True),
        ("1.00000000000000000001", None, False, True),
        ("1.00000000000000000001", 30, True, False),
        ("0.99999999999999999999", 30, True, True),
    ],
)
def test_a_choice_that_rounding_leaves_open_at_the_start_is_in_doubt(rest, digits, certain, pushed):
    """c rests 1e-23 m before or behind the place that the choice is about."""
    text = CHOSEN.replace("START", "1 mm").replace(", d: 20 mm", "")
    result = vibsim.simulate(text.replace("FORMULA", f"step(x_c - {rest} mm)"), digits=digits)
    assert (result.attrs["uncertified"] == 0) == certain
    assert (abs(result["x_a"].mean() - 0.02) < 0.01) == pushed


@pytest.mark.parametrize("power", [2, 3, 4, 5])
def test_a_force_that_rounds_to_zero_soon_after_the_start_presses_on_a_contact(power):
    """1 - cos(w t) is 0 in doubles until 5 ns: its powers had no rounding bound there."""
    text = f"""
name: soft
bodies: {{a: 1 kg}}
stops: {{s: {{between: [a, ground], gap: 0 m, acts: compression, force: "K*p**1.5", K: 1e5 N/m^1.5}}}}
forces: {{f: {{on: a, force: "F*(1 - cos(w*t))**{power}", F: 1 N, w: 3 rad/s}}}}
run: {{t_end: 1 s, every: 20 ms}}
"""
    result = vibsim.simulate(text)

    def rates(t, y):
        return [y[1], (1 - cos(3 * t)) ** power - 1e5 * max(y[0], 0.0) ** 1.5]

    one = solve_ivp(
        rates, (0, 1), [0, 0], "DOP853", t_eval=result.time, rtol=1e-12, atol=1e-18, max_step=1e-3
    )
    assert np.abs(result["x_a"] - one.y[0]).max() < 1e-10


def test_a_contact_that_begins_at_rest_and_fits_into_one_step_is_felt():
    """A body at rest at Hertz's wall is pressed against it: neither end of the first step shows it."""
    run = vibsim.simulate(
        """
name: hertz
bodies: {a: 1 kg}
stops: {s: {between: [a, ground], gap: 0 mm, acts: compression, force: "K*p**1.5", K: 3e4 N/m^1.5}}
forces: {f: {on: a, force: "A - B*t", A: 1 mN, B: 50 mN/s}}
run: {t_end: 100 ms, every: 5 ms}
"""
    )

    def rates(t, y):
        return [y[1], 1e-3 - 0.05 * t - 3e4 * max(y[0], 0.0) ** 1.5]

    one = solved(rates, 0.1, [0, 0], t_eval=run.time, atol=1e-18, max_step=2e-4)
    assert np.abs(run["x_a"] - one.y[0]).max() < 1e-13
    assert run.attrs["uncertified"] == 0


def test_a_contact_begins_nearer_to_zero_than_series_of_its_power_can_be_written():
    """Soon after t = 0 time is resolved more finely than the depth is known: it began 1e-20 s late."""
    text = """
name: soon
bodies: {a: 1.703 kg, b: 0.3055 kg}
links: {la: {between: [a, ground], k: 4.085 N/m}, lb: {between: [b, a], k: 10.18 N/m, c: 0.0176 N s/m}}
stops: {s: {between: [b, ground], gap: GAP m, acts: extension, force: "K*p**1.5", K: 3630 N/m^1.5}}
forces: {f: {on: b, A: 0.0323 N, omega: 11.98831756609865 rad/s, F0: 0.0113 N}}
initial: {a: {x: -1.6 mm}}
run: {t_end: 0.2 s, every: 10 ms}
"""
    begun, touching = (vibsim.simulate(text.replace("GAP", gap)) for gap in ("1e-12", "0"))
    assert list(begun.events.words("kind")) == ["start", "contact_begin", "contact_end", "end"]
    assert np.abs(begun["x_b"] - touching["x_b"]).max() < 1e-11


@pytest.mark.parametrize(
    ("force", "numbers", "reason", "when"),
    [
        ("-k*sqrt(x_a)", "k: 3 N/m^0.5", "domain", None),
        ("-q/x_a", "q: 1 N m", "singular", (pi / 2) ** 0.5),
        ("k*x_a**3", "k: 1 N/m^3", "singular", 1.8540746773013719),
        ("-F*sign(v_a) - k*x_a", "F: 0.3 N, k: 1 N/m", "held", 2 * pi),
    ],
)
def test_where_a_formula_has_no_value_or_holds_the_motion_the_run_says_so(force, numbers, reason, when):
    scene = scene_of(f"""
bodies: {{a: 1 kg}}
forces: {{pull: {{on: a, force: "{force}", {numbers}}}}}
initial: {{a: {{x: 1 m}}}}
run: {{t_end: 20 s, every: 10 ms}}
""")
    for go in (run, lambda of: truth(exact_parts(of), 25)):
        with pytest.raises(EngineError, match="pull") as raised:
            go(scene)
        assert raised.value.reason == reason
        if when is not None:
            assert abs(raised.value.state.t - when) < 1e-6


CLUTCH = """
bodies: {a: 1 kg m^2, b: 2 kg m^2}
friction: {clutch: {between: [a, b], N: "A*sin(w*t)", mu: 0.3, static: STATIC, A: 3 N m, w: 3 Hz}}
initial: {a: {v: 0.1 rad/s}}
run: {t_end: 0.9 s, every: 50 ms}
"""
CARRIED = """
bodies: {block: 1 kg, foot: 1 kg}
links: {s: {between: [foot, ground], k: 100 N/m}}
friction: {floor: {between: [block, ground], N: "k*x_foot", mu: 0.3, k: 300 N/m}}
initial: {foot: {x: 1 cm}}
run: {t_end: 2.5 s, every: 50 ms}
"""


@pytest.mark.parametrize("static", [1, 1.4])
@pytest.mark.parametrize("digits", [None, 30])
def test_a_clutch_without_torque_opens_and_closes(static, digits):
    """It slips until its torque has taken the difference in speed: 1.35 (1 - cos w t)/w = 0.1 in SI units.

    Its release and the switch of its load are at one instant. Of these rounding tells which is first, so that
    in many digits it may stay closed where it bears nothing.
    """
    case = CLUTCH.replace("STATIC", str(static))
    result = vibsim.simulate(case, digits=digits)
    caught = np.arccos(1 - 0.1 * 6 * pi / 1.35) / (6 * pi)
    kinds = [EVENT_NAMES[kind] for kind in result.events["kind"][1:-1]]
    assert kinds == (["stick_begin", "stick_end"] * 3)[: len(kinds)] and (digits or len(kinds) == 6)
    expected = [caught, *np.arange(1, 6) / 6]
    assert all(min(abs(t - each) for each in expected) < 1e-13 for t in result.events["t"][1:-1])
    assert abs(result.events["t"][1] - caught) < 1e-13
    np.testing.assert_allclose([result["v_a"][-1], result["v_b"][-1]], 0.1 / 3, rtol=1e-14)


def test_a_load_that_another_body_brings_back_finds_what_rests():
    result = vibsim.simulate(CARRIED)
    kinds = [EVENT_NAMES[kind] for kind in result.events["kind"][1:-1]]
    assert kinds == (["stick_end", "stick_begin"] * 4)[: len(kinds)]
    times = (np.arange(len(kinds)) + 0.5) * pi / 10
    np.testing.assert_allclose(result.events["t"][1:-1], times, rtol=0, atol=1e-13)
    assert len(kinds) == 8 and not result["x_block"].any()


PRESSED = """
bodies: {slider: 1 kg, roller: 1 kg}
links: {spring: {between: [slider, ground], k: 50 N/m}}
stops: {floor: {between: [roller, ground], law: elastic, gap: 0 m, acts: extension, k: 10 kN/m, c: 5 N s/m}}
forces: {shake: {on: roller, F0: -9.81 N, A: 12 N, omega: 4 Hz}}
friction: {rub: {between: [slider, ground], N: "LOAD", k: 10 kN/m, mu: 0.4, belt: 0.2 m/s}}
run: {t_end: 1 s, every: 50 ms}
"""


@pytest.mark.parametrize("load", ["-k*x_roller", "max(0, -k*x_roller)", "k*(abs(x_roller) - x_roller)/2"])
def test_a_load_that_a_contact_makes_goes_with_it(load):
    """The switch of the load turns as contact begins and ends, and in between its side is no question."""
    result = vibsim.simulate(PRESSED.replace("LOAD", load))
    kinds = [EVENT_NAMES[kind] for kind in result.events["kind"][1:-1]]
    assert result.attrs["uncertified"] == 0 and kinds.count("contact_end") > 3
    expected = vibsim.simulate(PRESSED.replace("LOAD", "-k*x_roller"))
    np.testing.assert_allclose(result.events["t"], expected.events["t"], rtol=0, atol=1e-13)


@pytest.mark.parametrize(
    ("force", "factor"),
    [
        ("F*step(x_a/L)", 0),
        ("F*min(1, step(x_a/L))", 0),
        ("F*where(step(x_a/L) < 1, 0, 1)", 0),
        ("F*abs(step(x_a/L) - 1)", 1),
        ("F*max(step(x_a/L), step(-2*x_a/L) - 0.5)", 0.5),
    ],
)
def test_a_choice_behind_one_that_is_at_its_zero_at_the_start_takes_its_side_by_it(force, factor):
    """The body leaves x = 0 backwards: step(x) is 0 from there, and what reads it is on its side for that."""
    events = run(
        scene_of(f"""
bodies: {{a: 1 kg}}
forces: {{f: {{on: a, force: "{force}", F: 1 N, L: 1 m}}}}
initial: {{a: {{v: -2 m/s}}}}
run: {{t_end: 1 s, every: 100 ms}}
""")
    ).events
    assert abs(events["v_a"][-1] - (factor - 2)) < 1e-15


BENT_BY_VELOCITY = """
name: bent
bodies: {a: 1 kg}
links: {s: {between: [a, ground], k: 100 N/m}}
stops: {r: {between: [a, ground], gap: 5 mm, acts: compression, law: rigid, e: 0.8}}
friction: {f: {between: [a, ground], N: 1 N, mu: "0.1 + 0.2*exp(-s/vs)", vs: 10 mm/s}}
forces: {f0: {on: a, force: "FORCE", F: 1 N, V: 0.1 m/s}}
initial: {a: {v: 1 m/s}}
run: {t_end: 1 s, every: 10 ms}
"""


def test_an_impact_turns_a_switch_whatever_the_law_of_friction_before_it_says_behind():
    """exp(-s/vs) with the slip of before is 1e34 behind the impact: no measure of what rounding may do."""
    bent, smooth = (
        vibsim.simulate(BENT_BY_VELOCITY.replace("FORCE", force))
        for force in ("F*max(-1, min(1, v_a/V))", "F*sign(v_a)*min(1, abs(v_a)/V)")
    )
    assert bent.attrs["uncertified"] == 0 < bent.attrs["impacts"]
    assert np.abs(bent["x_a"] - smooth["x_a"]).max() < 1e-12


ON_A_BASE = """
bodies: {a: 1 kg}
links: {s: {between: [a, base], force: "k*d + q*v*abs(v)", k: 100 N/m, q: 3 N s^2/m^2}}
base: {x: "20 mm*BASE"}
run: {t_end: T_END, every: 50 ms}
"""


@pytest.mark.parametrize(
    ("base", "plain"),
    [
        ("max(0, sin(1 Hz*t))", "sin(1 Hz*t)"),
        ("min(0, -sin(1 Hz*t))", "(-sin(1 Hz*t))"),
        ("mod(-1 1/s*t, 1)", "(1 - 1 1/s*t)"),
        ("table(-1 1/s*t, [[-1, 1], [0, 0], [1, 4]], 'linear')", "(1 1/s*t)"),
    ],
)
def test_a_base_with_a_kink_at_the_start_moves_as_behind_it(base, plain):
    """v = v_a - v_base is what the base begins with; with the velocity of before the run was held."""
    bent, smooth = (
        run(scene_of(ON_A_BASE.replace("BASE", one).replace("T_END", "0.45 s"))).samples["x_a"]
        for one in (base, plain)
    )
    assert np.abs(bent - smooth).max() < 1e-15


def test_a_run_does_not_go_on_beyond_a_kink_of_the_base_at_its_end():
    """A kink is met where rounding says; the state was recorded one unit in the last place late."""
    text = ON_A_BASE.replace("BASE", "abs(sin(1 Hz*t))").replace("T_END", "3 s")
    events = run(scene_of(text + "friction: {f: {between: [a, base], N: 1 N, mu: 0.3}}")).events
    assert events["t"][-1] == 3.0


@pytest.mark.parametrize("gap", ["0 m", "1 mm"])
@pytest.mark.parametrize("sense", [1, -1])
def test_a_remainder_that_a_contact_holds_on_its_side_turns_as_that_begins(gap, sense):
    """Both are at zero at once: the mode in contact has no event function of the remainder there."""
    text = f"""
bodies: {{a: 1 kg}}
stops: {{s: {{between: [a, ground], gap: {gap}, acts: compression, k: 16 kN/m, c: 4 N s/m}}}}
forces: {{f: {{on: a, force: "1 N*FORCE"}}}}
initial: {{a: {{x: -10 mm, v: 0.1 m/s}}}}
run: {{t_end: 0.15 s, every: 1 ms}}
"""
    place = f"{sense}*(x_a - {gap})/(100 mm)"
    below = place if sense < 0 else f"1 + {place}"
    above = f"1 + {place}" if sense < 0 else place
    remainder, choice = (
        run(scene_of(text.replace("FORCE", force)))
        for force in (f"mod({place}, 1)", f"where(x_a < {gap}, {below}, {above})")
    )
    assert [kind for kind in remainder.kinds if kind != "switch"] == ["contact_begin", "contact_end"]
    for name in ("x_a", "v_a"):
        assert np.abs(remainder.samples[name] - choice.samples[name]).max() < 1e-13


@pytest.mark.parametrize(
    ("force", "load", "v"),
    [("-1 N*sign(v_a/V)", "10 N", "0.89 m/s"), ("-1 N*step(v_a/V)", "5 N", "0.81 m/s")],
)
def test_a_friction_holds_what_comes_to_rest_at_a_switch(force, load, v):
    """The velocity is zero for both at once; where rounding put the switch first the run was held there."""
    text = f"""
bodies: {{a: 1 kg}}
links: {{s: {{between: [a, ground], k: 100 N/m, c: 0.1 N s/m}}}}
friction: {{f: {{between: [a, ground], N: {load}, mu: 0.3}}}}
forces: {{f0: {{on: a, force: "{force}", V: UNIT}}}}
initial: {{a: {{v: {v}}}}}
run: {{t_end: 5 s, every: 100 ms}}
"""
    ends = [run(scene_of(text.replace("UNIT", V))).final("x_a") for V in ("20 mm/s", "1 m/s", "0.3 m/s")]
    assert np.ptp(ends) < 1e-12 < abs(ends[0])


@pytest.mark.parametrize(
    ("force", "start", "reason"),
    [
        ("-1 N*sign(v_a) - 100 N/m*x_a", "x: 30 mm, v: 0.5 m/s", "held"),
        ("1 N*sqrt(1 - x_a/(1 m)) + 1 N", "x: 0 m", "domain"),
        ("-1 N m^2/x_a**2", "x: 1 m", "singular"),
    ],
)
def test_a_run_that_fails_keeps_what_came_before(force, start, reason):
    """Where Python decides that it fails, as of "held", all since the last block was lost."""
    scene = scene_of(f"""
bodies: {{a: 1 kg}}
forces: {{f: {{on: a, force: "{force}"}}}}
initial: {{a: {{{start}}}}}
run: {{t_end: 9 s, every: 10 ms}}
""")
    blocks, trajectory = [], open_trajectory(scene)
    with pytest.raises(EngineError) as failure:
        for block in trajectory.blocks():
            blocks.append(block)
    samples, events = (whole([getattr(block, name) for block in blocks]) for name in ("samples", "events"))
    end = failure.value.state
    assert failure.value.reason == reason and end.t - 0.01 <= samples["time"][-1] <= end.t
    states = states_at(scene, events, samples["time"], end.t)
    assert all(same_bits(states[name], values) for name, values in samples.items())
    assert states_at(scene, events, end.t, end.t)["x_a"] == end.x[0]
    with pytest.raises(EngineError):
        open_trajectory(scene).state_at([end.t / 2, end.t, end.t + 1])
