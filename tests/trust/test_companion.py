"""The second run beside the first: what it integrates; that it keeps step, ends and fails as it should."""

import threading
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from tests.engine.runs import run
from vibsim.cases import load_case
from vibsim.cases.case import load_case_text
from vibsim.engine.errors import EngineError, State
from vibsim.engine.trajectory import open_trajectory
from vibsim.results.parallel_runs import (
    BLOCKS_AHEAD,
    GIVEN_UP,
    Companion,
    LastSamples,
    companion_scene,
    described,
    third_scene,
)

LONG = {"run.t_end": "100000 s"}
END = "run: {t_end: 1 s, every: 10 ms}"
# those of II-B that are no doubles
NUMBERS = [lambda it, i=i: it.bodies[i].m for i in range(2)]
NUMBERS += [lambda it: it.links[0].c, lambda it: it.stops[0].gap, lambda it: it.frictions[0].forward]
NUMBERS += [lambda it, n=n: getattr(it.motor, n) for n in ("m3", "e", "J", "M0", "Omega0")]


def any_number(samples):
    """Events that a companion may take up to each of so many samples: as many as it likes."""
    return np.full(samples, 10**9)


def companion_of(name, **changes):
    case = load_case(name, {key.replace("__", "."): value for key, value in changes.items()})
    return case, companion_scene(case, case.scene())


@pytest.fixture
def companions():
    """Companions that are ended with the test."""
    made = []

    def start(scene):
        made.append(Companion(scene))
        made[-1].start()
        return made[-1]

    yield start
    for companion in made:
        companion.close()


def test_data_that_are_no_doubles_move_one_ulp_towards_their_decimals():
    case, other = companion_of("II-B")
    scene, exact = case.scene(), case.exact_scene(Fraction)
    for number in NUMBERS:
        ours, theirs, true = number(scene), number(other), number(exact)
        assert abs(theirs - ours) == np.spacing(min(ours, theirs))
        assert min(ours, theirs) < true < max(ours, theirs)
    for number in (  # 200, 12400 and 0 are doubles
        lambda it: it.links[0].k,
        lambda it: it.stops[0].k,
        lambda it: [(body.x, body.v) for body in it.bodies],
        lambda it: it.motor.phi,
    ):
        assert number(scene) == number(other)


@pytest.mark.parametrize(
    ("name", "method", "changes", "expected"),
    [
        ("I-A", "closed_form", {}, ("taylor", 20)),
        ("I-A", "closed_form", {"run__order": "6"}, ("taylor", 20)),
        ("I-A", "taylor", {"run__method": "taylor"}, ("closed_form", 25)),
        ("II-B", "taylor", {}, ("taylor", 25)),
        ("II-B", "taylor", {"run__order": "25"}, ("taylor", 20)),
        ("II-B", "taylor", {"run__order": "4", "run__tol": "1e-3"}, ("taylor", 25)),
    ],
)
def test_the_companion_steps_otherwise_and_at_full_tolerance(name, method, changes, expected):
    case, other = companion_of(name, **changes)
    assert (other.method, other.order) == expected
    assert (other.method, other.order) != (method, case.two_blocks().order)
    assert other.method == "closed_form" or other.tol == 2.0**-53
    assert ("closed form" in described(other)) == (other.method == "closed_form")
    third = third_scene(other, case.scene())
    assert third.method == "taylor" and third.order not in (other.order, case.scene().order)
    assert third.tol == 2.0**-53


def test_data_of_a_third_run_lie_on_both_sides():
    """What two of them do to the motion may cancel in the companion; it must not in both."""
    case, other = companion_of("II-B")
    scene = case.scene()
    third = third_scene(other, scene)
    sides = []
    for number in NUMBERS:
        ours, theirs, last = number(scene), number(other), number(third)
        assert abs(last - ours) == np.spacing(min(ours, last))
        sides.append((last > ours) == (theirs > ours))
    assert sides.count(True) in (4, 5, 6)
    assert [body.x for body in third.bodies] == [body.x for body in scene.bodies]


def test_the_companion_goes_on_where_the_rest_distance_ends_the_run():
    changes = {"rest_distance__value": "1 mm", "rest_distance__on_violation": "stop"}
    case, other = companion_of("I-B", run__t_end="10 s", **changes)
    assert run(case.two_blocks()).events["t"][-1] < 10 == run(other).events["t"][-1]


@pytest.mark.parametrize("name", ["I-A", "II-B"])
def test_samples_come_in_any_portions(name, companions):
    _, other = companion_of(name, run__t_end="40 s", run__every="1 ms")
    whole = run(other, dither=Companion.dither).samples
    companion = companions(other)
    portions = [companion.take(any_number(count)) for count in (1, 0, 7, 20_000, 19_993)]
    got = np.concatenate(portions, axis=1)
    assert got.tobytes() == np.stack([whole["x1"], whole["x2"]]).tobytes()


