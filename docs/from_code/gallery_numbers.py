"""Numbers of the gallery: what was published or follows from mechanics, and how ours is measured in a run.

A build of the site fails where one is off by more than its bound, and a test says so sooner.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from decimal import ROUND_CEILING, Decimal, localcontext
from functools import partial
from math import acos, atan2, floor, log10, pi, sin, sqrt

import numpy as np

from vibsim import Result, load_case, simulate
from vibsim.physics.modes import EVENT_KINDS

G = 9.81
Run = Callable[..., Result]


@dataclass(frozen=True)
class Number:
    """One number of a case.

    Attributes
    ----------
    what : the quantity, in words
    published : its value, in `unit`
    origin : who says so, or from which law it follows
    ours : measures it; gets a function that runs the case with changes, such as run({"run.t_end": "500 s"})
    within : by how much the two may differ, in `unit`, and `because` what
    """

    what: str
    published: float
    unit: str
    origin: str
    ours: Callable[[Run], float]
    within: float
    because: str

    def measured(self, name: str) -> float:
        """Our value in a run of the case `gallery/NAME`. Raises ArithmeticError where it is off."""
        value = float(self.ours(partial(run_case, name)))
        if not abs(value - self.published) <= self.within:
            raise ArithmeticError(f"gallery/{name}: {self.what}: {value!r}, published {self.published!r}")
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


ROUNDING = "rounding"
SETTLED = "what is left of the transient"
INDEPENDENT = "an independent solver, at the source's parameters"
BALANCE = Number(
    "energy that the balance of the run misses, over its largest term",
    0.0,
    "",
    "first law of thermodynamics; no number is published",
    energy_missing,
    1e-12,
    "rounding of the ledger",
)
LONG = {"run.t_end": "500 s"}

NUMBERS: dict[str, tuple[Number, ...]] = {
    "ball-on-shaken-table": (
        Number(
            "displacement of the table at the bounce",
            table_phase_expected(),
            "um",
            "Holmes (1982), with the table's own motion: it moves at (g T/2)(1 - e)/(1 + e) there",
            table_phase,
            1e-4,
            SETTLED,
        ),
    ),
    "belt-oscillator": (
        Number(
            "speed of the belt up to which it sticks and slips",
            1.836600972207926,
            "m/s",
            INDEPENDENT,
            cycle_ends,
            2e-7,
            "the bisection, which ends there",
        ),
    ),
    "bilinear-oscillator": (
        Number(
            "velocity at which the mass meets the stop",
            1.073267857664968,
            "m/s",
            INDEPENDENT,
            bilinear_entry,
            1e-11,
            SETTLED,
        ),
    ),
    "block-on-belt": (
        Number(
            "period of stick and slip", 12.001031294830, "s", INDEPENDENT, stick_slip_period, 1e-11, ROUNDING
        ),
    ),
    "bouncing-ball": (
        Number(
            "time after which the ball rests",
            sqrt(2 / G) * 9,
            "s",
            "sqrt(2 h/g) (1 + e)/(1 - e)",
            first_rest,
            1e-12,
            ROUNDING,
        ),
    ),
    "chain-with-gaps": (
        Number("velocity of the last body", 1.0, "m/s", "closed form of contact", last_body, 1e-11, ROUNDING),
    ),
    "chattering-oscillator": (
        Number(
            "first release from the stop",
            (pi / 2 + 2 * pi) / 0.3,
            "s",
            "w t = pi/2 + 2 pi: where the force turns",
            released,
            1e-11,
            ROUNDING,
        ),
    ),
    "drifting-capsule": (BALANCE,),
    "drifting-oscillator": (
        Number(
            "mean force of the ground on the slider",
            2.0,
            "N",
            "momentum over a settled period: the static force",
            friction_impulse,
            2e-6,
            SETTLED,
        ),
    ),
    "energy-sink": (
        Number(
            "energy taken by the blows, over m M/(m + M) (1 - e^2) u^2/2",
            1.0,
            "",
            "Newton's law of impact",
            blow_energy,
            1e-11,
            ROUNDING,
        ),
    ),
    "friction-oscillator": (
        Number("amplitude", 2.42023635057437, "m", INDEPENDENT, friction_amplitude, 1e-11, SETTLED),
    ),
    "impact-damper": (
        Number(
            "amplitude of the body without the ball",
            amplitude_alone(0.2, 10, 394.78, 1.26, 2 * pi),
            "mm",
            "linear oscillator under a harmonic force",
            partial(settled_amplitude, column="x_body", changes={"stops": "none", **LONG}),
            1e-3,
            "samples beside the peaks",
        ),
    ),
    "impact-oscillator": (
        Number(
            "speed of the impacts",
            0.66569335283999,
            "m/s",
            "closed form of one impact in two periods (Budd and Dux 1994)",
            partial(last_speed, column="mass", changes=LONG),
            1e-11,
            SETTLED,
        ),
    ),
    "impact-oscillator-coco": (
        Number(
            "speed of the impacts",
            1.695732937594882,
            "m/s",
            "closed form of one impact in each period",
            partial(last_speed, column="mass", changes=LONG),
            1e-9,
            SETTLED,
        ),
        Number(
            "phase of the impacts",
            0.0759521649383,
            "rad",
            "the same closed form",
            phase_of_impact,
            1e-9,
            SETTLED,
        ),
    ),
    "impact-pair": (
        Number(
            "speed of the ball between the walls",
            pair_speed(),
            "mm/s",
            "closed form of one impact on each wall in each period",
            pair_measured,
            1e-6,
            SETTLED,
        ),
    ),
    "percussive-drill": (BALANCE,),
    "pile-driver": (
        Number(
            "way of the pile under the first blow",
            1000 * (1.6 * 0.25 * sqrt(2 * G)) ** 2 / (2 * (100e3 / 750 - G)),
            "mm",
            "u^2/(2 (R/M - g)), u = (1 + e) m sqrt(2 g h)/(m + M)",
            first_drive,
            1e-10,
            ROUNDING,
        ),
    ),
    "stack-of-blocks": (
        Number(
            "greatest acceleration of the upper block",
            0.1 * G,
            "m/s^2",
            "Coulomb's law: mu g",
            greatest_acceleration,
            1e-10,
            "rounding of velocities over a step of the samples",
        ),
    ),
    "three-balls": (
        Number(
            "velocity of the last ball",
            2 / 3,
            "m/s",
            "Newton-Moreau law of impact",
            speed_of_last_ball,
            1e-15,
            ROUNDING,
        ),
    ),
    "two-balls-and-a-spring": (
        Number(
            "first bounce",
            0.4038550218769,
            "s",
            "free fall of 0.8 m",
            partial(impact_time, number=0),
            1e-12,
            ROUNDING,
        ),
        Number(
            "second bounce",
            0.4233169688147,
            "s",
            INDEPENDENT,
            partial(impact_time, number=1),
            1e-12,
            "the digits published",
        ),
    ),
    "two-masses-with-friction": (BALANCE,),
}


def agreement(number: Number, value: float) -> str:
    """How well two values agree, in words that do not say more than they do."""
    if value == number.published:
        return "to the last bit"
    if number.published == 0:
        with localcontext() as context:
            context.rounding = ROUND_CEILING
            return f"within {Decimal(abs(value)):.0e}"
    return f"{floor(-log10(abs(value / number.published - 1)))} digits"
