"""Budgets: no slower for being general. The paper's six cases against the build that knew two blocks only, by
turns, 300 s with 60,001 samples each; and what a step costs in chains of bodies.
"""

from dataclasses import replace
from statistics import median

from tests.budgets.engine_clock import EngineClock, run_through
from tests.budgets.pinned_build import PINNED, engines, simulations
from tests.budgets.row import Row
from vibsim.engine.trajectory import open_trajectory
from vibsim.physics.parts import GROUND, Body, Link, Scene, Stop

CASES = ("I-A", "I-B", "I-C", "II-A", "II-B", "II-C")
ROUNDS, PAIRS = (5, 21)  # processes differ by where their memory lies; hosts change their speed
ENGINE_LIMIT, WHOLE_LIMIT = 0.97, 0.8  # of the pinned build
CHAINS = (2, 5, 20, 100)  # bodies


def rows():
    for what, opener, limit in (("engine", engines, ENGINE_LIMIT), ("simulate", simulations, WHOLE_LIMIT)):
        for name in CASES:
            pairs = [pair for _ in range(ROUNDS) for pair in timed_pairs(opener, name)]
            ratios = [a / b for a, b in pairs]
            new, old = (1e3 * median(each) for each in zip(*pairs, strict=True))
            note = f"{new:.2f} and {old:.2f} ms"
            yield Row(f"{name}, {what}, against {PINNED}", "x", limit, ratios, [note])
    for method in ("taylor", "auto"):
        for bodies in CHAINS:
            scene, figures = replace(chain(bodies), method=method), []
            for _ in range(5):
                with EngineClock() as clock:
                    totals = run_through(open_trajectory(scene))
                steps = totals["steps" if method == "taylor" else "evaluations"]
                figures.append(1e6 * clock.seconds / steps / bodies)
            work = "step" if method == "taylor" else "evaluation"
            yield Row(f"chain of {bodies} by {method}, each {work} and body", "us", None, figures)


def timed_pairs(opener, name):
    """Times [s] of both builds for a case, one right after the other, each first in every second pair."""
    ours, theirs = opener(name)
    pairs = []
    for _ in range(PAIRS):
        mine = ours.run()
        pairs += [(mine, theirs.run())]
        ours, theirs = theirs, ours
    ours.close(), theirs.close()
    return [pair if k % 2 == 0 else pair[::-1] for k, pair in enumerate(pairs)]


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
