"""Ledgers, meters, extremes and sections as flat numbers, in the order in which meters.c reads them."""

from vibsim.engine.packing import Packer


def pack_ledger(scene, names, jumps, ends):
    """Number of entries, and the stops whose stored energy jumps. ends: columns of the ends of a part."""
    pack = Packer()
    pack.put((len(names), len(jumps)))
    for jump in jumps:
        stop = scene.stops[jump.stop]
        pack.put((jump.stop, jump.entry, *ends(stop), stop.sense), (stop.gap, stop.k))
    return pack.ints.tobytes(), pack.doubles.tobytes()


def pack_extremes(pairs, gaps, since):
    """The pairs of columns whose extremes are kept, the stops whose gaps are, and the time they begin at."""
    pack = Packer()
    pack.put((len(pairs), len(gaps), *(column for pair in pairs for column in pair)))
    for stop, pair, sense, gap in gaps:
        pack.put((stop, pair, sense), (gap,))
    pack.put((), (since,))
    return pack.ints.tobytes(), pack.doubles.tobytes()


def pack_meters(meters, terms):
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
    return pack.ints.tobytes(), pack.doubles.tobytes()


def terms_of(rows):
    """Number of terms of the event functions of a mode."""
    slopes = [terms for event in rows.events for _, _, terms, _ in event.slope]
    return sum(len(event.terms) for event in rows.events) + sum(map(len, slopes))
