"""What the C engine is given from outside: every index, size, type and layout is checked."""

import threading

import numpy as np
import pytest
from vibsim.kernel import _kernel, open_trajectory, state_at
from vibsim.kernel.c_engine import PACKED, CTrajectory, pack

from tests.scenes import harmonic, paper, scene

ROW = dict.fromkeys(("t", "kind", "x1", "v1", "x2", "v2", "phi", "phidot", "phase"), 0.0)
ORDER = len(PACKED) + 1  # places in the packed scene
TANGENT = -2


@pytest.fixture
def trajectory():
    return CTrajectory(paper("II-B"), "taylor")


@pytest.mark.parametrize("engine", ("c", "python"))
@pytest.mark.parametrize(
    ("column", "code"),
    (("contact", 100), ("contact", -1), ("friction", -128), ("friction", 2), ("kind", 99), ("kind", -1)),
)
def test_codes_of_a_row_that_no_run_has_are_refused(engine, column, code):
    row = {**ROW, "contact": 0, "friction": 1, column: code}
    with pytest.raises(ValueError, match=f"event row: {column} must be one of .*, got {code}"):
        state_at(paper("II-B"), row, np.array([1e-3]), engine)


def test_contact_without_a_stop_is_refused():
    open_scene = scene(harmonic(3.5, 0.1), k2=None, G=None)
    with pytest.raises(ValueError, match="contact must be one of 0, got 1"):
        state_at(open_scene, {**ROW, "contact": 1, "friction": 1}, np.array([1e-3]))


@pytest.mark.parametrize(
    ("place", "value", "problem"),
    (
        (0, np.nan, "finite"),
        (0, -1e300, "t must be >= 0"),
        (8, 100, "contact"),
        (9, -128, "friction"),
        (9, 0.5, "friction"),
        (10, 2, "violated"),
        (11, 40, "known zero"),
        (15, -1, "known zero"),
    ),
)
def test_the_kernel_itself_refuses_a_point_to_go_on_from(trajectory, place, value, problem):
    row = np.zeros(16)
    row[place] = value
    with pytest.raises(ValueError, match=problem):
        _kernel.start(pack(paper("II-B"), "taylor"), row, *trajectory._buffers())


@pytest.mark.parametrize(
    ("place", "value", "problem"),
    (
        (ORDER, 41, "order"),
        (ORDER, 3, "order"),
        (ORDER, np.nan, "order"),
        (TANGENT, 6, "tangent"),
        (TANGENT, -1, "tangent"),
        (PACKED.index("every_num"), 0.0, "every_num"),
        (PACKED.index("every_den"), np.inf, "every_num"),
        (PACKED.index("t_end"), np.nan, "t_end"),
        (PACKED.index("t_end"), 1e300, "t_end"),
    ),
)
def test_the_kernel_itself_refuses_a_scene(trajectory, place, value, problem):
    packed = pack(paper("II-B"), "taylor")
    packed[place] = value
    with pytest.raises(ValueError, match=problem):
        _kernel.start(packed, None, *trajectory._buffers())


def misfits():
    """Tables for the output, one of which does not fit."""
    samples, modes = np.zeros((7, 64)), np.empty((2, 64), dtype="i1")
    events, codes, section = np.zeros((8, 64)), np.empty((3, 64), dtype="i1"), np.empty((7, 0))
    fit = [samples, modes, events, codes, section]
    for name, place, array in (
        ("too few rows", 0, samples[:6]),
        ("other type", 0, samples.astype("f4")),
        ("integers", 0, samples.astype("i8")),
        ("one dimension", 0, samples.ravel()),
        ("not contiguous", 0, np.empty((7, 128))[:, ::2]),
        ("other order", 0, np.asfortranarray(samples)),
        ("shorter modes", 1, modes[:, :32].copy()),
        ("unsigned modes", 1, modes.astype("u1")),
        ("no room for events", 2, np.empty((8, 4))),
        ("shorter codes", 3, codes[:, :32].copy()),
        ("section of one", 4, np.empty((7, 1))),
        ("not aligned", 0, np.empty(7 * 64 * 8 + 1, "i1")[1:].view("f8").reshape(7, 64)),
        ("bytes", 0, bytes(7 * 64 * 8)),
    ):
        yield pytest.param([array if i == place else part for i, part in enumerate(fit)], id=name)


@pytest.mark.parametrize("tables", list(misfits()))
def test_tables_that_do_not_fit_are_refused(trajectory, tables):
    with pytest.raises((ValueError, BufferError)):
        _kernel.advance(trajectory.run, *tables)
    with pytest.raises((ValueError, BufferError)):
        _kernel.start(pack(paper("II-B"), "taylor"), None, *tables)


def test_tables_that_are_read_only_are_refused(trajectory):
    trajectory.samples.flags.writeable = False
    with pytest.raises(ValueError, match="read-only"):
        _kernel.advance(trajectory.run, *trajectory._buffers())


@pytest.mark.parametrize("run", (None, b"", bytearray(20_000), object()))
def test_only_a_run_is_a_run(trajectory, run):
    for call in (_kernel.tally, _kernel.growth, lambda it: _kernel.state_at(it, 1.0)):
        with pytest.raises(ValueError):
            call(run)
    with pytest.raises(ValueError):
        _kernel.advance(run, *trajectory._buffers())


def test_a_run_serves_one_caller_at_a_time():
    """The GIL is free while it computes: a second thread gets through, and is told."""
    quiet = scene(harmonic(3.5, 1e-9), N=None, G=1.0, t_end=1e9, every_num=10**8)
    trajectory = open_trajectory(quiet, "c")
    done, told = threading.Event(), []

    def compute():
        while not done.is_set():
            try:
                _kernel.advance(trajectory.run, *trajectory._buffers())
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
    assert told[0] == "a run serves one caller at a time"
