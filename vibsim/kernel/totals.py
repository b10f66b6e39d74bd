"""The totals of a run: counts of events, work done and margins, one dict for both engines."""

from vibsim.physics.modes import EVENT_KINDS


def totals_of(counts, work, margin, first_violation, ledger=None):
    """Totals by name from event counts in the order of their codes.

    work: (steps, evaluations, uncertified); margin: (smallest gap at a turn without contact [m], its time
    [s]), NaN where there is none; first_violation: time [s] or NaN; ledger: the entries of the energy
    ledger [J] where it was kept.
    """
    by_kind = dict(zip(EVENT_KINDS, counts, strict=True))
    totals = {
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
    return totals if ledger is None else totals | balance(*ledger)


def balance(start, end, work, viscous, friction):
    """The energy ledger by name [J], with its closure: end - start - work + losses.

    The relative residual is taken by the largest of the entries.
    """
    residual = (end - start) - work + viscous + friction
    largest = max(abs(value) for value in (start, end, work, viscous, friction))
    return {
        "energy_start": start,
        "energy_end": end,
        "work_source": work,
        "loss_viscous": viscous,
        "loss_friction": friction,
        "energy_residual": residual,
        "energy_residual_relative": abs(residual) / largest if largest > 0 else 0.0,
    }
