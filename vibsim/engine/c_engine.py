"""The C engine as a trajectory: packs the scene, adds modes as they are met, decides what C leaves open."""

from __future__ import annotations

import threading
from array import array
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import cached_property
from time import monotonic
from typing import TYPE_CHECKING, Any
from weakref import ref

import numpy as np

import vibsim.engine._engine as _engine
from vibsim.engine.columns import part_columns
from vibsim.engine.doubts import REASONS_OF_C, Doubt, few_of, name_of_event
from vibsim.engine.errors import EngineError, State, Stopped, start_of
from vibsim.engine.events.automaton import Automaton, UnambiguousStart
from vibsim.engine.events.rule_maker import RuleMaker
from vibsim.engine.flows.base_motion import base_motion
from vibsim.engine.flows.closed.modal import pitches
from vibsim.engine.flows.expansion import Expansion
from vibsim.engine.ledger import struck_entries
from vibsim.engine.ledger_integrals import pack_extremes, pack_impacts, pack_ledger
from vibsim.engine.modes.mode_table import ModeTable, bytes_of, mode_table
from vibsim.engine.modes.packing import Packed, pack_scene, pack_state
from vibsim.engine.modes.parametric_rows import differences
from vibsim.engine.modes.row_maker import RowMaker
from vibsim.engine.modes.rows import DOMAIN, HOLD, SLIDE, Known, ModeRows
from vibsim.engine.modes.status import STICK, Status
from vibsim.engine.modes.ties import Edge
from vibsim.engine.number_forms import DOUBLES, NumberForm
from vibsim.engine.resume import Point
from vibsim.engine.tangent.tangent_space import length
from vibsim.physics.parts import EVENT_KINDS, ROTOR, Scene
from vibsim.physics.rates import common_period, turning_rotor

if TYPE_CHECKING:
    from vibsim.engine.tangent.tangencies import Jumps

SAMPLE_ROOM, EVENT_ROOM, SECTION_ROOM = 65536, 4096, 1024  # at most
MOST_BYTES = 1 << 23  # of packed modes that C is told of before it forgets them
MOST_RECALLED = 16  # modes that a run is told of before it meets them
SECONDS = 0.1  # between two blocks where Python decides: Ctrl-C is heard there
FEW = 1 << 13  # numbers of a run that is taken apart from it
ACCUMULATION, DIVERGED, UNDECIDED, STANDSTILL, SINGULAR = 1, 2, 3, 5, 6
REASONS = {ACCUMULATION: "accumulation", DIVERGED: "diverged", STANDSTILL: "standstill", SINGULAR: "singular"}
NO_EVENT = -1  # in place of the kind of an event, where nothing is told


def doubts_of(run: CRun) -> Callable[[Any, str, Iterable[str]], None]:
    """A function that counts a doubt of the automaton: at a time [s], for a reason, by the names of events.

    It does not keep that run: flows and automaton refer to each other, so that what they keep is freed by the
    garbage collector only, which knows nothing of the megabytes that C holds.
    """
    kept = ref(run)

    def doubt(t: Any, reason: str, names: Iterable[str]) -> None:
        of = kept()
        if of is not None:
            number = of.run.doubt(t)
            if number >= 0:
                of.described[number] = Doubt(float(t), few_of(names), reason)

    return doubt


def touch_alike(one: Scene, other: Scene) -> bool:
    """Whether two scenes have the same stops and frictions, which tell the mode of a start."""
    return one.stops is other.stops and one.frictions is other.frictions


# rows of samples, sample modes, events, event codes, section; time reached, time worked out to [s]
Filled = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray, tuple[float, float]]


