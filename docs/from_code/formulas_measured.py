"""How numbers of the gallery's cases with formulas are measured, and what closed forms say of them."""

from collections.abc import Mapping
from math import acos, cos, exp, pi, sin, sqrt

import mpmath
import numpy as np
from scipy.optimize import brentq
from scipy.special import ellipk

from from_code.gallery_measured import G, Run, at_events
from vibsim import Result

FREE_WELL = {"forces": "none", "links.spring.c": "0 N s/m"}


# Periods of free vibrations, from elliptic integrals.


def period(run: Run, column: str, about: float, changes: Mapping[str, str] | None = None) -> float:
    """Time of the first return to rest on the side of the start [s]; `about` within a tenth of it."""
    return crossing(run(changes or {}), column, 0.9 * about, 1.1 * about)


def crossing(result: Result, column: str, after: float, before: float) -> float:
    """Where a column is zero [s]."""
    return float(brentq(lambda t: float(result.at(t)[column]), after, before, xtol=1e-14, rtol=1e-14))


def hardening_period(amplitude: float) -> float:
    """x'' + x + x^3 = 0 from rest: 4 K(m)/sqrt(1 + A^2), m = A^2/(2 + 2 A^2)."""
    square = amplitude**2
    return 4 * float(ellipk(square / (2 + 2 * square))) / sqrt(1 + square)


def softening_period(amplitude: float) -> float:
    """x'' + x - x^3 = 0 from rest: 4 K(m)/sqrt(1 - A^2/2), m = A^2/(2 - A^2)."""
    square = amplitude**2
    return 4 * float(ellipk(square / (2 - square))) / sqrt(1 - square / 2)


def well_period(amplitude: float) -> float:
    """x'' - x + x^3 = 0 from rest in one well: 2 sqrt 2 K(m)/A, m = 2 - 2/A^2."""
    return 2 * sqrt(2) * float(ellipk(2 - 2 / amplitude**2)) / amplitude


def cubic_period(amplitude: float) -> float:
    """x'' + x^3 = 0 from rest: 4 K(1/2)/A."""
    return 4 * float(ellipk(0.5)) / amplitude


def pendulum_period(angle: float) -> float:
    """x'' + sin x = 0 from rest at an angle [rad]: 4 K(sin^2(angle/2))."""
    return 4 * float(ellipk(sin(angle / 2) ** 2))


def open_valve() -> float:
    """x^2 (x + 10) = 40^2, the one root above 0 [m]."""
    return float(max(np.roots([1.0, 10.0, 0.0, -1600.0]).real))


# The limit cycle of van der Pol.


def last_turns(run: Run) -> tuple[Result, list[float]]:
    """A run, and the last two instants at which the mass turns at its greatest displacement [s]."""
    result = run()
    v = result["v_mass"]
    turns = np.flatnonzero((v[:-1] > 0) & (v[1:] <= 0))[-2:]
    return result, [crossing(result, "v_mass", result.time[i], result.time[i + 1]) for i in turns]


def cycle_period(run: Run) -> float:
    _, (first, second) = last_turns(run)
    return second - first


def cycle_amplitude(run: Run) -> float:
    result, turns = last_turns(run)
    return float(result.at(turns[-1])["x_mass"])


# States at an instant, and instants of events.


def at_sample(run: Run, column: str, t: float, changes: Mapping[str, str] | None = None) -> float:
    """A column at the sample nearest to t [s]."""
    result = run(changes or {})
    return float(result[column][np.argmin(np.abs(result.time - t))])


def event_time(run: Run, kind: str, number: int) -> float:
    return float(at_events(run(), kind, "t")[number])


def at_event(run: Run, kind: str, column: str) -> float:
    """A column at the first event of a kind."""
    return float(at_events(run(), kind, column)[0])


# Contacts.


def hertz_depth(mass: float, speed: float, stiffness: float) -> float:
    """(5 m v^2/(4 K))^(2/5) [mm]."""
    return 1000 * (5 * mass * speed**2 / (4 * stiffness)) ** 0.4


def depth(run: Run) -> float:
    result = run()
    begin, end = (float(at_events(result, kind, "t")[0]) for kind in ("contact_begin", "contact_end"))
    middle = (begin + end) / 2
    return 1000 * float(result.at(crossing(result, "v_ball", middle - 1e-3, middle + 1e-3))["x_ball"]) - 1


def contact_duration(run: Run) -> float:
    """Of the first contact [ms]."""
    result = run()
    begin, end = (float(at_events(result, kind, "t")[0]) for kind in ("contact_begin", "contact_end"))
    return 1000 * (end - begin)


# The first turn of a struck Bouc-Wen spring.


def first_turn(run: Run) -> float:
    """Displacement at which the mass turns first [mm]."""
    result = run()
    v = result["v_mass"]
    i = int(np.flatnonzero((v[:-1] > 0) & (v[1:] <= 0))[0])
    t = crossing(result, "v_mass", result.time[i], result.time[i + 1])
    return 1000 * float(result.at(t)["x_mass"])


