"""The history of the budgets: every run of `make budgets` is appended to docs/benchmarks/history.json.

    {"format": 1, "runs": [{"date", "commit", "machine", "versions", "budgets": [...]}]}

A budget has name, unit, limit (null for none), at_least, median, smallest, largest, repetitions and met (null
where there is no limit). The page of the site that shows it is made by docs/from_code/benchmarks.py.
"""

import json
import platform
import subprocess
from datetime import datetime, timezone
from pathlib import Path
from statistics import median

from vibsim.engine.blocks_ahead import available_cores
from vibsim.evidence.benchmark.running import processor
from vibsim.results.output_files import output_file

FORMAT = 1
ROOT = Path(__file__).resolve().parents[2]
HISTORY = ROOT / "docs" / "benchmarks" / "history.json"
MET = {"met": True, "NOT MET": False}


def plain(row):
    """A row of the table as plain data."""
    return {
        "name": row.budget,
        "unit": row.unit,
        "limit": row.limit,
        "at_least": row.at_least,
        "median": median(row.figures),
        "smallest": min(row.figures),
        "largest": max(row.figures),
        "repetitions": len(row.figures),
        "met": MET.get(row.met),
    }


def run_of(rows, versions, now=None):
    """A run of the budgets as plain data. versions : of packages, by name"""
    moment = now or datetime.now(timezone.utc)
    return {
        "date": moment.strftime("%Y-%m-%dT%H:%M:%SZ"),
        "commit": commit(),
        "machine": f"{processor()}, {available_cores()} cores, {platform.system()} {platform.machine()}",
        "versions": {"Python": platform.python_version(), **versions},
        "budgets": [plain(row) for row in rows],
    }


def commit(root=ROOT):
    """What git calls the state of the sources, -dirty where it is changed; None without git."""
    command = ["git", "-C", str(root), "describe", "--always", "--dirty"]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        return None
    return done.stdout.strip()


def runs_in(path=HISTORY):
    """The runs of a history; none where there is no file. Raises ValueError for a file that is no history."""
    if not path.exists():
        return []
    history = json.loads(path.read_text(encoding="utf-8"))
    if not isinstance(history, dict) or history.get("format") != FORMAT:
        raise ValueError(f"{path} is no history of format {FORMAT}; move it away to begin another")
    return history["runs"]


def append(run, path=HISTORY):
    """Add a run at the end of a history: written beside it and renamed, so that none is ever lost."""
    history = {"format": FORMAT, "runs": [*runs_in(path), run]}
    path.parent.mkdir(parents=True, exist_ok=True)
    with output_file(path, force=True, encoding="utf-8") as file:
        file.write(json.dumps(history, indent=1, ensure_ascii=False) + "\n")
