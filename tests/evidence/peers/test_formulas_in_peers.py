"""Formulas, rotors and states in the peers: the engine's motions, closed forms, and what a peer cannot do."""

from textwrap import dedent

import numpy as np
import pytest

from tests.evidence.peers.test_scenes_of_parts import PEERS, displaced, reference, sample_times, solved
from tests.formulas.drawn_models import Drawn
from vibsim import simulate
from vibsim.cases import load_case
from vibsim.cases.case import load_case_text
from vibsim.evidence.benchmark.plan import family_of, make_plan
from vibsim.evidence.peers.solvers import EventlessSolver, EventSolver, RungeKutta4, TimeLimit, kinds_of
from vibsim.physics.parts import EVENT_NAMES

SPANS = {
    "gallery/bouc-wen": "1 s",
    "gallery/brake-squeal": "30 s",
    "gallery/coupled-clutches": "1.5 s",
    "gallery/dc-motor-start": "2 s",
    "gallery/energy-harvester": "0.1 s",
    "gallery/gear-pair": "20 s",
    "gallery/hertz-chain": "6 s",
    "gallery/pendulum-on-cart": "2 s",
    "gallery/two-exciters": "0.5 s",
    "gallery/van-der-pol": "5 s",
}


def motion_of(peer, text, t_end="2 s"):
    """Times, states and events (time, name) of a peer on a case."""
    run = f"run: {{t_end: {t_end}, every: 0.1 s}}"
    scene = load_case_text(f"{dedent(text)}\n{run}", name="scene").scene()
    times = sample_times(scene)
    attempt = peer(scene).run(times, TimeLimit())
    return times, attempt.states, [(t, EVENT_NAMES[kind]) for t, kind in attempt.events]


@pytest.mark.parametrize(("peer", "allowed"), PEERS)
@pytest.mark.parametrize("name", SPANS)
def test_events_and_displacements_of_the_gallery(name, peer, allowed):
    error, kinds, expected = solved(peer, name, {"run.t_end": SPANS[name]})
    assert kinds == [kind for kind in expected if kind != "switch"]
    assert error < allowed


@pytest.mark.parametrize(("peer", "allowed"), PEERS)
@pytest.mark.parametrize("seed", [1000, 1010, 1018, 1033])
def test_random_scenes(seed, peer, allowed):
    """With every function and switch of the language; of these four two begin with guards at 0."""
    scene = load_case_text(Drawn(seed).case, name="drawn").scene()
    times, x, events = reference(scene)
    attempt, kinds, x = peer(scene).run(times, TimeLimit()), kinds_of(scene), x[:, : len(scene.line)]
    assert [EVENT_NAMES[kind] for _, kind in attempt.events] == [kind for kind in events if kind in kinds]
    assert np.abs(displaced(attempt, x) - x).max() < allowed


@pytest.mark.parametrize("name", ["gallery/gear-pair", "gallery/hertz-chain", "gallery/dc-motor-start"])
def test_the_same_formulas_without_events(name):
    """To what the tolerance is worth, over kinks that no step ends at."""
    scene = load_case(name, {"run.t_end": "2 s"}).scene()
    times, x, _ = reference(scene)
    for peer, allowed in (
        (EventlessSolver(scene, "RK45", 1e-9, 1e-12), 1e-6),
        (EventlessSolver(scene, "LSODA", 1e-9, 1e-12, 1e-6), 1e-5),
        (RungeKutta4(scene, 1e-3), 2e-3),
    ):
        attempt = peer.run(times, TimeLimit())
        assert np.abs(displaced(attempt, x) - x).max() < allowed, type(peer).__name__


def test_the_error_goes_down_with_the_tolerance():
    """Over the corners of the gear pair, as fast as the tolerance: the switches are located."""
    scene = load_case("gallery/gear-pair", {"run.t_end": "20 s"}).scene()
    times, x, _ = reference(scene)
    errors = []
    for rtol in (1e-6, 1e-9, 1e-12):
        attempt = EventSolver(scene, "DOP853", rtol).run(times, TimeLimit())
        errors.append(np.abs(displaced(attempt, x) - x).max())
    assert errors[0] < 1e-5 and errors[1] < errors[0] / 100 and errors[2] < errors[1] / 100


