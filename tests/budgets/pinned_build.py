"""An older vibsim built beside this one, and processes of both that are timed by turns.

The pinned commit is the last with an engine of its own for two blocks. A process warms up
and then runs when it is asked, so that the two are measured within milliseconds of each other.
"""

import io
import os
import random
import subprocess
import sys
import tarfile
from pathlib import Path

PINNED = "6820568"
ROOT = Path(__file__).resolve().parents[2]
BUILD = ROOT / "build" / f"pinned-{PINNED}"

SERVER = """
import sys, time
{preparation}
for line in sys.stdin:
    began = time.perf_counter()
    {work}
    print(time.perf_counter() - began, flush=True)
"""
ENGINE = {
    "pinned": """
from vibsim.cases import load_case
from vibsim.kernel import open_trajectory
scene = load_case("{case}").scene()
""",
    "current": """
from vibsim.cases import load_case
from vibsim.engine.trajectory import open_trajectory
scene = load_case("{case}").scene()
""",
}
RUN_ENGINE = {
    "pinned": "for _ in open_trajectory(scene, 'c').blocks(): pass",
    "current": "for _ in open_trajectory(scene).blocks(): pass",
}
SIMULATE = """
from vibsim import load_case, simulate
case = load_case("{case}")
"""
RUN_SIMULATE = "simulate(case)"


def folder(which: str) -> Path:
    """Where the package of `which` ("pinned" or "current") is, built if need be."""
    if which == "current":
        return ROOT
    if not list(BUILD.glob("vibsim/kernel/_kernel*.so")):
        BUILD.mkdir(parents=True, exist_ok=True)
        archive = subprocess.run(["git", "archive", PINNED], cwd=ROOT, check=True, capture_output=True).stdout
        with tarfile.open(fileobj=io.BytesIO(archive)) as tar:
            tar.extractall(BUILD, filter="data")
        build = [sys.executable, "setup.py", "-q", "build_ext", "--inplace"]
        subprocess.run(build, cwd=BUILD, check=True, capture_output=True)
    return BUILD


class Timed:
    """A process of one build that runs a case when asked, on the core `core` where one is given."""

    def __init__(self, which: str, preparation: str, work: str, case: str, core: int | None = None):
        program = SERVER.format(preparation=preparation.format(case=case), work=work)
        self._process = subprocess.Popen(
            [sys.executable, "-c", program],
            cwd=folder(which),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        if core is not None:
            os.sched_setaffinity(self._process.pid, {core})
        self.run()

    def run(self) -> float:
        """Time [s] of one run, by the clock on the wall: all threads of a run count."""
        assert self._process.stdin and self._process.stdout
        self._process.stdin.write("run\n")
        self._process.stdin.flush()
        return float(self._process.stdout.readline())

    def close(self) -> None:
        self._process.communicate()


def engines(case: str) -> tuple[Timed, Timed]:
    """Engine runs by this build and by the pinned one, on the same core: two cores are not equally fast."""
    core = random.choice(sorted(os.sched_getaffinity(0))) if hasattr(os, "sched_getaffinity") else None
    ours, theirs = (
        Timed(which, ENGINE[which], RUN_ENGINE[which], case, core) for which in ("current", "pinned")
    )
    return ours, theirs


def simulations(case: str) -> tuple[Timed, Timed]:
    """`vibsim.simulate` by this build and by the pinned one."""
    ours, theirs = (Timed(which, SIMULATE, RUN_SIMULATE, case) for which in ("current", "pinned"))
    return ours, theirs
