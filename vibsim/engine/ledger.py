"""The ledgers of energy and momentum: what goes into a scene, what is lost, what is stored; totals.

    energy    stored: kinetic energy of bodies and rotor, springs of links, stops in contact
              in: work of forces, motor, base and belts; out: losses in links, stops and frictions
    momentum  of bodies and unbalanced mass; changed by impulses of forces, ground, base and belts alone

The integrals are taken stretch by stretch by Gauss-Legendre quadrature of the flow itself, to round-off, so
that stored - stored(0) - work + losses is zero but for rounding: a check on every run (first law).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from math import inf, nan
from typing import Any

from vibsim.engine.errors import State
from vibsim.engine.events.impacts.simultaneous import SimultaneousImpacts
from vibsim.engine.events.relative_motion import RelativeMotion
from vibsim.engine.ledger_integrals import Entry
from vibsim.engine.modes.status import CONTACT, Status
from vibsim.physics.numbers import Kit, N, abs, total_of
from vibsim.physics.parts import BODY, EVENT_KINDS, STATE, Scene


def struck_entries(
    scene: Scene[N], names: Sequence[Entry], touch: SimultaneousImpacts[N], V: N
) -> list[tuple[int, N]]:
    """Shares of rigid stops in the entries `names`, as [(number of the entry, value)]: loss at the stops,
    work and impulses of ground and base.

    V: velocity of the base [m/s]. An impact takes L (g' before + g' after) / 2; the base gives V times its
    impulse. What sequences leave out at their ends goes where their impacts went.
    """
    added: list[tuple[int, N]] = []

    def add(name: Entry, value: N) -> None:
        if name in names:
            added.append((names.index(name), value))

    def hold(column: int, impulse: N) -> None:
        """Count the impulse [N s] of ground or base, whose column it is, on the bodies."""
        place = "base" if column > len(scene.bodies) else "ground"
        if place == "base":
            add(("work", "base", ""), V * impulse)
        add(("impulse", place, ""), impulse)

    for one in touch.passed:
        stop = scene.stops[one.stop]
        add(("loss", "stops", stop.name), one.impulse * (one.before + one.after) / 2)
        for end, other, sign in ((stop.P, stop.Q, stop.sense), (stop.Q, stop.P, -stop.sense)):
            if end >= 0 > other:
                hold(scene.column(other), sign * one.impulse)
    for catch in touch.catches:
        add(("loss", "stops", scene.stops[catch.stop].name), catch.loss)
        hold(catch.column, catch.impulse)
    return added


def stored_energy(scene: Scene[N], kit: Kit[N], state: State[N], status: Status) -> N:
    """Kinetic and elastic energy [J] of `state` in the mode `status`; the unbalanced mass moves with velocity
    (v - e w sin phi, e w cos phi), from which Eqs. (2.9), (2.10) follow.
    """
    relative, energy = RelativeMotion(scene, kit), kit.number(0)
    for body, v in zip(scene.bodies, state.v, strict=True):
        if body.kind != STATE:
            energy = energy + body.m * (v * v) / 2
    for one in scene.rotors:
        turning = one.unbalance * kit.sin(state.x[one.column])
        energy = energy - turning * state.v[one.column] * state.v[one.on]
    for link in scene.links:
        xP, xQ = relative.ends(link, state, "x")
        energy = energy + link.k * ((xP - xQ) * (xP - xQ)) / 2
    for i, stop in scene.elastic_stops:
        if status.stops[i] == CONTACT:
            depth = relative.depth(stop, state)
            energy = energy + stop.k * (depth * depth) / 2
    return energy + rotor_energy(scene, kit, state) if scene.motor else energy


def rotor_energy(scene: Scene[N], kit: Kit[N], state: State[N]) -> N:
    """Kinetic energy [J] of rotor and unbalanced mass."""
    motor = scene.motor
    assert motor is not None
    v = state.v[motor.on]
    energy = motor.m3 * (v * v) / 2 + motor.inertia * (state.w * state.w) / 2
    return energy - motor.m3 * (v * (motor.e * state.w * kit.sin(state.phase)))


def momenta(scene: Scene[N], kit: Kit[N], state: State[N]) -> list[N]:
    """Momenta [N s] of bodies and unbalanced mass along the line."""
    each = [body.m * v for body, v in zip(scene.bodies, state.v, strict=True) if body.kind == BODY]
    for one in scene.rotors:
        each.append(-(one.unbalance * kit.sin(state.x[one.column]) * state.v[one.column]))
    if scene.motor:
        motor = scene.motor
        each += [motor.m3 * state.v[motor.on], -(motor.m3 * (motor.e * state.w * kit.sin(state.phase)))]
    return each


# The totals of a run: counts of events, work done and margins, by name.


ENERGY = {  # totals of the energy ledger, by quantity and section of the case
    ("work", "forces"): "work_source",
    ("work", "motor"): "work_source",
    ("work", "rotors"): "work_source",
    ("work", "base"): "work_base",
    ("work", "friction"): "work_belt",
    ("loss", "links"): "loss_viscous",
    ("loss", "stops"): "loss_stops",
    ("loss", "friction"): "loss_friction",
}
MOMENTUM = {
    ("impulse", "forces"): "impulse_source",
    ("impulse", "ground"): "impulse_ground",
    ("impulse", "base"): "impulse_base",
    ("impulse", "friction"): "impulse_belt",
}


def totals_of(tally: Mapping[str, Any], certificate: Sequence[float]) -> dict[str, Any]:
    """Counts and margins by name, from the tally of a run in C.

    certificate: (doubts, time of the first [s], grazing margin [m], inf where there is none, its time [s])
    """
    counts = tally["counts"]
    by_kind = dict(zip(EVENT_KINDS, counts, strict=True))
    uncertified, first_doubt, margin, margin_time = certificate
    return {
        "impacts": by_kind["contact_begin"] + by_kind["impact"],
        "sticks": by_kind["stick_begin"],
        "reversals": by_kind["reversal"],
        "events": sum(counts) - by_kind["start"] - by_kind["end"],
        "steps": int(tally["steps"]),
        "evaluations": int(tally["evaluations"]),
        "uncertified": int(uncertified),
        "first_uncertified_time": first_doubt if uncertified else nan,
        "grazing_margin": margin if margin != inf else nan,
        "grazing_time": margin_time if margin != inf else nan,
        "violations": by_kind["violation_begin"],
        "first_violation_time": float(tally["first_violation"]) if tally["violated_once"] else nan,
    }


def rigid_totals(counts: Sequence[int], cut_off: Sequence[float]) -> dict[str, float]:
    """Counts of what only rigid stops do, by name.

    counts: as of `totals_of`; cut_off: time [s], speed [m/s] and distance [m] that the ends of infinite
    sequences of impacts left out, each summed over the run
    """
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
    start, end = (stored_energy(scene, kit, *where) for where in (first, last))
    totals = _balance(kit, "energy", ledger, ENERGY, start, end, (start, end))
    if any(quantity == "impulse" for quantity, *_ in names):
        moving = [momenta(scene, kit, state) for state, _ in (first, last)]  # which may cancel
        start, end = (total_of(kit, each) for each in moving)
        totals |= _balance(kit, "momentum", ledger, MOMENTUM, start, end, [*moving[0], *moving[1]])
    return totals | {".".join(filter(None, name)): value for name, value in ledger.items()}


def _balance(
    kit: Kit[N],
    what: str,
    ledger: Mapping[Entry, N],
    into: Mapping[tuple[str, str], str],
    start: N,
    end: N,
    sizes: Sequence[N],
) -> dict[str, N]:
    """Sums of a ledger, with its closure: end - start - work or impulses + losses, also by the largest of the
    sums and of `sizes`.
    """
    sums = dict.fromkeys(into.values(), kit.number(0))
    for (quantity, section, _), value in ledger.items():
        name = into.get((quantity, section))
        if name is not None:
            sums[name] = sums[name] + value
    residual = end - start
    for name, value in sums.items():
        residual = residual + value if name.startswith("loss") else residual - value
    return {
        f"{what}_start": start,
        f"{what}_end": end,
        **sums,
        f"{what}_residual": residual,
        f"{what}_residual_relative": relative(residual, (*sizes, *sums.values())),
    }


def relative(residual: N, entries: Iterable[N]) -> N:
    """`residual` by the largest of the entries; 0 where all of these are."""
    largest = max(abs(value) for value in entries)
    return abs(residual) / largest if largest > 0 else 0 * residual
