"""Table of the modes of one scene, shared by its runs: the rows of its modes, packed for C, and the rules of
their events.

Restarts from events, ensembles of starts, disturbances and branches over the speed of a motor run the same
modes many times; making them anew costs a millisecond each time.
"""

from __future__ import annotations

import pickle
from collections import OrderedDict
from collections.abc import Callable
from threading import Lock, RLock
from typing import TYPE_CHECKING, Any

from vibsim.engine.flows.closed.modal import harmonic_key, pitches
from vibsim.engine.flows.closed.modal_maker import may_have_closed_form, modal_of
from vibsim.engine.ledger_integrals import IntegralMaker, pack_integrals
from vibsim.engine.modes.formula_rows import FormulaRows
from vibsim.engine.modes.packing import EventNumbers, Packed, packed_mode
from vibsim.engine.modes.parametric_rows import Numbers, ParametricRows, Place, recipe_of, settings
from vibsim.engine.modes.row_maker import RowMaker
from vibsim.engine.modes.rows import Event, ModeRows, Rule
from vibsim.engine.modes.status import Kept, Status
from vibsim.engine.number_forms import DOUBLES, NumberForm
from vibsim.lazy import once
from vibsim.physics.parts import Scene

if TYPE_CHECKING:
    from vibsim.physics.formulas import Node

SCENES = 16  # whose tables are kept
MOST_BYTES, MOST_RULES, MOST_RECIPES = 1 << 23, 20_000, 1000  # in each of them; a rule has some kilobyte


def bytes_of(packed: Packed) -> int:
    """How much packed rows weigh."""
    return len(packed[0]) + len(packed[1])


class ModeTable:
    """Rows of the modes of a scene, and by status what C is told of them.

    maker : makes the rows; keys : numbers of event keys in C
    """

    def __init__(self, scene: Scene, form: NumberForm[Any] = DOUBLES) -> None:
        self.scene, self.form = scene, form
        self.keys = EventNumbers()
        self._packed = Kept[Status, Packed](MOST_BYTES)
        self._integrals = Kept[tuple[Status, bool], Packed](MOST_BYTES)
        self._slopes = Kept[Status, Packed](MOST_BYTES)
        self._makers: dict[bool, IntegralMaker] = {}
        self._rules = Kept[tuple[Status, int], Rule | None](MOST_RULES)
        self._recipes: dict[tuple[Place, ...], Kept[tuple[Status, bool], ParametricRows | None]] = {}
        self._lock = RLock()  # one thread at a time makes rows, keys, integrals and rules

    @once
    def maker(self) -> RowMaker:
        """Makes the rows, one for all threads."""
        with self._lock:
            maker: RowMaker = vars(self).setdefault("maker", RowMaker(self.scene, self.form.kit))
        return maker

    def packed(self, status: Status) -> Packed:
        """The rows of a mode as bytes of ints and of doubles, with its closed form where it moves by that."""
        packed = self._packed.get(status)
        if packed is None:
            with self._lock:
                made = self._pack(status)
                packed = self._packed.keep(status, made, bytes_of(made))
        return packed

    def _pack(self, status: Status) -> Packed:
        rows = self.maker.rows(status)
        modal = modal_of(self.scene, self.form.kit, rows, pitches(self.scene))
        return packed_mode(rows, self.keys, self.form, modal).packed

    def packed_without_closed_form(self, rows: ModeRows[Any]) -> Packed:
        """The rows of a mode that is looked at, and may never be entered; with its closed form where they are
        packed already.
        """
        packed = self._packed.get(rows.status)
        if packed is None:
            with self._lock:
                packed = packed_mode(rows, self.keys, self.form).packed
                if not may_have_closed_form(self.scene, rows):
                    packed = self._packed.keep(rows.status, packed, bytes_of(packed))
        return packed

    def retuned(self, scene: Scene, numbers: Numbers) -> ModeTable:
        """The table of a scene whose modes differ from those of this one in `numbers` alone, as
        `parametric_rows.differences` tells them.
        """
        return ParametricModeTable(self, scene, numbers) if numbers else self

    def recipes(self, places: tuple[Place, ...]) -> Kept[tuple[Status, bool], ParametricRows | None]:
        """How the packed numbers of the modes met so far follow from those of the scene in `places`; and, by
        True, those of the derivatives of their formulas.
        """
        return self._recipes.setdefault(places, Kept(MOST_RECIPES))

    def recipe(
        self, places: tuple[Place, ...], status: Status, slopes: bool = False
    ) -> ParametricRows | None:
        """The same of one mode, which may be new."""
        recipes, key = self.recipes(places), (status, slopes)
        if key not in recipes:
            if slopes:
                from vibsim.engine.tangent.packing_tangent import slope_packer

                made = recipe_of(self.scene, places, status, self.keys, slope_packer)
            else:
                made = recipe_of(self.scene, places, status, self.keys)
            return recipes.keep(key, made)
        return recipes[key]

    def statuses(self, most: int) -> list[Status]:
        """The modes packed so far, in their order; none where there are more than `most`."""
        met = list(self._packed)
        return met if len(met) <= most else []

    def events_with_rules(self) -> list[tuple[Status, int]]:
        """(status, number of the event) of what rules were made for."""
        return [key for key, rule in list(self._rules.items()) if rule is not None]

    def integral_maker(self, momentum: bool) -> IntegralMaker:
        """Maker of the integrals of the ledgers; momentum: whether of both of them."""
        with self._lock:
            if momentum not in self._makers:
                self._makers[momentum] = IntegralMaker(self.scene, self.form.kit, self.maker, momentum)
        return self._makers[momentum]

    def packed_integrals(self, status: Status, momentum: bool) -> Packed:
        """The integrals of a mode as bytes of ints and of doubles."""
        with self._lock:
            packed = self._integrals.get((status, momentum))
            if packed is None:
                rows = self.maker.rows(status)
                made = pack_integrals(self.integral_maker(momentum).integrals(rows), self.form)
                packed = self._integrals.keep((status, momentum), made, bytes_of(made))
        return packed

    def packed_slopes(self, status: Status) -> Packed:
        """The derivatives of the formulas of a mode as bytes of ints and of doubles."""
        from vibsim.engine.tangent.packing_tangent import pack_slopes

        with self._lock:
            packed = self._slopes.get(status)
            if packed is None:
                made = pack_slopes(self.maker.rows(status), self.form)
                packed = self._slopes.keep(status, made, bytes_of(made))
        return packed

    def rule(
        self, rows: ModeRows, number: int, make: Callable[[ModeRows, Event], Rule | None]
    ) -> Rule | None:
        """Rule for event `number` of a mode, made by `make(rows, event)` when it is first asked for."""
        key = rows.status, number
        with self._lock:
            if key not in self._rules:
                return self._rules.keep(key, make(rows, rows.events[number]))
            return self._rules[key]


