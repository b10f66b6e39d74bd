"""Runs whose steps are taken side by side (`lanes.c`) have the bits that each has by itself."""

from contextlib import suppress
from dataclasses import replace

import pytest

import vibsim.engine._engine as _engine
from tests.engine.random_formulas import formula_scene
from tests.engine.random_parts import part_scene, rigid_scene
from tests.engine.runs import opened, scene_of
from tests.random_scenes import Draws
from tests.scenes import paper
from vibsim.engine.errors import EngineError
from vibsim.physics.parts import GROUND, RigidStop

WIDTHS = (8, 4, 0)  # lanes in a vector: of AVX-512, of AVX2, none

ONE_BODY = """
name: one-body
title: A body with a motor between stops
bodies: {block: 1 kg}
links: {spring: {between: [block, ground], k: 40 N/m, c: 0.1 N s/m}}
stops:
  right: {between: [block, ground], gap: 5 mm, acts: extension, k: 4 kN/m, c: 2 N s/m}
  left: {between: [block, ground], gap: 6 mm, acts: compression, k: 3 kN/m}
friction: {floor: {between: [block, ground], mu: 0.02, belt: 1 mm/s}}
motor: {on: block, m3: 0.05 kg, e: 5 cm, J: 2e-4 kg m^2, M0: 0.01 N m, Omega0: 2 Hz}
run: {t_end: 20 s, every: 10 ms}
"""


def varied(scene, count):
    """Scenes that differ in their motors and starts, as the points of a sweep do."""
    for i in range(count):
        bodies = tuple(replace(body, x=body.x * (1 + 0.01 * i)) for body in scene.bodies)
        Omega0, phidot = scene.motor.Omega0 * (0.7 + 0.1 * i), scene.motor.phidot * (1 - 0.2 * i)
        yield replace(scene, motor=replace(scene.motor, Omega0=Omega0, phidot=phidot), bodies=bodies)


def rigid_inside(stop, places, far):
    """Whether a rigid stop would begin violated between the first body and the other, or the ground."""
    return isinstance(stop, RigidStop) and stop.gap + stop.sense * (places[0] - places[far]) <= 0


def small_scene(draw, radians, **options):
    """A random scene of one body or two whose motor is on the first one and that nothing else drives."""
    make = draw.sampled_from((part_scene, part_scene, rigid_scene))
    scene = make(draw, radians=radians, motor=True, bodies=2, based=False)
    far = 1 if len(scene.bodies) > 1 else GROUND
    places = [body.x for body in scene.bodies] + [0.0]
    free = [stop for stop in scene.stops if not rigid_inside(stop, places, far)]
    stops = tuple(replace(stop, P=0, Q=far) for stop in free)
    links = tuple(replace(link, P=0, Q=far) for link in scene.links)
    frictions = tuple(
        replace(one, P=draw.sampled_from((0, max(far, 0))), Q=GROUND) for one in scene.frictions
    )
    motor = replace(scene.motor, on=0)
    return replace(scene, links=links, stops=stops, frictions=frictions, motor=motor, forces=())


def open_all(scenes):
    """Their runs, with all that is recorded along them; without those that end before they begin."""
    for scene in scenes:
        ends = [(i, GROUND) for i in range(len(scene.bodies))]
        with suppress(EngineError):
            yield opened(scene, section=True, extremes=(ends, 0.1))


class Taken:
    """What comes of a run, block by block."""

    def __init__(self, run):
        self.run, self.blocks, self.error, self.ended = run, run.blocks_beside(), "", False
        self.columns = {}

    def go_on(self):
        """Take blocks to the next call of C, or to the end."""
        try:
            while (block := next(self.blocks)) is not None:
                for table in ("samples", "events", "section"):
                    for name, column in getattr(block, table).items():
                        self.columns.setdefault((table, name), []).append(column.tobytes())
                self.columns.setdefault("extremes", []).append(block.extremes.T.tobytes())
        except StopIteration:
            self.ended = True
        except EngineError as error:
            self.error, self.ended = f"{error}", True

    def bits(self):
        """All of it."""
        columns = {name: b"".join(parts) for name, parts in self.columns.items()}
        told = self.run.run.tally
        return columns, repr(self.run.totals), repr(self.run.extremes), self.error, told["state"]


def alone(scenes):
    """What comes of runs by themselves."""
    runs = [Taken(run) for run in open_all(scenes)]
    for one in runs:
        while not one.ended:
            one.go_on()
    return [one.bits() for one in runs]


