"""Corners and kinks of branches where sticking and impacts meet, beside an integrator of its own."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from vibsim.cases import load_case
from vibsim.orbits.branches.continuing import continue_branch
from vibsim.orbits.search import orbit
from vibsim.physics.parts import EVENT_KINDS
from vibsim.results.simulation import simulate

BELT = """
name: belt
bodies: {m: 1 kg}
links: {s: {between: [m, ground], force: "k*d + k3*d**3", k: 1 N/m, k3: 0.2 N/m^3}}
stops: {w: {between: [m, ground], law: rigid, gap: 1.2 m, acts: compression, e: 0.6}}
friction: {f: {between: [m, ground], N: 1 N, mu: "mud + (mus - mud)*exp(-s/vs)", mud: 0.5, mus: 1,
               vs: 0.5 m/s, belt: 1.44 m/s}}
initial: {m: {v: 1 m/s}}
run: {t_end: 200 s, every: 50 ms}
"""
SHAKEN = """
name: shaken
bodies: {m: 1 kg}
links: {s: {between: [m, base], k: 20 N/m, c: 0.3 N s/m}}
stops: {w: {between: [m, base], law: rigid, gap: 5 mm, acts: compression, e: 0.6}}
friction: {f: {between: [m, ground], N: 1 N, mu: 0.255}}
base: {a: 10 mm, omega: 1 Hz}
run: {t_end: 200 s, every: 20 ms}
"""
DRIVEN = """
name: driven
bodies: {m: 1 kg}
links: {s: {between: [m, ground], force: "k*d + k3*d**3 + c*v", k: 1 N/m, k3: 0.3 N/m^3, c: 0.1 N s/m}}
stops: {w: {between: [m, ground], law: rigid, gap: 0 m, acts: compression, e: 0.7}}
friction: {f: {between: [m, ground], N: 1 N, mu: 0.1}}
forces: {d: {on: m, A: 1 N, omega: 1.3 rad/s}}
run: {t_end: 400 s, every: 50 ms}
"""

MOTOR = """
name: motor
bodies: {f: 2 kg}
links: {s: {between: [f, ground], k: 3 kN/m, c: 4 N s/m}}
stops: {w: {between: [f, ground], law: rigid, gap: 3 mm, acts: compression, e: 0.5}}
friction: {g: {between: [f, ground], N: 10 N, mu: 0.3}}
rotors: {r: {on: f, m: 0.1 kg, e: 30 mm, J: 1e-3 kg m^2, M0: 0.5 N m, Omega0: 8 Hz}}
initial: {r: {w: 6 Hz}}
run: {t_end: 20 s, every: 5 ms}
"""


def slip_back(x, v, belt, gap):
    """Slip on the belt from (x, v) over an impact at the gap, if there is one ahead: (x, v) where the slip
    velocity next turns before zero, or where the gap is met again.
    """

    def rates(t, y):
        slip = y[1] - belt
        force = 0.5 + 0.5 * np.exp(-abs(slip) / 0.5)
        return [y[1], force - y[0] - 0.2 * y[0] ** 3]

    def wall(t, y):
        return y[0] - gap

    def turn(t, y):
        return rates(t, y)[1]

    wall.direction, wall.terminal, turn.direction, turn.terminal = 1, True, -1, True
    options = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-13}
    if x < gap:
        x, v = solve_ivp(rates, [0, 20], [x, v], events=[wall], **options).y[:, -1]
    start = [x - 1e-14, -0.6 * v]
    return solve_ivp(rates, [0, 20], start, events=[wall, turn], **options).y[:, -1]


def test_a_cycle_that_slips_has_a_fold_beside_the_corner():
    """The corner is where the slip from the place at which the spring is as strong as what holds just comes
    back to the belt; the orbits that slip all the time end in a fold 4.5e-5 m/s below it.
    """
    branch = continue_branch(load_case(BELT), "friction.f.belt", "1.44:1.46 m/s")
    (held,) = (root.real for root in np.roots([0.2, 0, 1, -1]) if abs(root.imag) < 1e-9)
    corner = brentq(lambda belt: slip_back(held, belt - 1e-13, belt, 1.2)[1] - belt, 1.44, 1.46, xtol=1e-11)
    assert [one.label for one in branch.specials] == ["CO1", "F1"]
    assert branch.special("CO1").parameter == pytest.approx(corner, abs=2e-9)
    assert 4e-5 < branch.special("CO1").parameter - branch.special("F1").parameter < 5e-5
    assert [one.jump for one in branch.specials] == [1, -1]
    assert branch.ends == ("end of the range", "end of the range") and set(branch["word"]) == {"isu", "i"}


def test_a_stick_that_begins_just_before_an_impact_is_born_at_a_kink():
    """The mass comes to the wall as fast as the belt; the slope of the branch jumps from 0.6 to 170 there."""
    start = BELT.replace("1.2 m,", "0.836 m,").replace("1.44 m/s", "1 m/s")
    branch = continue_branch(load_case(start), "stops.w.gap", "0.834:0.837 m")
    kink = brentq(lambda gap: slip_back(gap, 1.0, 1.0, gap)[1] - 1.0 + 1e-13, 0.834, 0.837, xtol=1e-11)
    (born,) = branch.specials
    assert born.kind == "sticking"
    assert {branch.spelled(born.before), branch.spelled(born.after)} == {"i", "ius"}
    assert born.parameter == pytest.approx(kink, abs=1e-9)
    assert branch.ends == ("end of the range", "end of the range")


def test_sticking_until_an_impact_ends_orbits_at_a_corner():
    """Orbits that reverse at the impact, and those that stick until it, end each other: one multiplier is on
    one side of 1 and on the other, and both exist on one side of the corner only.
    """
    branch = continue_branch(load_case(SHAKEN), "friction.f.mu", "0.254:0.266")
    corner = branch.special("CO1")
    at = corner.between
    one, other = (branch["multipliers"][i].real.max() for i in (at[0] - 1, at[1] + 1))
    assert (one - 1) * (other - 1) < 0 and corner.jump == -1
    beside = branch["parameter"][[at[0] - 1, at[1] + 1]]
    assert np.all(beside > corner.parameter)
    assert branch.ends == ("end of the range", "end of the range")


def test_a_rigid_stop_is_grazed_where_friction_reverses():
    """Friction between the ends of a stop reverses where the gap turns; the graze there is told as any other.
    Beyond it the case's own start is inside the stop, and an orbit of the branch can be run all the same.
    """
    branch = continue_branch(load_case(DRIVEN), "stops.w.gap", "-0.2:0 m")
    (graze,) = branch.specials
    assert graze.kind == "grazing" and branch.ends[0].startswith("a rigid stop is grazed")
    assert (branch.spelled(graze.before), branch.spelled(graze.after)) == ("irrirr", "irrrr")
    run = simulate(branch.case_at(1))
    turns = run.events["x_m"][run.events["kind"] == EVENT_KINDS["reversal"]]
    nearest = turns[np.argmin(np.abs(turns - graze.parameter))]
    assert nearest == pytest.approx(graze.parameter, abs=1e-6)
    assert run.case.values["stops.w.gap"].value < 0


def test_no_step_goes_over_a_fold_or_a_graze_to_other_orbits():
    """Orbits that strike the stop have a fold, and a graze ends them together with those that stay clear.

    Multipliers tell a step to other orbits, though not where a rigid stop is grazed: such steps went over
    both. The graze is where the motion without the stop just reaches it.
    """
    branch = continue_branch(load_case(MOTOR), "friction.g.mu", "0.19:0.41")
    fold, graze = (one for one in branch.specials if one.kind != "order")
    assert (fold.kind, graze.kind) == ("fold", "grazing")
    assert branch["parameter"].max() <= fold.parameter and set(branch["word"]) == {"irr"}
    values = {"friction.g.mu": f"{graze.parameter!r}", "stops.w": "none"}
    free = orbit(load_case(MOTOR).with_values(values))
    events = free.run.events
    turns = events["x_f"][events["kind"] == EVENT_KINDS["reversal"]]
    assert turns.max() == pytest.approx(3e-3, rel=1e-9)
