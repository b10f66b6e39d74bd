"""What a killed sweep, branch, locus or fit has left: it is read as far as it came, and completed."""

import json
import shutil

import numpy as np
import pytest

import vibsim
from tests.command_line.made import call
from tests.fitting.made import small_plan
from vibsim.fitting.fit_result import run_fit
from vibsim.orbits.branches.branch import BranchStore
from vibsim.orbits.branches.continuing import orbit_from
from vibsim.orbits.branches.curve import complete
from vibsim.orbits.branches.locus_result import LocusStore, locus_plan
from vibsim.orbits.branches.plan import plan_from, read_span
from vibsim.results.simulation import open_result
from vibsim.sweeps.sweep_file import SweepStore
from vibsim.sweeps.sweeping import complete as complete_sweep
from vibsim.sweeps.sweeping import make_plan
from vibsim.sweeps.workers import LocalWorkers


class Kill:
    """Keeps a folder as it stands once so much is done, and as a process that is killed then leaves it."""

    def __init__(self, folder, count):
        self.folder, self.count = folder, count
        self.there = 0  # points that were done by then

    def __call__(self, done):
        if done >= self.count and not self.there:
            shutil.copytree(self.folder, self.folder.parent / "killed")
            self.there = done
        return True


@pytest.fixture
def here(tmp_path, monkeypatch):
    """A folder to work in; what is killed is left in `killed` beside it, where commands are called."""
    (tmp_path / "work").mkdir()
    monkeypatch.chdir(tmp_path)
    return tmp_path / "work"


def info(name):
    done = call("info", f"killed/{name}", "--json")
    assert done.exit_code == 0, done.stderr
    return json.loads(done.stdout)


def test_a_killed_sweep(here, monkeypatch):
    case = vibsim.load_case("I-A", {"run.t_end": "5 s"})
    plan = make_plan(case, [("omega", "3:4:0.1", "Hz", "axes")], section=3)
    kill = Kill(here, 4)
    with LocalWorkers(plan.point_settings, 1, "auto") as workers:
        whole, _ = complete_sweep(
            SweepStore(plan, here / "s.h5"), workers, lambda table: kill(int((table.status == 1).sum()))
        )
    facts = info("s.h5")
    assert facts["points_done"] == kill.there >= 4 and facts["complete"] == 0
    found = open_result("killed/s.h5")
    done = found["status"] == 1
    assert done.sum() == kill.there and np.array_equal(found["impacts"][done], whole["impacts"][done])
    assert call("plot", "killed/s.h5", "-o", "p.png").exit_code == 0
    refused = call("sweep", "killed/s.h5", "--section", "9")
    assert refused.exit_code == 2 and "by the plan that it holds; leave --section out" in refused.stderr
    completed = call("sweep", "killed/s.h5", "-j", "1")
    assert completed.exit_code == 0 and f"{kill.there} points were there" in completed.stdout
    assert np.array_equal(open_result("killed/s.h5")["drift_rate"], whole["drift_rate"], equal_nan=True)
    assert "nothing to compute" in call("sweep", "killed/s.h5", "-j", "1").stdout


def test_a_killed_branch_and_a_killed_locus(here):
    orbit = orbit_from(vibsim.load_case("I-C", {"omega": "4.2 Hz"}))
    plan = plan_from(orbit, *read_span(orbit.case, "omega", "4:4.3 Hz"))
    kill = Kill(here, 5)
    whole, _ = complete(BranchStore(plan, here / "b.h5"), 5000, watch=lambda count, *_: kill(count))
    assert info("b.h5")["points"] == kill.there == 5
    found = open_result("killed/b.h5")
    assert not found.attrs["complete"]
    assert np.isin(found["period"], whole["period"]).all()
    assert call("plot", "killed/b.h5", "-o", "p.png").exit_code == 0
    assert call("continue", "killed/b.h5", "-q").exit_code == 0
    assert np.array_equal(open_result("killed/b.h5")["period"], whole["period"])
    shutil.rmtree("killed")
    followed = locus_plan(whole, "PD1", *read_span(whole.case, "c", "0.001:0.003 N s/m"))
    kill = Kill(here, 3)
    locus, _ = complete(LocusStore(followed, here / "l.h5"), 6, lambda count, *_: kill(count))
    assert len(info("l.h5")["points"]) == kill.there == 3
    assert call("continue", "killed/l.h5", "--max-points", "6", "-q").exit_code == 0
    assert np.array_equal(open_result("killed/l.h5")["second"], locus["second"])


def test_a_killed_fit(here):
    plan = small_plan()
    kill = Kill(here, 5)
    whole, _ = run_fit(plan, here / "f.h5", 1, watch=lambda *_: kill(count_of(here / "f.h5.journal")))
    facts = info("f.h5")
    assert facts["runs"] == kill.there >= 5 and facts["complete"] == 0
    found = open_result("killed/f.h5")
    assert [each.changes for each in found.candidates] == [
        each.changes for each in whole.candidates[: len(found.candidates)]
    ]
    assert found.candidates and len(found.runs) == kill.there
    assert call("fit", "killed/f.h5", "-j", "1", "-q").exit_code == 0
    completed = open_result("killed/f.h5")
    assert completed.complete and [each.price for each in completed.ranking] == [
        each.price for each in whole.ranking
    ]


def count_of(journal):
    """Runs in a journal: its lines behind the first."""
    return journal.read_bytes().count(b"\n") - 1 if journal.exists() else 0
