"""vibsim verify: table, JSON, exit codes, and that it fails where it must."""

import json
import re
import signal

import numpy as np

from tests.command_line.made import call, told
from vibsim.engine.errors import EngineError, State
from vibsim.evidence.verification import checks, laws, verify, vibrations
from vibsim.evidence.verification.catalogue import all_checks
from vibsim.results import Result

QUICK = ("V2", "V3/taylor", "hard/light-rotor")


def test_a_table_of_numbers():
    shown = told("verify", *QUICK)
    header, *lines, verdict = shown.splitlines()
    assert header.split() == ["expected", "obtained", "error", "bound", "verdict"]
    assert re.search(r"\n  frequency +7.697518867 Hz +7.697518867 Hz ", shown)
    assert "257 events, certified" in shown
    assert all(line.endswith("  ok") for line in lines if line.startswith("  "))
    assert verdict.startswith("11 numbers, all within their bounds (")


def test_the_table_as_json():
    found = json.loads(call("verify", "V3/closed_form", "--json").stdout)
    assert (found["passed"], found["fallen_short"]) == (3, [])
    row = found["rows"][1]
    assert (row["check"], row["name"], row["verdict"]) == ("V3/closed_form", "frequency", "ok")
    assert row["expected"] == "7.697518867 Hz"
    assert 0 <= row["error"] <= row["bound"] < 1e-12


def test_json_has_every_point_that_was_compared():
    found = json.loads(call("verify", "hard/light-rotor", "--json").stdout)
    states, events = found["rows"]
    assert len(states["points"]) == 11 * 6 and len(events["points"]) == 257
    assert {point["unit"] for point in states["points"]} == {"m", "m/s", "rad", "rad/s"}


def test_quiet_prints_what_falls_short_only():
    assert call("verify", "-q", *QUICK).stdout == ""


def test_verbose_says_where_bounds_come_from():
    done = call("verify", "-v", "V3/taylor", "hard/light-rotor")
    assert "rounding: 4 units per number of the scene" in done.stdout
    assert "twice the stray of runs of 30 digits that are kicked as doubles round" in done.stdout


def test_the_list_names_every_check():
    names = [line.split()[0] for line in call("verify", "--list").stdout.splitlines()]
    assert names == [check.name for check in all_checks()]
    listed = json.loads(call("verify", "V2", "--list", "--json").stdout)
    assert [check["name"] for check in listed] == ["V2/closed_form", "V2/taylor"]


def test_an_unknown_name_is_a_usage_error():
    done = call("verify", "V3", "hard/stif-stop")
    assert done.exit_code == 2
    assert "no check 'hard/stif-stop' (did you mean hard/stiff-stop?); see --list" in done.stderr
    assert done.stdout == ""


def test_a_planted_wrong_expectation_falls_short(monkeypatch):
    wrong = vibrations.BILINEAR_OSCILLATOR_PERIOD * (1 + 1e-12)
    monkeypatch.setattr(vibrations, "BILINEAR_OSCILLATOR_PERIOD", wrong)
    done = call("verify", "V2", "V3")
    assert done.exit_code == 4
    assert done.stdout.count("FALLS SHORT") == 2
    assert "2 of 12 numbers fall short of their bounds" in done.stdout
    quiet = call("verify", "V2", "V3", "-q")
    assert quiet.exit_code == 4 and "V2" not in quiet.stdout and "FALLS SHORT" in quiet.stdout


def test_a_jump_left_out_of_the_determinant_falls_short(monkeypatch):
    monkeypatch.setattr(laws, "jump_logarithms", lambda *given: ([], 0.0))
    (row,) = verify(["V10/period/closed_form"])
    assert not row.passed and row.error > 0.1


def broken(monkeypatch, change):
    """Let every run be followed by `change` of its samples and events."""
    sound = checks.simulate

    def simulate(*given, **options):
        result = sound(*given, **options)
        samples = {name: column.copy() for name, column in result._samples.items()}
        events = {name: column.copy() for name, column in result.events.items()}
        change(samples, events)
        return Result(result.attrs, samples, events, result.case)

    monkeypatch.setattr(checks, "simulate", simulate)


def fallen(*names):
    return [row.name for row in verify(names) if not row.passed]


def test_an_engine_that_is_a_little_wrong_falls_short(monkeypatch):
    def change(samples, events):
        samples["x1"][-1] *= 1 + 3e-11

    broken(monkeypatch, change)
    assert fallen("hard/light-rotor") == ["hard/light-rotor/taylor: x1 at 10 s"]
    assert call("verify", "hard/light-rotor").exit_code == 4


def test_a_missed_event_falls_short(monkeypatch):
    def change(samples, events):
        events.update({name: np.delete(column, 40) for name, column in events.items()})

    broken(monkeypatch, change)
    assert fallen("hard/light-rotor") == ["hard/light-rotor/taylor: events"]
    assert "256 events, 1 missed, 0 spurious" in call("verify", "hard/light-rotor").stdout


def test_a_spurious_event_falls_short(monkeypatch):
    def change(samples, events):
        events.update({name: np.insert(column, 40, column[40]) for name, column in events.items()})

    broken(monkeypatch, change)
    assert "258 events, 0 missed, 1 spurious" in call("verify", "hard/light-rotor").stdout


def test_a_number_that_is_none_falls_short(monkeypatch):
    def change(samples, events):
        samples["v1"][:] = float("nan")

    broken(monkeypatch, change)
    assert fallen("hard/light-rotor", "V2/taylor")
    found = json.loads(call("verify", "hard/light-rotor", "--json").stdout)
    assert found["rows"][0]["error"] is None and found["rows"][0]["verdict"] == "falls short"


def test_a_run_that_fails_is_a_row(monkeypatch):
    def failing(*given, **options):
        raise EngineError("diverged", State(1.5, [0.0], [0.0], 0.0, 0.0, 0.0))

    monkeypatch.setattr(checks, "simulate", failing)
    done = call("verify", "V2/taylor")
    assert done.exit_code == 4
    assert "failed: " in done.stdout and "FALLS SHORT" in done.stdout


def test_an_interrupted_verification_prints_what_it_has(monkeypatch):
    sound, calls = checks.simulate, []

    def simulate(*given, **options):
        calls.append(given)
        if len(calls) == 2:
            signal.raise_signal(signal.SIGINT)
        return sound(*given, **options)

    monkeypatch.setattr(checks, "simulate", simulate)
    done = call("verify", "V2", "V3")
    assert done.exit_code == 130
    assert "V2/taylor" in done.stdout and "V3" not in done.stdout
    assert "6 numbers, all within their bounds" in done.stdout
    assert "interrupted" in done.stderr
