"""The history of the budgets, and the page that is made from it."""

import json
import re
from datetime import datetime, timezone

import pytest

from from_code.benchmarks import HISTORY as STORED
from from_code.benchmarks import NONE_YET, page
from tests.budgets.history import HISTORY, append, commit, run_of, runs_in
from tests.budgets.row import Row
from tests.docs.pages import DOCS

NOON = datetime(2026, 3, 1, 12, tzinfo=timezone.utc)
MOTORS = ("II-A", "II-B", "II-C")
ROWS = [
    Row("engine, I-A", "ms", 10.0, [9.0, 8.0, 9.5]),
    Row("DOP853 | vibsim", "x", 500.0, [400.0], at_least=True),
    Row("no limit", "kB", None, [3.0]),
]


def run(rows=ROWS, day=1):
    return run_of(rows, {"numpy": "2.0"}, NOON.replace(day=day))


def test_runs_are_appended(tmp_path):
    path = tmp_path / "deep" / "history.json"
    assert runs_in(path) == []
    append(run(), path)
    append(run(day=2), path)
    first, second = runs_in(path)
    assert (first["date"], second["date"]) == ("2026-03-01T12:00:00Z", "2026-03-02T12:00:00Z")
    budget, peer, free = first["budgets"]
    assert (budget["median"], budget["smallest"], budget["largest"], budget["met"]) == (9.0, 8.0, 9.5, True)
    assert (peer["met"], peer["at_least"], free["met"], free["limit"]) == (False, True, None, None)
    assert first["versions"]["numpy"] == "2.0" and "cores" in first["machine"]
    assert [each.name for each in path.parent.iterdir()] == ["history.json"]


def test_what_is_no_history_is_kept(tmp_path):
    path = tmp_path / "history.json"
    path.write_text('{"format": 99}')
    with pytest.raises(ValueError, match="is no history of format 1; move it away"):
        append(run(), path)
    assert path.read_text() == '{"format": 99}'


def test_without_git_there_is_no_commit(tmp_path):
    assert commit(tmp_path) is None


def test_the_page(tmp_path):
    path = tmp_path / "history.json"
    append(run(), path)
    append(run([Row("engine, I-A", "ms", 10.0, [11.0, 12.0, 13.0])], day=2), path)
    text = page(path)
    assert "| engine, I-A | at most 10 ms | 12 ms (11 to 13) | **not met** |" in text
    latest, history = text.split("## History")
    assert "2026-03-02" in latest and "2026-03-01" not in latest
    assert history.index("2026-03-02") < history.index("2026-03-01")
    assert "9 ms (8 to 9.5)" in history and "no limit" not in history  # measured once


def test_pipes_in_names_break_no_table(tmp_path):
    path = tmp_path / "history.json"
    append(run(), path)
    assert r"| DOP853 \| vibsim | at least 500 x | 400 x | **not met** |" in page(path)


def test_a_page_without_runs(tmp_path):
    path = tmp_path / "history.json"
    path.write_text(json.dumps({"format": 1, "runs": []}))
    assert page(path).endswith(NONE_YET) and page(tmp_path / "none.json") == page(path)


def test_the_stored_history_is_the_one_that_is_shown():
    assert STORED.resolve() == HISTORY and isinstance(runs_in(), list)
    assert page().startswith("# Benchmarks")


def test_pages_say_of_heyoka_what_the_latest_stored_run_with_it_measured():
    """Times of whole runs against vibsim's, to a tenth; the pages have no other number for it."""
    stored = [{budget["name"]: budget["median"] for budget in run["budgets"]} for run in runs_in(STORED)]
    latest = [run for run in stored if "II-B, vibsim / heyoka.py, 60,001 samples" in run][-1]
    times = {name: f"{1 / latest[f'{name}, vibsim / heyoka.py, 60,001 samples']:.1f}" for name in MOTORS}
    speed, comparison = ((DOCS / page).read_text(encoding="utf-8") for page in ("speed.md", "comparison.md"))
    rows = re.findall(r"^\| (II-.), .* heyoka\.py.*: ([\d.]+) times", speed, flags=re.MULTILINE)
    assert dict(rows) == times
    for text in (speed, comparison):
        said = re.findall(r"heyoka\.py[^.;|]{0,40}? ([\d.]+) times", text.partition("\n| II-A")[0])
        assert said == [times["II-B"]]
