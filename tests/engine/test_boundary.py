"""What the C engine is given from outside: every index, size and layout is checked."""

import gc
import sys
import threading
from array import array
from copy import deepcopy

import numpy as np
import pytest

from tests.engine.runs import scene_of
from tests.scenes import harmonic, paper, scene
from vibsim.cases import load_case
from vibsim.engine import _engine
from vibsim.engine.c_engine import CRun
from vibsim.engine.flows.closed.modal import pitches
from vibsim.engine.modes.packing import pack_scene, pack_state, packed_mode
from vibsim.engine.number_forms import DOUBLES
from vibsim.engine.tangent.packing_tangent import bundle_form, bundle_numbers, pack_bundle
from vibsim.engine.tangent.tangent_space import dimension, length

HUGE = (2**31 - 1, 10**6, -(10**6), -(2**31))
PAPER = paper("II-B").as_parts()
DRILL = load_case("gallery/percussive-drill").scene()
FORMULAS = scene_of("""
parameters: {F: 1 N, L: 1 m, v0: 1 m/s, T: 1 s}
bodies: {a: 1 kg}
links: {spring: {between: [a, base], force: "F*(20*d/L + tanh(d/L) + sin(3*d/L))"}}
forces: {f: {on: a, force: "F*atan(x_a/L) + F*step(x_a/L - 0.1)"}}
states: {z: {rate: "0*z/T", start: 0 m}}
rotors: {r: {on: a, m: 0.1 kg, e: 1 m, J: 0.9 kg m^2}}
base: {x: "q*sin(t/T)", q: 1 cm}
run: {t_end: 3 s, every: 20 ms}
""")
SCENES = pytest.mark.parametrize("of", (PAPER, DRILL, FORMULAS), ids=("II-B", "drill", "formulas"))


def packed(of):
    """(scene, first mode, run) as they go into C."""
    run = CRun(of)
    scene_bytes = pack_scene(of, pitches(of), switches=len(run.switches))
    return scene_bytes, packed_mode(run.rows_of(0), deepcopy(run.keys)).packed, run


def opened(scene_bytes, mode_bytes):
    """A run of packed numbers with one mode, not yet started."""
    run = _engine.Run(*scene_bytes)
    run.add_mode(*mode_bytes)
    return run


def with_int(packed_ints, place, value):
    ints = array("i", packed_ints)
    ints[place] = value
    return ints.tobytes()


