"""Files appear whole or not at all, and never in place of another one unless told so."""

import os
import signal
import subprocess
import sys
import threading
import time
from types import SimpleNamespace

import numpy as np
import pytest

import vibsim
from tests.results.made import short_case, short_run
from vibsim.engine.blocks_ahead import MOST_AHEAD, BlocksAhead, Cores
from vibsim.results import ResultFileError, simulate_to_file
from vibsim.results.output_files import check_output, output_file


def files(folder):
    return sorted(path.name for path in folder.iterdir())


def test_an_existing_file_is_kept_unless_it_is_replaced_by_force(tmp_path):
    path = tmp_path / "a.h5"
    path.write_text("precious")
    with pytest.raises(ResultFileError, match=r"a\.h5: exists; kept"):
        short_run().save(path)
    assert path.read_text() == "precious"
    assert len(vibsim.open_result(short_run().save(path, force=True))) == len(short_run())
    assert files(tmp_path) == ["a.h5"]


def test_an_existing_file_is_noticed_before_anything_is_computed(tmp_path):
    (tmp_path / "a.h5").write_text("precious")
    never = []
    with pytest.raises(ResultFileError):
        simulate_to_file(short_case(), tmp_path / "a.h5", watch=never.append)
    assert never == []


def test_a_file_that_appears_meanwhile_is_kept(tmp_path):
    path = tmp_path / "a.h5"

    def somebody_else(t):
        path.write_text("precious")
        return True

    with pytest.raises(ResultFileError, match="appeared meanwhile; kept"):
        simulate_to_file(short_case(), path, watch=somebody_else)
    assert path.read_text() == "precious"


def test_the_target_is_replaced_only_when_the_new_file_is_whole(tmp_path):
    path = tmp_path / "a.h5"
    path.write_text("precious")
    seen = []

    def look(t):
        seen.append(path.read_text())
        return True

    simulate_to_file(short_case(), path, force=True, watch=look)
    assert set(seen) == {"precious"}
    assert vibsim.open_result(path).complete


def test_a_link_stays_a_link(tmp_path):
    (tmp_path / "real").mkdir()
    (tmp_path / "link.h5").symlink_to(tmp_path / "real" / "a.h5")
    short_run().save(tmp_path / "link.h5")
    assert (tmp_path / "link.h5").is_symlink()
    assert files(tmp_path / "real") == ["a.h5"]


def test_a_failing_run_leaves_a_partial_file_and_no_target(tmp_path):
    def fail(t):
        raise RuntimeError("as if the engine had failed")

    with pytest.raises(RuntimeError):
        simulate_to_file(short_case(), tmp_path / "a.h5", watch=fail)
    assert files(tmp_path) == ["a.h5.partial"]
    assert not vibsim.open_result(tmp_path / "a.h5.partial").complete


def test_a_run_that_is_stopped_is_finished_as_incomplete(tmp_path):
    blocks = []

    def stop_at_the_third(t):
        blocks.append(t)
        return len(blocks) < 3

    case = short_case(t_end="3000 s", run__every="1 ms")
    simulate_to_file(case, tmp_path / "a.h5", watch=stop_at_the_third)
    result = vibsim.open_result(tmp_path / "a.h5")
    assert not result.complete
    assert 0 < blocks[-1] <= result.t_reached < 3000  # told how far all is worked out, the ledger too
    assert result.t_reached - result.time[-1] < 2e-3
    whole = short_run(t_end="600 s", run__every="1 ms")
    judged = result.time <= result.trust_horizon
    for name in result:
        rows = judged if name == "error_estimate" else ...  # a companion that is behind judges no further
        assert np.array_equal(result[name][rows], whole[name][: len(result)][rows])
    assert len(result) > 0
    assert files(tmp_path) == ["a.h5"]


BLOCKED = {
    "missing folder": ("none/a.h5", "folder .*none does not exist"),
    "a file for a folder": ("file/a.h5", "cannot write"),
    "a folder": ("folder", "is a folder"),
    "a device": ("/dev/null", "is not a regular file"),
    "too long a name": ("x" * 300, "cannot write: File name too long"),
    "too long a name for its partial file": ("x" * 247 + ".h5", "cannot write: File name too long"),
    "a null byte": ("a\0b.h5", "cannot write"),
}


@pytest.mark.parametrize("name", BLOCKED)
def test_outputs_that_cannot_be(name, tmp_path):
    (tmp_path / "file").write_text("")
    (tmp_path / "folder").mkdir()
    target, message = BLOCKED[name]
    with pytest.raises(ResultFileError, match=message) as caught:
        check_output(tmp_path / target, force=True)
    assert "\n" not in str(caught.value)


