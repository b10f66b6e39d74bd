"""Numbers of the gallery's cases with formulas; with those of `gallery_numbers` they are all there are."""

from functools import partial
from math import pi, radians

from from_code import formulas_measured as ours
from from_code.gallery_measured import Kind, Number

ROUNDING = "rounding"
SETTLED = "what is left of the transient"
SOLVER = "at the source's parameters"
ELLIPTIC = "complete elliptic integral"


def period_of(column: str, expected: float, changes: dict[str, str] | None = None) -> Number:
    """The period of a free vibration."""
    return Number(
        "period of the free vibration",
        Kind.CLOSED_FORM,
        expected,
        "s",
        ELLIPTIC,
        partial(ours.period, column=column, about=expected, changes=changes),
        2e-12,
        ROUNDING,
    )


def solved(what: str, expected: float, unit: str, column: str, t: float, within: float) -> Number:
    """A column at an instant, by an independent solver."""
    measure = partial(ours.at_sample, column=column, t=t)
    return Number(what, Kind.INDEPENDENT, expected, unit, SOLVER, measure, within, "the digits that it gave")


FORMULAS: dict[str, tuple[Number, ...]] = {
    "bouc-wen": (
        Number(
            "displacement at which the struck mass turns",
            Kind.CLOSED_FORM,
            ours.first_turn_expected(),
            "mm",
            "energy, with z = u (1 - exp(-x/u)) while the spring is first drawn",
            ours.first_turn,
            1e-11,
            ROUNDING,
        ),
    ),
    "brake-squeal": (
        Number(
            "place of the sliding mass after 20 s",
            Kind.CLOSED_FORM,
            ours.brake_place(),
            "m",
            "linear equations of the sliding brake",
            partial(ours.at_sample, column="x_x", t=20),
            1e-12,
            ROUNDING,
        ),
    ),
    "captured-motor": (solved("angle of the rotor at 20 s", 101.316368225, "rad", "phi", 20, 1e-9),),
    "coupled-clutches": (
        Number(
            "instant at which the first clutch locks",
            Kind.CLOSED_FORM,
            ours.clutch_locks(),
            "s",
            "speeds of the discs, phase by phase",
            partial(ours.event_time, kind="stick_begin", number=1),
            1e-14,
            ROUNDING,
        ),
    ),
    "dc-motor-start": (
        Number(
            "current at the end of the ramp of voltage",
            Kind.CLOSED_FORM,
            ours.ramp_current(),
            "A",
            "linear circuit and shaft",
            partial(ours.at_sample, column="i", t=1),
            1e-11,
            ROUNDING,
        ),
    ),
    "driven-pendulum": (
        period_of(
            "v_pendulum",
            ours.pendulum_period(radians(170)),
            {"forces": "none", "links.weight.c": "0 N m s/rad", "initial.pendulum.x": "170 deg"},
        ),
    ),
    "duffing-hardening": (period_of("v_mass", ours.hardening_period(1)),),
    "duffing-softening": (period_of("v_mass", ours.softening_period(0.99)),),
    "duffing-two-well": (
        period_of("v_mass", ours.well_period(1.2), ours.FREE_WELL | {"initial.mass.x": "1.2 m"}),
    ),
    "energy-harvester": (
        Number(
            "amplitude of the voltage without stops",
            Kind.CLOSED_FORM,
            ours.voltage_alone(),
            "V",
            "linear oscillator and circuit under a harmonic force",
            ours.voltage_amplitude,
            1e-10,
            SETTLED,
        ),
    ),
    "gear-pair": (solved("displacement at 400 s", 1.066841539275, "m", "x_gears", 400, 1e-12),),
    "hertz-ball": (
        Number(
            "depth of the ball in the wall",
            Kind.PUBLISHED,
            ours.hertz_depth(1, 1, 1e6),
            "mm",
            "Hertz (1881), as in Johnson (1985)",
            ours.depth,
            1e-12,
            ROUNDING,
        ),
        Number(
            "duration of the contact",
            Kind.CLOSED_FORM,
            12.811349348247,
            "ms",
            "2 int_0^d dx/sqrt(v^2 - 4 K x^(5/2)/(5 m)) of Hertz's force",
            ours.contact_duration,
            1e-12,
            ROUNDING,
        ),
    ),
    "hertz-chain": (solved("velocity of the last ball", 0.99097257272, "m/s", "v_third", 20, 5e-12),),
    "lugre-friction": (solved("place of the mass at 10 s", 0.627583129, "m", "x_mass", 10, 5e-10),),
    "pendulum-on-cart": (
        Number(
            "speed of the cart in front of the stop",
            Kind.CLOSED_FORM,
            ours.cart_at_stop()[0],
            "m/s",
            "momentum and energy",
            partial(ours.at_event, kind="impact", column="before_v_cart"),
            1e-13,
            ROUNDING,
        ),
        Number(
            "speed of the pendulum behind the impact",
            Kind.CLOSED_FORM,
            ours.cart_at_stop()[1],
            "rad/s",
            "moment of the pendulum about its pivot, and restitution of the cart",
            partial(ours.at_event, kind="impact", column="w_pendulum"),
            1e-12,
            ROUNDING,
        ),
    ),
    "relief-valve": (
        Number(
            "place at which much flow, q = 40, holds the disc",
            Kind.CLOSED_FORM,
            ours.open_valve(),
            "m",
            "x sqrt(x + delta) = q, a cubic equation",
            partial(ours.at_sample, column="x_disc", t=60, changes={"q": "40"}),
            2e-12,
            SETTLED,
        ),
        solved("place of the disc at 20 s", 0.40674506444, "m", "x_disc", 20, 5e-11),
    ),
    "two-exciters": (
        Number(
            "angle between the exciters",
            Kind.CLOSED_FORM,
            pi,
            "rad",
            "opposition of equal exciters: the frame rests",
            ours.phase_between,
            1e-10,
            SETTLED,
        ),
    ),
    "ueda-oscillator": (
        period_of("v_mass", ours.cubic_period(1), ours.FREE_WELL | {"initial.mass.x": "1 m"}),
    ),
    "van-der-pol": (
        Number(
            "period of the limit cycle",
            Kind.PUBLISHED,
            6.6632868593231301897,
            "s",
            "Amore (2021)",
            ours.cycle_period,
            1e-12,
            ROUNDING,
        ),
        Number(
            "amplitude of the limit cycle",
            Kind.PUBLISHED,
            2.0086198608748431365,
            "m",
            "Amore (2021)",
            ours.cycle_amplitude,
            1e-13,
            ROUNDING,
        ),
    ),
}