def beside(scenes, widest):
    """The same of runs whose steps are taken side by side as long as more than one is left; the steps, and
    those of them that were.
    """
    going = runs = [Taken(run) for run in open_all(scenes)]
    for one in going:
        one.go_on()
    while going := [one for one in going if not one.ended]:
        reached = _engine.advance_together(tuple(one.run.run.run for one in going), widest)
        for one, progress in zip(going, reached, strict=True):
            one.run.run.advanced = progress
            if progress is not None:
                one.go_on()
    tallies = [one.run.run.tally for one in runs]
    steps = [sum(tally[name] for tally in tallies) for name in ("steps", "steps_beside")]
    return [one.bits() for one in runs], steps


@pytest.mark.parametrize("widest", WIDTHS)
@pytest.mark.parametrize("name", ["II-A", "II-B", "II-C", "one-body"])
def test_runs_side_by_side_have_the_bits_of_each_by_itself(name, widest):
    scene = scene_of(ONE_BODY) if name == "one-body" else paper(name, t_end=40.0).as_parts()
    scenes = list(varied(scene, 11))
    outcomes, (steps, steps_beside) = beside(scenes, widest)
    assert outcomes == alone(scenes)
    in_lanes = 0.9 * steps if min(widest, _engine.LANES) else 0
    assert steps_beside >= in_lanes and (in_lanes or not steps_beside)


@pytest.mark.parametrize("order", [4, 5, 7, 40])
def test_other_orders_of_taylor_series_have_their_bits_too(order):
    scenes = list(varied(replace(paper("II-B", t_end=4.0).as_parts(), order=order), 5))
    expected = alone(scenes)
    for widest in WIDTHS:
        assert beside(scenes, widest)[0] == expected


def steps_of_random_scenes(seed):
    """By width, the steps side by side of random scenes, which have the bits of each by itself."""
    draw = Draws(seed)
    make = draw.sampled_from((small_scene, small_scene, part_scene, rigid_scene))
    scene = make(draw, radians=30.0, motor=True, bodies=2)
    scenes = [*varied(scene, draw.integers(2, 12)), *varied(small_scene(draw, 30.0), 2)]
    expected, steps = alone(scenes), {}
    for widest in WIDTHS:
        outcomes, (_, steps[widest]) = beside(scenes, widest)
        assert outcomes == expected
    return steps


@pytest.mark.parametrize("seed", range(40))
def test_random_scenes_side_by_side_have_their_bits(seed):
    steps_of_random_scenes(seed)


def test_random_scenes_have_taken_steps_side_by_side():
    steps = [steps_of_random_scenes(seed) for seed in range(8)]
    entered = sum(one[widest] > 0 for one in steps for widest in (8, 4))
    assert not any(one[0] for one in steps) and (entered >= 8 or not _engine.LANES)


def test_runs_of_any_other_scene_are_taken_by_themselves():
    scenes = [formula_scene(seed) for seed in range(6)] + [paper("I-B", t_end=5.0).as_parts()]
    outcomes, (_, steps_beside) = beside(scenes, 8)
    assert outcomes == alone(scenes) and steps_beside == 0


@pytest.mark.parametrize("count", range(2, 8))
@pytest.mark.parametrize("name", ["II-A", "II-B", "II-C"])
def test_a_run_that_waits_for_others_goes_on_by_itself(name, count):
    scenes = list(varied(paper(name, t_end=10.0).as_parts(), count))
    runs = [Taken(run) for run in open_all(scenes)]
    for one in runs:
        one.go_on()
    waited, time, going = False, 0.0, runs
    while going := [one for one in going if not one.ended]:
        time += 0.21
        for i, one in enumerate(going):
            one.run.pause_at(time + 0.1 * (i > 0))
        reached = _engine.advance_together(tuple(one.run.run.run for one in going))
        waited |= None in reached  # as the first one has come to its pause
        for one, progress in zip(going, reached, strict=True):
            one.run.run.advanced = progress
            one.go_on()
    assert waited or not _engine.LANES
    assert [run.bits() for run in runs] == alone(scenes)


def test_what_cannot_be_taken_together_is_refused():
    one, other = (Taken(run) for run in open_all(varied(paper("II-B", t_end=5.0).as_parts(), 2)))
    handle = one.run.run.run
    for wrong, error in (((handle, handle), RuntimeError), ((handle, "a run"), ValueError)):
        with pytest.raises(error):
            _engine.advance_together(wrong)
    with pytest.raises(ValueError, match="up to 64 runs"):
        _engine.advance_together((other.run.run.run, None))
    assert _engine.advance_together(()) == []
    while not one.ended:  # it was let go again
        one.go_on()
    assert not one.error
