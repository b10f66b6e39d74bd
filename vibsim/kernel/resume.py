"""Going on from a stored event row: the state, mode and known zeros that the engine had there."""

from math import isfinite

from vibsim.events.watch import CLEARANCE, GAP, SLIDE
from vibsim.physics.modes import EVENT_NAMES
from vibsim.physics.numbers import TWO_PI
from vibsim.physics.state import Mode, State

ZEROS = {
    "contact_begin": {GAP: 1},
    "contact_end": {GAP: 1},
    "reversal": {SLIDE: 1},
    "stick_end": {SLIDE: 2},
    "violation_begin": {CLEARANCE: 1},
    "violation_end": {CLEARANCE: 1},
}


def resume_point(scene, row):
    """State, mode and known zeros of an event row.

    row: values by column name (t, kind, states, phase, modes); columns that the scene has not got may be
    missing. The turns of the rotor are the whole ones between phi and phase. Raises ValueError for a row that
    no run of the scene has.
    """
    _check(scene, row)
    phase = float(row.get("phase", 0.0))
    turns = float(round((float(row.get("phi", 0.0)) - phase) / TWO_PI))
    t, x1, v1, x2, v2, w = (float(row.get(name, 0.0)) for name in ("t", "x1", "v1", "x2", "v2", "phidot"))
    state = State(t, x1, v1, x2, v2, phase, turns, w)
    kind = EVENT_NAMES[int(row["kind"])]
    mode = Mode(int(row.get("contact", 0)), int(row.get("friction", 1)), _violated(scene, state, kind))
    return state, mode, ZEROS.get(kind, {})


def _check(scene, row):
    allowed = {
        "kind": range(len(EVENT_NAMES)),
        "contact": (0, 1) if scene.has_stop else (0,),
        "friction": (-1, 0, 1),
    }
    for name, codes in allowed.items():
        if row.get(name, codes[0]) not in codes:
            listed = ", ".join(map(str, codes))
            raise ValueError(f"event row: {name} must be one of {listed}, got {row[name]}")
    for name in ("t", "x1", "v1", "x2", "v2", "phi", "phidot", "phase"):
        if not isfinite(row.get(name, 0.0)):
            raise ValueError(f"event row: {name} must be finite, got {row[name]}")
    if not 0 <= row["t"] <= scene.t_end:
        raise ValueError(f"event row: t must be 0 to {scene.t_end:g} s, got {row['t']:g} s")


def _violated(scene, state, kind):
    """1 where the blocks are closer than the rest distance allows; at its crossing the event tells, not a
    rounded zero.
    """
    if scene.rest_distance is None or kind == "violation_end":
        return 0
    return 1 if kind == "violation_begin" or state.x1 - state.x2 > scene.rest_distance else 0
