"""Belts whose velocity is a formula, between bodies, beside a base, several that differ; kinks of a base."""

from math import cos, exp, sin

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tests.engine.bundles import assert_derivative
from tests.engine.runs import run, scene_of
from vibsim import simulate
from vibsim.cases.case import load_case_text
from vibsim.engine.errors import EngineError
from vibsim.engine.truth import open_truth
from vibsim.physics.parts import EVENT_KINDS

# A load rides on a cart whose surface moves to and fro, and the cart on a floor that moves otherwise, held by
# a spring at a base that shakes.
TWO_BELTS = """\
name: two belts
bodies: {cart: 1 kg, load: 0.4 kg}
links: {spring: {between: [cart, base], k: 100 N/m, c: 0.3 N s/m}}
friction:
  top: {between: [load, cart], N: 3 N, mu: 0.25, static: 1.2, belt: "u*sin(wb*t)", u: 0.3 m/s, wb: 2 rad/s}
  floor: {between: [cart, ground], N: 5 N, mu: "m0 + m1*exp(-s/vs)", m0: 0.05, m1: 0.1, vs: 0.1 m/s,
          belt: "b*cos(wb*t)", b: 0.1 m/s, wb: 1.3 rad/s}
base: {a: 40 mm, omega: 7 rad/s}
run: {t_end: 2.5 s, every: 10 ms}
"""
BODIES = ("cart", "load")
HELD, SLIPS = 3 * 0.25 * 1.2, 3 * 0.25  # by the load [N]


def case_of(text, **changes):
    for old, new in changes.items():
        text = text.replace(old, new)
    return load_case_text(text, name="belts")


def events_of(run):
    kinds = {number: name for name, number in EVENT_KINDS.items()}
    return [(float(t), kinds[int(kind)]) for t, kind in zip(run.events["t"], run.events["kind"], strict=True)]


def belt(t):
    return 0.3 * sin(2 * t), 0.6 * cos(2 * t)


def floor(t):
    return 0.1 * cos(1.3 * t)


def pull_on_cart(t, y, sense):
    """Force on the cart but for that of the load [N]; sense: of its sliding on the floor."""
    spring = 100 * (y[0] - 0.04 * sin(7 * t)) + 0.3 * (y[2] - 0.28 * cos(7 * t))
    return -spring - sense * 5 * (0.05 + 0.1 * exp(-abs(y[2] - floor(t)) / 0.1))


def second_solution(t_end):
    """The motion of TWO_BELTS while the cart slips on the floor, by equations and switches of its own:
    (state at the end, [(time, whether the load begins to stick)]).
    """
    t, y, sense, load, told = 0.0, np.zeros(4), -1, 0, []  # at 0.6 m/s^2 the belt takes the load along

    def rates(t, y):
        force, (_, du) = pull_on_cart(t, y, sense), belt(t)
        if load:  # slips
            on_load = -load * SLIPS
            return [y[2], y[3], force - on_load, on_load / 0.4]
        a = (force - 0.4 * du) / 1.4  # of both, the load du beyond
        return [y[2], y[3], a, a + du]

    def on_floor(t, y):
        return sense * (y[2] - floor(t))

    def on_belt(t, y):
        return load * (y[3] - y[2] - belt(t)[0]) if load else HELD - abs(0.4 * rates(t, y)[3])

    for event in (on_floor, on_belt):
        event.terminal, event.direction = True, -1
    while True:
        course = solve_ivp(
            rates, (t, t_end), y, "DOP853", events=(on_floor, on_belt), rtol=1e-12, atol=1e-13, max_step=0.01
        )
        t, y = course.t[-1], course.y[:, -1]
        if course.status == 0:
            return y, told
        if len(course.t_events[0]):
            sense = -sense  # what holds is never enough here
        elif load:
            was, load = load, 0
            y[3] = y[2] + belt(t)[0]
            if abs(0.4 * rates(t, y)[3]) > HELD:
                load = -was
            told.append((t, load == 0))
        else:
            load = -1 if rates(t, y)[3] > 0 else 1
            told.append((t, False))
        t, y = t + 1e-10, y + 1e-10 * np.array(rates(t, y))


