"""The totals of a run: counts of events, work done and margins, one dict for both engines."""

from math import inf, nan

from vibsim.physics.modes import EVENT_KINDS


def totals_of(counts, work, certificate, first_violation, ledger=None, tangent=None):
    """Totals by name from event counts in the order of their codes.

    work: (steps, evaluations); certificate: (stretches without proof, time of the first [s], smallest gap at
    a turn without contact [m], inf where there is none, its time [s]); first_violation: time [s] or NaN;
    ledger: the entries of the energy ledger [J] where it was kept.
    """
    uncertified, first_doubt, margin, margin_time = certificate
    by_kind = dict(zip(EVENT_KINDS, counts, strict=True))
    totals = {
        "impacts": by_kind["contact_begin"],
        "sticks": by_kind["stick_begin"],
        "reversals": by_kind["reversal"],
        "events": sum(counts) - by_kind["start"] - by_kind["end"],
        "steps": work[0],
        "evaluations": work[1],
        "uncertified": int(uncertified),
        "first_uncertified_time": first_doubt if uncertified else nan,
        "grazing_margin": margin if margin != inf else nan,
        "grazing_time": margin_time if margin != inf else nan,
        "violations": by_kind["violation_begin"],
        "first_violation_time": first_violation,
    }
    return totals | ({} if ledger is None else balance(*ledger)) | (tangent or {})


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