class ParametricModeTable(ModeTable):
    """The table of a scene whose modes are those of another table but for some numbers."""

    def __init__(self, of: ModeTable, scene: Scene, numbers: Numbers) -> None:
        super().__init__(scene)
        self.origin, self.keys, self._rules, self._lock = of, of.keys, of._rules, of._lock
        self._places, self._numbers = tuple(numbers), tuple(numbers.values())
        self._known = of.recipes(self._places)

    def packed(self, status: Status) -> Packed:
        """As of any table: by a known recipe, which is as soon done as looked up."""
        recipe = self._known.get((status, False))
        packed = None if recipe is None else recipe.packed(self._numbers)
        return super().packed(status) if packed is None else packed

    def _pack(self, status: Status) -> Packed:
        return self._repeated(status, False) or super()._pack(status)

    def packed_slopes(self, status: Status) -> Packed:
        with self._lock:
            return self._repeated(status, True) or super().packed_slopes(status)

    def _repeated(self, status: Status, slopes: bool) -> Packed | None:
        recipe = self.origin.recipe(self._places, status, slopes)
        return None if recipe is None else recipe.packed(self._numbers)


_tables: OrderedDict[bytes, ModeTable] = OrderedDict()
_lock = Lock()


def mode_table(scene: Scene, harmonic_keys: bool = True) -> ModeTable:
    """The table of a scene, the same for all that differ in nothing but their starts, ends, samples and the
    numbers of a motor, which no row holds.

    harmonic_keys : False to share it over the frequencies of forces as well; then what is packed is that of
        all these scenes, and of its rows the closed form is that of the first
    """
    key = _signature(scene, harmonic_keys)
    with _lock:
        table = _tables.pop(key, None) or ModeTable(scene)
        _tables[key] = table
        if len(_tables) > SCENES:
            _tables.popitem(last=False)
    return table


def switching_formulas(scene: Scene) -> FormulaRows[float] | None:
    """What the formulas of a scene add to its modes; None where none of them has switches."""
    formulas = mode_table(scene).maker.formulas if scene.has_formulas else None
    return formulas if formulas and formulas.switches else None


PARTS = ("links", "stops", "frictions", "base", "clearances", "base_formula", "base_is_rate", "rotors")


def _signature(scene: Scene, harmonic_keys: bool) -> bytes:
    """Bits of all numbers and names that modes are made of: -0.0 is not 0.0 here."""
    masses = [body.m for body in scene.bodies]
    parts = [getattr(scene, name) for name in PARTS]
    forces = scene.forces if harmonic_keys else _loads(scene)
    kinds = [(body.kind, body.turns) for body in scene.bodies]
    return pickle.dumps((harmonic_keys, masses, kinds, parts, forces, settings(scene)))


def _loads(scene: Scene) -> list[tuple[int, float, list[tuple[float, int | None]], Node | None]]:
    """Forces with the number of the harmonic in the place of its frequency and phase."""
    numbers = {one: number for number, one in enumerate(pitches(scene))}
    return [
        (
            force.on,
            force.constant,
            [(term.amplitude, numbers.get(harmonic_key(term))) for term in force.terms],
            force.formula,
        )
        for force in scene.forces
    ]
