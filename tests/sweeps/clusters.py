"""A dask cluster of real processes on loopback, for tests."""

import json
import os
import subprocess
import sys
import time
from contextlib import contextmanager
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
QUIET = ("--no-dashboard", "--host", "127.0.0.1")
DEADLINE = 100.0  # seconds


class LoopbackCluster:
    """A scheduler and its workers, each a process of one thread."""

    def __init__(self, folder, **environment):
        self.file = folder / "scheduler.json"
        self._log = open(folder / "cluster.log", "wb")  # noqa: SIM115, closed in `end`
        self.processes = []
        words = ("--port", "0", "--scheduler-file", str(self.file))
        self.scheduler = self._start("scheduler", *words, **environment)
        self.workers = []

    @property
    def address(self):
        """Address of the scheduler, once it is up."""
        deadline = time.monotonic() + DEADLINE
        while True:
            try:
                return json.loads(self.file.read_text())["address"]
            except (FileNotFoundError, ValueError):
                assert time.monotonic() < deadline and self.scheduler.poll() is None
                time.sleep(0.02)

    def add_worker(self, **environment):
        """Start one more worker; it is there some time later."""
        worker = self._start("worker", self.address, "--nthreads", "1", "--no-nanny", **environment)
        self.workers.append(worker)
        return worker

    def await_workers(self, count):
        """Wait until so many workers are there."""
        from distributed import Client

        with Client(self.address, timeout=DEADLINE, set_as_default=False) as client:
            client.wait_for_workers(count, timeout=DEADLINE)

    def _start(self, *words, **environment):
        command = [sys.executable, "-m", "dask", *words, *QUIET]
        paths = os.pathsep.join(filter(None, [environment.pop("PYTHONPATH", ""), str(ROOT)]))
        process = subprocess.Popen(
            command,
            stdout=self._log,
            stderr=self._log,
            cwd=self.file.parent,
            env={**os.environ, "PYTHONPATH": paths, **environment},
        )
        self.processes.append(process)
        return process

    def end(self):
        """Kill what is left."""
        for process in self.processes:
            process.kill()
            process.wait()
        self._log.close()


@contextmanager
def loopback_cluster(folder, workers=2, **environment):
    """A cluster that ends with the block; `environment` is the scheduler's."""
    cluster = LoopbackCluster(folder, **environment)
    try:
        for _ in range(workers):
            cluster.add_worker()
        cluster.await_workers(workers)
        yield cluster
    finally:
        cluster.end()
