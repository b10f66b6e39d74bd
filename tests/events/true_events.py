"""A stretch of a run, held against the exact flow from its start: what a certificate is judged by."""

from dataclasses import dataclass, fields, replace

from vibsim.kernel.driver import Driver
from vibsim.kernel.python_engine import FLOWS
from vibsim.physics.state import State

from vibsim.physics.modes import EVENT_NAMES
from vibsim.physics.number_kits import number_kit
from vibsim.physics.numbers import Doubles

DIGITS = 40
WHOLE = ("stop_sign", "order", "every_num", "every_den")  # whole numbers stay what they are


@dataclass(frozen=True)
class Stretch:
    """From `state` in `mode` to time `end` [s], and the kind of the event there ("" for none)."""

    state: State
    mode: object
    known: dict
    end: float
    kind: str
    first: bool


def stretches(scene):
    """(the stretches of a run in doubles, one after the other; its certificate).

    A stretch is what one step of the flow proves: a segment in closed form, a Taylor step.
    """
    flow = FLOWS[scene.method](scene, Doubles)
    driver = Driver(scene, Doubles, flow)
    found = []
    while not driver.finished:
        state, mode, recorded = State(**vars(driver.state)), driver.mode, len(driver.events)
        known = driver.known if driver.known_since == state.t else {}
        driver.run(10**9, 10**9, 1)
        kinds = [EVENT_NAMES[code] for code, _, _ in driver.events[recorded:]]
        kinds = [kind for kind in kinds if kind != "end"]
        found.append(Stretch(state, mode, known, driver.state.t, kinds[0] if kinds else "", not found))
    return found, flow.certificate


class ExactFlow:
    """The flow of `scene` in 40 digits, its doubles taken as exact."""

    def __init__(self, scene):
        self.kit, self.method = number_kit(DIGITS), scene.method
        names = [field.name for field in fields(scene) if field.name not in WHOLE]
        values = {name: getattr(scene, name) for name in names}
        exact = {name: self.kit.number(value) for name, value in values.items() if isinstance(value, float)}
        if scene.source == "harmonic":
            exact["omega"] = self.kit.two_pi * (exact["cycles"] + exact["cycles_lo"])
        self.scene = replace(scene, **exact, every_num=10**9, every_den=1)

    def first_event(self, stretch, end):
        """(kind, time [s]) of the first event behind the start of `stretch`, ("", end) without one."""
        self.kit.activate()
        state = State(*(self.kit.number(value) for value in vars(stretch.state).values()))
        resume = None if stretch.first else (state, stretch.mode, stretch.known)
        scene = replace(self.scene, t_end=self.kit.number(end))
        driver = Driver(scene, self.kit, FLOWS[self.method](scene, self.kit), resume)
        while len(driver.events) < 2:
            driver.run(10, 10, 1)
        code, state, _ = driver.events[1]
        kind = EVENT_NAMES[code]
        return "" if kind == "end" else kind, self.kit.rounded([state.t])[0]