@pytest.fixture
def as_nobody():
    """The rest of the test has no more rights than any user."""
    if os.geteuid() != 0:
        yield
        return
    os.seteuid(65534)
    yield
    os.seteuid(0)


def test_a_folder_without_permission(as_nobody):
    with pytest.raises(ResultFileError, match="folder / is not writable"):
        check_output("/a.h5")


def test_other_outputs_are_whole_or_absent_too(tmp_path):
    with pytest.raises(RuntimeError), output_file(tmp_path / "a.csv", encoding="ascii") as file:
        file.write("half")
        raise RuntimeError
    assert files(tmp_path) == []
    with output_file(tmp_path / "a.csv", encoding="ascii") as file:
        file.write("whole")
    assert files(tmp_path) == ["a.csv"]


ENDLESS = """
import vibsim
from vibsim.results import simulate_to_file
case = vibsim.load_case("II-B", {"run.t_end": "1000000 s", "run.every": "1 ms"})
told = False
def watch(t):
    global told
    if t > 700 and not told:  # two flushes, of some 72 s of samples each, are through, and 460 s may wait
        told = True
        print("going", flush=True)
    return True
simulate_to_file(case, "a.h5", watch=watch)
"""


def test_a_killed_run_leaves_a_partial_file_that_opens(tmp_path):
    with subprocess.Popen([sys.executable, "-c", ENDLESS], cwd=tmp_path, stdout=subprocess.PIPE) as run:
        assert run.stdout.readline() == b"going\n"
        run.send_signal(signal.SIGKILL)
    assert files(tmp_path) == ["a.h5.lock", "a.h5.partial"]
    result = vibsim.open_result(tmp_path / "a.h5.partial")
    assert not result.complete
    assert len(result) >= 4 * 16384
    whole = vibsim.simulate(vibsim.load_case("II-B", {"run.t_end": "70 s", "run.every": "1 ms"}))
    for name in result:
        assert np.array_equal(result[name][:60_000], whole[name][:60_000])
    assert result.t_reached == (result.events["t"][-1] if len(result.events["t"]) else 0.0)


@pytest.mark.parametrize("locks_of_hdf5", ["TRUE", "FALSE"])  # many clusters switch them off
def test_a_second_run_does_not_disturb_the_first_one(tmp_path, locks_of_hdf5):
    simulating, environment = [], {**os.environ, "HDF5_USE_FILE_LOCKING": locks_of_hdf5}

    def another(t):
        if not simulating:
            simulating.append(t)
            command = [sys.executable, "-m", "vibsim", "run", "I-A", "-o", str(tmp_path / "a.h5")]
            done = subprocess.run(command, capture_output=True, text=True, check=False, env=environment)
            assert done.returncode == 6
            assert f"a.h5: another command is writing it (process {os.getpid()} on " in done.stderr
        return True

    simulate_to_file(short_case(), tmp_path / "a.h5", watch=another)
    assert np.array_equal(vibsim.open_result(tmp_path / "a.h5")["x1"], short_run()["x1"])
    assert simulating


def test_a_run_stopped_before_its_energy_ledger_began_states_no_residual(tmp_path):
    """The ledger of a free vibration is taken of the whole run at once; of none of it nothing is known."""
    free = {"stop": "none", "friction": "none", "x1": "1 mm", "omega": "1e6 Hz", "t_end": "20 s"}
    case = vibsim.load_case("I-A", free)
    path = tmp_path / "a.h5"
    simulate_to_file(case, path, watch=lambda reached: False)
    stopped = vibsim.open_result(path)
    assert not stopped.complete and not [name for name in stopped.attrs if name.startswith("energy")]
    simulate_to_file(short_case("I-A", "1 s"), path, force=True)
    assert abs(vibsim.open_result(path).attrs["energy_residual"]) < 1e-12


# Blocks of a run that are computed ahead: how far, what ends them, errors where they are asked for.


class Counting:
    """A run of so many blocks, which counts those that it has computed."""

    def __init__(self, count, error=None):
        self.count, self.error, self.computed, self.stopped = count, error, 0, False

    def stop(self):
        self.stopped = True

    def blocks(self):
        for number in range(self.count):
            self.computed += 1
            yield SimpleNamespace(number=number)
        if self.error:
            raise self.error


