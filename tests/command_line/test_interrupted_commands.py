"""Ctrl-C and SIGTERM in the middle of every command that takes long, and what of its work is then there."""

import builtins
import gc
import importlib
import os
import pkgutil
import re
import shutil
import signal
import subprocess
import sys
import threading
import time
import warnings
from pathlib import Path

import pytest

import vibsim
from tests.command_line.made import SLOW_SOURCE, begun, call, own_handlers, refused, told
from vibsim.results.simulation import open_result
from vibsim.signals import Interruption, ended_by_signals, heard_from_now_on

GOES_ON = "holds what was done; the same command resumes it"
REFINE = "vibsim.orbits.orbit_digits:refine"
RUN = "vibsim.results.recording:Recording.into"
FRAMES = "vibsim.plots.animation:Film.frames"
PAGE, PAGES = "vibsim.plots.html_pages:run_data", "vibsim.plots.picture:_pages"
DIGITS = "vibsim.results.recording:TruthWriter.append_digits"
TRUTH = "vibsim.evidence.benchmark.running:compute_truth"
POINT = "vibsim.orbits.branches.branch:BranchStore.take"
POINT_OF_LOCUS = "vibsim.orbits.branches.locus_result:LocusStore.take"
ROWS, JUDGED = "vibsim.results.result:_texts", "vibsim.command_line.commands.analyse:analyse"
BLOCK = "vibsim.results.recording:TrajectoryWriter.append"
PARTIAL = "slow.h5.partial"  # of a run whose first block takes minutes
CAPTURED = "II-B -s c=0.03 -s Omega0=3.8Hz"
BELT = "--spread block.x=-2:2m --spread block.v=0:2m/s --section 0 --compute end-state"
OVERDAMPED = """
name: slow
blocks: {m1: 1 g, m2: fixed}
coupling: {k1: 1 N/m, c: 1e6 N s/m}
initial: {x1: 1 mm}
run: {t_end: 100 s}
"""
# what is called; when the signal comes: a moment after a file is there, or at once where MODULE:FUNCTION is
# called; what is said; what is left. Nothing depends on the speed of the machine: what is waited for comes
# sooner or later, and what waits for a file takes a minute and more
COMMANDS = {
    "run": ("run II-B --t-end 1e6s", BLOCK, "II-B.h5 holds the run until", ["II-B.h5"]),
    "digits": ("run II-B --digits 90", DIGITS, "II-B.h5 holds the run until", ["II-B.h5"]),
    "lyapunov": ("run II-B --t-end 1e6s --lyapunov all", BLOCK, "holds the run", ["II-B.h5"]),
    "sweep": ("sweep II-B --omega0 3:7:0.0001 -j 2 -o s.h5", "s.h5", f"s.h5 {GOES_ON}", ["s.h5"]),
    "carry": ("sweep II-B --omega0 3:7:0.0001 --carry-state -o s.h5", "s.h5", f"s.h5 {GOES_ON}", ["s.h5"]),
    "end-state": (
        f"sweep gallery/belt-oscillator --ensemble 90000 {BELT} -o s.h5",
        "s.h5",
        GOES_ON,
        ["s.h5"],
    ),
    "search": (f"orbit {CAPTURED} --search 900 -o o.h5", "o-1.h5", "after .* in o-1.h5", ["o-1.h5"]),
    "refine": (f"orbit {CAPTURED} --digits 900 -o o.h5", REFINE, "o.h5 holds the orbit without", ["o.h5"]),
    "continue": (f"continue {CAPTURED} --omega0 3:9 -o b.h5", POINT, f"b.h5 {GOES_ON}", ["b.h5"]),
    "locus": ("continue all.h5 --locus NS1 --param c=0.001:0.1 -o l.h5", POINT_OF_LOCUS, GOES_ON, ["l.h5"]),
    "fit": (f"fit {CAPTURED} --free J=0.5:20gm^2 --want captured -o f.h5", "f.h5.journal", GOES_ON, ["f.h5"]),
    "bench": (
        "bench II-B --methods rk4 -o b.h5",
        TRUTH,
        "stopped before the truth was computed; nothing is kept",
        [],
    ),
    "verify": ("verify V1 V7 V10", RUN, "interrupted after . of", []),
    "gif": ("animate long.h5 -o a.gif", FRAMES, "a.gif is not written", []),
    "page": ("plot long.h5 -o p.html", PAGE, "interrupted", []),
    "picture": ("plot long.h5 --kind motor,stiffness -o p.pdf", PAGES, "p.pdf is not written", []),
    "csv": ("export long.h5 -o a.csv", ROWS, "a.csv is not written", []),
    "analyse": ("analyse long.h5 --exponent", JUDGED, "interrupted", []),
    # work that takes long between two moments at which it could be left
    "slow-ledger": ("run slow-source.yaml", PARTIAL, "slow.h5 holds the run until", ["slow.h5"]),
    "slow-companion": (
        "run slow-source.yaml -s omega=1000Hz --t-end 1e6s",
        PARTIAL,
        "slow.h5 holds",
        ["slow.h5"],
    ),
    "slow-tangent": ("run overdamped.yaml --no-trust --lyapunov all", BLOCK, "slow.h5 holds", ["slow.h5"]),
    "slow-sweep": (
        "sweep overdamped.yaml --param k1=1,2 --compute lyapunov -o s.h5",
        "s.h5",
        GOES_ON,
        ["s.h5"],
    ),
    "slow-analysis": ("analyse slow-source.yaml", RUN, "interrupted", []),
    "slow-digits": (  # whose first block the machine may not compute in the time that is left for it
        "run slow-source.yaml --digits 1000 --t-end 1e6s",
        PARTIAL,
        "slow.h5 holds|nothing came before",
        None,
    ),
    "paper": ("paper -o p", "p", f"p {GOES_ON}", ["p"]),
}