def test_a_companion_that_nobody_asks_waits_and_can_be_ended(companions):
    _, other = companion_of("I-A", **{"run__t_end": "100000 s"})
    companion = companions(other)
    companion.take(any_number(10))
    assert companion._thread.is_alive()
    companion._thread.join(0.3)
    assert companion._queue.qsize() <= BLOCKS_AHEAD
    companion.close()
    assert not companion._thread.is_alive()
    assert "vibsim companion" not in [thread.name for thread in threading.enumerate()]


class Failing:
    """A trajectory that fails after its second block."""

    def __init__(self, trajectory, error):
        self.trajectory, self.error, self.stop = trajectory, error, trajectory.stop

    def blocks(self):
        for i, block in enumerate(self.trajectory.blocks()):
            yield block
            if i == 1:
                raise self.error


@pytest.fixture
def failing(monkeypatch, companions):
    def start(scene, error):
        real = open_trajectory
        monkeypatch.setattr(
            "vibsim.results.parallel_runs.open_trajectory",
            lambda scene, *_, **wishes: Failing(real(scene), error),
        )
        return companions(scene)

    return start


def test_of_a_companion_that_fails_nothing_is_known(failing):
    _, other = companion_of("I-A", run__t_end="1000 s")
    companion = failing(other, EngineError("diverged", State(0.0, [0.0], [0.0], 0.0, 0.0, 0.0)))
    got = companion.take(any_number(200_000))
    known = int(np.count_nonzero(~np.isnan(got[0])))
    assert 0 < known < 200_000
    assert np.isnan(got[:, known:]).all()
    assert np.isnan(companion.take(any_number(3))).all()
    assert companion.failure.startswith("ended at 0 s: the state is no longer finite")


def test_a_bug_in_the_companion_is_raised(failing):
    _, other = companion_of("I-A", run__t_end="1000 s")
    with pytest.raises(ZeroDivisionError):
        failing(other, ZeroDivisionError()).take(any_number(200_000))


@pytest.mark.parametrize("portion", [7, 1000, 20_001])
def test_a_companion_that_takes_too_many_events_is_given_up_where_it_does(portion, companions):
    """However its blocks and the portions asked for fall, and whether it is asked before it is waited for."""
    _, other = companion_of("I-B", run__t_end="100 s")
    whole = run(other, early=True, dither=Companion.dither)
    taken = np.searchsorted(whole.events["t"], whole.samples["time"], side="right")
    most = np.minimum(taken, taken[9000])
    known = int(np.argmax(taken > most))
    assert 9000 < known < 19_000
    companion = companions(other)
    got = []
    for begin in range(0, 20_001, portion):
        while not companion.has(most[begin : begin + portion]):
            companion._thread.join(0.01)
        got.append(companion.take(most[begin : begin + portion]))
    got = np.concatenate(got, axis=1)
    assert got[:, :known].tobytes() == np.stack([whole.samples[x][:known] for x in ("x1", "x2")]).tobytes()
    assert np.isnan(got[:, known:]).all()
    assert companion.failure == GIVEN_UP and companion.t_reached == np.inf


def test_of_a_third_run_that_takes_too_many_events_nothing_is_known():
    _, other = companion_of("I-B", run__t_end="100 s")
    events = len(run(other).events["t"])
    for most, known in ((events, True), (events - 1, False)):
        third = LastSamples(other, 20_001, 16, most)
        third.start()
        while (told := third.told(0.1)) is None:
            pass
        assert np.isfinite(told).all() == known and np.isinf(told).all() != known
        assert (third.failure == GIVEN_UP) != known
        third.close()


@pytest.mark.parametrize("dither", [1, 2])
def test_events_lie_one_unit_in_the_last_place_aside(dither):
    """The first exactly, the others but for what comes of it; motions are the same but for rounding."""
    scene = replace(load_case("I-A", {"run.t_end": "20 s"}).scene(), method="taylor")
    plain, moved = run(scene), run(scene, dither=dither)
    one, other = plain.events["t"][1:-1], moved.events["t"][1:-1]
    assert len(one) == len(other) > 100
    assert abs(other[0] - one[0]) == np.spacing(one[0])
    units = np.rint((other - one) / np.spacing(one))
    assert min(np.sum(units > 0), np.sum(units < 0)) > 30
    assert np.abs(units).max() < 64
    for name in ("x1", "x2"):
        assert 0 < np.abs(moved.samples[name] - plain.samples[name]).max() < 1e-14


def test_events_at_the_end_of_a_run_stay_within_it():
    """A body dropped from g / 2 strikes the floor after 1 s, where the run ends."""
    text = (
        "bodies: {a: 1 kg}\nstops: {s: {between: [a, ground], gap: 0 m, acts: extension, law: rigid, e: 0.5}}"
    )
    case = load_case_text(f"{text}\nforces: {{f: {{on: a, F0: -2 N}}}}\ninitial: {{a: {{x: 1 m}}}}\n{END}")
    for dither in range(4):
        found = run(case.scene(), dither=dither)
        start, impact, end = found.events["t"].tolist()
        assert start == 0 and 1 - 1e-14 < impact <= end == found.samples["time"][-1] == 1
