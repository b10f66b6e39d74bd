"""What a completed chatter leaves out counts as error, and chatters come to an end."""

from decimal import Decimal
from pathlib import Path

import numpy as np
import pytest

from tests.trust.judging import FACTOR, true_error
from tests.trust.random_chatters import chatter, crowded, pushed
from vibsim import simulate
from vibsim.cases.case import load_case, load_case_text
from vibsim.physics.parts import EVENT_KINDS


def test_the_estimate_covers_what_chatter_leaves_out():
    result = simulate("gallery/pile-driver")
    left_out = result.attrs["chatter_distance"]
    assert result.attrs["chatters"] > 0 and left_out > 1e-14
    assert result.error_estimate[-1] >= left_out


RUBBED = """
bodies: {a: 2.598 kg, b: 0.5684 kg}
links:
  la: {between: [a, base], k: 462.8 N/m}
  ab: {between: [a, b], k: 266.1 N/m, c: 2.486 N s/m}
stops: {wall: {between: [ground, b], law: rigid, gap: 5.478 mm, acts: extension, e: 0.6127}}
friction: {rub: {between: [a, b], N: 1.698 N, mu: 0.3578, static: 1.282}}
base:
  terms:
  - {a: 1.696 mm, omega: 0.6284 Hz, phase: 2.76722382455 rad}
  - {a: 4.237 mm, omega: 2.032 Hz, phase: 2.62508340958 rad}
forces:
  drive:
    on: a
    terms:
    - {A: 1.405 N, omega: 1.373 Hz, phase: 0.805682437623 rad}
    - {A: 1.701 N, omega: 1.099 Hz, phase: 5.95644492161 rad}
initial:
  a: {x: 6.34896768997 mm, v: 16.3543497299 mm/s}
  b: {x: 5.46274685816 mm, v: -8.27399518885 mm/s}
run: {t_end: 40 ms, every: 10 ms}
"""


def test_the_estimate_covers_the_velocity_that_chatter_leaves_out():
    """b strikes the wall and rubs on a, which goes on: what a lacks when the hops end early is not given
    back. It is 2e-9 m/s, and grows far beyond the height of the hops. The truth has 30 digits.
    """
    case = load_case_text(RUBBED)
    result, truth = simulate(case), simulate(case, digits=30)
    error = max(abs(result[name][-1] - truth[name][-1]) for name in ("x_a", "x_b"))
    assert result.attrs["chatters"] == 1
    assert error > 1e3 * result.attrs["chatter_distance"]
    assert error < result.error_estimate[-1] < 1e2 * error


def test_what_is_left_out_counts_from_where_the_chatter_ends():
    """It counted for all samples of the block that the engine handed over, before the chatter as well."""
    case = load_case_text(RUBBED, overrides={"run.every": "1 ms"})
    run = simulate(case)
    end = run.events["t"][run.events["kind"] == EVENT_KINDS["chatter"]][0]
    assert run.error_estimate[run.time < end].max() < run.attrs["chatter_distance"]


CASES = Path(__file__).parent / "cases"


@pytest.mark.parametrize(
    ("name", "t_end", "error"),
    [("hops-turned-in-a-fifth", "5.4 s", 3e-10), ("hops-held-in-a-sixth", "4.2 s", 3e-10)],
)
def test_the_estimate_covers_hops_that_shrink_fast_under_friction(name, t_end, error):
    """Their speeds shrink to a fifth and to a sixth. The truth has 36 digits."""
    case = load_case(CASES / f"{name}.yaml", overrides={"run.t_end": t_end})
    run, truth = simulate(case), simulate(case, digits=36)
    errors = np.max([abs(run[x] - truth[x]) for x in ("x_a", "x_b")], axis=0)
    assert errors[-1] > error
    grown = errors > 1e-13
    ratio = run.error_estimate[grown] / errors[grown]
    assert ratio.min() > 1 and np.median(ratio) < FACTOR
    assert run.attrs["uncertified"] == 0


