"""`vibsim bench`: the table, files, pictures, the truth used again, interruption."""

import json
import os
import re
import signal
from importlib.util import find_spec
from pathlib import Path

import pytest

from tests.command_line.made import call, refused, told
from vibsim.cases.quantities import number
from vibsim.evidence.benchmark import open_bench, running
from vibsim.evidence.benchmark.plan import FAMILIES

SHORT = ("--t-end", "1s", "--methods", "taylor,dop853,rk4")
SHORTEST = ("--t-end", "0.5s", "--methods", "dop853")


@pytest.fixture(autouse=True)
def own_folder(here, monkeypatch):
    monkeypatch.setattr("vibsim.evidence.benchmark.running.ENOUGH", 0.0)
    return here


def test_a_small_bench_from_end_to_end():
    done = call("bench", *SHORT, "--plot", "b.png")
    assert (done.exit_code, done.stderr) == (0, "no case given: measuring II-B\n")
    bench = open_bench("II-B-bench.h5")
    assert bench.complete and len(bench.rows) == 15 and Path("b.png").stat().st_size > 10_000
    lines = done.stdout.splitlines()
    assert lines[0].startswith("II-B  ") and "30 digits carried" in done.stdout
    for row in bench.rows:
        (line,) = [line for line in lines if line.startswith(f"  {row.setting} ")]
        assert number(row.error_until(bench["time"], 1.0), 2) in line and f" {row.steps} " in line
    assert sum("fastest" in line for line in lines) == sum("most accurate" in line for line in lines) == 1
    assert re.search(
        r"beside it +DOP853 with events, rtol \S+ +\d\S* x the time, \S+ x the error", done.stdout
    )
    assert len({len(line) for line in lines if line.startswith("  rtol")}) <= 2  # aligned, but for a remark


def test_json():
    done = call("bench", "I-A", *SHORT, "--json", "-o", "b.h5")
    found = json.loads(done.stdout)
    assert found["file"] == "b.h5" and found["case"]["name"] == "I-A" and found["complete"] == 1
    assert [row["setting"] for row in found["rows"]][:6:5] == ["tol 1e-3", "rtol 1e-3"]
    assert found["rows"][5]["events"]["contact_begin"].keys() == {"found", "missed", "spurious"}
    assert found["beside"][0]["method"] == "dop853"


def test_compiling_of_heyoka_is_told_apart():
    pytest.importorskip("heyoka")
    done = call("bench", "I-A", "--t-end", "1s", "--methods", "heyoka,dop853")
    assert re.search(r"heyoka\.py with events  \(compiled beforehand in \d\.\d\d s at most\)", done.stdout)
    assert "DOP853 with events\n" in done.stdout


def test_info_prints_the_same_table():
    table = call("bench", "I-A", *SHORTEST).stdout.splitlines()
    shown = call("info", "I-A-bench.h5")
    assert shown.exit_code == 0 and shown.stdout.splitlines()[:-1] == table[:-1]
    assert json.loads(call("info", "I-A-bench.h5", "--json").stdout)["vibsim_kind"] == "bench"
    more = call("info", "-v", "I-A-bench.h5").stdout
    assert "truth_digits = " in more and set(shown.stdout.splitlines()) < set(more.splitlines())
    assert call("info", "I-A-bench.h5", "--case").stdout == call("cases", "I-A").stdout


def test_the_truth_is_computed_once(monkeypatch):
    assert call("bench", "I-A", *SHORTEST).exit_code == 0
    again = "vibsim.evidence.benchmark.running.compute_truth"
    monkeypatch.setattr(again, lambda *given: pytest.fail("computed again"))
    told("bench", "I-A", *SHORTEST, "--force")
    told("bench", "I-A", *SHORTEST, "-o", "b.h5", "--truth", "I-A-bench.h5")
    said = refused("bench", "I-B", *SHORTEST, "--truth", "b.h5")
    assert "--truth: b.h5: its truth is of another case; it differs in excitation.A (0.0725 N there" in said


