"""One or two bodies on a line under constant forces and Coulomb friction, between rigid stops: parabolas
from event to event, in decimals. It knows nothing of vibsim, and follows hops down to 1e-40 m/s.

Ties hold where forces within their limits can keep them; of several modes that with most ties is taken.
"""

from dataclasses import dataclass
from decimal import Decimal, getcontext
from itertools import product

getcontext().prec = 120
ZERO, HALF = Decimal(0), Decimal("0.5")
# speeds [m/s] and gaps [m] that are none, such as these speeds make
STILL, SHUT = Decimal("1e-40"), Decimal("1e-76")
FAR = Decimal("1e9")  # of a force that has no limit [N]
GROUND = -1


@dataclass(frozen=True)
class Rub:
    """Friction between P and Q: limits while slipping and sticking [N], speed of the belt [m/s]."""

    P: int
    Q: int
    slide: Decimal
    stick: Decimal
    belt: Decimal


@dataclass(frozen=True)
class Wall:
    """A rigid stop: x_P - x_Q is never more than its gap [m]; restitution e."""

    P: int
    Q: int
    gap: Decimal
    e: Decimal


@dataclass
class Line:
    """Masses, places, speeds and forces of the bodies, and what is between them."""

    m: list
    x: list
    v: list
    F: list
    rubs: list
    walls: list

    def difference(self, part, of):
        return of[part.P] - (ZERO if part.Q == GROUND else of[part.Q])

    def slip(self, rub):
        return self.difference(rub, self.v) - rub.belt

    def depth(self, wall):
        return self.difference(wall, self.x) - wall.gap

    def touches(self, wall):
        return abs(self.depth(wall)) < SHUT

    def run(self, times):
        """Places at the times [s]: a list of lists."""
        rows, now, left = [], ZERO, list(times)
        while left:
            A = self._accelerations()
            after, struck = self._next(A)
            while left and (after is None or left[0] < now + after):
                dt = left.pop(0) - now
                rows.append([x + dt * (v + HALF * dt * a) for x, v, a in zip(self.x, self.v, A, strict=True)])
            if not left:
                break
            self.x = [x + after * (v + HALF * after * a) for x, v, a in zip(self.x, self.v, A, strict=True)]
            self.v = [v + after * a for v, a in zip(self.v, A, strict=True)]
            now += after
            assert all(self.depth(wall) < SHUT for wall in self.walls), "ends have passed each other"
            if struck:
                self._strike()
        return rows

    def _next(self, A):
        """When the next stop is struck or the next friction stands [s], and whether it is a stop."""
        found = []
        for wall in self.walls:
            d, rate, a = self.depth(wall), self.difference(wall, self.v), self.difference(wall, A)
            if abs(d) < SHUT:
                d = ZERO
                if abs(rate) < STILL:
                    continue  # rests, or parts by its acceleration
            when = _root(d, rate, a)
            if when is not None:
                found.append((when, True))
        for rub in self.rubs:
            slip, a = self.slip(rub), self.difference(rub, A)
            if abs(slip) > STILL and slip * a < 0:
                found.append((-slip / a, False))
        return min(found, default=(None, False))

    def _strike(self):
        """Newton's and Moreau's law over all stops that touch, again as long as one closes."""
        while True:
            walls = [wall for wall in self.walls if self.touches(wall)]
            before = [self.difference(wall, self.v) for wall in walls]
            before = [ZERO if abs(rate) < STILL else rate for rate in before]
            if not any(rate > 0 for rate in before):
                return
            for active in sorted(product((False, True), repeat=len(walls)), key=sum):
                impulses = self._impulses(walls, before, active)
                if impulses is None or any(one < 0 for one in impulses):
                    continue
                v = self._behind(walls, impulses)
                met = zip(walls, before, strict=True)
                if all(self.difference(wall, v) + wall.e * rate < SHUT for wall, rate in met):
                    self.v = v
                    break

    def _behind(self, walls, impulses):
        v = list(self.v)
        for wall, impulse in zip(walls, impulses, strict=True):
            v[wall.P] -= impulse / self.m[wall.P]
            if wall.Q != GROUND:
                v[wall.Q] += impulse / self.m[wall.Q]
        return v

    def _impulses(self, walls, before, active):
        """Impulses of the active stops that give these -e times their rates; None where they cannot."""
        on = [i for i, one in enumerate(active) if one]
        G = [[self._coupling(walls[i], walls[j]) for j in on] for i in on]
        need = [(1 + walls[i].e) * before[i] for i in on]
        solved = []
        if len(on) == 1:
            solved = [need[0] / G[0][0]]
        elif len(on) == 2:
            det = G[0][0] * G[1][1] - G[0][1] * G[1][0]
            if abs(det) < SHUT:
                return None
            solved = [
                (need[0] * G[1][1] - need[1] * G[0][1]) / det,
                (need[1] * G[0][0] - need[0] * G[1][0]) / det,
            ]
        impulses = [ZERO] * len(walls)
        for i, value in zip(on, solved, strict=True):
            impulses[i] = value
        return impulses

    def _coupling(self, a, b):
        total = ZERO
        for end, sign in ((a.P, 1), (a.Q, -1)):
            for other, factor in ((b.P, 1), (b.Q, -1)):
                if end == other != GROUND:
                    total += sign * factor / self.m[end]
        return total

    def _standing(self):
        """Of each friction whether it stands."""
        return [abs(s) < STILL for s in map(self.slip, self.rubs)]

    def _accelerations(self):
        """Accelerations in the mode that is consistent now; what joining ends has made stand may stick."""
        while True:
            standing, A = self._standing(), self._consistent()
            if self._standing() == standing:
                return A

    def _consistent(self):
        rubs = [(0, 1, -1) if abs(s) < STILL else (1 if s > 0 else -1,) for s in map(self.slip, self.rubs)]
        walls = []
        for wall in self.walls:
            stands = self.touches(wall) and abs(self.difference(wall, self.v)) < STILL
            walls.append((0, 1) if stands else (1,))  # 0: tied
        for mode in sorted(product(*rubs, *walls), key=lambda mode: sum(state != 0 for state in mode)):
            A = self._tried(mode[: len(rubs)], mode[len(rubs) :], rubs, walls)
            if A is not None:
                parts = zip([*self.rubs, *self.walls], mode, strict=True)
                self._join([part for part, state in parts if state == 0])
                return A
        raise AssertionError("no consistent mode")

    def _join(self, ties):
        """Take from tied ends what is left of their speeds against each other, less than 1e-40 m/s."""
        for tie in ties:
            carried = ZERO if tie.Q == GROUND else self.v[tie.Q]
            self.v[tie.P] = carried + (tie.belt if isinstance(tie, Rub) else ZERO)

    def _tried(self, senses, opened, rubs, walls):
        """Accelerations where frictions slip with these senses, 0 for stick, and stops are open; or None."""
        n = len(self.m)
        group, force = list(range(n + 1)), list(self.F)  # the last is the ground
        ties = [rub for rub, s in zip(self.rubs, senses, strict=True) if s == 0]
        ties += [wall for wall, one in zip(self.walls, opened, strict=True) if one == 0]
        for rub, s in zip(self.rubs, senses, strict=True):
            force[rub.P] -= s * rub.slide
            if rub.Q != GROUND:
                force[rub.Q] += s * rub.slide
        for tie in ties:
            old, new = group[tie.P], group[tie.Q]
            group = [new if one == old else one for one in group]
        A = []
        for i in range(n):
            mates = [k for k in range(n) if group[k] == group[i]]
            free = group[i] != group[GROUND]
            A.append(sum(force[k] for k in mates) / sum(self.m[k] for k in mates) if free else ZERO)
        for rub, s, choices in zip(self.rubs, senses, rubs, strict=True):
            if s and len(choices) > 1 and s * self.difference(rub, A) <= 0:
                return None
        for wall, one, choices in zip(self.walls, opened, walls, strict=True):
            if one and len(choices) > 1 and self.difference(wall, A) >= 0:
                return None
        return A if self._held(A, force, ties) else None

    def _held(self, A, force, ties):
        """Whether the ties can give what the accelerations need: limits of the force on the first body by the
        second, and of those by the ground.
        """
        n = len(self.m)
        ground, between = [[ZERO, ZERO] for _ in range(n)], [ZERO, ZERO]
        for tie in ties:
            low, high = (-tie.stick, tie.stick) if isinstance(tie, Rub) else (-FAR, ZERO)
            if tie.Q == GROUND:
                ground[tie.P] = [ground[tie.P][0] + low, ground[tie.P][1] + high]
            elif tie.P == 0:
                between = [between[0] + low, between[1] + high]
            else:
                between = [between[0] - high, between[1] - low]
        needs = [m * a - f for m, a, f in zip(self.m, A, force, strict=True)]
        low, high = between
        low, high = max(low, needs[0] - ground[0][1]), min(high, needs[0] - ground[0][0])
        if n == 2:
            low, high = max(low, ground[1][0] - needs[1]), min(high, ground[1][1] - needs[1])
        return low <= high + SHUT


def _root(d, rate, a):
    """The first time [s] at which d + rate t + a t^2 / 2 comes up to 0 from below; None without any."""
    if d == 0 and rate > 0:  # another stop has just set it into motion
        return ZERO
    if d == 0:
        return -2 * rate / a if rate < 0 < a else None
    if a == 0:
        return -d / rate if rate > 0 else None
    square = rate * rate - 2 * a * d
    if square < 0 or (a < 0 and rate <= 0):
        return None
    root = square.sqrt()
    return -2 * d / (rate + root)
