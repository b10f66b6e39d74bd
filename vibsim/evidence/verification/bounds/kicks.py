"""Rounding, imitated where it can be seen: runs of many digits that are kicked as a run in doubles is.

A run in doubles rounds every number of its scene, and the state behind every event, for Taylor series behind
every step. Here the very same is done to a run of many digits, by random signs and known amounts. How far its
states and event times then stray tells what an algorithm without faults of its own may be off by in doubles:
the conditioning of the motion, amplification by impacts and chaos included.
"""

from __future__ import annotations

from dataclasses import replace
from random import Random
from typing import TYPE_CHECKING

from vibsim.engine.flows.flow import Flow
from vibsim.engine.state import State
from vibsim.physics.arithmetic.numbers import Kit, Number
from vibsim.physics.parts import Scene
from vibsim.physics.two_blocks import TwoBlocks

if TYPE_CHECKING:
    from vibsim.engine.modes.rows import Known, ModeRows

UNIT = 2.0**-53  # unit round-off of doubles
# a number of the scene is rounded once, and what follows from several (k1 + k2, 1/m1 + 1/m2, w0) twice more
SCENE_UNITS = 4
# a state is made of responses right to 6, 8 and 16 units (tests/flows/test_responses.py)
STATE_UNITS = 16
NUMBERS = ("m1", "m2", "k1", "c", "k2", "G", "N", "A", "F0", "omega", "m3", "e", "J", "M0", "Omega0")
START = ("x1", "v1", "x2", "v2", "phi", "phidot")


def kicked_scene(scene: TwoBlocks, kit: Kit[Number], rng: Random) -> TwoBlocks:
    """`scene` with every number of it off by SCENE_UNITS, up or down.

    The frequency in Hz stays: both flows reduce the phase with twice the digits of a double.
    """
    numbers = {name: getattr(scene, name) for name in NUMBERS + START}
    return replace(
        scene,
        **{
            name: value * _factor(kit, rng, SCENE_UNITS)
            for name, value in numbers.items()
            if value is not None
        },
    )


def _factor(kit: Kit[Number], rng: Random, units: int) -> Number:
    return 1 + kit.number(rng.choice((-1, 1)) * units * UNIT)


def kicked_state(state: State[Number], kit: Kit[Number], rng: Random) -> State[Number]:
    """Displacements and velocities off by STATE_UNITS of the larger of the two, the phase by as much of a
    radian. An exact zero stays: such are set, not computed.
    """

    def kicked(value: Number, size: Number | int) -> Number:
        return value + size * (_factor(kit, rng, STATE_UNITS) - 1) if value != 0 else value

    length, speed = max(map(abs, state.x)), max(map(abs, state.v))
    return State(
        state.t,
        [kicked(x, length) for x in state.x],
        [kicked(v, speed) for v in state.v],
        kicked(state.phase, 1),
        state.turns,
        kicked(state.w, abs(state.w)),
    )


class KickedFlow(Flow[Number]):
    """The flow of a run, kicked at every event, and by Taylor series at every step."""

    def __init__(self, scene: Scene[Number], kit: Kit[Number], rng: Random) -> None:
        self.rng = rng
        super().__init__(scene, kit)

    def enter(self, state: State[Number], rows: ModeRows[Number], known: Known) -> None:
        """Go on from `state`, kicked."""
        super().enter(kicked_state(state, self.kit, self.rng), rows, known)

    def carry_on(self, state: State[Number]) -> None:
        """The next step, from `state`, kicked."""
        self.now.carry_on(kicked_state(state, self.kit, self.rng))
