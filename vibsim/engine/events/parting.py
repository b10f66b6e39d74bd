"""Elastic stops and clearances that tied ends just touch, and that part or close where the tie lets go.

Their functions rest at zero while the tie holds. Behind the release they have a zero of order 3, as the
motion itself, or of order 2 where a force jumps there.
"""

from __future__ import annotations

from vibsim.engine.modes.rows import RowMaker
from vibsim.engine.modes.status import Status
from vibsim.physics.numbers import Kit, N, abs
from vibsim.physics.parts import Clearance, RigidStop, Stop

START_ROUNDING = 16  # at least: each of three numbers and of two differences is rounded once


def meets(
    kit: Kit[N], part: Stop[N] | RigidStop[N] | Clearance[N], value: N, places: tuple[N, N], distance: N
) -> bool:
    """Whether the ends at `places` [m] are exactly where `value` = x_P - x_Q + ... is zero: as computed, or
    as told of the start from exact numbers, whose rounding it may be then.
    """
    size = abs(places[0]) + abs(places[1]) + abs(distance)
    return value == 0 or (part.at_start and abs(value) <= START_ROUNDING * kit.eps * size)


def let_go(maker: RowMaker[N], before: Status, behind: Status) -> tuple[list[int], list[int]]:
    """The numbers of the elastic stops and of the clearances whose ends are tied in the mode `before` and not
    in the one `behind`.
    """
    tied, loose = maker.ties(before)[0], maker.ties(behind)[0]

    def parts(one: Stop[N] | Clearance[N]) -> bool:
        P, Q = maker.ends(one)
        return tied[P] == tied[Q] and loose[P] != loose[Q]

    stops = [i for i, stop in maker.scene.elastic_stops if i not in maker.guarded and parts(stop)]
    return stops, [i for i, one in enumerate(maker.scene.clearances) if parts(one)]
