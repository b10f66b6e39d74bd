"""Runs that the search needs: those that are not there yet are handed to workers, and kept as they come."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait

from vibsim.fitting.errors import Interrupted
from vibsim.fitting.goals.measuring import TRUST, Index, Task
from vibsim.fitting.goals.plan import FitPlan
from vibsim.fitting.goals.reading import Candidate
from vibsim.fitting.judgement import Judgement, judge
from vibsim.fitting.store.run_store import RunStore
from vibsim.sweeps.points.point import Point
from vibsim.sweeps.schedule.runner import AHEAD, PATIENCE
from vibsim.sweeps.schedule.workers import LocalWorkers

Watch = Callable[[str, int, int], bool]  # what is done, how many runs of it, of how many; False to stop


class Evaluation:
    """What is known of the candidates of a plan, and the means to know more."""

    def __init__(
        self, plan: FitPlan, store: RunStore, workers: LocalWorkers | None, watch: Watch | None = None
    ):
        """workers : None where nothing is to be run; what is missing is then Interrupted"""
        self.plan, self.store, self._workers = plan, store, workers
        self._watch = watch or (lambda *_: True)
        self.candidates: list[Candidate] = []

    def make(self, origin: str, changes: dict[str, str], leaving: float) -> Candidate:
        """A new candidate, the next in number."""
        candidate = Candidate(len(self.candidates), origin, changes, leaving)
        self.candidates.append(candidate)
        return candidate

    def judge(self, candidates: Sequence[Candidate], starts: Sequence[int], step: str) -> list[Judgement]:
        """The candidates judged from these starts, run as far as they are not yet. Raises Interrupted."""
        self._complete(
            [
                self.plan.task(one, case, start)
                for one in candidates
                for start in starts
                for case in self._cases
            ],
            step,
        )
        return [judge(self.plan, one, self.store.runs, starts) for one in candidates]

    def tell_horizons(self, candidates: Iterable[Candidate], step: str) -> None:
        """Run candidates from the cases' own start with their trust horizons."""
        self._complete(
            [
                Task((one.number, case, TRUST), case, one.changes, True)
                for one in candidates
                for case in self._cases
            ],
            step,
        )

    @property
    def _cases(self) -> range:
        return range(len(self.plan.cases))

    def _complete(self, tasks: Sequence[Task], step: str) -> None:
        waiting = deque(task for task in tasks if task.index not in self.store.runs)
        if self._workers is None:
            if waiting:
                raise Interrupted
            return
        active: dict[Future[list[Point]], Index] = {}
        while True:
            while waiting and len(active) < AHEAD * self._workers.count:
                task = waiting.popleft()
                active[self._workers.submit((task,))] = task.index
            if not self._watch(step, len(tasks) - len(waiting) - len(active), len(tasks)):
                self._give_up(self._workers, active)
                raise Interrupted
            if not active:
                return
            for future in wait(active, PATIENCE, FIRST_COMPLETED).done:
                del active[future]
                self.store.add(self._workers.result(future))

    def _give_up(self, workers: LocalWorkers, active: Iterable[Future[list[Point]]]) -> None:
        workers.stop()
        running = [future for future in active if not future.cancel()]
        for future in wait(running).done:
            self.store.add(workers.result(future))
