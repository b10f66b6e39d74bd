"""The return map: from the section to the section after n periods of the source or turns of a motor.

Its derivative is that of the motion, flow and saltation. Where the time of return T is free, it differs from
one start to the next: with the rates f at the end and the pinned component p (the angle of a motor),

    dP/dX = M - f m_p / f_p,    M = d X(T) / dX,    m_p = d p(T) / dX,

which has lost the multiplier 1 that a shift along the orbit brings.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf, isfinite, pi

import numpy as np

from vibsim.cases.problems import counted
from vibsim.engine.modes.status import RESTING, STICK
from vibsim.engine.resume import Row
from vibsim.engine.tangent.carried import Carried
from vibsim.engine.tangent.monodromy import Carrier
from vibsim.engine.trajectory import open_trajectory
from vibsim.lazy import once
from vibsim.orbits.coordinates import Coordinates, OrbitError, PoincareSection, placed, section_of
from vibsim.orbits.words import Word, at_once, in_order, word_of
from vibsim.physics.parts import Scene
from vibsim.physics.rates import natural_rates

TRIES = 20  # of the time of return
STILL = 1e-150  # rate of a pinned component (SI) that no disturbance can be divided by


@dataclass(eq=False)
class Return:
    """One motion from the section, of the duration T.

    X, T : the start, and the duration [s]
    image : the unknowns at the end
    ahead : by how much the pinned component is beyond the section at the end (motor: rad); 0 where T is known
    carried : the state, disturbances and events of the motion
    """

    coordinates: Coordinates
    X: np.ndarray
    T: float
    ahead: float
    carried: Carried

    @once
    def image(self) -> np.ndarray:
        return self.coordinates.in_turn_of(self.coordinates.of(self.carried.state), self.X)

    @once
    def flow_matrix(self) -> np.ndarray:
        """M = d X(T) / dX at the same T (m x m)."""
        return np.asarray(self.coordinates.of(self.carried.vectors).T)

    @once
    def rate(self) -> np.ndarray:
        """Rates of change of the unknowns at the end."""
        return self.coordinates.of(self.carried.rate)

    @once
    def tilt(self) -> tuple[np.ndarray, float] | None:
        """(d p(T) / dX, dp/dt) of the pinned component p; None where T is known."""
        p = self.coordinates.section.pinned
        return None if p is None else (self.carried.vectors[:, p], float(self.carried.rate[p]))

    @property
    def stands_still(self) -> bool:
        """Whether the pinned component does not move at the end, as a body that sticks to a belt: no time
        of return follows from a disturbance.
        """
        return self.tilt is not None and abs(self.tilt[1]) < STILL

    @once
    def derivative(self) -> np.ndarray:
        """dP/dX, the reduced monodromy matrix (m x m); its eigenvalues are the multipliers."""
        if self.tilt is None:
            return self.flow_matrix
        slopes, rate = self.tilt
        return self.flow_matrix - np.outer(self.rate, slopes / rate)

    @once
    def difference(self) -> np.ndarray:
        """image - X, what Newton's method brings to 0."""
        return np.asarray(self.image - self.X)

    @once
    def residual(self) -> float:
        """Weighed distance by which the motion fails to close [m/s]: difference, and the rest of the turn."""
        return max(self.coordinates.size(self.difference), self._missing)

    @property
    def _missing(self) -> float:
        """Remainder of the turn, as weighed [m/s]: of a motor, or the velocity of the body that turns."""
        if self.tilt is None:
            return 0.0
        if self.coordinates.section.turning:
            return abs(self.ahead)
        return abs(self.ahead / self.tilt[1]) * self.pace

    @once
    def pace(self) -> float:
        """Size of the rates of change at the end, as weighed [m/s^2]."""
        return self.coordinates.size(self.rate)

    @once
    def events(self) -> Word:
        """(kind, part) of what happened, in the order from the section."""
        events, scene = self.carried.events, self.coordinates.scene
        if len(scene.stops) > 1 or len(scene.frictions) > 1:
            return word_of(in_order(events, self.carried.times.tolist(), self.T, self._at_once))
        return word_of(events)

    def _at_once(self, i: int) -> bool:
        """Whether event i is due with the one before it but for rounding."""
        (kind, part), carried = self.carried.events[i], self.carried
        return at_once(self.coordinates.scene, kind, part, float(carried.times[i - 1]), carried.states[i - 1])

    @property
    def held(self) -> np.ndarray:
        """By the unknowns (k, m): velocities of ends against each other that stick or rest behind the last
        event, and distances of those that rest.
        """
        if not len(self.carried.codes):
            return np.empty((0, len(self.X)))
        scene, at = self.coordinates.scene, self.coordinates
        codes = self.carried.codes[-1].tolist()
        resting = [stop for stop, code in zip(scene.stops, codes, strict=False) if code == RESTING]
        sticking = [
            part
            for part, code in zip(scene.frictions, codes[len(scene.stops) :], strict=False)
            if code == STICK
        ]
        return np.array(
            [at.between(part, speed=True) for part in (*resting, *sticking)]
            + [at.between(part, speed=False) for part in resting]
        )

    @property
    def drift(self) -> dict[str, float]:
        """By name of body [m]."""
        return self.coordinates.drift(self.carried.state)

    @property
    def margin(self) -> float:
        """Smallest gap at a turn without contact [m]; inf without any."""
        return self.carried.margin

    @property
    def uncertified(self) -> int:
        return self.carried.uncertified