def first_turn_expected() -> float:
    """m v^2/2 = r k x^2/2 + (1 - r) k u (x - u (1 - exp(-x/u))) [mm]."""
    k, r, u, energy = 400.0, 0.3, 0.01, 0.5 * 0.5**2

    def missing(x: float) -> float:
        return r * k * x**2 / 2 + (1 - r) * k * u * (x - u * (1 - exp(-x / u))) - energy

    return 1000 * float(brentq(missing, 0, 0.1, xtol=1e-17, rtol=1e-15))


# A pendulum that pulls its cart against a stop.


def cart_at_stop() -> tuple[float, float]:
    """Speed of the cart in front of the stop, and of the pendulum behind it [m/s, rad/s].

    x = m e (1 - cos phi)/M and M v = m e w sin phi, M the mass of both, m e^2 w^2 (1 - m sin^2 phi/M)/2
    = -m g e sin phi. The stop keeps the moment about the pivot, m e (e w - v sin phi).
    """
    m, M, e, gap, restitution = 0.5, 1.5, 0.3, 0.05, 0.5
    sine = sin(-acos(1 - gap * M / (m * e)))
    w = -sqrt(-2 * G * sine / (e * (1 - m * sine**2 / M)))
    v = m * e * w * sine / M
    return v, w - (1 + restitution) * v * sine / e


# Linear motions: of a circuit, of a brake that slides.


def linear_state(matrix: np.ndarray, drive: np.ndarray, start: np.ndarray, t: float) -> np.ndarray:
    """y(t) of y' = A y + b, y(0) = start, by the exponential of the matrix with b beside it."""
    size = len(start)
    whole = np.zeros((size + 1, size + 1))
    whole[:size, :size], whole[:size, size] = matrix, drive
    with mpmath.workdps(40):  # in doubles the exponential itself loses three digits
        power = mpmath.expm(mpmath.matrix(whole.tolist()) * t, method="taylor")
        return np.array([float(y) for y in power * mpmath.matrix([*start, 1.0])])[:size]


def ramp_current() -> float:
    """Current of the motor at the end of the ramp of its voltage, V' = 125 V/s for 0.8 s [A].

    L i' = V - R i - k w, J w' = k i; V is the third state.
    """
    J, R, k, L = 0.3, 0.05, 0.6366197723675815, 1.5e-3
    matrix = np.array([[-R / L, -k / L, 1 / L], [k / J, 0, 0], [0, 0, 0]])
    return float(linear_state(matrix, np.array([0, 0, 125.0]), np.zeros(3), 0.8)[0])


def brake_place() -> float:
    """x of the sliding brake at 20 s [m]: M y'' + K y = (mu N0, 0) with K12 = k12 - mu k3."""
    mu, k3, load = 0.6, 1.3333333333333333, 1.0
    stiffness = np.array([[1.0, 0.5 - mu * k3], [0.5, 0.3333333333333333 + k3]])
    matrix = np.block([[np.zeros((2, 2)), np.eye(2)], [-stiffness, np.zeros((2, 2))]])
    drive = np.array([0, 0, mu * load, 0])
    return float(linear_state(matrix, drive, np.array([0.57, -0.16, 0, 0]), 20.0)[0])


def voltage_alone() -> float:
    """Amplitude of the voltage without stops [V]: u = theta i w X/(1/R + i w C)."""
    theta, R, C, k, c, m, force = 1.5e-3, 60e3, 50e-9, 990.0, 0.06, 0.01, 0.05
    w = 2 * pi * 50
    admittance = 1 / R + 1j * w * C
    X = force / (k - m * w**2 + 1j * w * c + theta**2 * 1j * w / admittance)
    return abs(theta * 1j * w * X / admittance)


def voltage_amplitude(run: Run) -> float:
    """From two samples a quarter of a period apart [V]."""
    u = run({"stops": "none", "run.t_end": "6 s"})["u"]
    return float(np.hypot(u[-1], u[-26]))


def phase_between(run: Run) -> float:
    """Of the exciters at the end of a run [rad], below a turn."""
    result = run()
    return float((result["phi_right"][-1] - result["phi_left"][-1]) % (2 * pi))


# Coupled clutches, each phase of which is in closed form.


def clutch_locks() -> float:
    """When the first clutch locks [s]: discs 2 and 3 turn as one since t1, pressed by 10 cos(0.4 pi t)."""
    a, drive = 0.4 * pi, 10 * pi

    def pressed(t: float) -> float:
        return 10 * sin(a * t) / a

    def driven(t: float) -> float:
        return 10 + 10 * (1 - cos(drive * t)) / drive - pressed(t)

    together = brentq(lambda t: pressed(t) - 20 * (t - 0.4), 0.6, 0.8, xtol=1e-16, rtol=1e-15)
    second = 10 * (together - 0.4)
    return float(
        brentq(
            lambda t: driven(t) - second - (pressed(t) - pressed(together)) / 2,
            together,
            0.82,
            xtol=1e-16,
            rtol=1e-15,
        )
    )
