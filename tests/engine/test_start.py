"""What rests at the start goes on under the forces that there are behind it, those of stops included."""

import pytest

from vibsim.engine.trajectory import open_trajectory
from vibsim.physics.parts import BASE, GROUND, Body, Force, Friction, Harmonic, Scene, Stop

LIMIT = 0.5  # of the friction between the bodies [N]


def two_bodies(stop, **parts):
    """Two bodies of 1 kg that rub on each other, the first before a stop."""
    rub = Friction("rub", 1, 0, LIMIT, LIMIT, 0.0)
    speeds = parts.pop("v", 0.0)
    bodies = (Body("a", 1.0, 0.0, speeds), Body("b", 1.0, 0.0, speeds))
    return Scene(bodies, stops=(stop,), frictions=(rub,), every_num=1, every_den=1000, **parts)


@pytest.mark.parametrize("engine", ("c", "python"))
def test_a_stop_whose_damper_would_pull_moves_nothing(engine):
    """Deep at the start, the base draws back: without a force both bodies stay, stuck to each other."""
    stop = Stop("s", BASE, 0, -0.002, 1, 1000.0, 100.0, "force")
    base = (Harmonic(0.005, 9.0, 9.0 / 6.283185307179586, 0.0, 0.0),)
    run = open_trajectory(two_bodies(stop, base=base, t_end=0.03), engine, ledger=True)
    samples = [block.samples for block in run.blocks()][-1]
    assert samples["s"][0] == 2 and not samples["rub"].any()
    assert not samples["x_a"].any() and not samples["x_b"].any()
    assert run.totals["loss_friction"] == 0.0


@pytest.mark.parametrize("engine", ("c", "python"))
def test_a_damper_that_is_touched_at_the_start_sets_the_sense_of_slip(engine):
    """The stop brakes a with c v = 3 N against a force of 1.6 N that alone would have it overtake b: b slips
    forwards under -LIMIT, a under 1.6 - 3 + LIMIT [N].
    """
    stop = Stop("s", GROUND, 0, 0.0, 1, 10.0, 20.0)
    push = (Force("push", 0, 1.6, ()),)
    run = open_trajectory(two_bodies(stop, forces=push, v=0.15, t_end=0.001), engine, ledger=True)
    samples = [block.samples for block in run.blocks()][-1]
    assert samples["s"][0] == 1 and samples["rub"][0] == 1
    # 1.6 - 20 * 0.15 + 0.5 = -0.9 m/s^2; the stop's force changes by 2 % within a millisecond
    assert samples["v_a"][-1] - 0.15 == pytest.approx(-0.9e-3, rel=0.03)
    assert samples["v_b"][-1] - 0.15 == pytest.approx(-LIMIT * 1e-3, rel=1e-9)
    assert run.totals["loss_friction"] > 0
