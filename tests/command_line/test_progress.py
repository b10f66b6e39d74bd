"""What the bar shows, and the time still to wait, on a terminal of our own and under our own clock."""

import io
import re
import sys
import time

import pytest

from vibsim.command_line.terminal import PROGRESS_AFTER, Progress


class Terminal(io.StringIO):
    def isatty(self):
        return True


@pytest.fixture
def clock(monkeypatch):
    """The time, as seconds in a list."""
    now = [1e9]
    monkeypatch.setattr(time, "time", lambda: now[0])
    return now


def test_the_rest_takes_as_long_as_what_is_done(monkeypatch, clock):
    monkeypatch.setattr(sys, "stderr", Terminal())
    progress = Progress(shown=True, patience=PROGRESS_AFTER)
    for done in (10, 20):
        clock[0] += 10 * PROGRESS_AFTER
        progress.show("points", done, 100)
    progress.close()
    shown = sys.stderr.getvalue().split("\r")[-1]
    assert re.search(r"points .* 20/100 +00:01:20", shown), shown  # 80 points at one a second


def test_time_of_the_motion_is_shown_in_seconds(monkeypatch, clock):
    monkeypatch.setattr(sys, "stderr", Terminal())
    progress = Progress(shown=True, patience=PROGRESS_AFTER)
    for t in (15.0, 30.0):
        clock[0] += 2 * PROGRESS_AFTER
        progress.show("II-B", t, 300.0)
    progress.close()
    assert re.search(r"II-B .* 10% +00:00:36 +30.0 of 300 s", sys.stderr.getvalue())


def test_the_same_step_once_more_has_a_bar_and_a_beginning_of_its_own(monkeypatch, clock):
    monkeypatch.setattr(sys, "stderr", Terminal())
    progress = Progress(shown=True, patience=PROGRESS_AFTER)
    clock[0] += 10 * PROGRESS_AFTER
    progress.show("II-B", 300.0, 300.0)
    progress.show("II-B", 1.0, 300.0)  # within its first second
    assert sys.stderr.getvalue().endswith("300.0 of 300 s\x1b[?25h\n")
    for t in (75.0, 150.0):
        clock[0] += 5 * PROGRESS_AFTER
        progress.show("II-B", t, 300.0)
    progress.close()
    assert re.search(r" 50% +00:00:10 +150.0 of 300 s", sys.stderr.getvalue())


def test_a_step_of_unequal_things_names_them_and_promises_no_time(monkeypatch, clock):
    monkeypatch.setattr(sys, "stderr", Terminal())
    progress = Progress(shown=True)
    for number, name in enumerate(("taylor, 20", "rk45, 1e-6")):
        clock[0] += 10
        progress.show("methods", number / 2, 1.0, name)
    progress.close()
    first, second = (line for line in sys.stderr.getvalue().split("\r") if ", " in line)
    assert "  0%  taylor, 20" in first and " 50%  rk45, 1e-6" in second and "00:" not in second


def test_no_bar_within_the_first_second(monkeypatch, clock):
    monkeypatch.setattr(sys, "stderr", Terminal())
    progress = Progress(shown=True, patience=PROGRESS_AFTER)
    clock[0] += PROGRESS_AFTER / 2
    progress.show("points", 1, 100)
    assert sys.stderr.getvalue() == ""


@pytest.mark.parametrize(("listed", "said"), [(False, ""), (True, "runs\nfigures\n")])
def test_without_a_terminal_there_are_lines_at_most(monkeypatch, clock, capsys, listed, said):
    progress = Progress(shown=True, listed=listed)
    for step, done in (("runs", 0), ("runs", 9), ("figures", 0)):
        clock[0] += 100
        progress.show(step, done, 10)
    progress.close()
    assert capsys.readouterr().err == said


def test_nothing_is_shown_where_it_is_not_wanted(monkeypatch, clock):
    monkeypatch.setattr(sys, "stderr", Terminal())
    Progress(shown=False, listed=True).show("runs", 5, 10)
    assert sys.stderr.getvalue() == ""