def test_belts_between_bodies_and_beside_a_base_are_those_of_another_solver():
    run = simulate(case_of(TWO_BELTS))
    end, told = second_solution(2.5)
    ours = [float(run[f"{letter}_{body}"][-1]) for letter in "xv" for body in BODIES]
    assert ours == pytest.approx(end, abs=1e-9)
    assert run.events["top"].tolist().count(0) > 1  # it sticks and slips
    changes = [
        t
        for (t, _), one, other in zip(
            events_of(run)[1:], run.events["top"][:-1], run.events["top"][1:], strict=True
        )
        if one != other
    ]
    assert changes == pytest.approx([t for t, _ in told], abs=1e-9)
    assert abs(run.attrs["energy_residual_relative"]) < 1e-14


def test_a_constant_formula_is_a_number():
    evenly = {'"u*sin(wb*t)", u: 0.3 m/s, wb: 2 rad/s': "0.3 m/s"}
    number = simulate(case_of(TWO_BELTS, **evenly), trust=False)
    formula = simulate(case_of(TWO_BELTS, **{'"u*sin(wb*t)", u: 0.3 m/s, wb: 2 rad/s': '"u", u: 0.3 m/s'}))
    assert [kind for _, kind in events_of(formula)] == [kind for _, kind in events_of(number)]
    for body in BODIES:
        assert formula[f"x_{body}"] == pytest.approx(number[f"x_{body}"], abs=1e-13)


def test_belts_that_agree_carry_a_body_and_those_that_do_not_only_meet():
    """Two floors under one body: of one course they hold it together, of two they let go at once."""
    text = """\
name: floors
bodies: {a: 1 kg, b: 1 kg}
links: {spring: {between: [b, base], k: 10 N/m}}
friction:
  one: {between: [a, ground], N: 4 N, mu: 0.3, belt: "u*sin(w*t)", u: 0.1 m/s, w: 3 rad/s}
  two: {between: [a, ground], N: 2 N, mu: 0.3, belt: COURSE, u: 0.1 m/s, w: 3 rad/s}
  far: {between: [b, a], N: 1 N, mu: 0.1, belt: "u*t", u: 0.01 m/s^2}
base: {a: 1 mm, omega: 1 Hz}
run: {t_end: 1.5 s, every: 0.1 s}
"""
    together = simulate(case_of(text, COURSE='"u*sin(w*t)"'), trust=False)
    t = together["time"]
    assert together["v_a"] == pytest.approx(0.1 * np.sin(3 * t), abs=1e-14)
    assert set(together["one"].tolist()) == set(together["two"].tolist()) == {0}
    apart = simulate(case_of(text, COURSE='"-u*sin(w*t)"'), trust=False)
    assert {tuple(pair) for pair in zip(apart["one"].tolist(), apart["two"].tolist(), strict=True)} >= {
        (0, 1)
    }
    assert apart["v_a"][1:-1] == pytest.approx(0.1 * np.sin(3 * t[1:-1]), abs=1e-14)  # the heavier load wins


JUMP = """\
name: jump
bodies: {a: 1 kg, b: 2 kg}
friction:
  on: {between: [a, b], N: 2 N, mu: 0.25, belt: "where(t < t1, 0, u)", t1: 1 s, u: 0.6 m/s}
  floor: {between: [b, ground], N: 5 N, mu: 0.5}
run: {t_end: 3 s, every: 0.5 s}
"""


def test_a_belt_that_jumps_lets_go_and_catches_again():
    """From 1 s on the body is pulled by 0.5 N until it has the speed of the belt, at 2.2 s."""
    run = simulate(case_of(JUMP), trust=False)
    happened = [(round(t, 12), kind) for t, kind in events_of(run)]
    assert happened[1:] == [(1.0, "switch"), (1.0, "stick_end"), (2.2, "stick_begin"), (3.0, "end")]
    assert run["v_a"].tolist() == pytest.approx([0, 0, 0, 0.25, 0.5, 0.6, 0.6], abs=1e-15)
    assert run["v_b"].tolist() == [0] * 7
    assert run.attrs["work.friction.on"] == pytest.approx(0.5 * 1.2 * 0.6, rel=1e-14)
    assert run.attrs["loss.friction.on"] == pytest.approx(0.5 * (0.6 * 1.2 - 0.36), rel=1e-14)


