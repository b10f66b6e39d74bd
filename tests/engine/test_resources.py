"""Work, memory and threads: no call is without bound, none fails badly, runs at once have their bits."""

import hashlib
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from ctypes import CDLL
from dataclasses import replace
from functools import cache, partial
from itertools import chain, islice
from math import cos, log, sin
from platform import libc_ver
from threading import Barrier
from time import process_time, sleep

import numpy as np
import pytest
from scipy.optimize import linprog

import vibsim
from tests.engine.random_parts import rigid_scenes
from tests.engine.runs import run, scene_of
from tests.random_scenes import always
from vibsim.cases import load_case
from vibsim.engine.c_engine import UNDECIDED, CRun
from vibsim.engine.errors import EngineError, State, start_of
from vibsim.engine.ledger_integrals import IntegralMaker
from vibsim.engine.modes import mode_table
from vibsim.engine.modes.status import CONTACT, OPEN, Status
from vibsim.engine.number_forms import DOUBLES, WordsForm
from vibsim.engine.resume import resume_point
from vibsim.engine.tangent.carried import free_scene
from vibsim.engine.tangent.carrying_run import CarryingRun
from vibsim.engine.trajectory import open_trajectory
from vibsim.engine.truth import open_truth
from vibsim.physics.precision import number_kit

WORK_AT_ONCE = 100_000  # evaluations of the motion, as engine.h has it


SPRING = """
bodies: {m: 1 kg}
links: {l: {between: [m, ground], k: 1 N/m}}
initial: {m: {x: 1 mm}}
run: {t_end: 100 s, every: 1 s}
"""
DRIVEN = f"{SPRING}forces: {{F: {{on: m, A: 1 N, omega: 150 Hz}}}}"
FAST = scene_of(DRIVEN, {"F.omega": "1e9 Hz"})  # one stretch without events of 1e10 pieces


def test_the_ledger_of_one_long_stretch_is_kept_in_many_calls():
    trajectory = open_trajectory(FAST, ledger=True, momentum=True)
    evaluations, worked_to = 0, 0.0
    for block in islice(trajectory.blocks(), 4):
        totals = trajectory.totals
        assert totals["evaluations"] - evaluations < 1.2 * WORK_AT_ONCE
        assert block.worked_to > worked_to
        assert block.t_reached == 0.0
        # what is told belongs to whole stretches
        assert totals["work_source"] == totals["energy_residual"] == totals["momentum_residual"] == 0.0
        evaluations, worked_to = totals["evaluations"], block.worked_to


@pytest.mark.parametrize("method", ("auto", "taylor"))
def test_the_disturbances_of_one_long_stretch_are_carried_in_many_calls(method):
    """A damper that wants 1e9 pieces."""
    trajectory = open_trajectory(scene_of(SPRING, {"l.c": 1e8}, method=method), tangent=2)
    pieces, worked_to = 0, 0.0
    for block in islice(trajectory.blocks(), 4):
        totals = trajectory.totals
        assert totals["tangent_pieces"] - pieces < WORK_AT_ONCE
        assert block.worked_to > worked_to
        pieces, worked_to = totals["tangent_pieces"], block.worked_to
    assert 0 < worked_to < 100.0


def test_the_disturbances_of_many_calls_add_up_as_in_one():
    trajectory = open_trajectory(scene_of(DRIVEN, {"l.c": 2e4}, t_end=16, every=10), tangent=2)
    assert len(list(trajectory.blocks())) > 1
    totals = trajectory.totals
    # the slow motion fades with k / c, and half of the first disturbance is the fast one; their sum is -c / m
    slow = 16 / 2e4 + log(2) / 2
    assert totals["exponents"] * 16 == pytest.approx([-slow, slow - 16 * 2e4], abs=1e-3)
    assert sum(totals["exponents"]) == pytest.approx(-2e4, rel=1e-12)
    assert abs(totals["volume_residual"]) < 1e-14 * 16 * 2e4


def test_a_stretch_of_many_calls_adds_up_as_one():
    """The ledger closes over all of them: no piece is left out or taken twice."""
    scene = scene_of(DRIVEN, {"l.c": 1e-3}, t_end=20, every=10)
    trajectory = open_trajectory(scene, ledger=True, momentum=True)
    assert len(list(trajectory.blocks())) > 1
    for residual in ("energy_residual_relative", "momentum_residual_relative"):
        assert abs(trajectory.totals[residual]) < 1e-12


