"""An older vibsim built beside this one, and processes of both that are timed by turns.

The pinned commit is the last with an engine of its own for two blocks. Every process starts once, warms up
and then does what it is asked, so that the two are measured within milliseconds of each other.
"""

import io
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
    what = line.strip()
    began = time.perf_counter()
    {work}
    print(time.perf_counter() - began, flush=True)
"""
ENGINE = {
    "pinned": """
from vibsim.cases import load_case
from vibsim.kernel import open_trajectory
scenes = {name: load_case(name).scene() for name in CASES}
""",
    "current": """
from vibsim.cases import load_case
from vibsim.engine.trajectory import open_trajectory
scenes = {name: load_case(name).scene() for name in CASES}
""",
}
RUN_ENGINE = "for _ in open_trajectory(scenes[what], 'c').blocks(): pass"
SIMULATE = """
from vibsim import load_case, simulate
cases = {name: load_case(name) for name in CASES}
"""
RUN_SIMULATE = "simulate(cases[what])"


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
    """A process of one build that does `work` when asked; `of(name)` is the time that takes [s]."""

    def __init__(self, which: str, preparation: str, work: str, cases: tuple[str, ...]):
        program = SERVER.format(preparation=f"CASES = {cases!r}\n{preparation}", work=work)
        self._process = subprocess.Popen(
            [sys.executable, "-c", program],
            cwd=folder(which),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        for name in cases:
            self.of(name)

    def of(self, name: str) -> float:
        """Time [s] for one piece of work, by the clock on the wall: all threads of a run count."""
        assert self._process.stdin and self._process.stdout
        self._process.stdin.write(f"{name}\n")
        self._process.stdin.flush()
        return float(self._process.stdout.readline())

    def close(self) -> None:
        self._process.communicate()


def engines(cases: tuple[str, ...]) -> tuple[Timed, Timed]:
    """Engine runs by this build and by the pinned one."""
    ours, theirs = (Timed(which, ENGINE[which], RUN_ENGINE, cases) for which in ("current", "pinned"))
    return ours, theirs


def simulations(cases: tuple[str, ...]) -> tuple[Timed, Timed]:
    """`vibsim.simulate` by this build and by the pinned one."""
    ours, theirs = (Timed(which, SIMULATE, RUN_SIMULATE, cases) for which in ("current", "pinned"))
    return ours, theirs