def numbers(ahead, go_on=lambda: True):
    return [(block.number, told) for block, told in ahead.blocks(go_on)]


def ahead_of(run):
    ahead = BlocksAhead(run, lambda block: -block.number)
    ahead.start()
    return ahead


def stays_at(run, count):
    """Whether a run comes to so many blocks and waits there; one that is to go on has a moment for it."""
    while run.computed < count:
        time.sleep(0.001)
    time.sleep(0.05)
    return run.computed == count


def test_blocks_come_in_order_with_what_is_told_of_each():
    ahead = ahead_of(Counting(20))
    assert numbers(ahead) == [(i, -i) for i in range(20)]
    ahead.close()


def test_a_run_waits_for_those_who_take_its_blocks():
    ahead = ahead_of(run := Counting(100))
    assert stays_at(run, MOST_AHEAD)
    taken = ahead.blocks(lambda: True)
    next(taken), next(taken), next(taken)
    assert stays_at(run, MOST_AHEAD + 3)
    ahead.close()
    assert run.computed < 10


def test_what_is_computed_when_a_run_is_stopped_is_there():
    ahead = ahead_of(run := Counting(100))
    taken = ahead.blocks(lambda: True)
    first = next(taken)
    ahead.stop()
    rest = list(taken)
    assert [block.number for block, _ in (first, *rest)] == list(range(run.computed))
    assert run.computed < 10


def test_an_error_comes_behind_the_blocks_before_it():
    ahead, taken = ahead_of(Counting(3, ValueError("no motion"))), []
    with pytest.raises(ValueError, match="no motion"):
        for block, _ in ahead.blocks(lambda: True):
            taken.append(block.number)
    assert taken == [0, 1, 2]


def test_who_waits_is_asked_whether_to_go_on():
    release = threading.Event()

    class Slow(Counting):
        def blocks(self):
            for block in super().blocks():
                yield block
                release.wait(100)

    asked = []

    def go_on():
        asked.append(True)
        release.set()
        return False

    ahead = ahead_of(run := Slow(50))
    assert len(numbers(ahead, go_on)) == run.computed <= 2 and asked
    ahead.close()


def test_closing_ends_the_thread_also_of_a_run_that_was_never_begun():
    for ahead in (BlocksAhead(Counting(3), lambda block: None), ahead_of(Counting(10**9))):
        ahead.close()
        assert not ahead._thread.is_alive()


def test_news_is_told_while_a_block_is_waited_for():
    told, released = [], threading.Event()

    class Slow(Counting):
        def blocks(self):
            released.wait(100)
            yield from super().blocks()

    ahead = ahead_of(Slow(2))
    ahead.tell_news()

    def meanwhile():
        told.append("news")
        released.set()

    assert [block.number for block, _ in ahead.blocks(lambda: True, meanwhile)] == [0, 1]
    assert told == ["news"]
    ahead.close()


# Threads take turns on the cores that they may use, in the order in which they ask.


@pytest.mark.parametrize("count", [1, 2])
def test_no_more_compute_than_there_are_cores(count):
    """The first ones wait in there for each other: as many compute at a time as may."""
    cores, lock, inside, most = Cores(count), threading.Lock(), [], []
    all_in = threading.Barrier(count)

    def work():
        for _ in range(20):
            with cores:
                with lock:
                    inside.append(1)
                    most.append(len(inside))
                    waits = len(most) <= count
                if waits:
                    all_in.wait(100)
                time.sleep(0.0005)
                with lock:
                    inside.pop()

    threads = [threading.Thread(target=work) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert max(most) == count and len(most) == 80


def test_who_asks_again_waits_behind_those_who_have_asked():
    cores, order, asked = Cores(1), [], threading.Event()

    def other():
        asked.set()
        with cores:
            order.append("other")

    thread = threading.Thread(target=other)
    with cores:
        thread.start()
        asked.wait()
        while not cores._waiting:
            time.sleep(0.001)
    with cores:
        order.append("again")
    thread.join()
    assert order == ["other", "again"]


def test_a_core_that_becomes_free_is_used():
    cores, done = Cores(1), threading.Event()

    def other():
        with cores:
            done.set()

    thread = threading.Thread(target=other)
    with cores:
        thread.start()
        assert not done.wait(0.02)
        cores.add()
        assert done.wait(100)
    thread.join()


def test_a_failure_gives_the_core_back():
    cores = Cores(1)
    with pytest.raises(KeyError), cores:
        raise KeyError
    with cores:
        pass
