"""Random scenes whose whole runs are held against another way to compute them."""

import random
from dataclasses import dataclass, fields, replace
from math import inf, pi

import numpy as np

from tests.engine.many_digits import exact_parts, faults, touches, touching
from tests.engine.runs import Run, whole
from tests.engine.test_resources import is_jammed
from vibsim.engine.c_engine import REASONS, UNDECIDED, CRun
from vibsim.engine.errors import EngineError, State, start_of
from vibsim.engine.number_forms import WordsForm
from vibsim.engine.resume import resume_point
from vibsim.engine.trajectory import Trajectory, open_trajectory
from vibsim.physics.parts import EVENT_NAMES, Scene
from vibsim.physics.precision import number_kit

DITHERS = (1, 2, 3)
ALIKE = 1e-8  # of displacements, or m: far less than what an event more or fewer does


def finished(scene, **options):
    """The run of a scene, options as of `open_trajectory`; raises Crawling where it takes too long or goes on
    no further, None where bodies are caught between rigid stops.
    """
    trajectory, blocks = open_trajectory(scene, **options), []
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
    """The faults of a certified run, but for events behind those whose order rounding decides: a run is
    certified stretch by stretch, and hops of two stops in turn before they end part runs a billionfold.
    """
    run = finished(scene)
    found = faults(scene, run, ALIKE) if certified(run) else []
    events = [one for one in found if isinstance(one, tuple)]
    until = settled_until(scene, run) if events else inf
    return [one for one in found if one not in events or one[2] < until]


def settled_until(scene, run):
    """Time [s] up to which runs have the same events whose times are moved by one unit in the last place."""
    until = inf
    for dither in DITHERS:
        other = finished(scene, dither=dither)
        pairs = [[run.events[name], other.events[name]] for name in ("kind", "part")]
        length = min(map(len, pairs[0]))
        differ = np.any([one[:length] != two[:length] for one, two in pairs], axis=0)
        if differ.any():
            until = min(until, run.events["t"][np.argmax(differ)])
    return until


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


def crawl(steps):
    """Give up where the search creeps along a limit."""
    if steps > MOST_STEPS:
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
    """(the stretches of a run in doubles, one after the other; its doubts).

    A stretch is what one step of the flow proves: a segment in closed form, a Taylor step.
    """
    run = SteppedRun(scene if isinstance(scene, Scene) else scene.as_parts())
    found, behind, finished = [], [], 0
    while not finished:
        tally, told = run.tally, []
        state, status = State(*tally["state"]), run.statuses[tally["mode"]]
        known = resume_point(run.scene, behind)[2] if behind and behind[0]["t"] == state.t else {}
        while run.tally["state"][0] == state.t and not told and not finished:
            happened, finished = run.step()
            told += [row for row in happened if EVENT_NAMES[row["kind"]] not in ("start", "end")]
            crawl(run.tally["steps"])
        kind = EVENT_NAMES[told[0]["kind"]] if told else ""
        found.append(Stretch(state, status, known, run.tally["state"][0], kind, not found))
        behind = [row for row in [*behind, *told] if row["t"] == (told or behind)[-1]["t"]]
    return found, run.tally["certificate"][0]


class SteppedRun(CRun):
    """A run in doubles, stretch by stretch."""

    def step(self):
        """(rows of the events behind a stretch, whether the run is over)."""
        *counts, finished, status = self.run.advance(1)
        while status == UNDECIDED:
            number, event, order, values = self.run.pending()
            if self._set_rule(number, event):
                *counts, finished, status = self.run.advance(0)
            else:
                *counts, finished, status = self._decide(number, event, State(*values), order)
        if status in REASONS:
            raise self._failure(status)
        events = Trajectory(self).columns.block(*self._block(counts, finished)).events
        return [
            {name: column[i].item() for name, column in events.items()} for i in range(len(events["t"]))
        ], finished


class ExactRun(CRun):
    """Runs of one scene on numbers of words, one after the other."""

    def first_event(self, point, end):
        """(kind, time [s]) of the first event behind `point`, the start where that is None; ("", end) without
        one up to `end`.
        """
        self.run.rewind(self.kit.number(end))
        self.run.fill(*self.arrays)
        self._set_off(*(point or self._begun(start_of(self.scene, self.kit))))
        told = []
        for _, _, events, codes, *_ in self.blocks():
            crawl(self.tally["steps"])
            told += zip(codes[0].tolist(), self.form.doubles(events[0]).tolist(), strict=True)
            if len(told) > 1:
                kind, t = told[1]
                return "" if EVENT_NAMES[kind] == "end" else EVENT_NAMES[kind], t
        raise AssertionError("a run has an end")


class ExactFlow:
    """The flow of `scene`, two blocks or made of parts, in 40 digits, its doubles taken as exact."""

    def __init__(self, scene):
        self.kit = number_kit(DIGITS)
        scene = replace(scene, every_num=10**9, every_den=1)
        self.kit.activate()
        if isinstance(scene, Scene):
            exact = at_quarters(exact_parts(scene)(self.kit.number, self.kit.pi), self.kit)
        else:
            exact = self._exact_blocks(scene).as_parts()
        self.run = ExactRun(exact, form=WordsForm(self.kit))

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
        point = None if stretch.first else (self._state(stretch.state), stretch.status, stretch.known)
        return self.run.first_event(point, end)

    def _state(self, state):
        number = self.kit.number
        x, v = [number(value) for value in state.x], [number(value) for value in state.v]
        return State(number(state.t), x, v, number(state.phase), number(state.turns), number(state.w))


def at_quarters(scene, kit):
    """An exact scene, whose phases that are quarter turns in doubles are quarter turns."""

    def turned(terms):
        return tuple(
            replace(one, phase=kit.pi / 2 if one.phase > 0 else -kit.pi / 2)
            if abs(one.phase) == QUARTER_TURN
            else one
            for one in terms
        )

    base, forces = turned(scene.base), tuple(replace(one, terms=turned(one.terms)) for one in scene.forces)
    X = sum((one.amplitude * kit.sin(one.phase) for one in base), kit.zero)
    places = [*(body.x for body in scene.bodies), X, kit.zero]  # BASE is -2, GROUND -1
    stops = tuple(touching(stop, places) if touches(stop) else stop for stop in scene.stops)
    return replace(scene, base=base, forces=forces, stops=stops)