IMPACTS = """\
name: struck
bodies: {a: 1.3 kg, b: 0.5 kg}
links: {one: {between: [a, base], k: 129 N/m, c: 0.9 N s/m}, two: {between: [b, ground], k: 30 N/m}}
stops: {wall: {between: [a, ground], gap: 5 mm, acts: compression, law: rigid, e: 0.7}}
friction:
  on: {between: [b, base], N: 5 N, mu: 0.3, belt: "u*sin(w*t + ph)", u: 0.04 m/s, w: 4.8 rad/s, ph: 4.9}
  under: {between: [a, ground], N: 2 N, mu: 0.1, belt: "u*sin(w*t)", u: 0.09 m/s, w: 4.8 rad/s}
base: {a: 34 mm, omega: 7.5 rad/s}
run: {t_end: 0.6 s, every: 10 ms}
"""


def test_an_impact_leaves_what_sticks_on_a_belt_elsewhere_as_it_is():
    """It gave all that the base carries the velocity of the base alone."""
    run = simulate(case_of(IMPACTS), trust=False)
    t = run["time"]
    carried = 0.255 * np.cos(7.5 * t) + 0.04 * np.sin(4.8 * t + 4.9)
    stuck = run["on"] == 0
    assert "impact" in dict(map(reversed, events_of(run))) and stuck.sum() > 30
    assert run["v_b"][stuck] == pytest.approx(carried[stuck], abs=1e-14)
    assert abs(run.attrs["energy_residual_relative"]) < 1e-14


@pytest.mark.parametrize(("text", "t_end"), ((TWO_BELTS, 0.75), (IMPACTS, 0.15)), ids=("belts", "impacts"))
def test_disturbances_are_difference_quotients_in_forty_digits(text, t_end):
    """Through sticks, slips and impacts."""
    start = {"cart.x": "1 mm", "load.x": "2 mm", "cart.v": "2 cm/s", "load.v": "5 cm/s"}
    scene = scene_of(text, start if text == TWO_BELTS else {}, t_end=t_end)
    columns, kinds = assert_derivative(scene, doubles=1e-9)
    assert columns >= 3 and len(kinds) > 1


# A base whose velocity jumps, under what sticks to it and what rests on it.


KINK = """\
name: kink
bodies: {a: 1 kg}
PARTS
base: {x: "V*max(t - t1, 0)", V: SPEED, t1: 1 s}
run: {t_end: 3 s, every: 0.5 s}
"""
STICKS = "friction: {on: {between: [a, base], N: 5 N, mu: 0.1}}"
RESTS = """stops: {w: {between: [a, base], gap: 0 mm, acts: extension, law: rigid, e: 0.5}}
forces: {weight: {on: a, F0: -1 N}}"""


@pytest.mark.parametrize(
    ("parts", "speed", "told", "velocities"),
    (
        (STICKS, 0.2, [(1, "switch"), (1, "stick_end"), (1.4, "stick_begin")], [0, 0, 0, 0.2, 0.2, 0.2, 0.2]),
        # struck by 0.2 m/s it leaves with 1.5 times that, and comes down 2 0.1 / 1 later
        (RESTS, 0.2, [(1, "switch"), (1, "impact"), (1, "rest_end"), (1.2, "impact")], [0, 0, 0.3]),
        # the base falls away, and it follows: 0.2 t = t^2 / 2
        (RESTS, -0.2, [(1, "switch"), (1, "rest_end"), (1.4, "impact")], [0, 0, 0]),
    ),
)
def test_a_kink_of_the_base_is_a_blow_to_what_rests_on_it(parts, speed, told, velocities):
    """Friction gives no impulse, and a stop no pull: both went along with the base at once."""
    text = KINK.replace("PARTS", parts).replace("SPEED", f"{speed} m/s")
    run = simulate(case_of(text), trust=False)
    happened = [(round(t, 12), kind) for t, kind in events_of(run)]
    assert happened[1 : 1 + len(told)] == told
    assert run["v_a"][: len(velocities)].tolist() == pytest.approx(velocities, abs=1e-14)
    assert run["v_a"][-1] == pytest.approx(speed, abs=1e-14)
    assert abs(run.attrs["energy_residual"]) < 1e-15
    assert float(run.at(1.15)["v_a"]) == pytest.approx(
        float(simulate(case_of(text.replace("every: 0.5", "every: 0.05")))["v_a"][23]), abs=1e-14
    )


