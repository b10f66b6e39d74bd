"""The time still to wait that the bar of a sweep shows, on a terminal of our own and under our own clock."""

import io
import re
import sys
import time

import pytest

from vibsim.cases import load_case
from vibsim.command_line.sweep_jobs import PATIENCE, PointsProgress
from vibsim.sweeps.points.table import Table
from vibsim.sweeps.statistics.columns import DONE
from vibsim.sweeps.sweeping import make_plan


class Terminal(io.StringIO):
    def isatty(self):
        return True


@pytest.fixture
def clock(monkeypatch):
    """The time, as seconds in a list."""
    now = [1e9]
    monkeypatch.setattr(time, "time", lambda: now[0])
    return now


def points(done):
    table = Table(make_plan(load_case("II-B"), [("excitation.Omega0", "3:7:0.04", "Hz")]))
    table.status.flat[:done] = DONE
    return table


def test_the_rest_takes_as_long_as_the_points_so_far(monkeypatch, clock):
    monkeypatch.setattr(sys, "stderr", Terminal())
    table = points(done=1)  # of 101, there before
    progress = PointsProgress(table, wanted=True)
    for done in (11, 21):
        clock[0] += 10 * PATIENCE
        table.status.flat[:done] = DONE
        progress.show(table)
    progress.close()
    shown = sys.stderr.getvalue().split("\r")[-1]
    assert re.search(r"20/100 +00:01:20", shown), shown  # 80 points at one a second


def test_no_bar_within_the_first_second(monkeypatch, clock):
    monkeypatch.setattr(sys, "stderr", Terminal())
    table = points(done=0)
    progress = PointsProgress(table, wanted=True)
    clock[0] += PATIENCE / 2
    progress.show(table)
    assert sys.stderr.getvalue() == ""


def test_no_bar_without_a_terminal(monkeypatch, clock):
    monkeypatch.setattr(sys, "stderr", io.StringIO())
    progress = PointsProgress(points(done=0), wanted=True)
    clock[0] += 100
    progress.show(points(done=50))
    assert sys.stderr.getvalue() == ""
