"""A second solver of scenes with formulas: Newton's equations stated anew, Runge-Kutta steps, located events.

It shares nothing with vibsim: mass matrix of rotors on bodies from the kinetic energy, friction as the
force of a constraint while it sticks, sides of switches fixed from event to event. Between events SciPy's
DOP853 integrates; each zero is found on its dense output, and met by integrating to it and Newton's method.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import Any

import numpy as np
from scipy.integrate import DOP853, solve_ivp
from scipy.optimize import brentq, minimize_scalar

from tests.formulas.second_expressions import Compiled
from tests.formulas.second_model import BASE, GROUND, Friction, Model, Rotor, Stop

FIRST_STEP = 1e-6  # s: p**1.5 has no fourth derivative where a contact begins, which longer steps overlook
GRID = 8  # places in a step at which event functions are looked at
SAME = 1e-9  # relative, below which two values of a formula are one: no jump


class TooHard(Exception):
    """The second solver cannot follow the motion: endless impacts, or a number that is none."""


@dataclass
class Mode:
    """contacts: 0 open, 1 pressed, 2 within its depth without force; frictions: slip +1, -1 or stick 0."""

    contacts: list[int]
    frictions: list[int]
    sides: dict[int, int]


class SecondSolver:
    """Runs a model; `events` [(t, kind, part)], `states` at the times asked for."""

    def __init__(self, model: Model, tolerance: float = 1e-12) -> None:
        self.model, self.tolerance = model, tolerance
        self.names = list(model.bodies)
        n, r = len(self.names), len(model.rotors)
        self.n, self.r = n, r
        columns = {f"x_{b}": f"y[{i}]" for i, b in enumerate(self.names)}
        columns |= {f"v_{b}": f"y[{n + i}]" for i, b in enumerate(self.names)}
        columns |= {f"phi_{o.name}": f"y[{2 * n + k}]" for k, o in enumerate(model.rotors)}
        columns |= {f"w_{o.name}": f"y[{2 * n + r + k}]" for k, o in enumerate(model.rotors)}
        columns |= {z: f"y[{2 * n + 2 * r + k}]" for k, z in enumerate(model.states)}
        self.columns = columns
        self.compiled = Compiled({**columns, "t": "t", "pi": "np.pi"})
        self._compile()
        start = [b[1] for b in model.bodies.values()] + [b[2] for b in model.bodies.values()]
        start += [o.phi for o in model.rotors] + [o.w for o in model.rotors]
        self.y = np.array(start + [z[1] for z in model.states.values()], dtype=float)
        self.t = 0.0
        self.events: list[tuple[float, str, str]] = []
        self.least_margin = inf

    # What formulas are, with the names of their places.

    def _compile(self) -> None:
        make, model = self.compiled.function, self.model
        self.base = (
            [make(e, "base") for e in (model.base.x, model.base.v, model.base.a)] if model.base else None
        )
        motion = self.base or (_still, _still)
        self.compiled.functions |= dict(zip(("base_x", "base_v"), motion, strict=False))
        self.of_links = [make(o.force, o.name, self._relative(o)) for o in model.links]
        self.of_stops = [
            make(o.force, o.name, self._depth(o)) if o.force is not None else None for o in model.stops
        ]
        self.of_forces = [make(o.force, o.name) for o in model.forces]
        self.of_torques = [
            make(o.torque, o.name, self._turning(o)) if o.torque is not None else None for o in model.rotors
        ]
        self.rates = [make(rate, name) for name, (rate, _) in model.states.items()]
        self.slips, self.holds = [], []
        zero = {"s": "0.0"}
        for o in model.frictions:
            v = f"({self._end('v', o.P)} - {self._end('v', o.Q)} - {o.belt!r})"
            sides = [make(o.mu, f"{o.name}|{sign}", {"s": f"({sign}1*{v})"}) for sign in "+-"]
            load = make(o.load, o.name)
            self.slips.append((load, sides))
            self.holds.append((load, make(o.mu, f"{o.name}|0", zero), o.static))

    def _end(self, column: str, end: str) -> str:
        if end == GROUND:
            return "0.0"
        if end == BASE:
            return f"base_{column}(t, y, S)"
        return self.columns[f"{column}_{end}"]

    def _relative(self, o) -> dict[str, str]:
        return {
            "d": f"({self._end('x', o.P)} - {self._end('x', o.Q)})",
            "v": f"({self._end('v', o.P)} - {self._end('v', o.Q)})",
        }

    def _turning(self, o: Rotor) -> dict[str, str]:
        own = {"phi": self.columns[f"phi_{o.name}"], "w": self.columns[f"w_{o.name}"]}
        return own | {"m": repr(o.m), "e": repr(o.e), "J": repr(o.J)}

    def _depth(self, o: Stop) -> dict[str, str]:
        places = self._relative(o)
        return {"p": f"({o.sense}*{places['d']} - {o.gap!r})", "pv": f"({o.sense}*{places['v']})"}

    # The balance of forces.

    def motion(self, t, y, end, order) -> float:
        """Displacement (order 0) or velocity (1) of an end."""
        if end == GROUND:
            return 0.0
        if end == BASE:
            return self.base[order](t, y, {}) if self.base else 0.0
        return y[order * self.n + self.names.index(end)]

    def between(self, t, y, o, order) -> float:
        """The same of the first end of a part against the second."""
        return self.motion(t, y, o.P, order) - self.motion(t, y, o.Q, order)

    def _row(self, o) -> np.ndarray:
        """Of the relative motion of a part in the coordinates."""
        row = np.zeros(self.n + self.r)
        for end, sign in ((o.P, 1.0), (o.Q, -1.0)):
            if end in self.names:
                row[self.names.index(end)] = sign
        return row

    def mass(self, y) -> np.ndarray:
        """From T = sum m x'^2/2 + sum [m (x' - e sin(phi) phi')^2 + m (e cos(phi) phi')^2 + J phi'^2]/2."""
        n = self.n
        M = np.diag(
            [b[0] for b in self.model.bodies.values()] + [o.J + o.m * o.e**2 for o in self.model.rotors]
        )
        for k, o in enumerate(self.model.rotors):
            i, j = self.names.index(o.on), n + k
            M[i, i] += o.m
            M[i, j] = M[j, i] = -o.m * o.e * np.sin(y[2 * n + k])
        return M

    def _applied(self, t, y, mode: Mode) -> np.ndarray:
        """Forces on the coordinates, but those of what sticks."""
        model, S, n = self.model, mode.sides, self.n
        Q = np.zeros(n + self.r)
        for o, force in zip(model.links, self.of_links, strict=True):
            Q -= self._row(o) * force(t, y, S)
        for o, force, contact in zip(model.stops, self.of_stops, mode.contacts, strict=True):
            if contact == 1:
                Q -= o.sense * self._row(o) * force(t, y, S)
        for o, (load, sides), side in zip(model.frictions, self.slips, mode.frictions, strict=True):
            if side:
                N = max(load(t, y, S), 0.0)
                Q -= side * self._row(o) * N * sides[0 if side > 0 else 1](t, y, S)
        for o, force in zip(model.forces, self.of_forces, strict=True):
            Q[self.names.index(o.on)] += force(t, y, S)
        for k, (o, torque) in enumerate(zip(model.rotors, self.of_torques, strict=True)):
            phi, w = y[2 * n + k], y[2 * n + self.r + k]
            Q[self.names.index(o.on)] += o.m * o.e * np.cos(phi) * w * w
            if torque is not None:
                Q[n + k] += torque(t, y, S)
        return Q

    def solved(self, t, y, mode: Mode) -> tuple[np.ndarray, dict[int, float]]:
        """Accelerations, and the friction on P of each part that sticks [N]."""
        M, Q = self.mass(y), self._applied(t, y, mode)
        stuck = [i for i, side in enumerate(mode.frictions) if side == 0]
        if not stuck:
            return np.linalg.solve(M, Q), {}
        B = np.array([self._row(self.model.frictions[i]) for i in stuck])
        wanted = np.zeros(len(stuck))
        for k, i in enumerate(stuck):
            o = self.model.frictions[i]
            for end, sign in ((o.P, -1.0), (o.Q, 1.0)):
                if end == BASE and self.base:
                    wanted[k] += sign * self.base[2](t, y, {})
        size = len(Q)
        K = np.block([[M, -B.T], [B, np.zeros((len(stuck), len(stuck)))]])
        solution = np.linalg.solve(K, np.concatenate([Q, wanted]))
        return solution[:size], dict(zip(stuck, solution[size:], strict=True))

    def rhs(self, t, y, mode: Mode) -> np.ndarray:
        n, r = self.n, self.r
        a, _ = self.solved(t, y, mode)
        rates = [rate(t, y, mode.sides) for rate in self.rates]
        return np.concatenate([y[n : 2 * n], a[:n], y[2 * n + r : 2 * n + 2 * r], a[n:], rates])

    # What ends a mode.

    def functions(self, mode: Mode) -> list[tuple[Any, Any]]:
        """[(key, (t, y) -> value)]: positive as long as the mode lasts."""
        found: list[tuple[Any, Any]] = []
        for i, o in enumerate(self.model.stops):
            found += self._of_stop(i, o, mode)
        for i, o in enumerate(self.model.frictions):
            found += self._of_friction(i, o, mode)
        for i in mode.sides:
            for k in range(2 if self.compiled.switches[i].kind in ("mod", "table") else 1):
                found.append((("switch", i, k), lambda t, y, i=i, k=k: self._margin(i, k, t, y, mode)))
        return found

    def _margin(self, i, k, t, y, mode) -> float:
        margins = self.compiled.switches[i].margins(mode.sides[i], t, y, mode.sides)
        return margins[k][0] if k < len(margins) else 1.0

    def depth(self, t, y, o: Stop) -> float:
        return o.sense * self.between(t, y, o, 0) - o.gap

    def _of_stop(self, i, o, mode):
        state = mode.contacts[i]
        if state == 0:
            return [(("open", i), lambda t, y: -self.depth(t, y, o))]
        functions = [(("depth", i), lambda t, y: self.depth(t, y, o))]
        if state == 2 or o.release == "force":
            sign = 1 if state == 1 else -1
            functions.append((("force", i), lambda t, y: sign * self.of_stops[i](t, y, mode.sides)))
        return functions

    def slip(self, t, y, o: Friction) -> float:
        return self.between(t, y, o, 1) - o.belt

    def hold(self, i, t, y, mode) -> float:
        load, mu, static = self.holds[i]
        return static * mu(t, y, mode.sides) * max(load(t, y, mode.sides), 0.0)

    def _of_friction(self, i, o, mode):
        side = mode.frictions[i]
        if side:
            return [(("slip", i), lambda t, y: side * self.slip(t, y, o))]

        def spare(t, y, sign):
            return self.hold(i, t, y, mode) - sign * self.solved(t, y, mode)[1][i]

        return [
            (("stick+", i), lambda t, y: spare(t, y, -1)),  # it would slip forwards
            (("stick-", i), lambda t, y: spare(t, y, 1)),
        ]

    # Switches that are awake, and their sides.

    def _awake(self, mode: Mode) -> list[int]:
        model = self.model
        owners = {o.name for o in (*model.links, *model.forces, *model.rotors, *model.frictions)}
        owners |= {*model.states}
        owners |= {o.name for o, contact in zip(model.stops, mode.contacts, strict=True) if contact}
        sides = zip(model.frictions, mode.frictions, strict=True)
        owners |= {f"{o.name}|{'0' if side == 0 else '+' if side > 0 else '-'}" for o, side in sides}
        return [i for i, switch in enumerate(self.compiled.switches) if switch.owner in owners]

    def with_sides(self, t, y, mode: Mode, turned: dict[int, int] | None = None) -> Mode:
        """The mode with the sides of all switches that are awake, those of before as they were."""
        sides: dict[int, int] = {}
        for i in self._awake(mode):
            if turned and i in turned:
                sides[i] = turned[i]
            elif i in mode.sides:
                sides[i] = mode.sides[i]
            else:
                sides[i] = self.compiled.switches[i].side(t, y, {**mode.sides, **sides})
        return Mode(mode.contacts, mode.frictions, sides)

    # The run.

    def initial(self) -> Mode:
        model = self.model
        contacts = [0 if self.depth(0.0, self.y, o) < 0 else 1 for o in model.stops]
        slips = [self.slip(0.0, self.y, o) for o in model.frictions]
        frictions = [0 if s == 0 else 1 if s > 0 else -1 for s in slips]
        mode = self.with_sides(0.0, self.y, Mode(contacts, frictions, {}))
        return self._settled(0.0, self.y, mode, record=False)

    def run(self, times) -> np.ndarray:
        """States at ascending times, the last one the end of the run."""
        mode, states = self.initial(), []
        for until in times:
            while self.t < until:
                mode = self._stretch(mode, until)
            states.append(self.y.copy())
        return np.array(states)

    def _stretch(self, mode: Mode, until: float) -> Mode:
        """To the next event, or to `until`."""
        functions = self.functions(mode)
        solver = self._solver(mode, self.t, self.y, until)
        while solver.status == "running":
            solver.step()
            if solver.status == "failed" or not np.all(np.isfinite(solver.y)):
                raise TooHard("a step failed")
            event = self._first_zero(solver, functions)
            if event is not None:
                key, function, bracket = event
                self._arrive(solver, mode, function, bracket)
                return self._behind(mode, key)
        self.t, self.y = until, solver.y.copy()
        return mode

    def _solver(self, mode, t, y, until):
        first = min(FIRST_STEP, (until - t) / 2)
        return DOP853(
            lambda t, y: self.rhs(t, y, mode),
            t,
            y,
            until,
            rtol=self.tolerance,
            atol=self.tolerance * 1e-2,
            max_step=0.02,
            first_step=first,
        )

    def _first_zero(self, solver, functions):
        """(key, function, bracket) of the function that turns negative first."""
        dense, a, b = solver.dense_output(), solver.t_old, solver.t
        grid = np.linspace(a, b, GRID + 1)
        ys = [dense(t) for t in grid]
        best = None
        for key, function in functions:
            values = [function(t, y) for t, y in zip(grid, ys, strict=True)]
            bracket = self._bracket(function, dense, grid, values)
            if bracket and (best is None or bracket[1] < best[2][1]):
                best = (key, function, bracket)
        if best is None:
            return None
        key, function, (low, high) = best  # of several in one place, the first zero
        found = [
            (self._root(f, dense, *w), k, f) for k, f in functions if (w := self._window(f, dense, low, high))
        ]
        when, key, function = min(
            [(self._root(function, dense, low, high), key, function), *found], key=lambda r: r[0]
        )
        return key, function, when

    def _window(self, function, dense, low, high):
        values = [function(t, dense(t)) for t in (low, high)]
        return (low, high) if values[0] > 0 > values[1] else None

    def _bracket(self, function, dense, grid, values):
        for j in range(1, len(grid)):
            if values[j] < 0:
                low = grid[j - 1]
                if values[j - 1] <= 0 or j == 1:
                    low = self._behind_start(function, dense, grid[j - 1], grid[j])
                return (low, grid[j])
            if 1 <= j < len(grid) - 1 and values[j] < values[j - 1] and values[j] < values[j + 1]:
                touch = self._least(function, dense, grid[j - 1], grid[j + 1])
                if touch is not None:
                    return (grid[j - 1], touch)
        return None

    def _least(self, function, dense, a, b):
        """Where a function is least between a and b, if it is negative there."""
        result = minimize_scalar(
            lambda t: function(t, dense(t)), bounds=(a, b), method="bounded", options={"xatol": 1e-13}
        )
        return result.x if result.fun < 0 else None

    @staticmethod
    def _behind_start(function, dense, a, b):
        """A time behind a at which the function is positive; a itself where there is none."""
        for k in range(1, 40):
            t = a + (b - a) * 0.5**k
            if function(t, dense(t)) > 0:
                return t
        return a

    @staticmethod
    def _root(function, dense, a, b):
        if function(a, dense(a)) <= 0:
            return a
        return brentq(lambda t: function(t, dense(t)), a, b, xtol=1e-15, rtol=1e-15)

    def _arrive(self, solver, mode, function, when) -> None:
        """Integrate to the zero anew, and correct it by Newton's method."""
        t0, y0 = solver.t_old, solver.y_old
        t, y = when, y0
        if when > t0:
            y = self._integrated(mode, t0, y0, when)
            for _ in range(3):
                f, step = function(t, y), 1e-7
                slope = (function(t + step, y + step * self.rhs(t, y, mode)) - f) / step
                if slope == 0 or not abs(f / slope) < 1e-6:
                    break
                change = -f / slope
                y, t = self._small_step(mode, t, y, change), t + change
        self.t, self.y = t, y

    def _integrated(self, mode, t0, y0, t):
        done = solve_ivp(
            lambda t, y: self.rhs(t, y, mode),
            (t0, t),
            y0,
            "DOP853",
            rtol=max(self.tolerance / 10, 3e-14),
            atol=self.tolerance * 1e-3,
        )
        return done.y[:, -1]

    def _small_step(self, mode, t, y, h):
        middle = y + h / 2 * self.rhs(t, y, mode)
        return y + h * self.rhs(t + h / 2, middle, mode)

    # What follows an event.

    def _record(self, kind, part) -> None:
        self.events.append((self.t, kind, part))
        if len(self.events) > 3000:
            raise TooHard("too many events")

    def _behind(self, mode: Mode, key) -> Mode:
        kind, i = key[0], key[1]
        contacts, frictions = list(mode.contacts), list(mode.frictions)
        turned: dict[int, int] = {}
        t, y = self.t, self.y
        if kind == "open":
            o = self.model.stops[i]
            if o.e is not None:
                self._impact(mode, i)
                anew = self.with_sides(t, self.y, Mode(contacts, frictions, {}))
                return self._settled(t, self.y, anew)
            contacts[i] = 1
            self._record("contact_begin", o.name)
        elif kind == "depth":
            if contacts[i] == 1:
                self._record("contact_end", self.model.stops[i].name)
            contacts[i] = 0
        elif kind == "force":
            self._record("contact_end" if contacts[i] == 1 else "contact_begin", self.model.stops[i].name)
            contacts[i] = 2 if contacts[i] == 1 else 1
        elif kind == "slip":
            return self._at_rest(mode, i)
        elif kind in ("stick+", "stick-"):
            frictions[i] = 1 if kind == "stick+" else -1
            self._record("stick_end", self.model.frictions[i].name)
        else:
            margins = self.compiled.switches[i].margins(mode.sides[i], t, y, mode.sides)
            turned[i] = margins[key[2]][1]
            if self._jumps(mode, turned):
                self._record("switch", self.compiled.switches[i].owner.partition("|")[0])
        new = self.with_sides(t, y, Mode(contacts, frictions, mode.sides), turned)
        return self._settled(t, y, new)

    def _jumps(self, mode, turned) -> bool:
        after = Mode(mode.contacts, mode.frictions, {**mode.sides, **turned})
        t, y = self.t, self.y
        pairs = [
            (f(t, y, mode.sides), f(t, y, after.sides))
            for f in (*self.of_links, *self.of_forces, *self.rates)
        ]
        pairs += [
            (f(t, y, mode.sides), f(t, y, after.sides))
            for f, contact in zip(self.of_stops, mode.contacts, strict=True)
            if contact and f
        ]
        pairs += [(f(t, y, mode.sides), f(t, y, after.sides)) for f in self.of_torques if f]
        pairs += [(load(t, y, mode.sides), load(t, y, after.sides)) for load, _ in self.slips]
        scale = 1 + max(abs(a) for a, _ in pairs)
        return any(abs(a - b) > SAME * scale for a, b in pairs)

    def _at_rest(self, mode: Mode, i: int) -> Mode:
        """A slip comes to zero: all stick at first, then the one that is overloaded most lets go, ..."""
        frictions = list(mode.frictions)
        frictions[i] = 0
        tied = self.with_sides(self.t, self.y, Mode(mode.contacts, frictions, mode.sides))
        settled = self._settled(self.t, self.y, tied, record=False)
        self._record_changes(tied, settled, {i})
        if settled.frictions[i] == 0:
            self._record("stick_begin", self.model.frictions[i].name)
        elif settled.frictions[i] != mode.frictions[i]:
            self._record("reversal", self.model.frictions[i].name)
        return settled

    def _record_changes(self, before: Mode, after: Mode, but: set[int]) -> None:
        """The sticks that have ended."""
        pairs = zip(before.frictions, after.frictions, strict=True)
        for i, (one, other) in enumerate(pairs):
            if i not in but and one == 0 != other:
                self._record("stick_end", self.model.frictions[i].name)

    def _settled(self, t, y, mode: Mode, record: bool = True) -> Mode:
        """Let go what cannot hold."""
        before = mode
        for _ in range(8):
            forces = self.solved(t, y, mode)[1]
            over = {i: abs(f) - self.hold(i, t, y, mode) for i, f in forces.items()}
            worst = max(over, key=lambda i: over[i], default=None)
            if worst is None or over[worst] <= 1e-9 * (1 + abs(forces[worst])):
                if record:
                    self._record_changes(before, mode, set())
                return mode
            frictions = list(mode.frictions)
            frictions[worst] = -1 if forces[worst] > 0 else 1
            mode = self.with_sides(t, y, Mode(mode.contacts, frictions, mode.sides))
        raise TooHard("frictions that do not settle")

    def _impact(self, mode: Mode, i: int) -> None:
        o = self.model.stops[i]
        n, r, row = self.n, self.r, o.sense * self._row(o)
        rate = o.sense * self.between(self.t, self.y, o, 1)
        if rate < 1e-5:
            raise TooHard("an impact too slow to follow")
        kick = np.linalg.solve(self.mass(self.y), row)
        impulse = -(1 + o.e) * rate / (row @ kick)
        change = impulse * kick
        self.y = self.y.copy()
        self.y[n : 2 * n] += change[:n]
        self.y[2 * n + r : 2 * n + 2 * r] += change[n:]
        self._record("impact", o.name)


def _still(t, y, S) -> float:
    """The motion of a base that rests."""
    return 0.0