@pytest.mark.parametrize(
    ("belt", "told"),
    (
        # it sticks at 0.25 m/s, and the base takes the belt 0.2 m/s away from it
        (0.25, [(0.5, "stick_begin"), (1, "switch"), (1, "stick_end"), (1.4, "stick_begin")]),
        # it slips on, towards what the belt and the base come to
        (0.9, [(1, "switch"), (2.2, "stick_begin")]),
        (-0.9, [(1, "switch"), (1.4, "stick_begin")]),
    ),
)
def test_a_kink_of_the_base_beneath_a_belt_of_constant_speed(belt, told):
    """Slip there was read without the belt: it turned round, and the energy ledger did not close."""
    text = KINK.replace("PARTS", STICKS.replace("mu: 0.1", f"mu: 0.1, belt: {belt} m/s"))
    run = simulate(case_of(text.replace("SPEED", "0.2 m/s")), trust=False)
    assert [(round(t, 12), kind) for t, kind in events_of(run)][1:-1] == told
    assert run["v_a"][-1] == pytest.approx(belt + 0.2, abs=1e-14)
    assert abs(run.attrs["energy_residual"]) < 1e-15


DAMPED = """\
name: damped
bodies: {a: 1 kg}
links: {d: {between: [a, ON], k: 1 N/m, c: 20 N s/m}}
friction: {f: {between: [a, ground], N: 10 N, mu: 0.1}}
DRIVE
run: {t_end: 2 s, every: 0.1 s}
"""
NUMBERS = "V: 0.2 m/s, t1: 1 s, A: 0.1 m/s^2"


def test_a_kink_of_the_base_tears_off_what_a_damper_holds_to_it():
    """The damper's force jumps to 4 N on friction that holds 1 N: as the same force from the ground does."""
    base = f'base: {{x: "V*max(t - t1, 0) - A*max(t - t1, 0)**2", {NUMBERS}}}'
    force = "where(t < t1, 0, k*(V*(t - t1) - A*(t - t1)**2) + c*(V - 2*A*(t - t1)))"
    pull = f'forces: {{g: {{on: a, force: "{force}", k: 1 N/m, c: 20 N s/m, {NUMBERS}}}}}'
    kinked, pulled = (
        simulate(case_of(DAMPED.replace("ON", on).replace("DRIVE", drive)), trust=False)
        for on, drive in (("base", base), ("ground", pull))
    )
    assert [kind for _, kind in events_of(kinked)][1:-1] == ["switch", "stick_end", "stick_begin"]
    assert kinked.events["t"].tolist() == pytest.approx(pulled.events["t"].tolist(), abs=1e-14)
    assert kinked["x_a"].tolist() == pytest.approx(pulled["x_a"].tolist(), abs=1e-15)
    assert kinked.attrs["uncertified"] == 0


def test_a_kink_of_the_base_closes_a_stop_that_had_let_go():
    """The base comes after a body faster than it goes: the damper pushes at once, less and less."""
    text = """\
name: behind
bodies: {a: 1 kg}
stops: {s: {between: [a, base], gap: -10 mm, acts: extension, k: 50 N/m, c: 20 N s/m, release: force}}
base: {x: "V*max(t - t1, 0)", V: 0.4 m/s, t1: 20 ms}
initial: {a: {v: 0.3 m/s}}
run: {t_end: 60 ms, every: 10 ms}
"""
    run = simulate(case_of(text), trust=False)
    assert [(round(t, 12), kind) for t, kind in events_of(run)][1:3] == [
        (0.02, "switch"),
        (0.02, "contact_begin"),
    ]
    # depth g: g'' = -20 g' - 50 g from 4 mm at 0.1 m/s
    w, tau = 50**0.5, 0.04
    g = np.exp(-10 * tau) * (0.004 * np.cosh(w * tau) + (0.1 + 0.04) / w * np.sinh(w * tau))
    assert run["x_a"][-1] == pytest.approx(0.4 * 0.04 + 0.01 - g, abs=1e-15)
    again = run.at(np.array([0.03, 0.05]))["x_a"]
    assert again.tolist() == pytest.approx(run["x_a"][[3, 5]].tolist(), abs=1e-16)


