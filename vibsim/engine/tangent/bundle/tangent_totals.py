"""What the tangent bundle of a run came to, by name."""

from math import inf, nan
from typing import Any

import numpy as np

from vibsim.engine.tangent.events.tangencies import CLOSE
from vibsim.engine.tangent.tangent_space import natural_rate
from vibsim.physics.arithmetic.numbers import Kit, N
from vibsim.physics.parts import Scene


def tangent_totals(
    scene: Scene[N], kit: Kit[N], entries: dict[str, Any], margin: float, margin_time: float
) -> dict[str, Any]:
    """Totals from `TangentBundle.entries()`.

    margin, margin_time: smallest gap at a turn without contact [m] (inf without any) and when [s].

    exponents : growth rates [1/s] over the recorded span, the largest first; NaN where there is no span yet
    and where there is no derivative, -inf where ties took the direction
    growth : rows (t [s], logarithm of the growth of each disturbance since the first row)
    rank_losses : directions that ties took within the span, and those that they held at its start
    tangent_pieces : stretches after which it was orthonormalised
    volume_residual : what is missing in the identity of Liouville [-]; NaN unless the bundle is complete
    tangencies, closest_tangency [-], closest_tangency_time [s] : events crossed almost tangentially, turns
    almost in contact; see `vibsim.engine.tangent.events.tangencies`
    undefined_time : time [s] of the first event in the span that has no derivative; NaN without any
    """
    columns, lost = entries["columns"], np.array(entries["lost"])
    table = np.array(entries["rows"], dtype="f8").reshape(-1, 1 + len(columns))
    growth = np.ascontiguousarray(table[:, [0, *(1 + column for column in columns)]])
    growth[1:, 1:][:, lost] = -inf
    known = len(growth) > 1
    count, undefined_time = entries["undefined"]
    if count:
        growth[growth[:, 0] > undefined_time, 1:] = nan
    exponents = growth[-1, 1:] / (growth[-1, 0] - growth[0, 0]) if known else np.full(len(columns), nan)
    return {
        "exponents": exponents,
        "undefined_time": float(undefined_time) if count else nan,
        "growth": growth,
        "rank_losses": int(entries["losses"]),
        "tangent_pieces": int(entries["pieces"]),
        "volume_residual": float(entries["residual"]) if entries["complete"] and not count else nan,
        **_tangencies(scene, kit, entries["near"], growth[0, 0] if known else inf, margin, margin_time),
    }


def _tangencies(
    scene: Scene[N],
    kit: Kit[N],
    near: tuple[int, float, float, float],
    begin: float,
    margin: float,
    margin_time: float,
) -> dict[str, Any]:
    """Crossings and the closest turn. A turn as far from contact as the deepest crossing at the natural rate
    counts 1, as that crossing does.
    """
    count, closest, time, fastest = near
    if begin <= margin_time and margin < inf and fastest > 0:
        share = 2 * margin * float(natural_rate(scene, kit)) / fastest
        count += share < CLOSE
        closest, time = min((closest, time), (share, margin_time))
    return {
        "tangencies": int(count),
        "closest_tangency": float(closest),
        "closest_tangency_time": float(time) if closest < 1 else nan,
    }
