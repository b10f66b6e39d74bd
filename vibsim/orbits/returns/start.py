"""A scene, or a case, that starts on an orbit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from vibsim.physics.parts import Scene, columns_of

if TYPE_CHECKING:
    from vibsim.cases.case import Case

SAMPLES = 400  # of a stored orbit, about


def placed(scene: Scene, state: Mapping[str, float], t_end: float) -> Scene:
    """The scene from a state, by name of the column, to `t_end` [s]."""
    bodies = []
    for body in scene.bodies:
        x, v = columns_of(body.name)
        bodies.append(replace(body, x=state[x], v=state[v]))
    motor = scene.motor
    if motor is not None:
        motor = replace(motor, phi=state["phi"], phidot=state["phidot"])
    stops = tuple(replace(stop, at_start=False) for stop in scene.stops)
    return replace(scene, bodies=tuple(bodies), motor=motor, stops=stops, t_end=t_end)


def case_on_orbit(case: Case, state: Mapping[str, float], period: float) -> Case:
    """The case from a state by name of the column over one period [s]; every number as the double it is."""
    return case.with_values({**_initial(case, state), **_span(period), **_freely(case)})


def _initial(case: Case, state: Mapping[str, float]) -> dict[str, str]:
    values: dict[str, str] = {}
    for body in case.scene().bodies:
        x, v = columns_of(body.name)
        names = (f"{body.name}.x", f"{body.name}.v") if case.is_long else (x, v)
        values |= {f"initial.{names[0]}": f"{state[x]!r} m", f"initial.{names[1]}": f"{state[v]!r} m/s"}
    if "phidot" in state:
        motor = "initial.motor." if case.is_long else "initial."
        values |= {f"{motor}phi": f"{state['phi']!r} rad", f"{motor}phidot": f"{state['phidot']!r} rad/s"}
    return values


def _span(period: float) -> dict[str, str]:
    """Samples lie on decimals; the end of the period is in the table of events."""
    return {"run.t_end": f"{period!r} s", "run.every": f"{period / SAMPLES:.3g} s"}


def _freely(case: Case) -> dict[str, str]:
    """A limit that is watched ends no orbit."""
    if case.is_long:
        return {"run.on_violation": "warn"}
    return {"rest_distance.on_violation": "warn"} if case.scene().clearances else {}
