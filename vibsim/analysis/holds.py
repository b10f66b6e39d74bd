"""Stretches in which the mean speed of a motor stays within a narrow band, and how much they delay it.

Without vibration the motor would run up as Omega0 (1 - exp(-t/T)), T = Omega0 (J + m3 e^2)/M0, and pass the
band from w1 to w2 in T ln((Omega0 - w1)/(Omega0 - w2)). A hold that lasts n times as long is one in which
the vibration takes up the share 1 - 1/n of the torque.
"""

from collections import deque
from dataclasses import dataclass
from math import inf

import numpy as np

from vibsim.analysis.cycles import TURN
from vibsim.physics.arithmetic import elementary
from vibsim.physics.arithmetic.sums import mean
from vibsim.physics.parts import Motor

TURNS = 12  # to average over: a multiple of the periods 1, 2, 3, 4 and 6 that the motion may have
BAND = 0.03  # half width of the band, relative; beside a resonance the mean speed beats by about 2 %
LEAST_TURNS = 20  # of a hold
DELAY = 3.0  # least delay that is called lingering
MOST_MEANS = 20_000  # of a run; longer ones are thinned


@dataclass(frozen=True)
class Hold:
    """A stretch in which the mean speed stays within the band.

    Attributes
    ----------
    begin, end : [s]
    speed_hz : mean over it [Hz]
    turns : of the rotor
    below_no_load : 1 - speed / no-load speed, the share of the stall torque that drives
    delay : its length over the time in which the free motor would pass the band; 0 where it never would
    at_end : whether it lasts to the end of the span
    """

    begin: float
    end: float
    speed_hz: float
    turns: float
    below_no_load: float
    delay: float
    at_end: bool

    @property
    def absorbed(self) -> float:
        """Share of the driving torque that the vibration takes up: 1 - 1/delay."""
        return max(0.0, 1 - 1 / self.delay) if self.delay else 0.0


def mean_speeds(turn_times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Mean speeds over TURNS turns [Hz] and the middles of those turns [s], from the ends of the turns."""
    step = max(1, len(turn_times) // MOST_MEANS)
    first, last = turn_times[:-TURNS:step], turn_times[TURNS::step]
    return (first + last) / 2, TURNS / (last - first)


def run_up_time(motor: Motor) -> float:
    """Time constant of the motor without vibration [s]: Omega0 (J + m3 e^2)/M0; inf without torque."""
    return motor.Omega0 * motor.inertia / motor.M0 if motor.M0 else inf


def holds_of(times: np.ndarray, speeds: np.ndarray, motor: Motor) -> list[Hold]:
    """All holds among the mean speeds [Hz] at `times` [s], the longest taken first, in order of time."""
    spans = [(0, len(speeds))]
    holds = []
    while spans:
        start, stop = spans.pop()
        first, last = longest_stretch(speeds[start:stop])
        first, last = first + start, last + start
        hold = _hold(times, speeds, first, last, motor)
        if hold is not None:
            holds.append(hold)
            spans += [(start, first), (last + 1, stop)]
    return sorted(holds, key=lambda hold: hold.begin)


def _hold(times: np.ndarray, speeds: np.ndarray, first: int, last: int, motor: Motor) -> Hold | None:
    """The means from `first` to `last` as a hold; None where it has too few turns."""
    if last <= first:
        return None
    length = float(times[last] - times[first])
    speed = float(mean(speeds[first : last + 1]))
    if speed * length < LEAST_TURNS:
        return None
    no_load = motor.Omega0 / TURN
    return Hold(
        float(times[first]),
        float(times[last]),
        speed,
        speed * length,
        1 - speed / no_load,
        length / free_passage(motor, speed),
        last == len(speeds) - 1,
    )


def free_passage(motor: Motor, speed: float) -> float:
    """Time in which the motor would pass the band about `speed` [Hz] without vibration [s]; inf: never."""
    low, high = speed * (1 - BAND), speed * (1 + BAND)
    no_load = motor.Omega0 / TURN
    return run_up_time(motor) * elementary.log((no_load - low) / (no_load - high)) if high < no_load else inf


def longest_stretch(speeds: np.ndarray) -> tuple[int, int]:
    """First and last of the longest stretch of consecutive positive values within the band; (0, -1): none."""
    ratio = (1 + BAND) / (1 - BAND)
    highest: deque[int] = deque()  # candidates for the greatest value from `start` on, descending
    lowest: deque[int] = deque()
    start, best = 0, (0, -1)
    values = speeds.tolist()
    for i, value in enumerate(values):
        if value <= 0:
            highest.clear()
            lowest.clear()
            start = i + 1
            continue
        while highest and values[highest[-1]] <= value:
            highest.pop()
        while lowest and values[lowest[-1]] >= value:
            lowest.pop()
        highest.append(i)
        lowest.append(i)
        while values[highest[0]] > ratio * values[lowest[0]]:
            start += 1
            if highest[0] < start:
                highest.popleft()
            if lowest[0] < start:
                lowest.popleft()
        if i - start > best[1] - best[0]:
            best = start, i
    return best
