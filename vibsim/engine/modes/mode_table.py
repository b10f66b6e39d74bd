"""What runs of one scene share, whatever they start from: the rows of its modes, packed for C, and what
follows their events.

Restarts from events, ensembles of starts, disturbances and branches over the speed of a motor run the same
modes many times; making them anew costs a millisecond each time.
"""

import pickle
from collections import OrderedDict
from threading import Lock

from vibsim.engine.ledgers.meters import MeterMaker
from vibsim.engine.ledgers.packing_meters import pack_meters, terms_of
from vibsim.engine.modes.packing import pack_mode
from vibsim.engine.modes.rows import RowMaker
from vibsim.physics.numbers import Doubles

SCENES = 16  # whose tables are kept


class ModeTable:
    """Rows of the modes of a scene, and by status what C is told of them.

    maker : makes the rows; keys : {event key: number in C}
    """

    def __init__(self, scene):
        self.scene, self.maker, self.keys = scene, RowMaker(scene, Doubles), {}
        self._packed, self._meters, self._makers, self._rules = {}, {}, {}, {}
        self._lock = Lock()  # keys are numbered one mode after the other

    def packed(self, status, flow):
        """The rows of a mode as bytes of ints and of doubles; flow: tells whether it has a closed form."""
        with self._lock:
            if status not in self._packed:
                rows = self.maker.rows(status)
                if flow.suits(rows) is flow.taylor:
                    rows.modal = False
                self._packed[status] = pack_mode(rows, self.keys)
        return self._packed[status]

    def statuses(self, most):
        """The modes packed so far, in their order; none where there are more than `most`."""
        met = list(self._packed)
        return met if len(met) <= most else []

    def events_with_rules(self):
        """(status, number of the event) of what rules were made for."""
        return [key for key, rule in list(self._rules.items()) if rule is not None]

    def meter_maker(self, momentum):
        """What makes the meters of the ledgers; momentum: whether of both of them."""
        if momentum not in self._makers:
            self._makers[momentum] = MeterMaker(self.scene, Doubles, self.maker, momentum)
        return self._makers[momentum]

    def packed_meters(self, status, momentum):
        """The meters of a mode as bytes of ints and of doubles."""
        if (status, momentum) not in self._meters:
            rows = self.maker.rows(status)
            meters = self.meter_maker(momentum).meters(rows)
            self._meters[status, momentum] = pack_meters(meters, terms_of(rows))
        return self._meters[status, momentum]

    def rule(self, rows, number, make):
        """What follows event `number` of a mode, made by `make(rows, event)` when it is first asked for."""
        key = rows.status, number
        if key not in self._rules:
            self._rules[key] = make(rows, rows.events[number])
        return self._rules[key]


_tables: OrderedDict[bytes, ModeTable] = OrderedDict()
_lock = Lock()


def mode_table(scene):
    """The table of a scene, the same for all that differ in nothing but their starts, ends, samples and the
    numbers of a motor, which no row holds.
    """
    key = _signature(scene)
    with _lock:
        table = _tables.pop(key, None) or ModeTable(scene)
        _tables[key] = table
        if len(_tables) > SCENES:
            _tables.popitem(last=False)
    return table


def _signature(scene):
    """Bits of all numbers and names that modes are made of: -0.0 is not 0.0 here."""
    masses = [body.m for body in scene.bodies]
    driven = scene.motor.on if scene.motor else None
    parts = scene.links, scene.stops, scene.frictions, scene.forces, scene.base, scene.clearances
    return pickle.dumps((masses, parts, driven, scene.method, scene.order, scene.tol))