def test_a_saw_of_many_teeth_asks_for_no_more_numbers_than_one_of_few():
    """Each piece had keys of its own: behind 100,000 of them they were no mode any more."""
    text = f"{SPRING}forces: {{f: {{on: m, force: 'F*mod(t/T, 1)', F: 1 N, T: 1 s}}}}"
    counts = []
    for length in (10.0, 90.0):
        trajectory = open_trajectory(scene_of(text, t_end=length))
        assert sum(len(block.events["t"]) for block in trajectory.blocks()) > length
        counts.append(len(trajectory.run.keys))
    assert counts[0] == counts[1] < 10


def test_section_points_of_one_long_stretch_come_in_blocks():
    for block in islice(open_trajectory(FAST, section=True).blocks(), 4):
        assert len(block.section["time"]) <= 65_536


def test_steps_of_a_run_without_events_come_in_many_calls():
    """A chain of twenty bodies whose stops are never reached; a call does a part of the work."""
    links = [f"l{i}: {{between: [b{i}, b{i + 1}], k: 1 N/m}}" for i in range(19)]
    stop = "gap: 1 m, acts: compression, k: 1 N/m"
    stops = [f"s{i}: {{between: [b{i}, b{i + 1}], {stop}}}" for i in range(19)]
    chain = scene_of(f"""
bodies: {{{", ".join(f"b{i}: 1 kg" for i in range(20))}}}
links: {{{", ".join(links)}}}
stops: {{{", ".join(stops)}}}
friction: {{f: {{between: [b0, ground], N: 1 N, mu: 1}}}}
initial: {{{", ".join(f"b{i}: {{x: {i} mm}}" for i in range(20))}}}
run: {{t_end: 1e9 s, every: 1e8 s}}
""")
    trajectory, steps = open_trajectory(chain), 0
    for _ in islice(trajectory.blocks(), 3):
        assert trajectory.totals["steps"] - steps < WORK_AT_ONCE / 2
        steps = trajectory.totals["steps"]


def test_a_state_far_from_its_event_takes_many_calls():
    stops = "\nstops: {s: {between: [m, ground], gap: 1 m, acts: compression, k: 1 N/m}}"
    quiet = scene_of(DRIVEN + stops, {"F.omega": "3.5 Hz", "F.A": 1e-9}, t_end=1e9, every=1e8)
    row = {name: values[0] for name, values in next(open_trajectory(quiet).blocks()).events.items()}
    far = CRun(quiet, resume_point(quiet, row))
    codes = np.empty((1, 1), dtype="i1")
    assert far.run.states_at(DOUBLES.packed([1e8]), DOUBLES.empty(5, 1), codes, 0) == (0, 0)
    near = open_trajectory(quiet, resume=row).state_at([1e5])
    there = open_trajectory(replace(quiet, t_end=1e5, every_num=10**5)).blocks()
    assert near["x_m"][0] == np.concatenate([block.samples["x_m"] for block in there])[-1]


@pytest.mark.parametrize("gap", ("1e-300 m", "1e-40 m"))
def test_a_gap_that_opens_by_the_fourth_power_of_time_takes_few_steps(gap):
    """A motor that sets off from rest parts the blocks as t^4; steps of the root of the gap would be 1e9."""
    case = load_case("II-B", {"x1": gap, "G": "0 m", "run.t_end": "0.05 s"})
    trajectory = open_trajectory(case.scene())
    samples = [block.samples["x1"] for block in islice(trajectory.blocks(), 40)]
    assert len(np.concatenate(samples)) == 11
    assert trajectory.totals["steps"] < 20


# Bodies between rigid stops without room: they come to rest, or the run says that no motion is possible.


TOUCHING = 1e-12  # m, of depths whose terms are some 0.01 m


WITHOUT_ROOM = """
bodies: {a: 2 kg, b: 1 kg}
stops:
  left: {between: [a, b], gap: 0 m, acts: extension, law: rigid, e: 0.5}
  right: {between: [a, b], gap: 0 m, acts: compression, law: rigid, e: 0.8}
run: {t_end: 0.5 s, every: 50 ms}
"""


@pytest.mark.parametrize(("e", "other"), [(0.5, 0.8), (0.8, 0.5), (0.0, 0.8), (0.3, 0.3)])
@pytest.mark.parametrize("v", [1.0, -1.0])
def test_body_without_room_stands(e, other, v):
    """Impacts at one instant take v, e v, e e' v, ... : nothing is left of the speed."""
    changes = {"left.e": e, "right.e": other, "initial.a.v": v}
    result = run(scene_of(WITHOUT_ROOM.replace("a, b]", "a, ground]"), changes), ledger=True, momentum=True)
    assert not result.samples["x_a"].any()
    assert not result.samples["v_a"][1:].any()
    assert result.totals["impulse_ground"] == pytest.approx(-2.0 * v, rel=1e-14)
    assert result.totals["loss_stops"] == pytest.approx(1.0, rel=1e-14)


