"""Numbers of the gallery: what each must be, of which kind that is, and how ours is measured in a run.

A build of the site fails where one is off by more than its bound, and a test says so sooner.
"""

from decimal import ROUND_CEILING, Decimal, localcontext
from functools import partial
from math import floor, log10, pi, sqrt

from from_code import gallery_measured as ours
from from_code.formulas_numbers import FORMULAS, ROUNDING, SETTLED, SOLVER
from from_code.gallery_measured import G, Kind, Number

BALANCE = Number(
    "energy that the balance of the run misses, over its largest term",
    Kind.NONE,
    0.0,
    "",
    "first law of thermodynamics",
    ours.energy_missing,
    1e-12,
    "rounding of the ledger",
)
LONG = {"run.t_end": "500 s"}

NUMBERS: dict[str, tuple[Number, ...]] = {
    "ball-on-shaken-table": (
        Number(
            "displacement of the table at the bounce",
            Kind.PUBLISHED,
            ours.table_phase_expected(),
            "um",
            "Holmes (1982), with the table's own motion: it moves at (g T/2)(1 - e)/(1 + e) there",
            ours.table_phase,
            1e-4,
            SETTLED,
        ),
    ),
    "belt-oscillator": (
        Number(
            "speed of the belt up to which it sticks and slips",
            Kind.INDEPENDENT,
            1.836600972207926,
            "m/s",
            SOLVER,
            ours.cycle_ends,
            2e-7,
            "the bisection, which ends there",
        ),
    ),
    "bilinear-oscillator": (
        Number(
            "velocity at which the mass meets the stop",
            Kind.INDEPENDENT,
            1.073267857664968,
            "m/s",
            SOLVER,
            ours.bilinear_entry,
            1e-11,
            SETTLED,
        ),
    ),
    "block-on-belt": (
        Number(
            "period of stick and slip",
            Kind.INDEPENDENT,
            12.001031294830,
            "s",
            SOLVER,
            ours.stick_slip_period,
            1e-11,
            ROUNDING,
        ),
    ),
    "bouncing-ball": (
        Number(
            "time after which the ball rests",
            Kind.CLOSED_FORM,
            sqrt(2 / G) * 9,
            "s",
            "sqrt(2 h/g) (1 + e)/(1 - e)",
            ours.first_rest,
            1e-12,
            ROUNDING,
        ),
    ),
    "cantilever": (
        Number(
            "amplitude of the tip clear of the stop",
            Kind.CLOSED_FORM,
            ours.clear_amplitude_expected(),
            "mm",
            "the linear oscillator, shaken at its root",
            ours.clear_amplitude,
            1e-6,
            "samples meet an extreme to (w h)^2 / 8 of it, 8e-8",
        ),
    ),
    "chain-with-gaps": (
        Number(
            "velocity of the last body",
            Kind.CLOSED_FORM,
            1.0,
            "m/s",
            "closed form of contact",
            ours.last_body,
            1e-11,
            ROUNDING,
        ),
    ),
    "chattering-oscillator": (
        Number(
            "first release from the stop",
            Kind.CLOSED_FORM,
            (pi / 2 + 2 * pi) / 0.3,
            "s",
            "w t = pi/2 + 2 pi: where the force turns",
            ours.released,
            1e-11,
            ROUNDING,
        ),
    ),
    "drifting-capsule": (BALANCE,),
    "drifting-oscillator": (
        Number(
            "mean force of the ground on the slider",
            Kind.CLOSED_FORM,
            2.0,
            "N",
            "momentum over a settled period: the static force",
            ours.friction_impulse,
            2e-6,
            SETTLED,
        ),
    ),
    "energy-sink": (
        Number(
            "energy taken by the blows, over m M/(m + M) (1 - e^2) u^2/2",
            Kind.CLOSED_FORM,
            1.0,
            "",
            "Newton's law of impact",
            ours.blow_energy,
            1e-11,
            ROUNDING,
        ),
    ),
    "friction-oscillator": (
        Number(
            "amplitude",
            Kind.INDEPENDENT,
            2.42023635057437,
            "m",
            SOLVER,
            ours.friction_amplitude,
            1e-11,
            SETTLED,
        ),
    ),
    "impact-damper": (
        Number(
            "amplitude of the body without the ball",
            Kind.CLOSED_FORM,
            ours.amplitude_alone(0.2, 10, 394.78, 1.26, 2 * pi),
            "mm",
            "linear oscillator under a harmonic force",
            partial(ours.settled_amplitude, column="x_body", changes={"stops": "none", **LONG}),
            1e-3,
            "samples beside the peaks",
        ),
    ),
    "impact-oscillator": (
        Number(
            "speed of the impacts",
            Kind.PUBLISHED,
            0.66569335283999,
            "m/s",
            "closed form of one impact in two periods (Budd and Dux 1994)",
            partial(ours.last_speed, column="mass", changes=LONG),
            1e-11,
            SETTLED,
        ),
    ),
    "impact-oscillator-coco": (
        Number(
            "speed of the impacts",
            Kind.CLOSED_FORM,
            1.695732937594882,
            "m/s",
            "closed form of one impact in each period",
            partial(ours.last_speed, column="mass", changes=LONG),
            1e-9,
            SETTLED,
        ),
        Number(
            "phase of the impacts",
            Kind.CLOSED_FORM,
            0.0759521649383,
            "rad",
            "the same closed form",
            ours.phase_of_impact,
            1e-9,
            SETTLED,
        ),
    ),
    "impact-pair": (
        Number(
            "speed of the ball between the walls",
            Kind.CLOSED_FORM,
            ours.pair_speed(),
            "mm/s",
            "closed form of one impact on each wall in each period",
            ours.pair_measured,
            1e-6,
            SETTLED,
        ),
    ),
    "percussive-drill": (BALANCE,),
    "pile-driver": (
        Number(
            "way of the pile under the first blow",
            Kind.CLOSED_FORM,
            1000 * (1.6 * 0.25 * sqrt(2 * G)) ** 2 / (2 * (100e3 / 750 - G)),
            "mm",
            "u^2/(2 (R/M - g)), u = (1 + e) m sqrt(2 g h)/(m + M)",
            ours.first_drive,
            1e-10,
            ROUNDING,
        ),
    ),
    "stack-of-blocks": (
        Number(
            "greatest acceleration of the upper block",
            Kind.CLOSED_FORM,
            0.1 * G,
            "m/s^2",
            "Coulomb's law: mu g",
            ours.greatest_acceleration,
            1e-10,
            "rounding of velocities over a step of the samples",
        ),
    ),
    "three-balls": (
        Number(
            "velocity of the last ball",
            Kind.CLOSED_FORM,
            2 / 3,
            "m/s",
            "Newton-Moreau law of impact",
            ours.speed_of_last_ball,
            1e-15,
            ROUNDING,
        ),
    ),
    "two-balls-and-a-spring": (
        Number(
            "first bounce",
            Kind.CLOSED_FORM,
            0.4038550218769,
            "s",
            "free fall of 0.8 m",
            partial(ours.impact_time, number=0),
            1e-12,
            ROUNDING,
        ),
        Number(
            "second bounce",
            Kind.INDEPENDENT,
            0.4233169688147,
            "s",
            SOLVER,
            partial(ours.impact_time, number=1),
            1e-12,
            "the digits that the solver gave",
        ),
    ),
    "two-masses-with-friction": (BALANCE,),
    **FORMULAS,
}


def agreement(number: Number, value: float) -> str:
    """How well two values agree, in words that do not say more than they do."""
    if value == number.expected:
        return "to the last bit"
    if number.expected == 0:
        with localcontext() as context:
            context.rounding = ROUND_CEILING
            return f"within {Decimal(abs(value)):.0e}"
    return f"{floor(-log10(abs(value / number.expected - 1)))} digits"