@pytest.mark.parametrize(("peer", "allowed"), PEERS)
def test_a_force_by_remainder_table_and_step(peer, allowed):
    """v' = F (mod(t, T)/T + table + step): 0.5 a period, a triangle of 1 N s, 1 N from 1.5 s on."""
    text = """
    bodies: {a: 1 kg}
    forces:
      saw: {on: a, force: "F*mod(t, T)/T", F: 1 N, T: 0.3 s}
      triangle: {on: a, force: "table(t, [[0.5 s, 0 N], [1 s, 2 N], [1.5 s, 0 N]], 'linear')"}
      late: {on: a, force: "F*step(t - t1)", F: 1 N, t1: 1.5 s}
    """
    times, states, _ = motion_of(peer, text)
    turns = np.floor(times / 0.3 + 1e-9)
    saw = 0.15 * turns + (times - 0.3 * turns) ** 2 / 0.6
    rising, falling = 2 * np.clip(times - 0.5, 0, 1) ** 2, 1 - 2 * np.clip(1.5 - times, 0, 1) ** 2
    triangle = np.where(times < 1, rising, falling)
    assert states[:, 1] == pytest.approx(saw + triangle + np.clip(times - 1.5, 0, 1), abs=allowed)


@pytest.mark.parametrize(("peer", "allowed"), PEERS)
def test_a_belt_whose_velocity_is_a_formula(peer, allowed):
    """Its velocity rises to 0.1 m/s, then jumps to 0.3 m/s; friction makes up for that in 0.4 s."""
    text = """
    bodies: {a: 2 kg}
    friction: {f: {between: [a, ground], N: 2 N, mu: 0.5, belt: "where(t < t1, u*t/t1, w)", t1: 1 s,
      u: 0.1 m/s, w: 0.3 m/s}}
    """
    times, states, events = motion_of(peer, text)
    speed = np.where(times < 1, 0.1 * times, np.clip(0.1 + 0.5 * (times - 1), 0, 0.3))
    assert states[:, 1] == pytest.approx(speed, abs=10 * allowed)
    assert [kind for _, kind in events] == ["stick_end", "stick_begin"]
    assert [t for t, _ in events] == pytest.approx([1.0, 1.4], abs=allowed)


@pytest.mark.parametrize(("peer", "allowed"), PEERS)
def test_a_base_that_stops_at_once(peer, allowed):
    """What sticks to it slides on from 0.2 m/s at mu N/m = 1 m/s^2; what stands behind its wall is struck."""
    text = """
    bodies: {a: 1 kg, b: 1 kg}
    friction: {f: {between: [a, base], N: 2 N, mu: 0.5}}
    stops: {wall: {between: [b, base], law: rigid, gap: 0 m, acts: compression, e: 0.5}}
    base: {x: "V*min(t, t1)", V: 0.2 m/s, t1: 0.5 s}
    initial: {a: {v: 0.2 m/s}, b: {v: 0.2 m/s}}
    """
    times, states, events = motion_of(peer, text, "1 s")
    left = np.clip(times - 0.5, 0, 0.2)
    assert states[:, 0] == pytest.approx(0.2 * np.minimum(times, 0.5) + 0.2 * left - left**2 / 2, abs=allowed)
    struck = 0.1 - 0.1 * np.clip(times - 0.5, 0, 1)
    assert states[times > 0.5, 2] == pytest.approx(struck[times > 0.5], abs=allowed)
    assert [kind for _, kind in events][-4:] == ["impact", "rest_end", "stick_end", "stick_begin"]


@pytest.mark.parametrize(("peer", "allowed"), PEERS)
def test_a_load_that_passes_zero_lets_go(peer, allowed):
    """N = N0 (1 - t/T): a pull of 1 N starts the body where mu N is 1 N, at 0.5 s; from 1 s on it is free."""
    text = """
    bodies: {a: 1 kg}
    friction: {f: {between: [a, ground], N: "N0*(1 - t/T)", mu: 0.5, N0: 4 N, T: 1 s}}
    forces: {pull: {on: a, F0: 1 N}}
    """
    times, states, events = motion_of(peer, text)
    assert [kind for _, kind in events] == ["stick_end"] and events[0][0] == pytest.approx(0.5, abs=allowed)
    slides = np.clip(times - 0.5, 0, 0.5)
    assert states[:, 1] == pytest.approx(slides**2 + np.clip(times - 1, 0, 1), abs=allowed)


