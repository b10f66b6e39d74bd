"""Runs in several threads at once have the bits of runs one after the other: what they share is safe.

Without the global lock of Python the threads are truly at once; with it they take turns in Python and compute
in C at once.
"""

import hashlib
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from threading import Barrier, Thread
from time import sleep

import pytest

import vibsim
from vibsim.engine.ledger_integrals import IntegralMaker
from vibsim.engine.modes import mode_table
from vibsim.engine.modes.status import CONTACT, OPEN, Status
from vibsim.engine.truth import open_truth
from vibsim.physics.precision import GUARD_BITS

THREADS = 4
SPAN = {"run.t_end": "2 s", "run.every": "20 ms"}
NAMES = ("I-B", "II-B", "gallery/stack-of-blocks")


@contextmanager
def frequent_switches():
    """Threads take turns in Python every few microseconds."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-5)
    yield
    sys.setswitchinterval(before)


def at_once(work: list[Callable[[], str]]) -> list[str]:
    """What each piece of work returns, begun at one instant in threads of their own, on empty tables."""
    mode_table._tables.clear()
    gate = Barrier(len(work))

    def go(one: Callable[[], str]) -> str:
        gate.wait(timeout=60)
        return one()

    with frequent_switches(), ThreadPoolExecutor(len(work)) as pool:
        return list(pool.map(go, work))


def in_turn(work: list[Callable[[], str]]) -> list[str]:
    """What each returns by itself, on empty tables."""
    answers = []
    for one in work:
        mode_table._tables.clear()
        answers.append(one())
    return answers


def bits(result: vibsim.Result) -> str:
    """Of all samples, events and estimates."""
    columns = [result[name] for name in sorted(result.keys())] + list(result.events.values())
    return hashlib.sha256(b"".join(column.tobytes() for column in columns)).hexdigest()


def run_of(name: str, engine: str = "auto", **changes: str) -> Callable[[], str]:
    settings = SPAN | {key.replace("__", "."): value for key, value in changes.items()}
    return lambda: bits(vibsim.simulate(vibsim.load_case(name, settings), engine=engine))


def orbit_of(speed: str) -> Callable[[], str]:
    def answer() -> str:
        orbit = vibsim.orbit("I-A", overrides={"excitation.omega": speed})
        return repr([*orbit.state.values(), *orbit.multipliers])

    return answer


@pytest.mark.parametrize("name", NAMES)
def test_one_case_many_times_at_once(name):
    """All share one table of modes, and fill it together."""
    work = [run_of(name)] * THREADS
    assert at_once(work) == in_turn(work)


def test_meters_of_two_modes_at_once(monkeypatch):
    """The maker of integrals works on one mode at a time."""
    scene = vibsim.load_case("II-B").scene()
    modes = [Status((stop,), (1,), ()) for stop in (OPEN, CONTACT)]

    def packed(table):
        with ThreadPoolExecutor(2) as pool:
            return list(pool.map(lambda status: table.packed_integrals(status, False), modes))

    alone = [mode_table.ModeTable(scene).packed_integrals(status, False) for status in modes]
    sources = IntegralMaker._sources
    monkeypatch.setattr(IntegralMaker, "_sources", lambda self: (sleep(0.05), sources(self)))
    assert packed(mode_table.ModeTable(scene)) == alone


def test_different_cases_at_once():
    work = [run_of(name) for name in NAMES]
    assert at_once(work) == in_turn(work)


def test_values_of_one_case_at_once():
    """Their tables are renewed from one another's."""
    work = [run_of("II-B", Omega0=f"{5 + i / 4} Hz") for i in range(2)]
    work += [run_of("I-B", c=f"0.0{i + 1} N s/m") for i in range(2)]
    assert at_once(work) == in_turn(work)


def test_both_engines_at_once():
    work = [run_of("II-B", engine, run__t_end="50 ms", run__every="5 ms") for engine in ("c", "python") * 2]
    answers = at_once(work)
    assert answers == in_turn(work)
    assert len(set(answers)) == 1


def test_orbits_at_once():
    work = [orbit_of(f"{3.5 + i / 50} Hz") for i in range(2)]
    assert at_once(work) == in_turn(work)


def test_runs_of_many_digits_take_turns(monkeypatch):
    """python-flint has one working precision in a process: a run of 20 digits that begins while another
    computes with 60 must wait for it.
    """
    flint = pytest.importorskip("flint")
    case = vibsim.load_case("I-B", {"run.t_end": "1 ms", "run.every": "1 ms"})
    trajectory = open_truth(case.exact_scene, 60, engine="python")
    compute, bits_during = trajectory.driver.run, []

    def run_beside_another(*limits):
        bits_during.append(flint.ctx.prec)
        other.start()
        other.join(timeout=0.2)
        bits_during.append(flint.ctx.prec)
        return compute(*limits)

    other = Thread(target=open_truth, args=(case.exact_scene, 20))
    monkeypatch.setattr(trajectory.driver, "run", run_beside_another)
    next(trajectory.blocks())
    other.join(timeout=60)
    assert bits_during == [trajectory.kit.bits + GUARD_BITS] * 2
    assert flint.ctx.prec < bits_during[0]
