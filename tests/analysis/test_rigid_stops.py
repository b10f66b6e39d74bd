"""Verdicts on runs with rigid stops: what needs no exponent is judged, an exponent is never made up."""

import numpy as np
import pytest
from click import UsageError
from click.testing import CliRunner

import vibsim
from vibsim.cases import load_case
from vibsim.command_line.main import group
from vibsim.engine.monodromy import Carrier
from vibsim.sweeps.plan.sweep_plan import PlanError


@pytest.fixture(scope="module")
def pair():
    """One impact at each wall in each period of 0.2 s."""
    return vibsim.simulate(load_case("gallery/impact-pair", {"run.t_end": "20 s"}), trust=False)


def test_a_periodic_motion_with_impacts_is_called_so(pair):
    found = vibsim.analyse(pair)
    assert (found.regime.verdict, found.regime.period) == ("periodic", 1)
    assert {name: each.impacts for name, each in found.impacts.items()} == {"left": 1.0, "right": 1.0}


@pytest.mark.parametrize("compute", ["lyapunov", "lyapunov-spectrum"])
def test_a_sweep_refuses_exponents_before_it_runs(compute):
    with pytest.raises(PlanError, match=f"{compute} needs elastic stops alone, which impact-pair has not"):
        vibsim.sweep("gallery/impact-pair", {"stops.left.e": "0.5:0.7/2"}, compute=compute)


def test_all_that_can_be_computed_is():
    case = load_case("gallery/impact-pair", {"run.t_end": "4 s"})
    sweep = vibsim.sweep(case, {"stops.left.e": "0.5:0.7/2"}, compute="all")
    assert np.all(sweep["status"] == 1)
    assert not [name for name in sweep if "lyapunov" in name]


@pytest.mark.parametrize("engine", ("c", "python"))
def test_no_disturbance_is_carried_through_an_impact(engine):
    with pytest.raises(ValueError, match="not carried through the impacts of rigid stops"):
        Carrier(load_case("gallery/impact-pair").scene(), engine)


def test_a_run_refuses_exponents(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    words = ["run", "gallery/impact-pair", "--lyapunov", "1"]
    with pytest.raises(UsageError, match="rigid stops"):
        CliRunner().invoke(group, words, standalone_mode=False, catch_exceptions=False)
    assert list(tmp_path.iterdir()) == []