@pytest.mark.parametrize(("peer", "allowed"), PEERS)
def test_what_has_no_value_is_not_read_where_it_does_not_count(peer, allowed):
    """A logarithm and a root in the branch that is not taken: x'' = log(1) = 0, then sqrt(t - 1)."""
    text = """
    bodies: {a: 1 kg}
    forces: {f: {on: a, force: "F*where(t < t1, log((t1 - t)/t1 + t/t1), ((t - t1)/t1)**0.5)", F: 1 N,
      t1: 1 s}}
    """
    times, states, _ = motion_of(peer, text)
    assert states[:, 1] == pytest.approx(np.clip(times - 1, 0, 1) ** 1.5 / 1.5, abs=2e-9)


@pytest.mark.parametrize(("peer", "allowed"), PEERS)
@pytest.mark.parametrize("law", ["K*(max(d, 0)/d0)**1.5", "where(d > 0 m, K*(d/d0)**1.5, 0)"])
def test_powers_that_begin_where_a_switch_turns(law, peer, allowed):
    text = f"""
    bodies: {{a: 1 kg}}
    links: {{l: {{between: [a, ground], force: "{law} + k*d", K: 5 N, d0: 10 mm, k: 50 N/m}}}}
    initial: {{a: {{x: -10 mm}}}}
    """
    run = simulate(load_case_text(f"{dedent(text)}run: {{t_end: 2 s, every: 0.1 s}}", name="a"), trust=False)
    assert motion_of(peer, text)[1][:, 0] == pytest.approx(run["x_a"], abs=allowed)


def test_powers_without_a_series_on_either_side_are_none_for_heyoka():
    text = """
    bodies: {a: 1 kg}
    links: {l: {between: [a, ground], force: "k*sign(d)*abs(d)**0.5", k: 1 N/m^0.5}}
    initial: {a: {x: 1 m}}
    run: {t_end: 1 s, every: 10 ms}
    """
    scene = load_case_text(text, name="root").scene()
    refusal = "left out: abs(d)**0.5 has no Taylor series where it is 0, on neither side"
    assert family_of("heyoka").refusal(scene) == refusal
    assert family_of("dop853").refusal(scene) is None
    assert family_of("heyoka").refusal(load_case("gallery/hertz-chain").scene()) is None


def test_all_peers_take_part():
    plan = make_plan(load_case("gallery/coupled-clutches"))
    assert [family.name for family in plan.families if family.refusal(plan.case.scene())] == ["closed-form"]


CARRIED = """
bodies: {a: 1 kg, b: 0.5 kg}
links: {l: {between: [a, base], k: 100 N/m, c: 0.5 N s/m}, m: {between: [b, a], k: 60 N/m}}
friction:
  f: {between: [a, ground], N: "N0*(1 + 0.5*sin(w1*t))", mu: 0.5, static: 1.2, belt: "u*sin(w*t)", N0: 4 N,
    w1: 0.7 Hz, u: 0.1 m/s, w: 1 Hz}
  h: {between: [b, a], N: 2 N, mu: 0.3, belt: "q*min(t/T, 1)", q: 0.05 m/s, T: 0.8 s}
stops: {w: {between: [b, ground], gap: 4 mm, acts: compression, force: "K*p**1.5", K: 3e4 N/m^1.5}}
rotors:
  r: {on: a, m: 0.1 kg, e: 0.1 m, J: 0.001 kg m^2, torque: "-m*g*e*cos(phi)", g: 9.81 m/s^2}
  s: {on: b, m: 0.1 kg, e: 0.02 m, J: 0.0001 kg m^2, M0: 0.01 N m, Omega0: 3 Hz}
base: {x: "A*sin(w*t)", A: 2 mm, w: 2 Hz}
initial: {r: {phi: -40 deg}}
"""


@pytest.mark.parametrize(("peer", "allowed"), PEERS)
def test_belts_by_formulas_under_bodies_with_rotors(peer, allowed):
    """They stick three times: on a belt on the ground, and on one that a body carries along."""
    run = simulate(load_case_text(f"{CARRIED}run: {{t_end: 1 s, every: 0.1 s}}", name="carried"), trust=False)
    _, states, events = motion_of(peer, CARRIED, "1 s")
    kinds = [kind for kind in run.events.words("kind") if kind not in ("start", "switch", "end")]
    assert [kind for _, kind in events] == kinds and kinds.count("stick_begin") == 3
    columns = ("x_a", "v_a", "x_b", "v_b", "phi_r", "w_r", "phi_s", "w_s")
    assert np.abs(states - np.column_stack([run[name] for name in columns])).max() < 20 * allowed
    assert abs(run.attrs["energy_residual_relative"]) < 1e-14