@pytest.fixture(scope="module")
def inputs(tmp_path_factory):
    """Results that other commands read. All of vibsim is imported: no command is interrupted there."""
    for module in pkgutil.walk_packages(vibsim.__path__, "vibsim."):
        if module.name != "vibsim.__main__":
            try:
                importlib.import_module(module.name)
            except ModuleNotFoundError as error:  # a peer that there is not for every machine
                assert error.name == "heyoka"
    folder = tmp_path_factory.mktemp("inputs")
    vibsim.simulate("II-B", trust=False, overrides={"run.t_end": "600 s"}).save(folder / "long.h5")
    (folder / "slow-source.yaml").write_text(SLOW_SOURCE)
    (folder / "overdamped.yaml").write_text(OVERDAMPED)
    found = vibsim.orbit("II-B", {"c": "0.03", "Omega0": "3.8 Hz"})
    vibsim.continue_branch(found, "excitation.Omega0", "3:9 Hz", out=folder / "all.h5")
    short = vibsim.load_case("II-B", {"run.t_end": "2 s"})
    vibsim.sweep(short, {"Omega0": "3,4 Hz"}, jobs=1, out=folder / "sweep.h5")
    return folder


@pytest.fixture
def linked(inputs, here):
    """They are in the present folder; their names."""
    for path in inputs.iterdir():
        os.link(path, path.name)
    return {*os.listdir()}


class Signal(threading.Thread):
    """Sends a signal to this process a moment after a file is there."""

    def __init__(self, signum, sign):
        super().__init__(daemon=True)
        self.signum, self.sign = signum, sign
        self.sent, self.over, self.lock = 0.0, False, threading.Lock()

    def run(self):
        while not Path(self.sign).exists() and not self.over:
            time.sleep(0.002)
        time.sleep(0.1)
        with self.lock:
            if not self.over:
                self.send()

    def send(self):
        self.sent = time.monotonic()
        os.kill(os.getpid(), self.signum)

    def end(self):
        with self.lock:
            self.over = True


def sends_when_called(sender, monkeypatch):
    """Let the function that is the sign send the signal, once, before it does what it does."""
    module, names = sender.sign.split(":")
    owner = importlib.import_module(module)
    *classes, name = names.split(".")
    for each in classes:
        owner = getattr(owner, each)
    function = getattr(owner, name)

    def sending(*args, **options):
        if not sender.sent:
            sender.send()
        return function(*args, **options)

    monkeypatch.setattr(owner, name, sending)