def refusals(use, ints, values=HUGE, then=lambda run: None):
    """How often `use` refuses packed whole numbers, each of which is far out in turn; what it takes does no
    harm, nor does what is done `then`.
    """
    refused = 0
    for place in range(len(ints) // 4):
        for value in values:
            try:
                run = use(with_int(ints, place, value))
            except (ValueError, MemoryError):
                refused += 1
            else:
                then(run)
    return refused


@SCENES
@pytest.mark.parametrize("which", (0, 1), ids=("scene", "mode"))
def test_no_index_reaches_beyond_its_table(of, which):
    whole = packed(of)
    ints, doubles = whole[which]

    def use(changed):
        numbers = [whole[0], whole[1]]
        numbers[which] = (changed, doubles)
        opened(*numbers)

    assert refusals(use, ints) > 2 * len(ints) // 4  # signs and switches may be anything


@SCENES
@pytest.mark.parametrize("which", (0, 1), ids=("scene", "mode"))
@pytest.mark.parametrize("part", (0, 1), ids=("ints", "doubles"))
def test_numbers_cut_short_or_too_many_are_refused(which, part, of):
    whole = packed(of)
    for change in (lambda text: text[:-8], lambda text: text + bytes(8), lambda text: b"", lambda t: t[:-1]):
        numbers = [list(whole[0]), list(whole[1])]
        numbers[which][part] = change(numbers[which][part])
        with pytest.raises(ValueError, match="packed numbers"):
            opened(*numbers)


def bundles(of, run):
    """Disturbances as they go into C: those whose growth is told, and given ones."""
    ends, size = run.maker.ends, length(of)
    carried = bundle_form(of, True, size, ends), bundle_numbers(of, 0.0, DOUBLES) + np.eye(size).tobytes()
    return pack_bundle(of, dimension(of), 0.0, ends), carried


@pytest.mark.parametrize("of", (PAPER, DRILL), ids=("II-B", "drill"))
@pytest.mark.parametrize("which", (0, 1), ids=("bundle", "given"))
def test_no_index_of_disturbances_reaches_beyond_its_table(of, which):
    *whole, run = packed(of)
    ints, doubles = bundles(of, run)[which]
    state, known = pack_state(run.first[0]), bytes(4 * len(run.keys))

    def use(changed):
        fresh = opened(*whole)
        fresh.keep_tangent(changed, doubles)
        return fresh

    def advance(fresh):
        fresh.fill(*run.arrays)
        fresh.start(0, state, known)
        fresh.advance()
        fresh.disturbances()

    assert refusals(use, ints, (*HUGE, 0, 1, 2), advance) > 3 * len(ints) // 4


def test_disturbances_cut_short_or_too_many_are_refused():
    *whole, run = packed(PAPER)
    for numbers in bundles(PAPER, run):
        for part, text in enumerate(numbers):
            for changed in (text[:-8], text + bytes(8), b"", text[:-1]):
                fresh = opened(*whole)
                with pytest.raises(ValueError, match="packed numbers"):
                    fresh.keep_tangent(*(changed if i == part else other for i, other in enumerate(numbers)))
                fresh.keep_tangent(*numbers)  # nothing of the refused ones is left


def misfits():
    """Tables for the output, one of which does not fit."""
    samples, modes = np.zeros((7, 64)), np.empty((2, 64), dtype="i1")
    events, codes, section = np.zeros((8, 64)), np.empty((4, 64), dtype="i1"), np.empty((7, 0))
    fit = [samples, modes, events, codes, section]
    for name, place, array_ in (
        ("too few rows", 0, samples[:6]),
        ("no samples", 0, samples[:, :0].copy()),
        ("not contiguous", 0, np.empty((7, 128))[:, ::2]),
        ("shorter modes", 1, modes[:, :32].copy()),
        ("no room for events", 2, np.empty((8, 4))),
        ("shorter codes", 3, codes[:, :32].copy()),
        ("section of one", 4, np.empty((7, 1))),
        ("bytes", 0, bytes(7 * 64 * 8)),
    ):
        yield pytest.param([array_ if i == place else part for i, part in enumerate(fit)], id=name)


@pytest.mark.parametrize("tables", list(misfits()))
def test_tables_that_do_not_fit_are_refused(tables):
    whole = packed(PAPER)
    state, known = pack_state(whole[2].first[0]), bytes(4 * len(whole[2].keys))
    for run in (whole[2].run, opened(*whole[:2])):
        with pytest.raises((ValueError, BufferError, TypeError)):
            run.fill(*tables)
    with pytest.raises(ValueError, match="cannot start"):
        run.start(0, state, known)  # with nothing to fill


@pytest.mark.parametrize(
    ("mode", "state", "known"),
    ((1, None, None), (-1, None, None), (0, b"", None), (0, None, bytes(4)), (0, bytes(8 * 7), None)),
)
def test_a_start_that_does_not_fit_is_refused(mode, state, known):
    *whole, run = packed(PAPER)
    state = pack_state(run.first[0]) if state is None else state
    known = bytes(4 * len(run.keys)) if known is None else known
    fresh = opened(*whole)
    fresh.fill(*run.arrays)
    with pytest.raises(ValueError):
        fresh.start(mode, state, known)


def test_a_run_that_was_not_started_tells_nothing():
    *whole, _ = packed(PAPER)
    fresh = opened(*whole)
    for call in (
        fresh.advance,
        fresh.pending,
        fresh.tally,
        lambda: fresh.states_at(b"", np.empty(0), np.empty(0, dtype="i1"), 0),
    ):
        with pytest.raises(ValueError, match="not been started"):
            call()


def test_no_state_is_written_where_there_is_no_room():
    run, times = packed(PAPER)[2].run, np.array([0.1, 0.2])
    states, codes = np.empty((7, 2)), np.empty((2, 2), dtype="i1")
    assert run.states_at(times.tobytes(), states, codes, 0) == (2, 0)
    for args in (
        (states[:, :1].copy(), codes, 0),
        (states, codes[:1], 0),
        (states, codes, 3),
        (states, codes, -1),
    ):
        with pytest.raises(ValueError, match="no room"):
            run.states_at(times.tobytes(), *args)


def test_no_rule_leads_out_of_the_table_of_modes():
    run = packed(PAPER)[2].run
    for rule in ((1, 99, 0, -1, 1, 0, 0, 1), (9, 0, 0, -1, 1, 0, 0, 1), (1, 0, 0, -1, 77, 0, 0, 1)):
        with pytest.raises(ValueError, match="no such rule"):
            run.set_rule(0, 0, rule)
    with pytest.raises(ValueError, match="no such rule"):
        run.set_rule(0, 99, (1, 0, 0, -1, 1, 0, 0, 1))


def test_a_run_serves_one_caller_at_a_time():
    """The GIL is free while it computes: a second thread gets through, and is told."""
    quiet = scene(harmonic(3.5, 1e-9), N=None, G=1.0, t_end=1e9, every_num=10**8)
    run = CRun(quiet.as_parts())
    done, told = threading.Event(), []

    def compute():
        while not done.is_set():
            try:
                run.run.advance()
            except RuntimeError as error:
                told.append(str(error))

    threads = [threading.Thread(target=compute) for _ in range(2)]
    for thread in threads:
        thread.start()
    while not told and any(thread.is_alive() for thread in threads):
        done.wait(0.01)
    done.set()
    for thread in threads:
        thread.join()
    assert told[0] == "the run is being computed by another thread"


@pytest.mark.parametrize("of", (PAPER, DRILL), ids=("II-B", "drill"))
def test_what_c_holds_of_a_run_is_freed_with_the_run(of):
    """Not by the garbage collector, which sees a few hundred bytes of it and waits for thousands of runs."""
    gc.collect()
    gc.disable()
    try:
        run = CRun(of)
        for _ in run.blocks():
            pass
        held = run.run
        del run
        assert sys.getrefcount(held) == 2  # `held` and the argument
    finally:
        gc.enable()