@pytest.mark.parametrize("v", [1.0, -1.0])
def test_bodies_without_room_go_on_together(v):
    result = run(scene_of(WITHOUT_ROOM, {"initial.a.v": v}), ledger=True, momentum=True)
    for name in ("v_a", "v_b"):
        assert result.samples[name][1:] == pytest.approx(2 / 3 * v, rel=1e-15)
    assert abs(result.totals["momentum_residual"]) < 1e-15


def is_jammed(scene, state):
    """Whether no velocities of the bodies keep all stops that touch from closing, by linear programming."""
    n = len(scene.bodies)
    angles = [(term, term.omega * state.t + term.phase) for term in scene.base]
    X = sum(term.amplitude * sin(angle) for term, angle in angles)
    V = sum(term.amplitude * term.omega * cos(angle) for term, angle in angles)
    places, rates = [*state.x, X, 0.0], {-1: 0.0, -2: V}  # BASE is -2, GROUND -1
    rows, limits = [], []
    for _, stop in scene.rigid_stops:
        if -(stop.sense * (places[stop.P] - places[stop.Q])) - stop.gap > -TOUCHING:
            row, limit = np.zeros(n), 0.0
            for end, sign in ((stop.P, -stop.sense), (stop.Q, stop.sense)):
                if end >= 0:
                    row[end] += sign
                else:
                    limit -= sign * rates[end] / abs(V or 1.0)
            rows.append(row)
            limits.append(limit)
    slack = linprog(
        [0.0] * n + [1.0],
        A_ub=np.hstack([np.array(rows), -np.ones((len(rows), 1))]),
        b_ub=limits,
        bounds=[(None, None)] * n + [(0.0, None)],
    )
    return slack.fun > 1e-9  # shares of the base's speed


def assert_solved_or_jammed(scene):
    try:
        run(scene, most=2000)
    except EngineError as error:
        assert error.reason == "crushed"
        assert is_jammed(scene, error.state)
        assert sum(stop.name in str(error) for _, stop in scene.rigid_stops) >= 2


test_errors_are_of_jammed_bodies = always(assert_solved_or_jammed, rigid_scenes(), few=40, many=3000)


# Arrays of one run are not faulted in anew by the next.


RUNS = 2
SCRIPT = f"""
import resource
from vibsim import load_case, simulate
case = load_case("II-B", {{"run.t_end": "150 s"}})
def faults():
    return resource.getrusage(resource.RUSAGE_SELF).ru_minflt
for _ in range({RUNS}):
    simulate(case)
before = faults()
for _ in range({RUNS}):
    simulate(case)
print((faults() - before) / {RUNS})
"""


def faults_per_run(**environment):
    told = {key: value for key, value in os.environ.items() if not key.startswith("MALLOC_")}
    command = [sys.executable, "-c", SCRIPT]
    done = subprocess.run(command, env=told | environment, capture_output=True, text=True, check=True)
    return float(done.stdout)


@pytest.mark.skipif(libc_ver()[0] != "glibc", reason="the C library of Linux")
@pytest.mark.skipif("libasan" in os.environ.get("LD_PRELOAD", ""), reason="another malloc")
def test_a_run_uses_the_memory_that_the_one_before_it_freed():
    pytest.importorskip("vibsim.engine._engine")
    assert faults_per_run() < 1000 < faults_per_run(MALLOC_TRIM_THRESHOLD_="1000000")


# Runs in several threads at once have the bits of runs one after the other: what they share is safe.
# Without the global lock of Python the threads are truly at once; with it they take turns in Python and
# compute in C at once.


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


def run_of(name: str, **changes: str) -> Callable[[], str]:
    settings = SPAN | {key.replace("__", "."): value for key, value in changes.items()}
    return lambda: bits(vibsim.simulate(vibsim.load_case(name, settings)))


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


def test_orbits_at_once():
    work = [orbit_of(f"{3.5 + i / 50} Hz") for i in range(2)]
    assert at_once(work) == in_turn(work)


def test_runs_of_other_digits_may_be_computed_meanwhile():
    """The precision of C is that of a thread: a run of 80 digits has its digits beside one of 150."""
    case = vibsim.load_case("I-B", {"run.t_end": "1 s", "run.every": "1 s"})

    def digits_of(digits):
        return [block.sample_digits["x1"].tolist() for block in open_truth(case.exact_scene, digits).blocks()]

    work = [partial(digits_of, digits) for digits in (80, 150, 80, 150)]
    assert at_once(work) == in_turn(work)


class Heard(Exception):
    """Raised by a signal, as Ctrl-C raises a KeyboardInterrupt."""


