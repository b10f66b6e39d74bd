"""The paper's cases: what follows of them without the engine, and their energy ledgers."""

import math

import numpy as np
import pytest
from hypothesis import given

from tests.random_scenes import scenes
from tests.scenes import CASE_NAMES, MOTORS, fixed_block, harmonic, motor, paper, scene
from tests.trajectories import collect, opened, run

# x1 [m], x2 [m], v1 [m/s], v2 [m/s] at 300 s; impacts, sticks, events
PUBLISHED = {
    "I-A": (
        0.0049838576146675,
        0.0050150524787833,
        -0.0017985024624189,
        -0.00037796325802528,
        630,
        419,
        3780,
    ),
    "I-B": (-0.0208657036721520, -0.0233895811558076, 0.0056039388001598, -0.0015125299416625, 1466, 0, 6232),
    "I-C": (-0.0846686050797213, -0.0868864712155865, 0.0795244964939589, -0.0094857232508406, 1948, 0, 7794),
}
TOLERANCE = {"closed_form": 1e-11, "taylor": 1e-9}  # absolute, in m and m/s; by 60 digits


@pytest.mark.parametrize("method", TOLERANCE)
@pytest.mark.parametrize("name", PUBLISHED)
def test_state_and_events_at_300_s(name, method):
    *state, impacts, sticks, events = PUBLISHED[name]
    result = run(paper(name, t_end=300.0, method=method))
    got = [result.final(column) for column in ("x1", "x2", "v1", "v2")]
    assert got == pytest.approx(state, abs=TOLERANCE[method], rel=0)
    assert (result.totals["impacts"], result.totals["sticks"], result.totals["events"]) == (
        impacts,
        sticks,
        events,
    )
    assert result.totals["uncertified"] == 0
    assert len(result.samples["time"]) == 60001


# Case II-B before its chaos: checkpoints from 50 digits.


CHECKPOINTS = {
    20.0: (0.003511, 4.00240, 115),
    50.0: (0.014103, 5.27362, 339),
}  # x2 [m], w / 2 pi [Hz], impacts


@pytest.mark.parametrize("t", CHECKPOINTS)
@pytest.mark.parametrize(("order", "tol"), [(20, 2.0**-53), (30, 2.0**-53), (24, 1e-18)])
def test_checkpoints_of_ii_b(t, order, tol):
    drift, frequency, impacts = CHECKPOINTS[t]
    result = run(paper("II-B", t_end=t, order=order, tol=tol))
    assert result.final("x2") == pytest.approx(drift, abs=0.5e-6)  # half a unit of the last digit given
    assert result.final("phidot") / (2 * math.pi) == pytest.approx(frequency, abs=0.5e-5)
    assert result.totals["impacts"] == impacts
    assert result.totals["uncertified"] == 0


# V9: the motor on a block that does not move runs up exponentially.


@pytest.mark.parametrize("start", (0.0, -20.0, 50.0))
def test_run_up(start):
    # (J + m3 e^2) w' = M0 (1 - w / Omega0)
    Omega0 = 2 * math.pi * 5.5
    heavy = fixed_block(
        {**motor(5.5), "phidot": start, "phi": 0.3}, m1=1e30, k1=0.0, c=0.0, G=None, t_end=60.0
    )
    result = run(heavy)
    t = result.samples["time"]
    decay = np.exp(-0.005 * t / (Omega0 * (0.001 + 0.03 * 0.11**2)))
    w = Omega0 + (start - Omega0) * decay
    # about 1000 steps, each rounding w to eps: their errors decay as w does
    np.testing.assert_allclose(result.samples["phidot"], w, rtol=0, atol=1e-13 * Omega0)
    tau = Omega0 * (0.001 + 0.03 * 0.11**2) / 0.005
    phi = 0.3 + Omega0 * t + (start - Omega0) * tau * (1 - decay)
    np.testing.assert_allclose(result.samples["phi"], phi, rtol=1e-13, atol=1e-12)
    assert result.samples["phi"][-1] / (2 * math.pi) > 100
    assert np.all(np.abs(result.samples["x1"]) < 1e-25)


# V11: work in = stored + dissipated, to round-off; and each entry where a closed form gives it.


CASE_RESIDUAL = 1e-12  # relative; measured 3e-15 ... 4e-14
RANDOM_RESIDUAL = 1e-11  # a random scene may end with its entries cancelling to a tenth of their throughput


def totals(a_scene):
    return collect(opened(a_scene, ledger=True)).totals


def methods(name):
    return ("taylor",) if name in MOTORS else ("closed_form", "taylor")


@pytest.mark.parametrize(("name", "method"), [(n, m) for n in CASE_NAMES for m in methods(n)])
def test_the_ledger_of_the_nine_cases_closes(name, method):
    assert totals(paper(name, t_end=300.0, method=method))["energy_residual_relative"] < CASE_RESIDUAL


@given(scenes())
def test_the_ledger_of_random_scenes_closes(a_scene):
    assert totals(a_scene)["energy_residual_relative"] < RANDOM_RESIDUAL


def test_a_sliding_block_loses_its_kinetic_energy_to_friction():
    ledger = totals(scene(k1=0.0, c=0.0, k2=None, G=None, v2=0.05, t_end=10.0))
    assert ledger["loss_friction"] == pytest.approx(2.94 * 0.05**2 / 2, rel=1e-14)
    assert ledger["work_source"] == ledger["loss_viscous"] == 0.0


@pytest.mark.parametrize("c", [0.5, 14.6, 500.0])  # weak, near critical, far above critical
def test_a_damped_oscillator_loses_what_it_no_longer_has(c):
    bare = {"N": None, "k2": None, "G": None, "m2": None, "x2": None, "v2": None}
    ledger = totals(scene(**bare, c=c, x1=0.01, t_end=2.0))
    assert ledger["energy_start"] == pytest.approx(200 * 0.01**2 / 2, rel=1e-15)
    assert ledger["loss_viscous"] == pytest.approx(ledger["energy_start"] - ledger["energy_end"], rel=1e-13)


def test_the_source_does_the_work_of_a_driven_free_mass():
    """m x'' = A sin(w t) from rest: v = A (1 - cos w t) / (m w), work m v^2 / 2."""
    bare = {"N": None, "k2": None, "G": None, "m2": None, "x2": None, "v2": None, "k1": 0.0, "c": 0.0}
    ledger = totals(scene(harmonic(2.0, 0.3), **bare, t_end=0.7))
    speed = 0.3 * (1 - math.cos(4 * math.pi * 0.7)) / (0.297 * 4 * math.pi)
    assert ledger["work_source"] == pytest.approx(0.297 * speed**2 / 2, rel=1e-12)


def test_the_motor_spends_its_work_on_the_rotor_where_nothing_else_moves():
    """V9: phidot = Omega0 (1 - exp(-M0 t / (Omega0 (J + m3 e^2)))), work = (J + m3 e^2) phidot^2 / 2."""
    heavy = {
        "m1": 1e12,
        "N": None,
        "k2": None,
        "G": None,
        "m2": None,
        "x2": None,
        "v2": None,
        "k1": 0.0,
        "c": 0.0,
    }
    ledger = totals(scene(motor(5.5), **heavy, t_end=20.0))
    inertia, speed = 0.001 + 0.03 * 0.11**2, 2 * math.pi * 5.5
    reached = speed * -math.expm1(-0.005 * 20.0 / (speed * inertia))
    assert ledger["work_source"] == pytest.approx(inertia * reached**2 / 2, rel=1e-9)