def interrupted(words, sign, signum, monkeypatch):
    """The outcome of a command that gets a signal, and how long it took to answer [s]."""
    monkeypatch.setattr(sys, "unraisablehook", sys.unraisablehook)
    sender = Signal(signum, sign)
    if ":" in sign:
        sends_when_called(sender, monkeypatch)
    else:
        sender.start()
    with own_handlers():
        heard_from_now_on()
        try:
            done = call(*words.split())
            answered = time.monotonic()
        finally:
            sender.end()
    assert sender.sent, f"was over before: {done.stdout}"
    return done, answered - sender.sent


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_ends_at_once_and_says_what_is_kept(name, linked, monkeypatch):
    words, sign, said, left = COMMANDS[name]
    by_sigterm = len(name) % 2 == 1
    done, seconds = interrupted(words, sign, signal.SIGTERM if by_sigterm else signal.SIGINT, monkeypatch)
    assert done.exit_code == (143 if by_sigterm else 130), done.stderr
    assert re.search(said, done.stderr) and "interrupted" in done.stderr and "Traceback" not in done.stderr
    assert seconds < 300  # half a second on a machine that does nothing else
    files = sorted({*os.listdir()} - linked)
    of_one_orbit = {re.sub(r"-\d+\.", "-1.", each) for each in files}  # -2, -3: found since
    assert left is None or of_one_orbit == {*left}
    for each in files:
        if each.endswith(".h5"):
            assert open_result(each).attrs["complete"] == (name in ("search", "refine"))


WRITERS = {
    "csv": "export long.h5 --window 0:9 -o a.csv",
    "table": "export sweep.h5 -o a.csv",
    "parquet": "export long.h5 --window 0:9 -o a.parquet",
    "mat": "export long.h5 --window 0:9 -o a.mat",
    "png": "plot long.h5 --kind motor -o a.png",
    "pdf": "plot long.h5 --kind motor -o a.pdf",
    "pages": "plot long.h5 --kind motor,stiffness -o a.pdf",
    "svg": "plot long.h5 --kind motor -o a.svg",
    "page": "plot sweep.h5 -o a.html",
    "gif": "animate long.h5 --window 0:0.5 -o a.gif",
    "moving page": "animate long.h5 --window 0:0.5 -o a.html",
    "case": "new mine",
    "sweep": "sweep II-B --omega0 3,4 --t-end 1s -j 1 -o s.h5",
}


@pytest.mark.parametrize("name", WRITERS)
def test_a_signal_between_opening_a_file_and_keeping_it_leaves_none_open(name, linked, monkeypatch):
    """There Python drops what was opened, and warns of it; the suite makes warnings errors."""
    opened, signum, sent = open, signal.SIGINT, []

    def open_and_signal(file, *args, **options):
        stream = opened(file, *args, **options)
        if str(file).endswith(".partial") and not sent:
            sent.append(file)
            os.kill(os.getpid(), signum)
        return stream

    monkeypatch.setattr(builtins, "open", open_and_signal)
    monkeypatch.setattr(sys, "unraisablehook", sys.unraisablehook)
    with own_handlers(), warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("always", ResourceWarning)
        heard_from_now_on()
        done = call(*WRITERS[name].split())
        gc.collect()
    assert sent and done.exit_code == 130 and "Traceback" not in done.stderr
    assert not [each for each in warned if issubclass(each.category, ResourceWarning)]
    assert {*os.listdir()} - {"s.h5"} == linked


STARTING = """
import signal, sys
class Finder:
    def find_spec(self, name, path=None, target=None):
        if name == sys.argv[2]:
            signal.raise_signal(int(sys.argv[1]))
sys.meta_path.insert(0, Finder())
from vibsim.__main__ import main
main()
"""


@pytest.mark.parametrize(
    ("signum", "module"),
    [(signal.SIGINT, "click"), (signal.SIGTERM, "click"), (signal.SIGINT, "vibsim.signals")],
)
def test_a_signal_while_the_command_line_is_imported_ends_without_a_word(signum, module):
    """The first thing that is imported behind `vibsim` itself, too."""
    command = [sys.executable, "-c", STARTING, str(int(signum)), module]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (-signum, "")