def test_the_time_that_a_chatter_under_friction_leaves_out_is_that_of_its_hops():
    """Forces of the last hop tell it, though its friction stops on the way up and sets off again."""
    case = load_case(CASES / "hops-held-in-a-sixth.yaml", overrides={"run.t_end": "4.1291 s"})
    run, truth = simulate(case), simulate(case, digits=36)
    begun = [one.events["t"][one.events["kind"] == EVENT_KINDS["rest_begin"]][-1] for one in (run, truth)]
    assert run.attrs["chatters"] == 1
    assert run.attrs["chatter_time"] == pytest.approx(begun[1] - begun[0], rel=1e-3)
    assert begun[1] - begun[0] > 9e-8


@pytest.mark.parametrize(("name", "doubts"), [("hops-without-loss", False), ("hops-on-two-stops", True)])
def test_hops_come_to_an_end(name, doubts):
    """Of hops with e = 1 friction takes by standing in part of each; on two stops in turn rounding does."""
    result = simulate(load_case(CASES / f"{name}.yaml"))
    assert result.trust_horizon == 4 and result.error_estimate[-1] < 1e-9
    assert result.attrs["chatters"] > 0
    assert (result.attrs["uncertified"] > 0) == doubts


@pytest.mark.parametrize("seed", [470, 20251])
def test_a_body_between_two_stops_comes_to_rest(seed):
    """Struck in turn, on a way below the rounding of displacements while its speed is far from it."""
    case, _ = pushed(seed)
    run = simulate(case)
    assert len(run.events["t"]) < 200
    assert true_error(case, run)[0].max() < 1e-16
    assert abs(run.attrs["energy_residual"]) < 1e-15


def worst(case):
    """Least ratio of the estimate to the true error of a random chatter; None where the run is in doubt."""
    run = simulate(case)
    return None if run.attrs["uncertified"] else least(run, true_error(case, run)[0])


def least(run, error, roundings=1):
    """Least ratio of the estimate to the true error where that is above so many units in the last place of
    the largest displacement so far.
    """
    names = [name for name in run if name.startswith("x_")]
    size = np.maximum.accumulate(np.max([np.abs(run[name]) for name in names], axis=0))
    known = error > roundings * np.spacing(size)
    return (run.error_estimate[known] / error[known]).min(initial=np.inf)


def worst_by_parabolas(seed):
    """The same against the motion from parabola to parabola: (beyond one rounding, beyond 16); None also
    where the run has no chatter.
    """
    case, line = pushed(seed)
    run = simulate(case)
    if run.attrs["uncertified"] or not run.attrs["chatters"]:
        return None
    true = line.run([Decimal(t) for t in run.time.tolist()])
    errors = []
    for i, name in enumerate(name for name in run if name.startswith("x_")):
        errors.append(
            [abs(float(Decimal(x) - row[i])) for x, row in zip(run[name].tolist(), true, strict=True)]
        )
    error = np.max(errors, axis=0)
    return least(run, error), least(run, error, 16)


@pytest.mark.parametrize("seed", [*range(6), 20311])
def test_a_run_is_that_of_parabolas(seed):
    """Bodies under constant forces and Coulomb friction, each hop followed down to 1e-40 m/s."""
    ratios = worst_by_parabolas(seed)
    assert ratios is None or ratios[0] > 1 / FACTOR


def test_the_estimate_of_a_random_chatter_holds():
    assert worst(chatter(13)) > 1 / FACTOR


@pytest.mark.slow
@pytest.mark.timeout(7200)
def test_estimates_of_two_hundred_random_chatters_hold():
    """At no sample is the true error more than the factor above the estimate."""
    cases = [*map(chatter, range(120)), *map(crowded, range(120))]
    ratios = [ratio for case in cases if (ratio := worst(case)) is not None]
    assert len(ratios) > 120
    assert min(ratios) > 1 / FACTOR


@pytest.mark.slow
@pytest.mark.timeout(3600)
def test_estimates_of_three_hundred_motions_of_parabolas_hold():
    ratios = [both for seed in range(450) if (both := worst_by_parabolas(seed)) is not None]
    assert len(ratios) > 250
    assert min(one for one, _ in ratios) > 1 / FACTOR
    assert min(one for _, one in ratios) > 1 / 4