class ReturnMap:
    """From the section of `scene` to itself after n periods of its source, or turns of its motor.

    Another value of a parameter is another scene, and another ReturnMap. Raises NoSection where the scene has
    no section, OrbitError for no period.
    """

    def __init__(self, scene: Scene, n: int = 1) -> None:
        if n < 1:
            raise OrbitError(f"an orbit takes one period or more, got {n}")
        self.scene, self.n, self.section = scene, n, section_of(scene)
        self.coordinates = Coordinates(scene, self.section)
        self.carrier = Carrier(scene)

    def of(self, n: int) -> ReturnMap:
        """The map of the same scene after n returns."""
        other = object.__new__(ReturnMap)
        vars(other).update(vars(self), n=n)
        return other

    def at(self, scene: Scene) -> ReturnMap:
        """The map of another scene with the same bodies, on the same run of the engine by turns where that
        can be.
        """
        carrier = self.carrier.of(scene)
        if carrier is None:
            return ReturnMap(scene, self.n)
        other = object.__new__(ReturnMap)
        vars(other).update(vars(self), scene=scene, carrier=carrier)
        own = self.scene
        if self.section.timed and not (scene.forces is own.forces and scene.base is own.base):
            other.section = section_of(scene)
        other.coordinates = self.coordinates.of_scene(scene)
        return other

    def __call__(self, X: np.ndarray, T: float | None = None) -> Return:
        """The motion from the unknowns X, as `Return`; T [s] where the section does not tell it, estimated
        where it is left out. Raises EngineError where the run fails.
        """
        return self._motion(X, T, self.coordinates.disturbances)

    def plain(self, X: np.ndarray, T: float | None = None) -> Return:
        """The same without derivatives, which is faster."""
        return self._motion(X, T, self.coordinates.none)

    def _motion(self, X: np.ndarray, T: float | None, disturbances: np.ndarray) -> Return:
        if self.section.timed:
            T = self.section.time(self.n)
        elif T is None:
            T = self.time_of_return(X)
        at, X, T = self.coordinates, np.asarray(X, dtype="f8"), float(T)
        components = at.lifted(X).tolist()
        if not (all(map(isfinite, components)) and 0 < T < inf):
            raise OrbitError(f"a motion needs a finite start and a time after it, got {components} and {T} s")
        carried = self.carrier.carried(components, T, disturbances)
        return Return(at, X, T, self._ahead(carried), carried)

    def _ahead(self, carried: Carried) -> float:
        if self.section.timed:
            return 0.0
        return float(carried.state[self.section.component] - self.n * self.section.advance)

    def time_of_return(self, X: np.ndarray, T: float | None = None) -> float:
        """Time [s] after which the pinned component has advanced by n of its returns. Raises OrbitError where
        it does not.
        """
        if self.section.turning:
            return self._time_of_turns(X)
        target, state = self.n * self.section.advance, self.coordinates.lifted(X)
        p = self.section.component
        pace = self.section.speed
        speed = state[pace]
        T = T or (target / speed if speed > 0 else target / self._fastest_speed())
        for _ in range(TRIES):
            carried = self.carrier.carry(state, T, [])
            missing, speed = target - carried.state[p], carried.rate[p]
            if abs(missing) < 1e-9 * target:
                return T
            T = min(max(T + missing / speed if speed > 0 else 1.5 * T, T / 2), 2 * T)
        raise OrbitError(f"the rotor does not come to turn {self.n} within {T:.4g} s")

    def _time_of_turns(self, X: np.ndarray) -> float:
        scene = placed(self.scene, self.coordinates.state(X), MANY * self.n * slowest_period(self.scene))
        times, _ = returns(scene, self.coordinates, first=self.n)
        if len(times) < self.n:
            raise OrbitError(
                f"{self.section.body} does not turn round {counted(self.n, 'time')} "
                f"within {scene.t_end:.4g} s"
            )
        return float(times[self.n - 1])

    def _fastest_speed(self) -> float:
        """Of the motor without load, or of the rotor at the start of the case [rad/s]."""
        if self.scene.motor is not None:
            return self.scene.motor.Omega0
        return abs(self.scene.bodies[self.section.component].v) or 1.0


