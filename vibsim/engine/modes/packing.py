"""Scenes and modes as flat numbers, in the order in which scene.c and modes.c read them."""

from __future__ import annotations

from array import array
from collections.abc import Iterable, Sequence
from itertools import islice
from typing import TYPE_CHECKING, Any

from vibsim.engine.errors import State
from vibsim.engine.flows.closed.modal import Pitch, harmonic_key
from vibsim.engine.modes.rows import DIFFERENCE, RATE, SWITCH, Event, EventKey, ModeRows, Term
from vibsim.engine.number_forms import DOUBLES, NumberForm
from vibsim.physics.parts import BASE, BODY, GROUND, Harmonic, Scene

if TYPE_CHECKING:
    from vibsim.engine.flows.closed.modal import Modal, Source
    from vibsim.engine.flows.tape import Tape


Packed = tuple[bytes, bytes]  # integers and doubles


class Packer:
    """Two lists of numbers: integers, and numbers of the motion in a form of C."""

    def __init__(self, form: NumberForm[Any] = DOUBLES) -> None:
        self.form = form
        self.ints: list[int] = []
        self.doubles: list[float] = []

    def put(self, ints: Iterable[int] = (), doubles: Iterable[float] = ()) -> None:
        self.ints.extend(ints)
        self.doubles.extend(doubles)

    @property
    def packed(self) -> Packed:
        """Both as bytes."""
        return array("i", self.ints).tobytes(), self.form.packed(self.doubles)


def harmonic(term: Harmonic) -> tuple[float, ...]:
    return term.amplitude, term.omega, term.cycles, term.cycles_lo, term.phase


def pack_scene(
    scene: Scene[Any],
    harmonics: Sequence[Pitch[Any]],
    form: NumberForm[Any] = DOUBLES,
    order: int | None = None,
    switches: int = 0,
) -> Packed:
    """The scene as bytes of ints and of numbers.

    harmonics : distinct pitches, as `modal.pitches`; order: of Taylor series, where not that of a run;
    switches : number of those of formulas whose sides events tell
    """
    motor = scene.motor
    parts = len(scene.stops) + len(scene.frictions) + len(scene.clearances)
    of_pitch = iter(harmonic_indices(scene, harmonics))
    ints = [
        len(scene.bodies),
        parts,
        len(scene.clearances),
        switches,
        len(harmonics),
        len(scene.forces),
        len(scene.base),
    ]
    ints += (motor is not None, motor.on if motor else 0, scene.has_base + scene.base_is_rate)
    ints += (rest_columns(scene),)
    alone = [c for c, body in enumerate(scene.bodies) if body.kind != BODY or body.turns]
    ints += (scene.stop_on_violation, order or form.kit.order(scene), len(scene.rotors), len(alone))
    ints += islice(of_pitch, len(scene.base))
    for force in scene.forces:
        ints += (force.on, len(force.terms), *islice(of_pitch, len(force.terms)))
    for rotor in scene.rotors:
        ints += (rotor.column, rotor.on)
    ints += alone
    return array("i", ints).tobytes(), scene_doubles(scene, harmonics, form)


def harmonic_indices(scene: Scene[Any], harmonics: Sequence[Pitch[Any]]) -> list[int]:
    """The number of the key of each harmonic of the base, then of the forces; -1 for amplitudes of 0."""
    terms = [*scene.base, *(term for force in scene.forces for term in force.terms)]
    return [harmonics.index(harmonic_key(term)) if term.amplitude != 0 else -1 for term in terms]


def scene_doubles(
    scene: Scene[Any], harmonics: Sequence[Pitch[Any]], form: NumberForm[Any] = DOUBLES
) -> bytes:
    """The doubles of `pack_scene`."""
    motor = scene.motor
    doubles = [0.0] * 6
    if motor:
        doubles = [motor.m3, motor.e, motor.M0, motor.unbalance, motor.inertia, motor.drag]
    doubles += (form.kit.tolerance_exponent(scene), scene.t_end, scene.every_num, scene.every_den)
    doubles += [body.m for body in scene.bodies]
    for one in harmonics:
        doubles += (1.0, *one)
    for term in scene.base:
        doubles += harmonic(term)
    for force in scene.forces:
        doubles.append(force.constant)
        for term in force.terms:
            doubles += harmonic(term)
    for rotor in scene.rotors:
        doubles += (rotor.unbalance, scene.bodies[rotor.column].m)
    return form.packed(doubles)


def rest_columns(scene: Scene[Any]) -> int:
    """How many columns at rest the tables of Taylor series need: ground and base, the ground, or none."""
    coupled = (*scene.links, *scene.stops)
    if scene.has_base or any(BASE in (p.P, p.Q) for p in (*coupled, *scene.frictions, *scene.clearances)):
        return 2
    return int(any(GROUND in (part.P, part.Q) for part in coupled))


def pack_state(state: State[Any], form: NumberForm[Any] = DOUBLES) -> bytes:
    return form.packed((state.t, *state.x, *state.v, state.phase, state.turns, state.w))


class EventNumbers:
    """Numbers in C of event keys. Of the pieces of mod and of tables, of which a run may come through any
    number, ends four pieces apart have one number: no two of these are known to be zero at one time.
    """

    def __init__(self) -> None:
        self._numbers: dict[EventKey, int] = {}

    def __len__(self) -> int:
        return len(self._numbers)

    def number(self, key: EventKey) -> int:
        """The number of a key, a new one if it has none."""
        return self._numbers.setdefault(_shared(key), len(self._numbers))

    def get(self, key: EventKey) -> int | None:
        """The number of a key, if it has one."""
        return self._numbers.get(_shared(key))