def test_an_impact_opens_a_stop_by_a_formula_as_one_by_numbers():
    """A ball knocks a body out of a damped stop, which would have to pull."""
    text = """\
name: knocked
bodies: {a: 1 kg, b: 1 kg}
stops:
  s: {between: [a, ground], gap: 0 mm, acts: compression, release: force, LAW}
  r: {between: [a, b], gap: 0 mm, acts: compression, law: rigid, e: 0.5}
initial: {a: {x: 10 mm, v: 0 m/s}, b: {x: 11 mm, v: -1 m/s}}
run: {t_end: 0.2 s, every: 10 ms}
"""
    laws = ("k: 500 N/m, c: 20 N s/m", 'force: "K*p*max(1, t/T) + C*pv", K: 500 N/m, C: 20 N s/m, T: 9 s')
    numbers, formula = (simulate(case_of(text.replace("LAW", law)), trust=False) for law in laws)
    assert "contact_end" in [kind for _, kind in events_of(numbers)]
    assert [kind for _, kind in events_of(formula)] == [kind for _, kind in events_of(numbers)]
    assert formula["x_a"].tolist() == pytest.approx(numbers["x_a"].tolist(), abs=1e-14)


def test_two_switches_of_a_base_that_turn_at_one_instant_turn_in_many_digits_too():
    """Where mod goes back the table inside it does: the velocity of the base is neither's alone."""
    text = """\
name: two
bodies: {a: 1 kg}
links: {d: {between: [a, base], k: 50 N/m, c: 2 N s/m}}
base: {x: "a0*table(mod(t, T), [[0 s, 0], [0.4046 s, 1], [0.7418 s, -0.5], [1.3487 s, 0]], 'linear')",
  a0: 1 mm, T: 1.3487 s}
run: {t_end: 8 s, every: 1 s}
"""
    case = case_of(text)
    *_, last = open_truth(case.exact_scene, 40).blocks()
    there = float(last.event_digits["x_a"][-1].decode())
    assert simulate(case, trust=False)["x_a"][-1] == pytest.approx(there, abs=1e-16)


@pytest.mark.parametrize("digits", [None, 30])
@pytest.mark.parametrize(("base", "begins"), [("(t/T)**2.5", 0.0), ("max(0, (t - T)/T)**2.5", 0.3)])
def test_a_base_that_begins_as_a_power_carries_along_what_sticks_to_it(base, begins, digits):
    """All coefficients of its series are zero there, and it moves."""
    text = f"""
name: power
bodies: {{a: 1 kg, b: 1 kg}}
links: {{l: {{between: [b, base], k: 100 N/m, c: 0.5 N s/m}}}}
friction: {{f: {{between: [a, base], N: 500 N, mu: 0.3}}}}
base: {{x: "A*{base}", A: 3 mm, T: 0.3 s}}
run: {{t_end: 1 s, every: 10 ms}}
"""
    run = simulate(load_case_text(text, name="power"), digits=digits)
    ahead = np.maximum(run.time - begins, 0) / 0.3
    np.testing.assert_allclose(run["x_a"], 3e-3 * ahead**2.5, rtol=0, atol=1e-16)
    np.testing.assert_allclose(run["v_a"], 25e-3 * ahead**1.5, rtol=0, atol=1e-15)
    assert run.attrs["uncertified"] == 0 and (digits or run.trust_horizon == 1)

    def rates(t, y):
        u = max(t - begins, 0) / 0.3
        return [y[1], 100 * (3e-3 * u**2.5 - y[0]) + 0.5 * (25e-3 * u**1.5 - y[1])]

    one = solve_ivp(rates, (0, 1), [0, 0], "DOP853", t_eval=[1], rtol=1e-11, atol=1e-14, max_step=1e-3)
    assert abs(run["x_b"][-1] - one.y[0, -1]) < 1e-10


@pytest.mark.parametrize("digits", [None, 30])
@pytest.mark.parametrize("power", [1.5, 2.5])
def test_a_belt_that_begins_as_a_power_of_the_time_carries_along_what_sticks_to_it(power, digits):
    text = f"""
name: power
bodies: {{a: 1 kg}}
friction: {{f: {{between: [a, ground], N: 500 N, mu: 0.3, belt: "V*(t/T)**{power}", V: 20 mm/s, T: 0.3 s}}}}
run: {{t_end: 1 s, every: 10 ms}}
"""
    run = simulate(load_case_text(text, name="power"), digits=digits)
    ahead = run.time / 0.3
    np.testing.assert_allclose(run["v_a"], 20e-3 * ahead**power, rtol=0, atol=1e-15)
    np.testing.assert_allclose(run["x_a"], 6e-3 / (power + 1) * ahead ** (power + 1), rtol=0, atol=1e-15)
    assert run.attrs["uncertified"] == 0 and (digits or run.trust_horizon == 1)


