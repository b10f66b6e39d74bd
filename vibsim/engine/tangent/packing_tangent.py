"""Small disturbances as flat numbers, in the order in which reading_tangent.c reads them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from itertools import accumulate, chain
from typing import Any, NamedTuple

from vibsim.engine.flows.tape import Tape, TapeMaker
from vibsim.engine.modes.packing import Packed, Packer, pack_tape
from vibsim.engine.modes.rows import Joined, ModeRows
from vibsim.engine.modes.ties import Edge
from vibsim.engine.number_forms import DOUBLES, NumberForm
from vibsim.engine.tangent.tangent_space import components, natural_rate, references, weights
from vibsim.physics import elementary
from vibsim.physics.formulas import Node, derivative, resolved, walk
from vibsim.physics.numbers import Kit, N
from vibsim.physics.parts import RigidStop, Scene

Ends = Callable[[Joined], Edge]  # columns of the ends of a part


def pack_bundle(scene: Scene, count: int, begin: float, ends: Ends) -> Packed:
    """A bundle of `count` disturbances whose growth counts from `begin` [s]. ends: columns of the ends of a
    part.
    """
    return bundle_form(scene, False, count, ends), bundle_numbers(scene, begin, DOUBLES)


def pack_slopes(rows: ModeRows[Any], form: NumberForm[Any] = DOUBLES) -> Packed:
    """The partial derivatives of the formulas of a mode."""
    return slope_packer(form.kit, rows, form).packed


def slope_packer(kit: Any, rows: ModeRows[Any], form: NumberForm[Any] = DOUBLES) -> Packer:
    """The same as numbers of a kit."""
    assert rows.tape is not None
    slopes, pack = slopes_of(kit, rows), Packer(form)
    pack.put((len(slopes.tape.ops),))
    pack_tape(pack, slopes.tape)
    of = [slopes.of.get(k, []) for k in range(len(rows.tape.outputs))]
    pack.put((sum(map(len, of)), *accumulate(map(len, of), initial=0)))
    for one in chain.from_iterable(of):
        pack.put((READ.index(one.kind), one.column, one.output))
    for kind in ("x", "v"):
        _pack_rows(pack, shares_of(rows, kind, slopes))
    return pack


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


def bundle_form(scene: Scene, carried: bool, count: int, ends: Ends) -> bytes:
    """Which components there are, and what the parts join; carried: whether disturbances stay as they are."""
    pack, present = Packer(), components(scene)
    measured_from = {c: r for c, r in enumerate(references(scene)) if r is not None}
    shifts = [(c, r) for c, r in measured_from.items() if r != c]  # that no force feels, to be taken out
    left_out = sorted(set(measured_from.values()))
    pack.put((carried, count, len(scene.stops), len(scene.frictions)))
    pack.put((len(present), len(shifts), len(left_out)))
    pack.put((*present, *(c for c, _ in shifts), *(r for _, r in shifts), *left_out))
    for part in (*scene.stops, *scene.frictions):
        pack.put(ends(part))
    return pack.packed[0]


def bundle_numbers(scene: Scene[Any], begin: float, form: NumberForm[Any]) -> bytes:
    """Dampers of the stops, forces with which slip begins, and what disturbances are measured by; those that
    are carried as they are follow.
    """
    pack = Packer(form)
    pack.put((), (0.0 if isinstance(stop, RigidStop) else stop.c for stop in scene.stops))
    for friction in scene.frictions:
        pack.put((), (friction.forward, friction.backward))
    farthest = reach(form.kit, form.kit.order(scene), form.kit.tolerance_exponent(scene))
    rate = natural_rate(scene, form.kit)
    pack.put((), (begin, farthest, rate, *weights(scene, form.kit, rate)))
    return pack.packed[1]


# Partial derivatives of the formulas of a mode: formulas themselves, made once for a mode, whose series along
# the motion come from a tape of their own.


READ = ("x", "v", "phi", "w")


class Slope(NamedTuple):
    """A partial derivative of output `of` of the tape of a mode: with respect to x or v of a column, or phi
    or w of the motor; `output` is its number on the tape of derivatives.
    """

    of: int
    kind: str
    column: int
    output: int


class Slopes(NamedTuple):
    """The partial derivatives of all outputs of a mode, by number of the output."""

    tape: Tape
    of: dict[int, list[Slope]]


def slopes_of(kit: Kit[N], rows: ModeRows[N]) -> Slopes:
    """The derivatives of the formulas of a mode, made when they are first asked for."""
    if rows.slopes is None:
        n = len(rows.leader) - 2
        maker, places = TapeMaker(kit, rows.columns), list[int]()
        found: dict[int, list[Slope]] = {}
        for k, node in rows.nodes.items():
            node, factor = resolved(node, rows.sides), rows.factors.get(k, kit.number(1))
            found[k] = []
            for of in _inputs(node, n):
                if (slope := derivative(node, of))[:2] != ("num", 0):
                    found[k].append(Slope(k, of[0], of[1] if len(of) > 1 else -1, len(places)))
                    places.append(maker.scaled(factor, maker.place(slope, {})))
        rows.slopes = Slopes(maker.tape(places), found)
    slopes: Slopes = rows.slopes
    return slopes


def _inputs(node: Node, bodies: int) -> list[Node]:
    """Parts of the state that a formula reads; ground and base are not disturbed."""
    return [one for one in walk([node]) if one[0] in READ and (len(one) < 2 or 0 <= one[1] < bodies)]


class SlopeShare(NamedTuple):
    """Share of derivative number `output` of force number `force` in the derivative of the acceleration of
    the column `row` with respect to x or v of `column`, both by their leaders; end: 0 for what acts on P, 1
    on Q.
    """

    row: int
    column: int
    force: int
    end: int
    output: int


def shares_of(rows: ModeRows[N], kind: str, slopes: Slopes) -> list[SlopeShare]:
    """All shares of derivatives with respect to x or v, by `kind`."""
    leader = rows.leader
    return [
        SlopeShare(leader[end], leader[one.column], force, place, one.output)
        for force, law in enumerate(rows.formulas)
        for one in slopes.of.get(law.output, ())
        if one.kind == kind
        for place, end in enumerate((law.P, law.Q))
        if end >= 0 and rows.mobility[leader[end]] > 0
    ]


def reach(kit: Kit[N], order: int, tolerance_exponent: float) -> N:
    """Longest step of exp(-t), by the tolerance on its last term."""
    return kit.power_of_two((tolerance_exponent + _spread(order) * elementary.PER_LN_2) / order)


@cache
def _spread(order: int) -> float:
    """ln order!, summed in its order."""
    spread = 0.0
    for n in range(2, order + 1):
        spread = spread + elementary.log(n)
    return spread