def test_what_is_not_installed_is_named(monkeypatch):
    monkeypatch.setattr(
        "vibsim.evidence.benchmark.plan.find_spec", lambda name: None if name == "heyoka" else find_spec(name)
    )
    shown = told("bench", "--t-end", "1s", "--methods", "taylor,heyoka")
    assert "heyoka.py with events  not installed: pip install 'vibsim[bench]'" in shown


@pytest.mark.parametrize(
    ("words", "code", "message"),
    [(("--methods", "dop85"), 2, "did you mean dop853?"), (("--limit", "0"), 2, "--limit"),
     (("--t-end", "1ms"), 2, "too short"), (("--t-end", "soon"), 3, "--t-end: must be a time"),
     (("-s", "nonsense=1"), 3, "nonsense"), (("--plot", "b.gif"), 2, "suffix .gif"),
     (("--truth", "none.h5"), 6, "No such file"), (("-o", "no/b.h5"), 6, "does not exist")],
)  # fmt: skip
def test_what_is_refused(words, code, message, own_folder):
    done = call("bench", "I-A", *(() if "--t-end" in words else ("--t-end", "1s")), *words)
    assert done.exit_code == code and message in done.stderr
    assert list(own_folder.iterdir()) == []


def test_without_an_engine_for_the_truth(monkeypatch):
    monkeypatch.setattr("vibsim.command_line.commands.run.is_built", lambda words: False)
    assert "which was not built here" in refused("bench", "I-A", *SHORT)


def test_the_help_names_every_method():
    words = call("bench", "--help").stdout.replace("\n", " ").split()
    assert {family.name for family in FAMILIES} <= {word.strip(",.") for word in words}


def test_interruption_keeps_the_rows_done(monkeypatch):
    sound, calls = running.measure, []

    def measure(*given):
        calls.append(given)
        if len(calls) == 4:
            signal.raise_signal(signal.SIGINT)
        return sound(*given)

    monkeypatch.setattr(running, "measure", measure)
    done = call("bench", "I-A", *SHORT, "-o", "b.h5")
    assert done.exit_code == 130
    assert "interrupted: b.h5 holds the rows that were done" in done.stderr and "stopped early" in done.stdout
    left = open_bench("b.h5")
    assert not left.complete and len(left.rows) == 3 and os.listdir() == ["b.h5"]


def test_a_case_with_a_rigid_stop():
    shown = told("bench", "gallery/ball-on-shaken-table", "--t-end", "1s", "--methods", "taylor,dop853,rk4")
    assert "RK4, sgn, no events  left out: the case has rigid stops, which need located events" in shown
    bench = open_bench("ball-on-shaken-table-bench.h5")
    best = bench.rows[-1]
    assert {row.method for row in bench.rows} == {"taylor", "dop853"} and bench.complete
    assert best.events["impact"].missed == 0 and best.events["impact"].found > 10
    assert best.error_until(bench["time"], 1.0) < 1e-12
    (line,) = [line for line in shown.splitlines() if line.startswith("  rtol 2.3e-14 ")]
    facts = json.loads(call("info", "ball-on-shaken-table-bench.h5", "--json").stdout)
    rate = facts["rows"][-1]["impacts_per_second"]
    assert f" {float(f'{rate:.3g}'):g} " in line and rate > 10


@pytest.mark.parametrize(
    ("name", "peers"),
    [
        ("gallery/chain-with-gaps", "dop853,rk45"),
        ("gallery/belt-oscillator", "dop853"),
        ("hard/zeno-ball", "dop853,rk45"),
    ],
)
def test_any_case(name, peers):
    methods = f"closed-form,taylor,{peers}"
    done = call("bench", name, "--t-end", "1s", "--limit", "600", "--methods", methods)
    assert done.exit_code == 0 and "failed" not in done.stdout and "beside it" in done.stdout
