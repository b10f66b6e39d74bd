"""A run is served in small blocks, whatever it does: Ctrl-C never waits long and memory never grows."""

import signal
import subprocess
import sys
import time
from dataclasses import replace
from itertools import islice

import pytest

from tests.scenes import fixed_block, harmonic, paper, scene
from tests.trajectories import opened

QUIET = scene(harmonic(3.5, 1e-9), N=None, G=1.0, t_end=1e9, every_num=10**8)
BUSY = fixed_block(k2=1e9, G=0.0, c=0.0, v1=-1.0, t_end=1e9, every_num=10**8)
SAMPLED = fixed_block(x1=0.01, G=None, t_end=1e6, every_num=1, every_den=1000)


@pytest.mark.parametrize("method", ("closed_form", "taylor"))
@pytest.mark.parametrize("scene", (QUIET, BUSY, SAMPLED), ids=("quiet", "busy", "sampled"))
def test_work_between_two_blocks_is_bounded(scene, method):
    trajectory = opened(replace(scene, method=method))
    steps = 0
    for block in islice(trajectory.blocks(), 4):
        # a step costs a microsecond or so, a sample less: 0.2 s would be 2e5 of them
        assert trajectory.totals["steps"] - steps <= 120_000
        assert len(block.samples["time"]) <= 65_536
        assert len(block.events["t"]) <= 20_000
        steps = trajectory.totals["steps"]
    assert block.t_reached < scene.t_end


def test_blocks_go_forward_and_join_without_gap_or_overlap():
    previous, samples = -1.0, 0
    for block in opened(paper("I-B", t_end=20.0, every_den=1000)).blocks():
        assert block.t_reached >= previous
        previous = block.t_reached
        samples += len(block.samples["time"])
    assert previous == 20.0
    assert samples == 20001


PROGRAM = """
from tests.kernel.test_interruption import {name}
from tests.trajectories import opened
print("ready", flush=True)
for block in opened({name}).blocks():
    pass
"""


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no SIGINT for one child")
@pytest.mark.parametrize("name", ("QUIET", "BUSY", "SAMPLED"))
def test_interrupt_stops_a_long_run(name):
    command = [sys.executable, "-c", PROGRAM.format(name=name)]
    child = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        assert child.stdout.readline() == "ready\n"
        time.sleep(0.2)
        assert child.poll() is None
        child.send_signal(signal.SIGINT)
        _, errors = child.communicate(timeout=10)  # 0.1 s where nothing else runs
    finally:
        child.kill()
    assert "KeyboardInterrupt" in errors
