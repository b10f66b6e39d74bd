"""Random scenes whose whole runs are held against another way to compute them."""

import random
from dataclasses import dataclass, fields, replace
from math import pi

import numpy as np
import pytest

from tests.engine.many_digits import exact_parts, sine, touches, touching
from tests.engine.runs import Run, whole
from tests.engine.test_resources import is_jammed
from tests.engine.whole_truth import faults
from vibsim.engine.driver import Driver
from vibsim.engine.errors import EngineError, State
from vibsim.engine.trajectory import open_trajectory
from vibsim.engine.truth import bare
from vibsim.physics.numbers import Doubles
from vibsim.physics.parts import EVENT_NAMES, Scene
from vibsim.physics.precision import number_kit

ALIKE = 1e-8  # of displacements, or m: far less than what an event more or fewer does


def finished(scene):
    """The run of the C engine; raises Crawling where it takes too long or goes on no further, None where
    bodies are caught between rigid stops.
    """
    trajectory, blocks = open_trajectory(scene, "c"), []
    try:
        for block in trajectory.blocks():
            blocks.append(block)
            if trajectory.totals["steps"] > MOST_STEPS:
                raise Crawling
    except EngineError as error:
        if error.reason != "crushed":
            raise Crawling from error
        assert is_jammed(scene, error.state), scene
        return None
    tables = [whole([getattr(block, name) for block in blocks]) for name in ("samples", "events", "section")]
    return Run(*tables, trajectory.totals)


def certified(run):
    return run is not None and run.totals["uncertified"] == 0


def alike(one, other):
    """Whether two runs have the same events, and displacements that agree; or no motion is possible."""
    if one is None or other is None:
        return one is other
    same = all(one.events[name].tolist() == other.events[name].tolist() for name in ("kind", "part"))
    return same and all(
        np.abs(column - other.samples[name]).max() < ALIKE * max(1.0, np.abs(column).max())
        for name, column in one.samples.items()
        if name.startswith("x_")
    )


def wrong_by_series(scene):
    """[(a certified run by closed form or by Taylor series, its faults)] where both are not alike."""
    runs = [finished(replace(scene, method=method)) for method in ("auto", "taylor")]
    if alike(*runs):
        return []
    judged = [(run, faults(scene, run, ALIKE)) for run in runs if certified(run)]
    return [(run, found) for run, found in judged if found]


def wrong_by_digits(scene):
    """The faults of a certified run."""
    run = finished(scene)
    return faults(scene, run, ALIKE) if certified(run) else []


def in_batches(seeds, size):
    """A parameter `seeds` of a test: those of a range, so many at a time."""
    return pytest.mark.parametrize(
        "seeds", [seeds[i : i + size] for i in range(0, len(seeds), size)], ids=str
    )


def judge(wrong, make, seeds):
    """No scene that `make` draws by a random.Random of the seeds is `wrong`; one in fifty at most takes too
    long or ends with an error.
    """
    given_up = 0
    for seed in seeds:
        scene = make(random.Random(seed))
        try:
            assert wrong(scene) == [], scene
        except Crawling:
            given_up += 1
    assert given_up <= len(seeds) / 50


# A stretch of a run, held against the exact flow from its start: what a certificate is judged by.


DIGITS = 40
MOST_STEPS = 40_000  # of a run, which takes some hundred
QUARTER_TURN = pi / 2  # rad, as a double
WHOLE = ("stop_sign", "order", "every_num", "every_den")  # whole numbers stay what they are


class Crawling(Exception):
    """A scene that takes too long to be judged."""


def crawl(driver):
    """Give up where the search creeps along a limit."""
    if driver.flow.steps > MOST_STEPS:
        raise Crawling


@dataclass(frozen=True)
class Stretch:
    """From `state` in the mode `status` to time `end` [s], and the kind of the event there ("" for none)."""

    state: State
    status: object
    known: dict
    end: float
    kind: str
    first: bool


def stretches(scene):
    """(the stretches of a run in doubles, one after the other; its certificate).

    A stretch is what one step of the flow proves: a segment in closed form, a Taylor step.
    """
    driver = Driver(scene if isinstance(scene, Scene) else scene.as_parts(), Doubles)
    found = []
    while not driver.finished:
        state, status, recorded = driver.state.copy(), driver.status, len(driver.events)
        known = driver.known if driver.known_since == state.t else {}
        while driver.state.t == state.t and len(driver.events) == recorded and not driver.finished:
            driver.run(1)
            driver.samples.clear()  # a run waits where many are not taken
            crawl(driver)
        kinds = [EVENT_NAMES[code] for code, *_ in driver.events[recorded:]]
        kinds = [kind for kind in kinds if kind != "end"]
        found.append(Stretch(state, status, known, driver.state.t, kinds[0] if kinds else "", not found))
    return found, driver.flow.certificate


class ExactFlow:
    """The flow of `scene`, two blocks or made of parts, in 40 digits, its doubles taken as exact."""

    def __init__(self, scene):
        self.kit = number_kit(DIGITS)
        scene = replace(scene, every_num=10**9, every_den=1)
        if isinstance(scene, Scene):
            self.scene = bare(
                at_quarters(exact_parts(scene)(self.kit.number, self.kit.pi), self.kit.pi), self.kit
            )
        else:
            self.scene = bare(self._exact_blocks(scene).as_parts(), self.kit)

    def _exact_blocks(self, scene):
        names = [field.name for field in fields(scene) if field.name not in WHOLE]
        values = {name: getattr(scene, name) for name in names}
        exact = {name: self.kit.number(value) for name, value in values.items() if isinstance(value, float)}
        if scene.source == "harmonic":
            exact["omega"] = self.kit.two_pi * (exact["cycles"] + exact["cycles_lo"])
        return replace(scene, **exact)

    def first_event(self, stretch, end):
        """(kind, time [s]) of the first event behind the start of `stretch`, ("", end) without one."""
        self.kit.activate()
        resume = None if stretch.first else (self._state(stretch.state), stretch.status, stretch.known)
        driver = Driver(replace(self.scene, t_end=self.kit.number(end)), self.kit, resume)
        while len(driver.events) < 2:
            driver.run(1)
            crawl(driver)
        code, _, state, *_ = driver.events[1]
        kind = EVENT_NAMES[code]
        return "" if kind == "end" else kind, self.kit.rounded([state.t])[0]

    def _state(self, state):
        number = self.kit.number
        x, v = [number(value) for value in state.x], [number(value) for value in state.v]
        return State(number(state.t), x, v, number(state.phase), number(state.turns), number(state.w))


def at_quarters(scene, pi):
    """An exact scene, whose phases that are quarter turns in doubles are quarter turns."""

    def turned(terms):
        return tuple(
            replace(one, phase=pi / 2 if one.phase > 0 else -pi / 2)
            if abs(one.phase) == QUARTER_TURN
            else one
            for one in terms
        )

    base, forces = turned(scene.base), tuple(replace(one, terms=turned(one.terms)) for one in scene.forces)
    X = sum((one.amplitude * sine(one.phase) for one in base), 0 * pi)
    places = [*(body.x for body in scene.bodies), X, 0 * pi]  # BASE is -2, GROUND -1
    stops = tuple(touching(stop, places) if touches(stop) else stop for stop in scene.stops)
    return replace(scene, base=base, forces=forces, stops=stops)
