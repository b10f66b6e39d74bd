"""Ledgers, meters, extremes and sections as flat numbers, in the order in which meters.c reads them."""

from collections.abc import Callable, Sequence

from vibsim.engine.ledgers.meters import Entry, Jump, Meters
from vibsim.engine.modes.packing import Packer
from vibsim.engine.modes.rows import Joined, ModeRows
from vibsim.engine.modes.ties import Edge
from vibsim.physics.parts import Scene


def pack_ledger(
    scene: Scene, names: Sequence[Entry], jumps: Sequence[Jump], ends: Callable[[Joined], Edge]
) -> tuple[bytes, bytes]:
    """Number of entries, and the stops whose stored energy jumps. ends: columns of the ends of a part."""
    pack = Packer()
    pack.put((len(names), len(jumps)))
    elastic = dict(scene.elastic_stops)
    for jump in jumps:
        stop = elastic[jump.stop]
        pack.put((jump.stop, jump.entry, *ends(stop), stop.sense), (stop.gap, stop.k))
    return pack.packed


def pack_blows(
    scene: Scene, names: Sequence[Entry], ends: Callable[[Joined], Edge], early: bool
) -> tuple[bytes, bytes]:
    """The rigid stops, with the entries `names` of the ledgers that a blow on them adds to, the frictions
    that it may turn, and the elastic stops and clearances that it may close or open. early: as of
    `Chatter`
    """
    pack = Packer()
    entry = {name: number for number, name in enumerate(names)}
    bounds = [(*ends(stop), stop.sense, stop.gap) for _, stop in scene.elastic_stops]
    bounds += [(*ends(one), -1, one.distance) for one in scene.clearances]
    pack.put((len(scene.rigid_stops), len(scene.frictions), len(bounds), int(early)))
    for j, stop in scene.rigid_stops:
        ground = len(scene.bodies)
        place = {ground: "ground", ground + 1: "base"}.get(max(ends(stop)), "")
        work = entry.get(("work", "base", ""), -1) if place == "base" else -1
        entries = entry.get(("loss", "stops", stop.name), -1), work, entry.get(("impulse", place, ""), -1)
        pack.put((j, *ends(stop), stop.sense, *entries), (stop.gap, stop.e))
    for friction in scene.frictions:
        pack.put(ends(friction), (friction.belt,))
    for P, Q, sense, gap in bounds:
        pack.put((P, Q, sense), (gap,))
    return pack.packed


def pack_extremes(
    pairs: Sequence[Edge], gaps: Sequence[tuple[int, int, int, float]], since: float
) -> tuple[bytes, bytes]:
    """The pairs of columns whose extremes are kept, the stops whose gaps are, and the time they begin at."""
    pack = Packer()
    pack.put((len(pairs), len(gaps), *(column for pair in pairs for column in pair)))
    for stop, pair, sense, gap in gaps:
        pack.put((stop, pair, sense), (gap,))
    pack.put((), (since,))
    return pack.packed


def pack_meters(meters: Meters, terms: int) -> tuple[bytes, bytes]:
    """The meters of a mode, whose event functions have so many `terms`."""
    pack, columns = Packer(), meters.columns
    pack.put((len(meters.meters), len(meters.functions), len(columns)))
    pack.put((terms, sum(len(function.terms) for function in meters.functions)))
    pack.put((meters.forces, meters.spins))
    pack.put(columns)
    for m in meters.meters:
        pack.put((m.kind, m.entry, m.P, m.Q, m.source), (m.factor, m.drift))
    for function in meters.functions:
        pack.put((len(function.terms),), (function.constant,))
        for term in function.terms:
            pack.put((term.kind, term.P), (term.coefficient,))
    return pack.packed


def terms_of(rows: ModeRows) -> int:
    """Number of terms of the event functions of a mode."""
    slopes = sum(len(one.terms) for event in rows.events for one in event.slope)
    return sum(len(event.terms) for event in rows.events) + slopes
