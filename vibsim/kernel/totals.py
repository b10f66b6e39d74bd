"""The totals of a run: counts of events, work done and margins, one dict for both engines."""

from vibsim.physics.modes import EVENT_KINDS


def totals_of(counts, work, margin, first_violation):
    """Totals by name from event counts in the order of their codes.

    work: (steps, evaluations, uncertified); margin: (smallest gap at a turn without contact [m], its time
    [s]), NaN where there is none; first_violation: time [s] or NaN.
    """
    by_kind = dict(zip(EVENT_KINDS, counts, strict=True))
    return {
        "impacts": by_kind["contact_begin"],
        "sticks": by_kind["stick_begin"],
        "reversals": by_kind["reversal"],
        "events": sum(counts) - by_kind["start"] - by_kind["end"],
        "steps": work[0],
        "evaluations": work[1],
        "uncertified": work[2],
        "grazing_margin": margin[0],
        "grazing_time": margin[1],
        "violations": by_kind["violation_begin"],
        "first_violation_time": first_violation,
    }