def advanced(run, with_signal=False):
    """What a run in C has come to; None where a signal ended it, which is there when C begins."""
    send, pieces = partial(CDLL(None)["raise"], signal.SIGVTALRM), []
    with suppress(Heard):  # from one call of C to the other: Python would hear it in between
        pieces.extend(chain(islice(iter(send, None), with_signal), islice(iter(run.advance, None), 1)))
    return pieces[with_signal] if len(pieces) > with_signal else None


@pytest.fixture
def signals():
    """Has a signal come after some processor time [s]; it raises Heard in vibsim and in `advanced`."""
    if sys.platform == "win32":
        pytest.skip("Windows has no such signals")

    def raise_it(_, frame):
        if frame.f_code is advanced.__code__ or frame.f_code.co_filename.startswith(vibsim.__path__[0]):
            raise Heard

    before = signal.signal(signal.SIGVTALRM, raise_it)
    yield lambda share: signal.setitimer(signal.ITIMER_VIRTUAL, share)
    signal.setitimer(signal.ITIMER_VIRTUAL, 0)
    signal.signal(signal.SIGVTALRM, before)


def first_step():
    """The first step of a run of 1000 digits."""
    open_truth(vibsim.load_case("II-B", {"run.t_end": "1 ms"}).exact_scene, 1000)


@cache
def seconds_of_first_step():
    """Processor time that it takes on this machine: 2.5 s, say."""
    begin = process_time()
    first_step()
    return process_time() - begin


def assert_hears(signals, work):
    """A signal ends work that takes as long as a first step or longer."""
    whole, begin = seconds_of_first_step(), process_time()
    signals(whole / 8)
    with pytest.raises(Heard):
        work()
    assert process_time() - begin < whole / 2


def test_a_step_of_many_digits_hears_a_signal(signals):
    assert_hears(signals, first_step)


def assert_made_anew(run_with):
    """Whether there are signals or none, a run comes to the same; of `run_with`, told so: what it comes to,
    and how often it was interrupted. Of two calls of C one at most is interrupted, so that it goes on.
    """
    (expected, never), (found, heard) = run_with(False), run_with(True)
    assert found == expected and never == 0 < heard


@pytest.mark.usefixtures("signals")
def test_a_step_that_a_signal_ends_is_made_anew():
    """With the same bits: between expansions and in the midst of them."""

    def first_event(with_signals):
        """State and steps of a run at its first event."""
        run, heard, status = open_truth(case.exact_scene, 200).run.run, 0, 0
        while not status:
            *_, status = advanced(run, with_signals and status is not None) or (None,)
            heard += status is None
        return (run.tally()["state"], run.tally()["steps"]), heard

    case = vibsim.load_case("II-B", {"run.t_end": "2 s"})
    assert_made_anew(first_event)


def carrying(case, digits, count):
    """A run of many digits about to begin, with so many disturbances of its start."""
    kit = number_kit(digits)
    scene = case.exact_scene(kit.number, kit.pi)
    run = CarryingRun(free_scene(scene), WordsForm(kit))
    vectors = [[kit.number(int(i == j)) for j in range(count)] for i in range(count)]
    run.restart(start_of(scene, kit), scene.t_end, vectors)
    return run


def test_disturbances_of_many_digits_hear_a_signal(signals):
    """A piece of the six of a motor in 600 digits takes 1.6 such steps, of which the motion has 0.2."""
    run = carrying(vibsim.load_case("II-B", {"run.t_end": "1 s"}), 600, 6)
    assert_hears(signals, run.run_out)


@pytest.mark.usefixtures("signals")
@pytest.mark.parametrize("carries", [False, True])
def test_what_a_signal_ends_beside_the_motion_is_made_anew(carries):
    """Disturbances, and the look of a rule at how a force comes to its limit: with the same bits. C
    looks for signals every 1e8 products of words: pieces of so many digits have several times that.
    """

    def ended(with_signals):
        """What a run has come to at its end."""
        case = vibsim.load_case("I-A", {"run.t_end": "0.3 s", "run.method": "taylor"})
        run = carrying(case, 600, 4) if carries else open_truth(case.exact_scene, 1000).run
        heard, finished, status = 0, 0, 0
        while not finished:
            *_, finished, status = advanced(run.run, with_signals and status is not None) or (0, None)
            heard += status is None
            if status == UNDECIDED:
                number, event, order, values = run.run.pending()
                if not run._set_rule(number, event):
                    *_, finished, _ = run._decide(number, event, State(*values), order)
        tally = run.run.tally()
        told = [repr(number) for number in (tally["state"], tally["steps"], tally["counts"])]
        return told + ([repr(run.outcome(4).vectors.tolist())] if carries else []), heard

    assert_made_anew(ended)
