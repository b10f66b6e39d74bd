"""The mode automaton: {free, contact} x {slip +, slip -, stick}, the Filippov solution of the paper's
equations.

    free <-> contact   at g = 0, by the sign of the first derivative of g that is not zero
    slip -> stick      at v2 = 0 while |S| <= N; else into slip with sigma = sgn(S)
    stick -> slip      when |S| = N and grows, with sigma = sgn(S)
Every decision at a zero looks at derivatives, never at the sign of a rounded zero. Two events at one instant
are taken one after the other. Each transition tells which event functions are zero at its instant, and to
which order. A decision that rounding could turn is in doubt, and the certificate counts it.
"""

from vibsim.events.watch import CLEARANCE, GAP, HOLD_MINUS, HOLD_PLUS, SLIDE
from vibsim.physics.forces import gap_function, gap_rate, transmitted_force, transmitted_force_size
from vibsim.physics.modes import EVENT_KINDS
from vibsim.physics.state import Mode

JET = 7  # order of the highest derivative consulted where lower ones vanish
START_ROUNDING = 16  # at least: each of three numbers and of two differences is rounded once


def initial_mode(scene, flow, state):
    """Mode that the motion starts in from `state`, and the known zeros there."""
    y, u = state.x1 - state.x2, state.v1 - state.v2
    gap = gap_function(scene, y) if scene.has_stop else -1
    at_stop = scene.has_stop and _starts_at(flow.kit, gap, state, scene.G, scene.at_stop)
    contact = 1 if gap > 0 and not at_stop else 0
    if scene.has_stop and not at_stop and _blurred(gap, state.x1, state.x2, scene.stop_sign * scene.G):
        flow.certificate.doubt(state.t)
    friction, known = 1, {}
    if scene.has_friction:
        friction = sign(state.v2) or _friction_at_rest(scene, flow, state, Mode(contact, 0))
        if state.v2 == 0 and friction != 0:
            known[SLIDE] = 1
    if at_stop:
        rate = gap_rate(scene, u)
        contact = 1 if _turning(scene, flow, state, Mode(0, friction), rate, -scene.stop_sign) > 0 else 0
        known[GAP] = 1
    violated = 0
    if scene.rest_distance is not None:
        violated, over = 1 if y > scene.rest_distance else 0, y - scene.rest_distance
        at_rest = _starts_at(flow.kit, over, state, scene.rest_distance, scene.at_rest_distance)
        if not at_rest and _blurred(over, state.x1, state.x2, -scene.rest_distance):
            flow.certificate.doubt(state.t)
        if at_rest:
            violated = 1 if _turning(scene, flow, state, Mode(contact, friction), u, 1) > 0 else 0
            known[CLEARANCE] = 1
    return Mode(contact, friction, violated), known


def transition(scene, flow, state, mode, function):
    """What the zero of `function` at `state` in `mode` leads to.

    Returns the mode behind it, the event kind (None for a touch that changes nothing) and {event function:
    order of its zero}. Sets state.v2 to zero where block 2 sticks. At a reversal it keeps the residue a2 dt
    of the time grid: the friction force turns dt too late, an impulse of 2 N dt, where cutting the residue
    would take m2 a2 dt from the momentum.
    """
    if function == GAP:
        return _contact_switch(scene, flow, state, mode)
    if function == SLIDE:
        return _sliding_ends(scene, flow, state, mode)
    if function == CLEARANCE:
        return _clearance_switch(scene, flow, state, mode)
    return _stick_ends(scene, flow, state, mode, 1 if function == HOLD_PLUS else -1)


def _contact_switch(scene, flow, state, mode):
    rate = gap_rate(scene, state.v1 - state.v2)
    turning = _turning(scene, flow, state, mode, rate, -scene.stop_sign)
    contact = mode.contact if turning == 0 else 1 if turning > 0 else 0
    kind = None
    if contact != mode.contact:
        kind = EVENT_KINDS["contact_begin" if contact else "contact_end"]
    return Mode(contact, mode.friction, mode.violated), kind, {GAP: 1}


