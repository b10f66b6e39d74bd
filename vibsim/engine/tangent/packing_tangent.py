"""Small disturbances as flat numbers, in the order in which reading_tangent.c reads them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import accumulate, chain
from typing import Any

from vibsim.engine.modes.packing import Packed, Packer, pack_tape
from vibsim.engine.modes.rows import Joined, ModeRows
from vibsim.engine.modes.ties import Edge
from vibsim.engine.number_forms import DOUBLES, NumberForm
from vibsim.engine.tangent.formula_tangent import READ, SlopeShare, shares_of, slopes_of
from vibsim.engine.tangent.tangent_space import Gauge, components, natural_rate, weights
from vibsim.engine.tangent.tangent_taylor import reach
from vibsim.lazy import once
from vibsim.physics.parts import RigidStop, Scene

Ends = Callable[[Joined], Edge]  # columns of the ends of a part


def pack_bundle(scene: Scene, count: int, begin: float, ends: Ends) -> Packed:
    """A bundle of `count` disturbances whose growth counts from `begin` [s]. ends: columns of the ends of a
    part.
    """
    return _form(scene, False, count, ends), _numbers(scene, begin, DOUBLES)


def pack_slopes(rows: ModeRows[Any], form: NumberForm[Any] = DOUBLES) -> Packed:
    """The partial derivatives of the formulas of a mode."""
    assert rows.tape is not None
    slopes, pack = slopes_of(form.kit, rows), Packer(form)
    pack.put((len(slopes.tape.ops),))
    pack_tape(pack, slopes.tape)
    of = [slopes.of.get(k, []) for k in range(len(rows.tape.outputs))]
    pack.put((sum(map(len, of)), *accumulate(map(len, of), initial=0)))
    for one in chain.from_iterable(of):
        pack.put((READ.index(one.kind), one.column, one.output))
    for kind in ("x", "v"):
        _pack_rows(pack, shares_of(rows, kind, slopes))
    return pack.packed


def _pack_rows(pack: Packer, shares: Sequence[SlopeShare]) -> None:
    """Packs the effect of derivatives on accelerations: entries of their matrix row by row, each row and each
    entry where it is met first, then what adds to them.
    """
    columns: dict[int, dict[int, None]] = {}
    for share in shares:
        columns.setdefault(share.row, {})[share.column] = None
    places = [(row, column) for row, of in columns.items() for column in of]
    numbers = {place: number for number, place in enumerate(places)}
    pack.put((len(places), len(shares)))
    for row, column in places:
        pack.put((row, column, numbers.get((column, row), -1)))
    for share in shares:
        pack.put((numbers[share.row, share.column], share.force, share.end, share.output))


class DisturbancePacker:
    """Packs disturbances of one scene that are carried along as they are; what does not depend on them is
    packed once.
    """

    def __init__(self, scene: Scene[Any], ends: Ends, form: NumberForm[Any] = DOUBLES) -> None:
        self.scene, self.ends, self.form = scene, ends, form
        self.forms: dict[int, bytes] = {}  # by number of disturbances

    @once
    def numbers(self) -> bytes:
        return _numbers(self.scene, 0.0, self.form)

    def of(self, scene: Scene[Any]) -> DisturbancePacker:
        """That of a scene whose modes have the same form."""
        other = DisturbancePacker(scene, self.ends, self.form)
        other.forms = self.forms
        return other

    def packed(self, vectors: Any) -> Packed:
        """vectors: one disturbance per row; of doubles an array."""
        count = len(vectors)
        if count not in self.forms:
            self.forms[count] = _form(self.scene, True, count, self.ends)
        return self.forms[count], self.numbers + self.form.packed_rows(vectors)


def _form(scene: Scene, carried: bool, count: int, ends: Ends) -> bytes:
    """Which components there are, and what the parts join; carried: whether disturbances stay as they are."""
    pack, gauge, present = Packer(), Gauge(scene), components(scene)
    pack.put((carried, count, len(scene.stops), len(scene.frictions)))
    pack.put((len(present), len(gauge.shifts), len(gauge.references)))
    pack.put((*present, *(c for c, _ in gauge.shifts), *(r for _, r in gauge.shifts), *gauge.references))
    for part in (*scene.stops, *scene.frictions):
        pack.put(ends(part))
    return pack.packed[0]


def _numbers(scene: Scene[Any], begin: float, form: NumberForm[Any]) -> bytes:
    """Dampers of the stops, forces with which slip begins, and what disturbances are measured by."""
    pack = Packer(form)
    pack.put((), (0.0 if isinstance(stop, RigidStop) else stop.c for stop in scene.stops))
    for friction in scene.frictions:
        pack.put((), (friction.forward, friction.backward))
    farthest = reach(form.kit, form.order(scene), form.tolerance_exponent(scene))
    rate = natural_rate(scene, form.kit)
    pack.put((), (begin, farthest, rate, *weights(scene, form.kit, rate)))
    return pack.packed[1]