SWALLOWED = """
import gc, os, signal, time, weakref
from vibsim.signals import heard_from_now_on
class Thing: pass
heard_from_now_on()
thing = Thing()
ref = weakref.ref(thing, lambda _: os.kill(os.getpid(), signal.SIGINT) or time.sleep(0.01))
began = time.monotonic()
try:
    del thing
    while time.monotonic() < began + 60: pass
except KeyboardInterrupt:
    try:
        time.sleep(1)  # while it is on its way nothing comes in between
    finally:
        print("heard")
"""


def test_an_interruption_that_python_swallows_is_raised_again():
    done = subprocess.run([sys.executable, "-c", SWALLOWED], capture_output=True, text=True, check=False)
    assert (done.stdout, done.stderr) == ("heard\n", "")


def test_signals_that_the_caller_ignores_stay_ignored(monkeypatch):
    monkeypatch.setattr(sys, "unraisablehook", sys.unraisablehook)
    with own_handlers():
        for each in (signal.SIGINT, signal.SIGTERM):
            signal.signal(each, signal.SIG_IGN)
        heard_from_now_on()
        with Interruption() as interruption:
            signal.raise_signal(signal.SIGINT)
            assert interruption.signum is None
        ended_by_signals()
        assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN


def killed(folder, words, sign):
    """A command that is killed as soon as a file is there."""
    with begun(*words.split(), cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as child:
        while not sign():
            assert child.poll() is None
            time.sleep(0.01)


def test_what_a_killed_run_has_computed_is_not_replaced_without_a_word(here):
    partial = Path("II-B.h5.partial")
    killed(here, "run II-B --t-end 1e6s", lambda: partial.exists() and partial.stat().st_size > 8e6)
    held = partial.read_bytes()
    reached = open_result(partial).column("time")[-1]
    assert reached > 10
    said = f"II-B.h5.partial: holds a run that did not come to its end, until {reached:g} s; kept"
    for words in ("run II-B", "sweep II-B --omega0 3,4 -o II-B.h5", "orbit I-A -o II-B.h5"):
        assert said in refused(*words.split(), code=6)
    assert partial.read_bytes() == held
    told("run", "II-B", "--t-end", "1s", "--force")
    assert os.listdir() == ["II-B.h5"]
    os.remove("II-B.h5")
    partial.write_bytes(b"")  # of one that had computed nothing
    told("run", "II-B", "--t-end", "1s")
    assert os.listdir() == ["II-B.h5"]


def test_orbits_of_a_killed_search_are_there(tmp_path):
    killed(tmp_path, f"orbit {CAPTURED} --search 900 -o o.h5", (tmp_path / "o-1.h5").exists)
    assert open_result(tmp_path / "o-1.h5").orbit is not None


def test_a_search_does_not_begin_where_its_orbits_could_not_be_stored(here):
    Path("o-1.h5").write_text("another")
    assert "o-1.h5: exists; kept" in refused(*f"orbit {CAPTURED} --search 900 -o o.h5".split(), code=6)


def test_a_run_that_fills_its_chunks_slowly_is_on_file_all_the_same(tmp_path, monkeypatch):
    """Flushed by the clock, its file holds at every moment what a run in one go has, and at its end all."""
    monkeypatch.setattr("vibsim.results.recording.LONGEST", 0.0)
    seen = []

    def watch(t):
        if t > 0:
            shutil.copy(tmp_path / "a.h5.partial", tmp_path / "copy.h5")  # as a kill would leave it
            seen.append(len(open_result(tmp_path / "copy.h5")))
        return True

    case = vibsim.load_case("II-B", {"run.t_end": "200 s"})
    vibsim.results.simulate_to_file(case, tmp_path / "a.h5", watch=watch)
    assert max(seen) > 16384 and any(count % 16384 for count in seen)
    whole, stored = vibsim.simulate(case), open_result(tmp_path / "a.h5")
    assert all((stored[name] == whole[name]).all() for name in whole)
    assert (stored.event_column("t") == whole.event_column("t")).all()