class CRun:
    """A run of a scene made of parts on the C engine.

    carries : whether disturbances are carried as they are (`CarryingRun`); such a run is begun later
    extremes, early, dither, record_from : as of `open_trajectory`
    kick : seed of the signs by which each state that the flow goes on from is moved as doubles round; 0: none
    """

    def __init__(
        self,
        scene: Scene,
        resume: Point | None = None,
        section: bool = False,
        ledger: bool = False,
        momentum: bool = False,
        tangent: tuple[int, float] = (0, 0.0),
        carries: bool = False,
        extremes: tuple[Sequence[Edge], float] | None = None,
        early: bool = False,
        dither: int = 0,
        kick: int = 0,
        record_from: tuple[float, float] = (0.0, 0.0),
        form: NumberForm[Any] = DOUBLES,
    ) -> None:
        self.scene, self.n, self.size, self.early = scene, len(scene.bodies), length(scene), early
        self.form, self.kit, self.momentum = form, form.kit, momentum
        if form is DOUBLES:
            self.table = self.origin = mode_table(scene, harmonic_keys=not carries)
        else:
            self.table = self.origin = ModeTable(scene, form)
        self.keys = self.table.keys
        self.carries = carries or tangent[0] > 0  # disturbances, now or later, by which rules are made
        formulas = self.maker.formulas
        self.switches = formulas.event_columns if formulas else ()  # names of columns of events
        ints, self._doubles = self._packed_scene(scene)
        self.run = form.run(ints, self._doubles)
        self.stopped = threading.Event()
        self.advanced: _engine.Progress | None = None  # what the next call of C came to, if made
        self.left_at: State | None = None  # before an event that was left undecided
        self.described: dict[int, Doubt] = {}  # of the first doubts, by number
        self.told = 0  # bytes of the modes that C knows
        self.numbers: dict[Status, int] = {}
        self.statuses: list[Status] = []
        self.ruled: dict[tuple[int, int], bool] = {}  # events asked about, and whether all is told
        self.integrals = self.table.integral_maker(momentum) if ledger or momentum else None
        if self.integrals:
            names = self.integrals.names
            self.run.keep_ledger(*pack_ledger(scene, names, self.maker.ends, form))
        if scene.rigid_stops:
            names = self.integrals.names if self.integrals else []
            self.run.keep_impacts(*pack_impacts(scene, names, self.maker.ends, early, form))
        self.run.dither(dither)
        self.run.kick(kick)
        if any(record_from):
            self.run.record_from(*record_from)
        count, begin = tangent
        self.moving = count > 0
        if self.moving:
            from vibsim.engine.tangent.packing_tangent import pack_bundle

            self.run.keep_tangent(*pack_bundle(scene, count, begin, self.maker.ends))
        self._measured, packed_extremes = extremes, extremes and pack_extremes(scene, *extremes)
        if packed_extremes:
            self.run.keep_extremes(*packed_extremes)
        self._packed_once = ints, packed_extremes
        self.extremes = len(extremes[0]) if extremes else 0
        self.sample_room = self._room_for_samples(scene)
        parts = len(part_columns(scene))
        self.event_room = max(form.room(EVENT_ROOM), min(EVENT_ROOM, 64 + 4 * parts))
        self.sectioned = section
        self.section_room = form.room(SECTION_ROOM) if section and self._keep_section() else 0
        self._fill_new_arrays()
        self._recall()
        if not carries:
            self._begin(*(resume or self._begun(start_of(scene, self.kit))))

    def begin_anew(self, scene: Scene) -> bool:
        """Begin anew from the start of a scene that differs from that of the run at most in its start and in
        numbers of its modes. Whether that was possible: if not, this run must not be used again.
        """
        self.run.rewind(scene.t_end)
        if not self.scene.same_but_for_start(scene) and not self._takes_over(scene):
            return False
        if scene.rigid_stops:  # whose automaton sums up what the ends of sequences of impacts leave out
            vars(self).pop("automaton", None)
        self.scene = scene
        self.described.clear()
        self._begin(*self._begun(start_of(scene, self.kit)))
        return True

    def _packed_scene(self, scene: Scene) -> Packed:
        return pack_scene(scene, pitches(scene), self.form, switches=len(self.switches))

    def _takes_over(self, scene: Scene) -> bool:
        """Take over the numbers of a scene. Whether that was possible: its modes have the same form, and
        what C takes at the beginning alone is the same.
        """
        if self.integrals or any(body.kind == ROTOR for body in scene.bodies):
            return False
        ints, doubles = self._packed_scene(scene)
        extremes = self._measured and pack_extremes(scene, *self._measured)
        numbers = differences(self.origin.scene, scene) if self._packed_once == (ints, extremes) else None
        if numbers is None:
            return False
        try:
            self.retune(scene, doubles, self.origin.retuned(scene, numbers))
        except ValueError:  # a mode has another form all the same
            return False
        if self.sectioned and self._keep_section() != (self.section_room > 0):
            return False  # one of the two has no common period
        room = self._room_for_samples(scene)
        if room > self.sample_room:
            self.sample_room = room
            self._fill_new_arrays()
        return True

    def retune(self, scene: Scene, doubles: bytes, table: ModeTable) -> None:
        """Go over to a scene whose modes have the same form (`parametric_rows.differences`); a new start has
        to follow. Raises ValueError where a mode has not.

        doubles : of the packed scene; table : of its modes
        """
        for name in ("expansion", "automaton", "jumps", "maker"):
            self.__dict__.pop(name, None)
        before, self.scene = self.scene, scene
        if doubles != self._doubles:
            self.run.retune(doubles)
            self._doubles = doubles
        if table is not self.table:
            self.table = table
            for number, status in enumerate(self.statuses):
                self.run.renew_mode(number, *table.packed(status))
                self._set_slopes(number, status)
        if not touch_alike(before, scene):
            vars(self).pop("plain", None)
            if scene.rigid_stops:
                self.run.keep_impacts(*pack_impacts(scene, [], self.maker.ends, self.early))

    @property
    def doubts(self) -> list[Doubt]:
        """The first doubts of the certificate, in the order in which they came."""
        self._describe_doubts()
        return [self.described[number] for number in sorted(self.described)]

    def _describe_doubts(self) -> None:
        """Name the events of the doubts of C while it knows the modes that they are numbered in."""
        for number, (at, reason, mode, *events) in enumerate(self.run.doubts()):
            if number not in self.described:
                rows = self.rows_of(mode)
                names = (name_of_event(self.maker, rows, rows.events[i]) for i in events if i >= 0)
                (time,) = self.kit.rounded([at])
                self.described[number] = Doubt(time, few_of(names), REASONS_OF_C[reason])

    @cached_property
    def maker(self) -> RowMaker:
        """Makes the rows of the modes of the scene, its closed forms among them."""
        maker = self.table.maker
        if self.carries and pitches(maker.scene) != pitches(self.scene):
            maker = RowMaker(self.scene, self.kit)
        return maker

    @cached_property
    def expansion(self) -> Expansion:
        """Looks ahead from an event that Python decides."""
        return Expansion(self.scene, self.table)

    @cached_property
    def automaton(self) -> Automaton:
        """Decides what C leaves open."""
        automaton = Automaton(self.scene, self.maker, self.expansion, doubts_of(self))
        automaton.rigid.chatter.early, automaton.departures.stopped = self.early, self.stopped
        return automaton

    @cached_property
    def jumps(self) -> Jumps:
        """Takes disturbances through events that Python decides."""
        from vibsim.engine.tangent.tangencies import Jumps

        return Jumps(self.scene, self.run, self.maker.rows, self.expansion)

    def rows_of(self, number: int) -> ModeRows:
        """The rows of a mode by its number in C."""
        return self.maker.rows(self.statuses[number])

    def _begin(self, state: State, status: Status, known: Known) -> None:
        self.first = state.copy(), status
        self._set_off(state, status, known)

    def _recall(self) -> None:
        """Tell C of modes and rules that other runs of the scene have met, where they are few."""
        for status in self.table.statuses(MOST_RECALLED):
            self._mode(status)
        for status, event in self.table.events_with_rules() if self.statuses else ():
            if status in self.numbers:
                self._set_rule(self.numbers[status], event)

    def _set_off(self, state: State, status: Status, known: Known) -> None:
        number = self._mode(status)  # which may know more keys
        *_, status_of_run = self.run.start(number, pack_state(state, self.form), self._known(known, 0))
        if status_of_run in REASONS:
            raise self._failure(status_of_run)

    def _begun(self, state: State) -> Point:
        """A state at t = 0 with the mode that the motion starts in, and the known zeros there."""
        status = self.plain.status(state) if self.plain else None
        return (state, *self.automaton.initial(state)) if status is None else (state, status, {})

    @cached_property
    def plain(self) -> UnambiguousStart | None:
        """Tells the modes of plain starts; None where there can be none."""
        plain, formulas = UnambiguousStart(self.scene, self.maker.ends), self.maker.formulas
        switching = formulas is not None and bool(formulas.switches)  # whose sides the state tells
        return plain if plain.known and not switching else None

    def _keep_section(self) -> bool:
        """Tell C of the period of forces and base, or the rotor that turns; whether there is a section to
        keep.
        """
        period = None if self.scene.motor else common_period(self.scene)
        rotor = turning_rotor(self.scene)
        if period is not None:
            self.run.keep_section(period.cycles, period.cycles_lo, period.turns, -1)
        elif rotor is not None:
            self.run.keep_section(0.0, 0.0, 0.0, rotor)
        return period is not None or rotor is not None or self.scene.motor is not None

    def _room_for_samples(self, scene: Scene) -> int:
        """How many samples of a scene C gives back at a time."""
        return min(scene.sample_index(scene.t_end) + 2, self.form.room(SAMPLE_ROOM))

    def _fill_new_arrays(self) -> None:
        """Let C fill new arrays, one row per column: samples, sample modes, events, event codes, section."""
        n, parts, extremes = self.n, len(part_columns(self.scene)), 2 * self.extremes
        self.arrays = (
            self.form.empty(3 + 2 * n, self.sample_room),
            np.empty((parts, self.sample_room), dtype="i1"),
            self.form.empty(5 + 3 * n + len(self.switches), self.event_room),
            np.empty((2 + parts, self.event_room), dtype="i1"),
            self.form.empty(3 + 2 * n + extremes, self.section_room),
        )
        self.run.fill(*self.arrays)

    def _mode(self, status: Status) -> int:
        """Number of a mode in C; adds it where it is new."""
        number = self.numbers.get(status)
        if number is None:
            packed = self.table.packed(status)
            number = self.run.add_mode(*packed)
            self.told += bytes_of(packed)
            if self.integrals:
                self.run.set_integrals(number, *self.table.packed_integrals(status, self.momentum))
            self._set_slopes(number, status)
            self.numbers[status] = number
            self.statuses.append(status)
        return number

    def _set_slopes(self, number: int, status: Status) -> None:
        """Tell C how disturbances feel the formulas of a mode, where it carries some."""
        if self.carries and self.scene.has_formulas:
            self.run.set_slopes(number, *self.table.packed_slopes(status))

    def _forget_modes(self) -> None:
        """Have C forget all modes but the one it is in: it is told of them again where it comes back."""
        self._describe_doubts()
        now = self.statuses[self.run.forget_modes()]
        self.numbers, self.statuses, self.told = {now: 0}, [now], 0
        self.ruled.clear()

    def _known(self, known: Known, missing: int) -> bytes:
        if not known and missing == 0:
            return bytes(array("i").itemsize * len(self.keys))
        orders = array("i", [missing]) * len(self.keys)
        for key, order in known.items():
            if (number := self.keys.get(key)) is not None:
                orders[number] = order
        return orders.tobytes()

    def blocks(self) -> Iterator[Filled]:
        """Yield (samples, sample modes, events, event codes, section), arrays of one row per column, and
        (time reached, time worked out to); raises EngineError. What is yielded holds until a restart.
        """
        return filter(None, self.blocks_beside())

    def blocks_beside(self) -> Iterator[Filled | None]:
        """The same, with None before each call of C. Others may make that call then, and set `advanced` to
        what it came to.
        """
        finished, last_told = 0, monotonic()
        while not finished:
            if not self.advanced:
                yield None
            *counts, finished, status = self.advanced or self.run.advance()
            self.advanced = None
            if status == UNDECIDED:
                number, event, order, values = self.run.pending()
                if self.told > MOST_BYTES and (number, event) not in self.ruled:  # else half of it is told
                    self._forget_modes()
                    number = 0
                if self._set_rule(number, event):
                    continue
                try:
                    *counts, finished, status = self._decide(number, event, State(*values), order)
                except Stopped:
                    self.left_at = State(*values)
                    yield self._block(counts, True)
                    return
                except EngineError:
                    yield self._block(counts, True)
                    raise
                if not finished and status not in REASONS and monotonic() - last_told < SECONDS:
                    continue
            yield self._block(counts, finished)
            last_told = monotonic()
            if status in REASONS:
                raise self._failure(status)

    def _failure(self, status: int) -> EngineError:
        """Why C cannot go on from its state."""
        tally = self.tally
        rows, state = self.rows_of(tally["mode"]), State(*tally["state"])
        if status != SINGULAR or not rows.tape:
            return EngineError(REASONS[status], state)
        self.expansion.look(state, rows)
        for event in rows.events:  # a root that is negative where the run begins
            if event.kind == DOMAIN and self.expansion.derivatives(event, 0)[0] < 0:
                return EngineError("domain", state, rows.tape.texts[event.part])
        return EngineError(REASONS[status], state, rows.tape.texts[tally["singular"]])

    def _block(self, counts: Sequence[int], finished: int) -> Filled:
        """Block of what C has filled, whose arrays are given away where they hold much and copied where they
        are to be filled again.
        """
        rows = self._rows(counts)
        rooms = self.sample_room, self.event_room, self.section_room
        if any(count > room // 4 for count, room in zip(counts, rooms, strict=True)):
            self._fill_new_arrays()
        elif not finished:
            rows = [row.copy() for row in rows]
            self.run.fill(*self.arrays)
        return self._filled(rows)

    def whole(self, advanced: _engine.Progress) -> Filled | None:
        """The block of a run that the first call of C has computed, copied; None where that was not all, or
        where the block is large.
        """
        *counts, finished, status = advanced
        if not finished or status or sum(counts) * len(self.arrays[2]) > FEW:
            return None
        return self._filled([row.copy() for row in self._rows(counts)])

    def _rows(self, counts: Sequence[int]) -> list[np.ndarray]:
        """The part of each array that C has filled."""
        samples, events, section = counts
        of = zip(self.arrays, (samples, samples, events, events, section), strict=True)
        return [array[:, :count] for array, count in of]

    def _filled(self, rows: Sequence[np.ndarray]) -> Filled:
        """A block of these rows, with the times that the run has come to."""
        tally = self.tally
        states, modes, happened, codes, crossings = rows
        return states, modes, happened, codes, crossings, (tally["state"][0], tally["worked_to"])

    def states_at(self, times: Sequence[float]) -> tuple[np.ndarray, np.ndarray]:
        """Columns at ascending times [s]: time, x and v of each body, rotor angle, its speed; and what each
        part does. Events on the way are taken. Raises EngineError where a time is later than that at which
        the run fails.
        """
        states = self.form.empty(3 + 2 * self.n, len(times))
        codes = np.empty((len(part_columns(self.scene)), len(times)), dtype="i1")
        packed, made = self.form.packed(times), 0
        while made < len(times):
            made, status = self.run.states_at(packed, states, codes, made)  # here a signal is heard
            try:
                if status == UNDECIDED:
                    number, event, order, values = self.run.pending()
                    if not self._set_rule(number, event):
                        self._decide(number, event, State(*values), order)
                elif status in REASONS and status != DIVERGED:
                    raise self._failure(status)
            except EngineError as error:
                end = error.state
                if end.t < times[-1]:
                    raise
                moving = (value for pair in zip(end.x, end.v, strict=True) for value in pair)
                row = self.form.packed([end.t, *moving, self.kit.unwind(end.phase, end.turns), end.w])
                states[:, made:] = np.frombuffer(row, dtype=states.dtype)[:, None]
                codes[:, made:] = np.array(self.statuses[self.tally["mode"]].codes)[:, None]
                break
        return states, codes

    def _decide(self, number: int, event: int, state: State, order: int) -> _engine.Progress:
        """Let the automaton, which is in Python, decide the pending event; order: as of `Automaton.take`."""
        rows = self.rows_of(number)
        status, happened, known = self.automaton.take(state, rows.status, rows.events[event], order)
        target, touch = self._mode(status), self.automaton.touch(rows.events[event])
        if rows.events[event].kind == SLIDE:
            self._rule_release(rows.status.with_frictions({rows.events[event].part: STICK}), status)
        if self.moving:
            after = self.rows_of(target)
            if not self.jumps.in_c(rows, after, rows.events[event], touch):
                self.jumps.hand(rows.events[event], state, rows, after, touch)
        kinds = array("i", (EVENT_KINDS[kind] for kind, _ in happened)).tobytes()
        parts = array("i", (part for _, part in happened)).tobytes()
        taken = self.run.take(target, pack_state(state, self.form), self._known(known, -1), kinds, parts)
        if self.integrals and touch:
            V = base_motion(self.scene, self.kit, state.t)[1]
            for entry, value in struck_entries(self.scene, self.integrals.names, touch, V):
                self.run.add_entry(entry, value)
        return taken

    def _set_rule(self, number: int, event: int) -> bool:
        """Tell C what follows an event, where that is simple; whether it is news. The mode that ends slide
        back in is told where C has asked for it, or knows it anyway: it is rarely met.
        """
        told = self.ruled.get((number, event))
        if told:
            return False
        rows = self.rows_of(number)
        rule = self.table.rule(rows, event, lambda *of: RuleMaker(self.automaton).rule(*of))
        if rule is None:
            self.ruled[number, event] = True
            return False
        back = rule.other if told is False or rule.other in self.numbers else None
        self.ruled[number, event] = back is not None or rule.other is None
        if back is not None and not self.maker.is_watched(back):
            back = None
        if back is None:
            if told is False:
                return False
            rule = rule._replace(other=None, hold=-1)
        target, other = (0 if status is None else self._mode(status) for status in (rule.target, back))
        if self.carries and not self.jumps.of_rule_in_c(rows, rule, rows.events[event]):
            return False
        kind = EVENT_KINDS[rule.happened] if rule.happened else NO_EVENT
        numbers = rule.kind, target, other, rule.hold, kind, rule.part, self.keys.number(rule.key), rule.order
        self.run.set_rule(number, event, numbers)
        return True

    def _rule_release(self, stuck: Status, after: Status) -> None:
        """Give C the rule of a tie that has let go as another one came to rest, so that C decides both the
        next time. stuck, after : the modes in which all ties hold, and all but that one.
        """
        released = set(stuck.tied) - set(after.tied)
        if stuck in self.numbers and len(released) == 1:
            rows = self.maker.rows(stuck)
            for number, event in enumerate(rows.events):
                if event.kind == HOLD and {tie for tie, _ in rows.cuts[event.part].ties} == released:
                    self._set_rule(self.numbers[stuck], number)

    @property
    def disturbances(self) -> dict[str, Any]:
        """Disturbances as C has them, by name; near: how close events were to tangency."""
        entries = self.run.disturbances()
        near = *entries["near"], max(entries["fastest"], default=0)
        return entries | {"lost": [bool(one) for one in entries["lost"]], "near": near}

    @property
    def tally(self) -> dict[str, Any]:
        return self.run.tally()
