"""The tangent flow is the derivative of the motion, events included: difference quotients in 40 digits."""

from dataclasses import replace

import pytest
from vibsim.kernel.driver import Driver
from vibsim.kernel.python_engine import FLOWS

from tests.scenes import paper
from vibsim.engine.tangent_space import components
from vibsim.physics.modes import EVENT_NAMES
from vibsim.physics.multiprecision import Balls

DIGITS = 40
SHIFT = "1e-20"  # the quotient is then wrong by 1e-20 times the second derivative, and by 1e-40 / 1e-20
FAST = {"x1": "0.004", "v1": "0.05", "x2": "0", "v2": "-0.004", "phi": "0.3", "phidot": "31"}
SLOW = {"x1": "0.0001", "v1": "0.001", "x2": "0", "v2": "-0.0001", "phi": "0.3", "phidot": "2"}


def exact(name, kit, start, shifts, **changes):
    """A case of the paper in numbers of the kit, started at `start` with some of its values shifted."""
    scene = paper(name, **changes)
    floats = {key: kit.number(value) for key, value in vars(scene).items() if isinstance(value, float)}
    names = [key for key in start if getattr(scene, key) is not None]
    start = {key: kit.number(start[key]) + shifts.get(key, 0) for key in names}
    return replace(scene, **{**floats, **start})


def driven(scene, kit, method):
    """A driver with one disturbance, not yet run."""
    return Driver(scene, kit, FLOWS[method](scene, kit), tangent=(1, 0.0))


def finish(driver):
    while not driver.finished:
        driver.run(10**9, 10**9, 10**6)
    return driver


def relative(state):
    """(y, v1, v2, phi, w) of a state."""
    return [state.x1 - state.x2, state.v1, state.v2, state.phase, state.w]


SHIFTED = ("x1", "v1", "v2", "phi", "phidot")
IMPACTS, STICKS = {"contact_begin", "contact_end", "reversal"}, {"stick_begin", "stick_end"}
SCENES = {
    "impacts and reversals, closed form": ("I-B", "closed_form", FAST, 3.0, IMPACTS),
    "impacts and reversals, series": ("I-B", "taylor", FAST, 1.0, IMPACTS),
    "impacts and reversals, motor": ("II-B", "taylor", FAST, 0.4, IMPACTS),
    "sticking, closed form": ("I-A", "closed_form", SLOW, 2.0, STICKS | IMPACTS),
    "sticking, motor": ("II-A", "taylor", SLOW, 2.0, STICKS),
}


@pytest.mark.parametrize("label", SCENES)
def test_columns_of_the_jacobian(label):
    name, method, start, t_end, expected = SCENES[label]
    kit = Balls(DIGITS)
    shift = kit.number(SHIFT)
    scene = exact(name, kit, start, {}, t_end=t_end)
    base = finish(driven(scene, kit, method))
    kinds = {EVENT_NAMES[code] for code, _, _ in base.events}
    assert kinds >= expected
    for component in components(scene):
        moved = finish(driven(exact(name, kit, start, {SHIFTED[component]: shift}, t_end=t_end), kit, method))
        assert [row[0] for row in moved.events] == [row[0] for row in base.events]
        carried = driven(scene, kit, method)
        carried.tangent.vectors = [[kit.number(int(k == component)) for k in range(5)]]
        finish(carried)
        size = kit.exp(carried.tangent.sums[0])
        ours = [size * value for value in carried.tangent.vectors[0]]
        ends = zip(relative(moved.state), relative(base.state), strict=True)
        theirs = [(after - before) / shift for after, before in ends]
        largest = max(abs(float(value.mid())) for value in theirs)
        for one, other in zip(ours, theirs, strict=True):
            assert abs(float((one - other).mid())) < 1e-14 * largest
