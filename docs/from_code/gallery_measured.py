"""How numbers of the gallery are measured in runs of its cases, and what mechanics says of them."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum
from functools import partial
from math import acos, atan2, pi, sin, sqrt

import numpy as np

from vibsim import Result, load_case, simulate
from vibsim.physics.parts import EVENT_KINDS

G = 9.81
Run = Callable[..., Result]


class Kind(str, Enum):
    """What a number of ours is held against."""

    PUBLISHED = "published formula or number"  # the origin cites where
    CLOSED_FORM = "closed form"  # of mechanics, worked out here
    INDEPENDENT = "independent solver"  # another program, at the parameters of the source
    NONE = "no number from elsewhere"  # ours must keep a law of conservation, and no more


@dataclass(frozen=True)
class Number:
    """One number of a case.

    Attributes
    ----------
    what : the quantity, in words
    kind : what the expected value is
    expected : that value, in `unit`
    origin : who says so, or from which law it follows
    ours : measures it; gets a function that runs the case with changes, such as run({"run.t_end": "500 s"})
    within : by how much the two may differ, in `unit`, and `because` what
    """

    what: str
    kind: Kind
    expected: float
    unit: str
    origin: str
    ours: Callable[[Run], float]
    within: float
    because: str

    def measured(self, name: str) -> float:
        """Our value in a run of the case `gallery/NAME`. Raises ArithmeticError where it is off."""
        value = float(self.ours(partial(run_case, name)))
        if not abs(value - self.expected) <= self.within:
            raise ArithmeticError(f"gallery/{name}: {self.what}: {value!r}, expected {self.expected!r}")
        return value


def run_case(name: str, changes: Mapping[str, str] | None = None) -> Result:
    """A run of a case of the gallery in doubles, not judged by a second run."""
    return simulate(load_case(f"gallery/{name}", changes), trust=False)


def at_events(result: Result, kind: str, column: str) -> np.ndarray:
    """A column of the events of a kind."""
    return result.events[column][result.events["kind"] == EVENT_KINDS[kind]]


def last_speed(run: Run, column: str, changes: Mapping[str, str] | None = None) -> float:
    """Speed in front of the last impact."""
    return abs(at_events(run(changes or {}), "impact", f"before_v_{column}")[-1])


def energy_missing(run: Run) -> float:
    """Energy that the balance of a run misses, over its largest term."""
    return run().attrs["energy_residual_relative"]


def settled_amplitude(run: Run, column: str, changes: Mapping[str, str]) -> float:
    """Half the peak-to-peak at the end of a long run [mm]; samples lie beside the peaks by 1e-6 of it."""
    late = run(changes)[column][-20000:]
    return 500 * float(late.max() - late.min())


def amplitude_alone(force: float, mass: float, stiffness: float, damping: float, omega: float) -> float:
    """Amplitude of a linear oscillator under a harmonic force [mm]."""
    return 1000 * force / sqrt((stiffness - mass * omega**2) ** 2 + (damping * omega) ** 2)


def bilinear_entry(run: Run) -> float:
    return at_events(run(), "contact_begin", "v_mass")[-1]


def friction_amplitude(run: Run) -> float:
    return abs(at_events(run(), "reversal", "x_mass")[-1])


def stick_slip_period(run: Run) -> float:
    return float(np.diff(at_events(run(), "stick_begin", "t"))[-1])


def cycle_ends(run: Run) -> float:
    """Speed of the belt up to which the stick-slip cycle lasts, by bisection [m/s]."""
    there, gone = 1.8, 1.9
    while gone - there > 1e-7:
        middle = (there + gone) / 2
        speed = f"{middle!r} m/s"
        result = run({"friction.belt.belt": speed, "initial.block.v": speed, "run.every": "1 s"})
        sticks = at_events(result, "stick_begin", "t")
        there, gone = (middle, gone) if len(sticks) and sticks[-1] > 150 else (there, middle)
    return there


def table_phase(run: Run) -> float:
    """Displacement of the table at the bounce [um]."""
    return 1e6 * at_events(run({"run.t_end": "6 s"}), "impact", "x_ball")[-1]


def table_phase_expected() -> float:
    omega, amplitude = 99.045444115315068, 0.7e-3
    return 1e6 * amplitude * sin(acos(pi * G / omega / 9 / (amplitude * omega)))


def last_body(run: Run) -> float:
    return float(run()["v_five"][-1])


def released(run: Run) -> float:
    return at_events(run(), "rest_end", "t")[0]


def first_rest(run: Run) -> float:
    return at_events(run(), "rest_begin", "t")[0]


def impact_time(run: Run, number: int) -> float:
    return at_events(run(), "impact", "t")[number]


def speed_of_last_ball(run: Run) -> float:
    return float(run()["v_last"][-1])


def first_drive(run: Run) -> float:
    """How far the first blow drives the pile [mm]."""
    return 1000 * at_events(run(), "stick_begin", "x_pile")[0]


def blow_energy(run: Run) -> float:
    """Energy that a blow takes over m M / (m + M) (1 - e^2) u^2 / 2, the mean over a run."""
    result = run()
    columns = ("v_body", "v_ball", "before_v_body", "before_v_ball")
    body, ball, body_before, ball_before = (at_events(result, "impact", name) for name in columns)
    lost = 2 * (body_before**2 - body**2) + 0.02 * (ball_before**2 - ball**2)
    expected = 4 * 0.04 / 4.04 * (1 - 0.6**2) * (ball_before - body_before) ** 2 / 2
    return float(lost.sum() / expected.sum())


def friction_impulse(run: Run) -> float:
    """Mean force of the ground on the drifting slider over a settled period [N]."""
    omega, result = 4 * pi, run()
    released_at = at_events(result, "rest_end", "t")[-2:]
    inside = (result.events["t"] >= released_at[0]) & (result.events["t"] <= released_at[1])
    t, slides, rests = (result.events[name][inside] for name in ("t", "ground_around", "face"))
    force = 2 * t - 5 / omega * np.cos(omega * t)  # its integral over time
    held = np.where(rests[:-1] != 0, np.diff(force), 0)
    impulse = np.where(slides[:-1] != 0, 8 * np.diff(t), held)
    return float(impulse.sum() / np.diff(released_at)[0])


def greatest_acceleration(run: Run) -> float:
    """Of the upper block, from its velocities at the samples [m/s^2]."""
    result = run()
    return float(np.abs(np.diff(result["v_upper"]) / np.diff(result["time"])).max())


def pair_speed() -> float:
    """u of (pi u / (2 w) - b)^2 + (u (1 - e) / (w (1 + e)))^2 = a^2 [mm/s]."""
    omega, amplitude, half_play, e = 10 * pi, 5e-3, 10e-3, 0.7
    p, q = pi / (2 * omega), (1 - e) / (omega * (1 + e))
    roots = np.roots([p * p + q * q, -2 * p * half_play, half_play**2 - amplitude**2])
    return 1000 * float(max(roots))


def pair_measured(run: Run) -> float:
    return 1000 * abs(at_events(run(), "impact", "v_ball")[-1])


def phase_of_impact(run: Run) -> float:
    """Phase of the force at the last impact [rad]."""
    t = at_events(run({"run.t_end": "400 s"}), "impact", "t")[-1]
    return atan2(np.sin(t), np.cos(t))


def clear_amplitude_expected() -> float:
    """Amplitude of the cantilever's tip clear of its stop [mm]: a |k + i w c| / |k - m w^2 + i w c|."""
    m, k, c, w, a = 0.12, 450.0, 0.25, 2 * pi * 13, 0.5
    return a * sqrt((k**2 + (w * c) ** 2) / ((k - m * w**2) ** 2 + (w * c) ** 2))


def clear_amplitude(run: Run) -> float:
    """Half of the way between the extremes of the tip in the last second, sampled finely [mm]."""
    result = run({"run.t_end": "60 s", "run.every": "10 us"})
    late = np.asarray(result["x_tip"])[np.asarray(result["time"]) > 59]
    return float(1e3 * np.ptp(late) / 2)