# Runs of scenes that nothing drives, seen where a body turns round: the returns to their section.
#
# The section is met where the velocity of the body comes through zero, at its least or its greatest
# displacement. A run is sampled finely against its fastest vibration, and each crossing is found on the flow.


SAMPLES = 64  # in a period of the fastest vibration, all elastic stops in contact
FINEST = 10**9  # of a second: what times of samples are whole multiples of
LEAST = 1e-9  # share of a step: a motion needs some time
STEPS = 4  # of Newton's method for a crossing
MANY = 128  # slowest periods that a run is followed where it is not said how long


def slowest_period(scene: Scene) -> float:
    """Of the slowest natural vibration [s]. Raises OrbitError where nothing vibrates."""
    return 2 * pi / _rates(scene)[0]


def _rates(scene: Scene) -> list[float]:
    rates = natural_rates(scene, scene.stops)
    if not rates:
        raise OrbitError(
            "near the start of the case no spring or formula brings a body back, so nothing sets how long a "
            "swing takes; start the case where one does"
        )
    return rates


def returns(
    scene: Scene,
    at: Coordinates,
    resume: Sequence[Row] | None = None,
    first: int | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Times [s] and state components (n, N) where a run of `scene` meets its section.

    at : `Coordinates` of the scene; resume : event rows to go on from, as of `open_trajectory`
    first : so many are enough. Raises EngineError where the run fails.
    """
    step = max(1, int(FINEST * 2 * pi / _rates(scene)[-1] / SAMPLES))
    sampled = replace(scene, every_num=step, every_den=FINEST, stop_on_violation=False)
    carrier, p = Carrier(scene), at.section.component
    times, states, last = [], [], np.empty((1 + len(at.components), 0))
    for block in open_trajectory(sampled, resume).blocks():
        rows = np.vstack([block.samples["time"], at.gathered(block.samples).T])
        rows = np.concatenate([last, rows], axis=1)
        rates = at.section.sense * rows[1 + p]
        for i in np.flatnonzero((rates[:-1] < 0) & (rates[1:] >= 0)):
            passed, state = _crossing(carrier, rows[1:, i], rows[0, i + 1] - rows[0, i], at.section)
            times.append(rows[0, i] + passed)
            states.append(state)
        if first is not None and len(times) >= first:
            break
        last = rows[:, -1:]
    return np.array(times), np.array(states).reshape(-1, len(at.components))


def _crossing(
    carrier: Carrier, state: np.ndarray, step: float, section: PoincareSection
) -> tuple[float, np.ndarray]:
    """(time, state) of the crossing within a step behind a state."""
    s = step / 2
    for _ in range(STEPS):
        there = carrier.carry(state, s, [])
        v, a = there.state[section.component], there.rate[section.component]
        if section.sense * a > 0:
            s = min(max(s - v / a, LEAST * step), step)
    return s, carrier.carry(state, s, []).state