def _shared(key: EventKey) -> EventKey:
    return (*key[:2], key[2] % 4) if key[0] == SWITCH and isinstance(key[2], int) else key


def packed_mode(
    rows: ModeRows,
    keys: EventNumbers,
    form: NumberForm[Any] = DOUBLES,
    modal: Modal | None = None,
) -> Packer:
    """The rows of a mode as ints and numbers. keys: of its events, which get numbers; modal: its closed form,
    where that is told of.
    """
    pack = Packer(form)
    terms: list[Term] = []
    slopes: list[tuple[int, int, int, int, float, int]] = []
    slope_constants: list[float] = []
    events: list[tuple[Event, int, int, int, int, int]] = []
    for event in rows.events:
        first, first_slope = len(terms), len(slopes)
        terms += event.terms
        for one in event.slope:
            counts = len(terms), len(one.terms), len(slope_constants), len(one.constants)
            slopes.append((*counts, one.mass, one.factor))
            terms += one.terms
            slope_constants += one.constants
        key = keys.number(event.key)
        events.append((event, key, first, len(event.terms), first_slope, len(slopes) - first_slope))
    pairs = {pair: i for i, pair in enumerate(modal.pairs)} if modal else {}
    sides = [float(side or 0) for side in rows.status.switches]
    pack.put(
        (
            len(rows.couplings),
            len(events),
            len(sides),
            len(rows.constants),
            len(terms),
            len(slopes),
            len(slope_constants),
        )
    )
    tape, base_tape = rows.tape, rows.base_tape
    pack.put((len(pairs), len(tape.ops) if tape else 0, len(base_tape.ops) if base_tape else 0))
    pack.put(rows.status.codes, sides)
    ints, doubles = pack.ints, pack.doubles
    ints += rows.leader
    for mobility, mass, drift in zip(rows.mobility, rows.mass, rows.drift, strict=True):
        doubles += (mobility, 0.0 if mass is None else mass, drift)
    for q in rows.couplings:
        ints += (q.P, q.Q, pairs.get((q.P, q.Q), -1))
        doubles += (q.k, q.c, q.offset)
    for column, value in rows.constants:
        ints.append(column)
        doubles.append(value)
    if tape and (tape.ops or base_tape):
        pack_tape(pack, tape)
        pack.put((len(rows.formulas),))
        for force in rows.formulas:
            pack.put(force)
        pack.put((len(rows.follow),))
        for follower in rows.follow.items():
            pack.put(follower)
        if base_tape and rows.base_values:
            pack_tape(pack, base_tape)
            pack.put((len(rows.base_values.ops),))
            pack_tape(pack, rows.base_values)
    doubles += slope_constants
    for term in terms:
        pair = pairs[term.P, term.Q] if modal and term.kind in (DIFFERENCE, RATE) else -1
        ints += (term.kind, term.P, term.Q, pair)
    doubles += [term.coefficient for term in terms]
    for first, count, first_constant, constants, mass, factor in slopes:
        ints += (first, count, first_constant, constants)
        doubles += (mass, factor)
    for event, key, first, count, first_slope, slope_count in events:
        ints += (event.kind, event.part, key, event.turns, first, count, first_slope, slope_count)
        doubles += (event.constant, event.size)
    pack.put((bool(modal),))
    if modal:
        pack_modal(pack, modal)
    return pack


def pack_tape(pack: Packer, tape: Tape) -> None:
    ints = pack.ints
    ints.append(len(tape.outputs))
    for op in tape.ops:
        ints += op[:3]
    pack.doubles += [op.value for op in tape.ops]
    ints += tape.outputs


def pack_modal(pack: Packer, modal: Modal) -> None:
    sources: list[Source] = []
    shifts: list[tuple[int, int, float]] = []
    shares: list[tuple[int, float]] = []
    fixed: list[tuple[int, int]] = []

    def place(
        shape: Iterable[tuple[int, float]], positions: Iterable[tuple[int, int]], base: int
    ) -> tuple[int, ...]:
        first, first_fixed = len(shares), len(fixed)
        shares.extend(shape)
        fixed.extend((column, sign) for sign, column in positions)
        return first, len(shares) - first, first_fixed, len(fixed) - first_fixed, base

    places = [place(one.shape.items(), one.fixed, one.base) for one in modal.places]
    places += [place(pair.terms, pair.fixed, pair.base) for pair in modal.pairs.values()]
    spans = []
    for coordinate in modal.coordinates:
        spans.append((len(sources), len(coordinate.sources), len(shifts), len(coordinate.shifts)))
        sources += coordinate.sources
        for factor, plus, minus in coordinate.shifts:
            first = len(fixed)
            fixed.extend((column, sign) for sign, column in plus)
            fixed.extend((column, -sign) for sign, column in minus)
            shifts.append((first, len(fixed) - first, factor))
    pack.put((len(modal.coordinates), len(sources), len(shifts), len(shares), len(fixed)))
    for (P, Q), weight in sources:
        pack.put((P, -1 if Q is None else Q), (weight,))
    for first, count, factor in shifts:
        pack.put((first, count), (factor,))
    for m, share in shares:
        pack.put((m,), (share,))
    for column, sign in fixed:
        pack.put((column, sign))
    for one in places:
        pack.put(one)
    for coordinate, (first, count, first_shift, shift_count) in zip(modal.coordinates, spans, strict=True):
        pack.put(
            (coordinate.free, first, count, first_shift, shift_count),
            (coordinate.a, coordinate.b, coordinate.load, coordinate.load_size),
        )
        pack.put((), coordinate.sines)
        pack.put((), coordinate.cosines)
        pack.put((), coordinate.sizes)