def test_a_base_ends_the_run_where_its_root_becomes_negative():
    text = """
name: root
bodies: {a: 1 kg}
links: {l: {between: [a, base], k: 100 N/m}}
base: {x: "A*(1 - t/T)**2.5", A: 3 mm, T: 0.3 s}
run: {t_end: 1 s, every: 10 ms}
"""
    with pytest.raises(EngineError, match=r"t = 0\.3.* base"):
        simulate(load_case_text(text, name="root"), trust=False)


@pytest.mark.parametrize("e", [0.0, 0.5])
def test_a_belt_that_jumps_as_a_kink_of_the_base_strikes_its_body_gives_no_impulse(e):
    """At 1 s the base grows faster and strikes b, which rests on it, as the belt between a and b jumps. From
    then on that takes N mu / m = 0.02 m/s^2 of a's velocity, which it once took 0.04 m/s of at once.
    """
    result = run(
        scene_of(f"""
bodies: {{a: 1 kg, b: 1 kg}}
friction: {{f: {{between: [a, b], N: 0.02 N, mu: 1, belt: "where(t < 1 s, 0 m/s, -0.05 m/s)"}}}}
stops: {{s: {{between: [b, base], gap: 0 m, acts: extension, law: rigid, e: {e}}}}}
forces: {{F: {{on: b, F0: -0.05 N}}}}
base: {{x: "0.01 m*max(t/1 s, 2*t/1 s - 1)"}}
initial: {{a: {{v: 0.01 m/s}}, b: {{v: 0.01 m/s}}}}
run: {{t_end: 2 s, every: 10 ms}}
"""),
        ledger=True,
    )
    course = 0.01 - 0.02 * np.maximum(result.samples["time"] - 1, 0)
    np.testing.assert_allclose(result.samples["v_a"], course, rtol=0, atol=1e-15)
    assert abs(result.totals["energy_residual"]) < 1e-15


def test_a_belt_that_turns_round_carries_a_body_off_the_stop_that_it_rests_on():
    """As the belt stands, it could hold the body as well as the stop does; then its course decides."""
    scene = scene_of("""
bodies: {b: 1 kg}
stops: {s: {between: [b, ground], gap: 10 mm, acts: compression, law: rigid, e: 0}}
friction: {f: {between: [b, ground], N: 0.1 N, mu: 1, belt: "u*sin(w*t)", u: 0.05 m/s, w: 1 rad/s}}
initial: {b: {x: 10 mm, v: 0.1 m/s}}
run: {t_end: 4 s, every: 20 ms}
""")
    result = run(scene, ledger=True)
    assert result.kinds == ["impact", "reversal", "rest_begin", "stick_begin", "rest_end"]
    t = result.samples["time"]
    course = 0.01 - 0.05 * np.where(t > np.pi, 1 + np.cos(t), 0)
    np.testing.assert_allclose(result.samples["x_b"], course, rtol=0, atol=1e-16)
    assert abs(result.totals["energy_residual"]) < 1e-17 and result.totals["uncertified"] == 0


def test_a_belt_that_just_comes_up_to_the_speed_of_another_falls_back():
    """b sticks to one belt and is as fast as the other at 5 t = pi/2 alone, where the switch of y turns. Of
    the rate of slip rounding of the time is left there: the second friction turned by that, and back by what
    follows, until the run ended.
    """
    scene = scene_of("""
bodies: {b: 1 kg}
links: {l: {between: [b, ground], force: "k*d + q*v*abs(v)", k: 25 N/m, q: 1 N s^2/m^2}}
states: {y: {rate: "max(x_b, 0*y)/tau - y/tau", start: 0 m, tau: 0.5 s}}
friction:
  carries: {between: [b, ground], N: 0.1 N, mu: 1, belt: "0.05 m/s*sin(5 rad/s*t)"}
  rubs: {between: [b, ground], N: 0.02 N, mu: 1, belt: "where(mod(t, 1 s) < 0.5 s, 0.05 m/s, 0 m/s)"}
  floor: {between: [b, ground], N: 0.02 N, mu: 0.5, static: 2}
forces: {F: {on: b, A: 0.05 N, omega: 5 rad/s, phase: 90 deg}}
initial: {b: {x: -10 mm}}
run: {t_end: 0.4 s, every: 10 ms}
""")
    samples = run(scene).samples
    np.testing.assert_allclose(samples["v_b"], 0.05 * np.sin(5 * samples["time"]), rtol=0, atol=1e-15)
