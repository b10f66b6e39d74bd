"""Event functions: what is watched in each mode. Each is positive inside its mode and ends the mode at zero.

    GAP         -g while free, g while in contact
    SLIDE       sigma v2 while block 2 slides
    HOLD_PLUS   N - S while it sticks (release into slip +)
    HOLD_MINUS  N + S while it sticks (release into slip -)
    CLEARANCE   rest distance - (x1 - x2), reversed while it is violated; only where a rest distance is given
What a scene has not got is not watched.
"""

NOTHING, GAP, SLIDE, HOLD_PLUS, HOLD_MINUS, CLEARANCE = -1, 0, 1, 2, 3, 4


def watched(scene, mode):
    """The event functions of `mode`, in the order in which simultaneous zeros are taken."""
    functions = [GAP] if scene.has_stop else []
    if scene.has_friction:
        functions += [SLIDE] if mode.friction != 0 else [HOLD_PLUS, HOLD_MINUS]
    if scene.rest_distance is not None:
        functions += [CLEARANCE]
    return tuple(functions)
