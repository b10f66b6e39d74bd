"""Which ties hold and which let go where several stand at one instant: the one consistent combination."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import combinations, product
from math import prod
from typing import Generic

from vibsim.engine.doubts import HOLDS, LEAVES, LOADED, name_of_tie
from vibsim.engine.errors import EngineError, State
from vibsim.engine.events.departures import DerivativeSigns, first_sign, sign
from vibsim.engine.flows.accelerations import accelerations
from vibsim.engine.flows.base_motion import base_acceleration, course_velocity
from vibsim.engine.modes.row_maker import RowMaker
from vibsim.engine.modes.rows import HOLD, SLIDE, STRIKE, Event, ModeRows
from vibsim.engine.modes.status import BACKWARD, FORWARD, STICK, Status
from vibsim.physics.numbers import N, abs, total_of
from vibsim.physics.parts import RigidStop, Scene

# of all forces of a mode: nearer to its limit than that the force of a tie is measured closely
NEAR = 2.0**-40
MOST_TRIED = 3**6  # combinations of ties that are tried one by one: those of six frictions
STEPS_A_TIE = 16  # of a descent; some two were needed in random scenes


class StickSlipResolution(Generic[N]):
    """Decides what sticks, rests, slips and parts where frictions and rigid stops stand."""

    def __init__(self, scene: Scene[N], maker: RowMaker[N], departures: DerivativeSigns[N]) -> None:
        self.scene, self.maker, self.kit = scene, maker, departures.kit
        self.departures, self.relative = departures, departures.relative

    def standing(self, status: Status, more: Iterable[int] = ()) -> list[int]:
        """Ties that stand in the moment in which the ties `more` come to rest: these, those that hold, and
        frictions that others which hold then keep from sliding.
        """
        standing = {*more, *status.tied}
        while any(k not in standing for k in range(len(status.frictions))):
            tied = status.with_ties(dict.fromkeys(standing, STICK))
            resting = self.maker.resting(tied) - standing
            if not resting:
                break
            standing |= resting
        return sorted(standing)

    def settle_behind(self, state: State[N], status: Status, after: Status) -> Status:
        """The mode behind a release at which a friction force drops: the jump of the accelerations may tear
        other ties too. after: the status with the ties of the cut let go.
        """
        standing = status.tied
        settled = self._release(state, after, standing)
        if settled is not None:
            return settled
        self._doubt_ties(state, standing)
        if self._are_many(standing):
            here = self._accelerations(state, status)
            consistent = self._descend(state, after, standing, here)
        else:
            consistent = self._first_consistent(state, after, standing, besides=status)
        return self._decided(state, consistent, after, standing)

    def settle(self, state: State[N], status: Status, standing: Sequence[int]) -> Status:
        """The status in which the ties `standing` (frictions with v_rel = 0, rigid stops with g = g' = 0)
        hold or let go consistently.
        """
        tied = status.with_ties(dict.fromkeys(standing, STICK))
        possible = self.possible(tied)
        if possible:
            after = self._release(state, tied, standing)
            if after is not None:
                return after
            self._doubt_ties(state, standing)
        if self._are_many(standing):
            start = (tied, self._accelerations(state, tied)) if possible else self._parted(state, tied)
            consistent = start and self._descend(state, start[0], standing, start[1])
        else:
            consistent = self._first_consistent(state, status, standing)
            if consistent is None and not possible:
                self._doubt_ties(state, standing)
        return self._decided(state, consistent, tied, standing)

    def _are_many(self, standing: Iterable[int]) -> bool:
        """Whether ties have more combinations than are tried one by one."""
        return combinations_count(standing, len(self.scene.frictions)) > MOST_TRIED

    def _doubt_ties(self, state: State[N], standing: Iterable[int]) -> None:
        """Doubt which of the ties `standing` hold."""
        self.departures.doubt(state, HOLDS, (name_of_tie(self.scene, k) for k in standing))

    def _first_consistent(
        self, state: State[N], status: Status, standing: Sequence[int], besides: Status | None = None
    ) -> Status | None:
        """The first consistent combination of the ties `standing`, those with most ties first; None
        without any. besides: a status that has been left.
        """
        for choice in combinations_of(standing, len(status.frictions)):
            candidate = status.with_ties(choice)
            if candidate != besides and self._consistent(state, candidate, standing):
                return candidate
        return None

    def possible(self, status: Status) -> bool:
        """Whether the ties of a mode can last: a base that moves cannot be tied to the ground, though it may
        rest for an instant.
        """
        ground, moves = self.maker.n, self.scene.base_moves
        if moves and self.maker.tied(status).groups.leader[ground + 1] == ground:
            return False
        return self.maker.can_last(status)

    def _release(
        self, state: State[N], candidate: Status, standing: Sequence[int], clearly: bool = False
    ) -> Status | None:
        """As long as cuts are overloaded, the ties of the one that is so most let go. None where that is not
        consistent in the end. clearly: what rounding alone overloads or turns round does not count, as where
        bodies that are alike move as one and ties between them have nothing to hold.
        """
        for _ in range(len(standing) + 1):
            rows = self.departures.enter(state, candidate)
            broken = self._overloaded(state, rows, clearly)
            if broken is None:
                break
            candidate = self._torn(candidate, rows, broken)
        else:
            return None
        slipping = self._apart(candidate, standing)
        if len(standing) == 1 or self._slips_as_said(state, candidate, slipping, clearly):
            return candidate
        return None

    def _descend(
        self, state: State[N], candidate: Status, standing: Sequence[int], here: Sequence[N]
    ) -> Status | None:
        """A consistent combination of many ties, by active sets; None where rounding keeps it from one.

        Coulomb's accelerations minimise sum m (a - F/m)^2 / 2 + sum f |a_P - a_Q|, f the forces of slip of
        the ties that stand, which is convex (Moreau 1966). The way leads from the accelerations `here`
        [m/s^2] towards those of the mode `candidate`, up to where a tie that slips would turn round: it
        sticks there. Where they are reached, the ties of the cut that is overloaded most let go. Each mode
        that is reached has a smaller sum than those before it, so none comes twice, whatever ties hold.
        """
        for _ in range(STEPS_A_TIE * len(standing)):
            there = self._accelerations(state, candidate)
            share, turning = self._first_to_turn(candidate, standing, here, there)
            if turning is None:
                broken = self._overloaded(state, rows := self.departures.enter(state, candidate))
                if broken is None:
                    slips = self._slips_as_said(state, candidate, self._apart(candidate, standing))
                    return candidate if slips and self.possible(candidate) else None
                candidate, here = self._torn(candidate, rows, broken), there
            else:
                here = [a + share * (b - a) for a, b in zip(here, there, strict=True)]
                candidate = candidate.with_ties({turning: STICK})
                candidate = self._with_kept(candidate, standing)
        return None

    def _accelerations(self, state: State[N], status: Status) -> list[N]:
        """Accelerations of all columns in a mode [m/s^2]."""
        return accelerations(self.scene, self.kit, self.maker.rows(status), state)[0]

    def _parted(self, state: State[N], tied: Status) -> tuple[Status, list[N]] | None:
        """A mode and accelerations to begin with where ground and base, which moves, are tied: bodies that
        rest, or else go with the base, slip on the other. None where rigid stops keep them from both.
        """
        n, base = self.maker.n, base_acceleration(self.scene, self.kit, state.t)
        for of_bodies in (self.kit.number(0), base):
            a = [*[of_bodies] * n, self.kit.number(0), base]
            slips: dict[int, int] = {}
            for k in tied.tied:
                sense = sign(self._parting(tied.with_ties({k: FORWARD}), k, a))
                if sense:
                    slips[k] = sense
            if all(sense > 0 for k, sense in slips.items() if k >= len(tied.frictions)):
                return tied.with_ties(slips), a
        return None

    def _parting(self, status: Status, k: int, a: Sequence[N]) -> N:
        """Acceleration [m/s^2] at which the ends of tie `k`, let go, slip as its status says, or open."""
        tie = self.maker.tie(k)
        P, Q = self.maker.ends(tie)
        return (tie.sense if isinstance(tie, RigidStop) else status.frictions[k]) * (a[P] - a[Q])

    def _first_to_turn(
        self, status: Status, standing: Sequence[int], here: Sequence[N], there: Sequence[N]
    ) -> tuple[N, int | None]:
        """How far on the way from the accelerations `here` to those `there` a tie that slips first comes to
        turn round, as a share, and which; 1 and None where none does.
        """
        first, turning = self.kit.number(1), None
        for k in self._apart(status, standing):
            now, then = self._parting(status, k, here), self._parting(status, k, there)
            if then < 0:
                share = now / (now - then) if now > 0 else self.kit.number(0)
                if turning is None or share < first:
                    first, turning = share, k
        return first, turning

    def _with_kept(self, status: Status, standing: Sequence[int]) -> Status:
        """The status with those of the ties `standing` that others keep from slipping or opening."""
        leader = self.maker.tied(status).groups.leader
        kept = self.maker.resting(status)
        for k in self._apart(status, standing):
            P, Q = self.maker.ends(self.maker.tie(k))
            if k >= len(status.frictions) and leader[P] == leader[Q]:
                kept = kept | {k}
        return status.with_ties(dict.fromkeys(kept & set(standing), STICK))

    def _decided(
        self, state: State[N], consistent: Status | None, tied: Status, standing: Sequence[int]
    ) -> Status:
        """The status `consistent`; where there is none, the one that cuts which let go lead to from `tied`
        without what rounding alone contradicts; else `tied`. Raises EngineError of many ties.
        """
        if consistent is None and self.possible(tied):
            consistent = self._release(state, tied, standing, clearly=True)
        if consistent is None and self._are_many(standing):
            names = ", ".join(self.maker.tie(k).name for k in standing)
            raise EngineError("undecided", state, f"{len(standing)} of them, {names}")
        return tied if consistent is None else consistent

    @staticmethod
    def _torn(status: Status, rows: ModeRows[N], broken: Event[N]) -> Status:
        """The status with the ties of an overloaded cut let go."""
        ties = rows.cuts[broken.part].ties
        return status.with_ties({i: orientation * broken.direction for i, orientation in ties})

    @staticmethod
    def _apart(status: Status, standing: Sequence[int]) -> list[int]:
        """The ties among `standing` that do not hold."""
        tied = set(status.tied)
        return [k for k in standing if k not in tied]

    def _overloaded(self, state: State[N], rows: ModeRows[N], clearly: bool = False) -> Event[N] | None:
        """The HOLD event furthest below zero behind the instant, `clearly` or by its rounding; or None."""
        worst: Event[N] | None = None
        depth: N | None = None
        forces = self.departures.expansion.forces()
        for event in rows.events:
            if event.kind == HOLD:
                values = self.departures.hold_values(state, rows, event)
                sense = first_sign(values)
                if abs(values[0]) <= NEAR * (forces + event.size) and self.departures.is_open(
                    state, event, values, 0
                ):
                    self.departures.doubt_event(state, rows.status, event, LOADED)
                    if clearly:
                        sense = self.departures.clear_sign(state, event, values, 0)
                if sense < 0 and (depth is None or values[0] < depth):
                    if values[0] < 0 < values[1] and self.departures.passes_now(state, event, values):
                        continue  # a load by a formula comes back from nothing: it would slip for no time
                    worst, depth = event, values[0]
        return worst

    def _slips_as_said(
        self, state: State[N], status: Status, slipping: Sequence[int], clearly: bool = False
    ) -> bool:
        """Whether the ties that let go do so in the direction of their status, and stops part: by their first
        derivative that is not rounding alone, where there is one. `clearly`: or where there is none.
        """
        if not slipping:
            return True
        rows, count = self.departures.enter(state, status), len(status.frictions)
        for k in slipping:
            key, order = ((SLIDE, k), 1) if k < count else ((STRIKE, k - count), 2)
            event = self.departures.event(rows, key)
            values = self.departures.as_far_as_needed(event, order, {})
            sense = first_sign(values[order:])
            clear = self.departures.clear_sign(state, event, values, order)
            if clear != sense or self.departures.is_open(state, event, values, order):
                self.departures.doubt_event(state, status, event, LEAVES)
                sense = clear or (0 if clearly else sense)
            if sense < 0:
                return False
        return True

    def _consistent(self, state: State[N], status: Status, standing: Sequence[int]) -> bool:
        """Whether a combination of the ties `standing` is; none is in which others keep a friction from
        sliding that has let go: with that one as well they hold as much.
        """
        kept = self.maker.resting(status) & {*self._apart(status, standing)}
        if kept or not self.possible(status):
            return False
        rows = self.departures.enter(state, status)
        if self._overloaded(state, rows) is not None:
            return False
        return self._slips_as_said(state, status, self._apart(status, standing))

    def drift(self, status: Status, state: State[N]) -> list[N]:
        """Velocity of each column against its group, with those of belts by formulas [m/s]."""
        drift, sides = list(self.maker.tied(status).drift), self.departures.sides(status)
        for c, signs in enumerate(self.maker.tied(status).courses):
            for course, sense in signs.items():
                drift[c] = drift[c] + sense * course_velocity(course, self.kit, state.t, sides)
        return drift

    def join(self, state: State[N], rows: ModeRows[N], i: int) -> None:
        """Give the bodies that friction `i` ties their common velocity; momentum is kept where they move
        freely.
        """
        P, _ = self.maker.ends(self.scene.frictions[i])
        leader, n, drift = rows.leader[P], self.maker.n, self.drift(rows.status, state)
        members = [c for c in rows.groups.members[leader] if c < n]
        if leader >= n:
            common = self.kit.number(0) if leader == n else self.relative.base(state, "v")
        else:
            momenta = (self.scene.bodies[c].m * (state.v[c] - drift[c]) for c in members)
            common = total_of(self.kit, momenta) / rows.own_mass(leader)
        old = list(state.v)
        for c in members:
            state.v[c] = common + drift[c]
        for one in rows.rotors:
            if one.on in members:
                coupling = one.unbalance * self.kit.sin(state.x[one.column])
                state.v[one.column] = (
                    state.v[one.column] + coupling * (state.v[one.on] - old[one.on]) / one.inertia
                )


def combinations_count(standing: Iterable[int], frictions: int) -> int:
    """How many statuses `combinations_of` gives."""
    return prod(3 if k < frictions else 2 for k in standing)


def combinations_of(standing: Sequence[int], frictions: int) -> Iterator[dict[int, int]]:
    """Statuses {number: status} that ties may go on with: those where most hold first. A tie behind the
    `frictions` is a stop, which opens one way only.
    """
    for count in range(len(standing) + 1):
        for chosen in combinations(standing, count):
            for senses in product(*((FORWARD, BACKWARD) if k < frictions else (FORWARD,) for k in chosen)):
                yield dict.fromkeys(standing, STICK) | dict(zip(chosen, senses, strict=True))
