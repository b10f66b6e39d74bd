"""Runs of many digits for the stored truths, kicked or not."""

from dataclasses import dataclass, replace
from decimal import Decimal
from random import Random
from typing import Any

from vibsim.cases import Case, load_case
from vibsim.engine.columns import state_columns
from vibsim.engine.driver import Driver
from vibsim.engine.state import State
from vibsim.engine.truth import bare
from vibsim.evidence.verification.bounds.kicks import KickedFlow, kicked_scene
from vibsim.evidence.verification.hard.hard_cases import PERIODIC
from vibsim.evidence.verification.hard.million_seconds import PERIOD, SETTLED
from vibsim.evidence.verification.hard.paper_cases import judged_case
from vibsim.evidence.verification.truths.event_matching import Event
from vibsim.physics.arithmetic.number_kits import DigitsKit, number_kit, one_precision
from vibsim.physics.arithmetic.numbers import Number
from vibsim.physics.modes import EVENT_NAMES

INSTANTS = 10  # at which states are kept, besides the start


@dataclass(frozen=True)
class Run:
    """A finished run: time [s] and states of its samples, its events."""

    time: list[float]
    states: dict[str, list[Decimal]]
    events: list[Event]


@dataclass(frozen=True)
class Plan:
    """How a truth is made: case to run, samples per instant kept, whether events are kept.

    settled, period : where only one period [s] after a settled start [s] is kept
    """

    case: Case
    stride: int
    with_events: bool = True
    settled: float | None = None
    period: float | None = None


def plan(name: str) -> Plan:
    """The plan for a hard case, or for one of the paper's."""
    if name == PERIODIC:
        case = load_case(name, {"run.t_end": f"{SETTLED + PERIOD:g} s", "run.every": f"{PERIOD / 16:g} s"})
        return Plan(case, 1, True, SETTLED, PERIOD)
    case = load_case(name) if name.startswith("hard/") else judged_case(name)
    stride = max(1, (case.two_blocks().sample_count - 1) // INSTANTS)
    return Plan(case, stride, name.startswith("hard/"))


def run_digits(how: Plan, flow: str, digits: int, seed: int | None = None) -> Run:
    """A run of many digits, kicked where a seed is given."""
    with one_precision:
        return _run_digits(how, flow, digits, seed)


def _run_digits(how: Plan, flow: str, digits: int, seed: int | None) -> Run:
    kit: Any = number_kit(digits)
    kit.activate()
    doubles = how.case.two_blocks()
    scene = how.case.exact_two_blocks(kit.number, kit.pi)
    scene = replace(scene, t_end=kit.number(doubles.t_end), every_num=scene.every_num * how.stride)
    rng = None if seed is None else Random(seed)
    if rng:
        scene = kicked_scene(scene, kit, rng)
    parts = replace(bare(scene.as_parts(), kit), method=flow)
    driver = Driver(parts, kit, flow=KickedFlow(parts, kit, rng) if rng else None)
    while not driver.finished:
        driver.run(10**9, 10**9, 10**9)
    return _kept_part(_finished(kit, driver), how)


def _finished(kit: DigitsKit[Number], driver: Driver[Number]) -> Run:
    samples, events, *_ = driver.take()
    states = [state for state, _ in samples]
    names = state_columns(driver.scene)
    rows = [_values(kit, state) for state in states]
    columns = {name: kit.texts([row[i] for row in rows]) for i, name in enumerate(names)}
    times = kit.texts([state.t for _, _, state, *_ in events])
    kinds = [EVENT_NAMES[code] for code, *_ in events]
    return Run(
        [float(state.t) for state in states],
        {name: [Decimal(text) for text in texts] for name, texts in columns.items()},
        list(zip(kinds, map(Decimal, times), strict=True))[1:-1],
    )


def _values(kit: DigitsKit[Number], state: State[Number]) -> list[Number]:
    moving = [value for pair in zip(state.x, state.v, strict=True) for value in pair]
    return [*moving, kit.unwind(state.phase, state.turns), state.w]


def _kept_part(run: Run, how: Plan) -> Run:
    """The run as its truth keeps it: without events, or one settled period with times from its start."""
    if not how.with_events:
        return replace(run, events=[])
    if how.settled is None:
        return run
    late = [i for i, t in enumerate(run.time) if t >= how.settled]
    return Run(
        [run.time[i] - how.settled for i in late[:-1]],  # the last one is the first of the next period
        {name: [column[i] for i in late[:-1]] for name, column in run.states.items()},
        [(kind, t - Decimal(how.settled)) for kind, t in run.events if t >= how.settled],
    )
