"""Budget: the engine on mode rows against the engine of two blocks, on the paper's six cases.

Both run in one process, by turns, 300 s with 60,001 samples each; processor time of this thread. In the
engine: what the compiled functions take. The whole run: from the scene to its last block, modes and their
rows included.
"""

import time
from dataclasses import replace
from statistics import median

from vibsim.kernel import _kernel
from vibsim.kernel import c_engine as on_blocks

from tests.budgets.row import Row
from vibsim.cases import load_case
from vibsim.engine import c_engine as on_rows
from vibsim.physics.parts import GROUND, Body, Link, Scene, Stop

CASES = ("I-A", "I-B", "I-C", "II-A", "II-B", "II-C")
REPETITIONS = 15
LIMIT = 0.97  # of the engine of two blocks
CHAINS = (2, 5, 20, 100)  # bodies


class Clock:
    """Adds up the processor time [s] of the calls that go through it to what it stands for."""

    def __init__(self, of):
        self.seconds, self.of = 0.0, of

    def __getattr__(self, name):
        function = getattr(self.of, name)

        def call(*arguments):
            began = time.thread_time()
            answer = function(*arguments)
            self.seconds += time.thread_time() - began
            return answer

        return call


def by_rows(scene):
    """A scene made of parts on the engine on mode rows: in the engine [ms], whole run [ms], its tally."""
    began = time.thread_time()
    run = on_rows.CRun(scene)
    inner = run.run
    clock = run.run = Clock(inner)
    for _ in run.blocks():
        pass
    return 1e3 * clock.seconds, 1e3 * (time.thread_time() - began), inner.tally()


def by_blocks(scene, method):
    """(in the engine, whole run) of a scene of two blocks on its engine [ms]."""
    clock = Clock(_kernel)
    on_blocks._kernel = clock
    try:
        began = time.thread_time()
        for _ in on_blocks.CTrajectory(scene, method).blocks():
            pass
        whole = time.thread_time() - began
    finally:
        on_blocks._kernel = _kernel
    return 1e3 * clock.seconds, 1e3 * whole


def rows():
    for name in CASES:
        case = load_case(name)
        parts, scene = case.scene(), case.two_blocks()
        method = "closed_form" if name in CASES[:3] else "taylor"
        pairs = [(by_rows(parts)[:2], by_blocks(scene, method)) for _ in range(REPETITIONS)]
        for i, what in enumerate(("in the engine", "whole run")):
            new, old = [one[i] for one, _ in pairs], [other[i] for _, other in pairs]
            ratios = [a / b for a, b in zip(new, old, strict=True)]
            note = f"{median(new):.2f} ms, on blocks {median(old):.2f} ms"
            yield Row(f"{name}, rows against blocks, {what}", "x", LIMIT, ratios, [note])
    for method in ("taylor", "auto"):
        for bodies in CHAINS:
            figures = []
            for _ in range(5):
                spent, _, tally = by_rows(replace(chain(bodies), method=method))
                figures.append(1e3 * spent / tally["steps" if method == "taylor" else "evaluations"] / bodies)
            work = "step" if method == "taylor" else "evaluation"
            yield Row(f"chain of {bodies} by {method}, each {work} and body", "us", None, figures)


def chain(bodies):
    """Equal bodies on springs, one end to the ground, a stop before the other; the first is displaced."""
    links = [Link("l0", 0, GROUND, 900.0, 0.0)]
    links += [Link(f"l{i}", i, i - 1, 900.0, 0.0) for i in range(1, bodies)]
    return Scene(
        tuple(Body(f"b{i}", 1.0, 0.01 if i == 0 else 0.0, 0.0) for i in range(bodies)),
        tuple(links),
        (Stop("stop", bodies - 1, GROUND, 0.004, 1, 4000.0, 0.0),),
        t_end=20.0,
        every_den=20,
    )