def _clearance_switch(scene, flow, state, mode):
    turning = _turning(scene, flow, state, mode, state.v1 - state.v2, 1)
    violated = mode.violated if turning == 0 else 1 if turning > 0 else 0
    kind = None
    if violated != mode.violated:
        kind = EVENT_KINDS["violation_begin" if violated else "violation_end"]
    return Mode(mode.contact, mode.friction, violated), kind, {CLEARANCE: 1}


def _sliding_ends(scene, flow, state, mode):
    friction = _friction_at_rest(scene, flow, state, Mode(mode.contact, 0, mode.violated))
    known = {SLIDE: 1} if friction != 0 else {}
    kind = None
    if friction == 0:
        state.v2 = state.v2 * 0
        kind = EVENT_KINDS["stick_begin"]
    elif friction != mode.friction:
        kind = EVENT_KINDS["reversal"]
    return Mode(mode.contact, friction, mode.violated), kind, known


def _stick_ends(scene, flow, state, mode, direction):
    if _force_growth(scene, flow, state, mode, direction) > 0:
        released = Mode(mode.contact, direction, mode.violated)
        return released, EVENT_KINDS["stick_end"], {SLIDE: 2}
    return mode, None, {HOLD_PLUS if direction > 0 else HOLD_MINUS: 1}


def _friction_at_rest(scene, flow, state, stuck):
    """Friction mode of block 2 at v2 = 0: 0 where the friction holds the force S, else the sign of S."""
    y, u = state.x1 - state.x2, state.v1 - state.v2
    force = transmitted_force(scene, y, u, stuck.contact)
    if abs(abs(force) - scene.N) < 4 * flow.kit.eps * transmitted_force_size(scene, y, u, stuck.contact):
        flow.certificate.doubt(state.t)
    if abs(force) < scene.N:
        return 0
    direction = sign(force)
    if abs(force) > scene.N or _force_growth(scene, flow, state, stuck, direction) > 0:
        return direction
    return 0


def _starts_at(kit, value, state, distance, told):
    """Whether a start lies exactly where `value` = x1 - x2 + ... is zero: as computed, or as `told` from
    exact numbers, whose rounding it may be then.
    """
    size = abs(state.x1) + abs(state.x2) + abs(distance)
    return value == 0 or (told and abs(value) <= START_ROUNDING * kit.eps * size)


def _blurred(value, x1, x2, distance):
    """Whether the rounding of x1 - x2 and of its sum with `distance` could turn the sign of `value`."""
    y = x1 - x2
    lost = abs(_difference_error(x1, x2, y)) + abs(_difference_error(y, -distance, y + distance))
    return lost > 0 and abs(value) <= lost


def _difference_error(a, b, difference):
    """What rounding took from a - b (Knuth's two-sum)."""
    back = a - difference
    return (a - (difference + back)) + (back - b)


def _turning(scene, flow, state, mode, rate, factor):
    """Sign of the first non-zero derivative of factor (x1 - x2) at `state`; `rate` is the first."""
    if rate != 0:
        return sign(rate)
    jet = flow.relative_jet(state, mode, JET)
    return first_sign([factor * value for value in jet[2:]])


def _force_growth(scene, flow, state, mode, direction):
    """Sign of the first non-zero derivative of direction * S at `state` in `mode`."""
    jet = flow.relative_jet(state, mode, JET + 1)
    k = scene.k1 + scene.k2 if mode.contact else scene.k1
    return first_sign([direction * (k * jet[n] + scene.c * jet[n + 1]) for n in range(1, JET)])


def sign(value):
    """-1, 0 or +1."""
    return 1 if value > 0 else -1 if value < 0 else 0


def first_sign(values):
    """Sign of the first value that is not zero; 0 where all are."""
    for value in values:
        if value != 0:
            return sign(value)
    return 0
