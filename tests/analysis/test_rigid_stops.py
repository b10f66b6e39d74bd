"""Verdicts on runs with rigid stops, exponents among them, which are never made up where there are none."""

import json

import numpy as np
import pytest

import vibsim
from tests.command_line.made import call
from vibsim.cases import load_case
from vibsim.physics.parts import EVENT_KINDS


@pytest.fixture(scope="module")
def pair():
    """One impact at each wall in each period of 0.2 s."""
    return vibsim.simulate(load_case("gallery/impact-pair", {"run.t_end": "20 s"}), trust=False)


def test_a_periodic_motion_with_impacts_is_called_so(pair):
    found = vibsim.analyse(pair)
    assert (found.regime.verdict, found.regime.period) == ("periodic", 1)
    assert {name: each.impacts for name, each in found.impacts.items()} == {"left": 1.0, "right": 1.0}


def test_a_periodic_motion_has_negative_exponents():
    found = vibsim.lyapunov(load_case("gallery/impact-pair", {"run.t_end": "20 s"}))
    assert np.all(found.exponents < 0) and found.warnings == ()


def test_a_sweep_computes_all_of_them():
    case = load_case("gallery/impact-pair", {"run.t_end": "4 s"})
    sweep = vibsim.sweep(case, {"stops.left.e": "0.5:0.7/2"}, compute="all")
    assert np.all(sweep["status"] == 1) and np.all(np.isfinite(sweep["lyapunov"]))
    assert np.all(sweep["lyapunov_spectrum"] < 1.0)


GRAZING = """
name: grazing
bodies: {m: 1 kg}
stops: {wall: {between: [m, ground], gap: 1 m, acts: compression, law: rigid, e: 0.8}}
forces: {weight: {on: m, F0: -2 N}}
initial: {m: {x: 0 m, v: 2 m/s}}
run: {t_end: 1.5 s}
"""


def test_a_motion_that_grazes_has_no_exponents(tmp_path, monkeypatch):
    """2 t - t^2 just comes up to 1 at t = 1 s."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "grazing.yaml").write_text(GRAZING)
    text = call("run", "grazing.yaml", "--lyapunov", "all", "--discard", "0").stdout
    assert "exponents       none, none 1/s" in text
    assert (
        "exponents are undefined: at 1 s the motion grazes a rigid stop or strikes several at one instant"
        in text
    )
    line = call("run", "grazing.yaml", "--lyapunov", "1", "--discard", "0", "--json", "--force").stdout
    attrs = json.loads(line)
    assert attrs["lyapunov_exponents"] == [None]
    assert attrs["lyapunov_undefined_time"] == pytest.approx(1.0, abs=1e-6)


def test_exponents_of_an_impact_pair_sum_up(tmp_path, monkeypatch):
    """Free flight between walls with e: each impact presses areas by e^2."""
    monkeypatch.chdir(tmp_path)
    words = ("gallery/impact-pair", "--lyapunov", "all", "--t-end", "20 s", "-o", "pair.h5")
    assert call("run", *words).exit_code == 0
    result = vibsim.open_result("pair.h5")
    growth = result.attrs["lyapunov_growth"]
    rows = result.events
    struck = rows["t"][rows["kind"] == EVENT_KINDS["impact"]]
    count = ((struck > growth[0, 0]) & (struck <= growth[-1, 0])).sum()
    e = load_case("gallery/impact-pair").scene().rigid_stops[0][1].e
    expected = 2 * np.log(e) * count
    assert growth[-1, 1:].sum() == pytest.approx(expected, abs=1e-9)
