"""The totals of a run: counts of events, work done and margins, one dict for both engines."""

from collections.abc import Iterable, Mapping, Sequence
from math import inf, nan
from typing import Any

from vibsim.engine.errors import State
from vibsim.engine.ledger import momenta, stored_energy
from vibsim.engine.ledger_integrals import Entry
from vibsim.engine.modes.status import Status
from vibsim.physics.numbers import Kit, N, abs, total_of
from vibsim.physics.parts import EVENT_KINDS, Scene

INTO = {  # totals of the energy ledger, by quantity and section of the case
    ("work", "forces"): "work_source",
    ("work", "motor"): "work_source",
    ("work", "rotors"): "work_source",
    ("work", "base"): "work_base",
    ("work", "friction"): "work_belt",
    ("loss", "links"): "loss_viscous",
    ("loss", "stops"): "loss_stops",
    ("loss", "friction"): "loss_friction",
}
IMPULSES = {
    "forces": "impulse_source",
    "ground": "impulse_ground",
    "base": "impulse_base",
    "friction": "impulse_belt",
}


def totals_of(
    counts: Sequence[int],
    certificate: tuple[int, float, float, float],
    work: tuple[int, int],
    first_violation: float,
) -> dict[str, Any]:
    """Counts and margins by name.

    counts: by kind of event, in the order of their codes; certificate: (doubts, time of the first [s],
    grazing margin [m], inf where there is none, its time [s]); work: (steps, evaluations); first_violation:
    time [s] or NaN.
    """
    by_kind = dict(zip(EVENT_KINDS, counts, strict=True))
    uncertified, first_doubt, margin, margin_time = certificate
    return {
        "impacts": by_kind["contact_begin"] + by_kind["impact"],
        "sticks": by_kind["stick_begin"],
        "reversals": by_kind["reversal"],
        "events": sum(counts) - by_kind["start"] - by_kind["end"],
        "steps": int(work[0]),
        "evaluations": int(work[1]),
        "uncertified": int(uncertified),
        "first_uncertified_time": first_doubt if uncertified else nan,
        "grazing_margin": margin if margin != inf else nan,
        "grazing_time": margin_time if margin != inf else nan,
        "violations": by_kind["violation_begin"],
        "first_violation_time": first_violation,
    }


def rigid_totals(scene: Scene[N], counts: Sequence[int], cut_off: Sequence[float]) -> dict[str, float]:
    """Counts of what only rigid stops do, by name, of scenes that have some.

    counts: as of `totals_of`; cut_off: time [s], speed [m/s] and distance [m] that the ends of infinite
    sequences of impacts left out, each summed over the run
    """
    if not scene.rigid_stops:
        return {}
    by_kind = dict(zip(EVENT_KINDS, counts, strict=True))
    return {
        "transmitted": by_kind["transmitted"],
        "chatters": by_kind["chatter"],
        "rests": by_kind["rest_begin"],
        **dict(zip(("chatter_time", "chatter_speed", "chatter_distance"), cut_off, strict=True)),
    }


def ledger_totals(
    scene: Scene[N],
    kit: Kit[N],
    names: Sequence[Entry],
    entries: Sequence[N],
    first: tuple[State[N], Status],
    last: tuple[State[N], Status],
) -> dict[str, N]:
    """The ledgers by name: energies [J] and impulses [N s], their sums and their closure.

    names, entries: as of a `Ledger`; first, last: (state, status) at the start and now. The entries of the
    parts are called by quantity, section and name, as loss.links.spring.
    """
    ledger = dict(zip(names, entries, strict=True))
    stored = [stored_energy(scene, kit, *where) for where in (first, last)]
    totals = energy_balance(kit, ledger, *stored)
    if any(quantity == "impulse" for quantity, *_ in names):
        moving = [momenta(scene, kit, state) for state, _ in (first, last)]
        totals |= momentum_balance(kit, ledger, *moving)
    return totals | {".".join(filter(None, name)): value for name, value in ledger.items()}


def energy_balance(kit: Kit[N], ledger: Mapping[Entry, N], start: N, end: N) -> dict[str, N]:
    """Sums of the energy ledger, with its closure: end - start - work + losses."""
    sums = dict.fromkeys(INTO.values(), kit.number(0))
    for (quantity, section, _), value in ledger.items():
        if quantity != "impulse":
            sums[INTO[quantity, section]] = sums[INTO[quantity, section]] + value
    residual = end - start
    for name, value in sums.items():
        residual = residual - value if name.startswith("work") else residual + value
    return {
        "energy_start": start,
        "energy_end": end,
        **sums,
        "energy_residual": residual,
        "energy_residual_relative": relative(residual, (start, end, *sums.values())),
    }


def momentum_balance(
    kit: Kit[N], ledger: Mapping[Entry, N], start: Sequence[N], end: Sequence[N]
) -> dict[str, N]:
    """Sums of the momentum ledger, with its closure: end - start - impulses; start, end: momenta of what
    moves, which may cancel.
    """
    sizes = [*start, *end]
    first, last = total_of(kit, start), total_of(kit, end)
    sums = dict.fromkeys(IMPULSES.values(), kit.number(0))
    for (quantity, section, _), value in ledger.items():
        if quantity == "impulse":
            sums[IMPULSES[section]] = sums[IMPULSES[section]] + value
    residual = last - first
    for value in sums.values():
        residual = residual - value
    return {
        "momentum_start": first,
        "momentum_end": last,
        **sums,
        "momentum_residual": residual,
        "momentum_residual_relative": relative(residual, (*sizes, *sums.values())),
    }


def relative(residual: N, entries: Iterable[N]) -> N:
    """`residual` by the largest of the entries; 0 where all of these are."""
    largest = max(abs(value) for value in entries)
    return abs(residual) / largest if largest > 0 else 0 * residual
