"""Was the motor captured by the vibration, and for how long?

    captured   held at the end, and so long that it counts (see below)
    escaped    held so long that it counts, then let go
    passed     went through a resonance without being held that long, and settled above it
    not met    settled near its no-load speed without having risen through a resonance
    undecided  with the reason

A hold (see `holds`) counts where it delays the motor by a factor of at least CAPTURE against its free run-up,
that is, where the vibration takes up at least 93 % of the driving torque; and where it lies at least FAR
below the no-load speed, or NEAR a resonance. A motor that has settled above a resonance, under the load of a
strong vibration, is neither.

Whether a resonance was met is judged from the start of the run on: by the speed there, by means over single
turns until there is a mean over TURNS turns, and then by these.
"""

from dataclasses import dataclass, replace
from math import floor, nan, pi

import numpy as np

from vibsim.analysis.cycles import (
    BAND,
    DELAY,
    TURN,
    TURNS,
    CaptureVerdict,
    Hold,
    Span,
    cycle_ends,
    events_within,
    holds_of,
    mean_speeds,
    name_verdict,
    span_of,
)
from vibsim.orbits.stability import solved_by_pivots
from vibsim.physics.formula_values import apart
from vibsim.physics.parts import Friction, Link, Motor, Scene
from vibsim.physics.rates import bilinear_frequencies, natural_rates
from vibsim.results.columns import IMPACT_CODES
from vibsim.results.result import Result, Window

# Frequencies at which a motor of limited power may be captured.


@dataclass(frozen=True)
class Resonance:
    """A frequency [Hz] of the vibration, friction and damping left out."""

    name: str
    hz: float


def resonances(scene: Scene, impacting: bool) -> tuple[Resonance, ...]:
    """Resonances of the vibration, ascending; numbered where there are several of a kind.

    Without impacts, and with those on rigid stops alone, its natural frequencies f1, all stops open. With
    impacts on elastic stops, in the limit of large amplitudes, the bilinear frequencies 2 f1 f2/(f1 + f2), f2
    with all stops closed, and half of them: superharmonic resonances, in which the bodies vibrate and strike
    twice in a turn of the rotor.
    """
    if not (impacting and scene.elastic_stops):
        return _named("free", [rate / (2 * pi) for rate in natural_rates(scene)])
    bilinear = bilinear_frequencies(scene)
    frequencies = _named("half bilinear", [hz / 2 for hz in bilinear]) + _named("bilinear", bilinear)
    return tuple(sorted(frequencies, key=lambda one: one.hz))


def _named(kind: str, frequencies: list[float]) -> tuple[Resonance, ...]:
    if len(frequencies) == 1:
        return (Resonance(kind, frequencies[0]),)
    return tuple(Resonance(f"{kind} {i}", hz) for i, hz in enumerate(frequencies, 1))


CAPTURE = 15.0  # II-B as printed: 10.6; every capture for good in 300 s: over 100
FAR = 0.15  # below the no-load speed, relative; a motor above the resonance settles 1 to 12 % below it
NEAR = 0.05  # relative distance from a resonance
FEWEST_TURNS = 2 * TURNS


@dataclass(frozen=True)
class Capture:
    """Verdict on a motor run.

    Attributes
    ----------
    verdict : "captured", "escaped", "passed", "not met" or "undecided"
    reason : what it rests on, in words
    since, until : of the hold that decides it [s]; None without one, and `until` of one that lasts to the end
    speed_hz : mean speed over that hold [Hz]
    resonance : the resonance that it lies near, if any
    final_speed_hz : mean over the last turns [Hz]
    no_load_speed_hz : Omega0 [Hz]
    holds : all stretches that delay the motor by a factor of at least 3
    passages : when the speed last rose through each resonance that it ended well above
    """

    verdict: CaptureVerdict | str
    reason: str
    span: Span
    no_load_speed_hz: float
    final_speed_hz: float | None = None
    since: float | None = None
    until: float | None = None
    speed_hz: float | None = None
    resonance: Resonance | None = None
    holds: tuple[Hold, ...] = ()
    passages: tuple["Passage", ...] = ()

    def __post_init__(self) -> None:
        name_verdict(self, CaptureVerdict)


@dataclass(frozen=True)
class Passage:
    """Time [s] at which the speed last rose through a resonance."""

    resonance: Resonance
    time: float


def judge_capture(result: Result, window: Window | None = None) -> Capture:
    """Judge the run of a motor, or the part of it within `window` [s].

    Raises ValueError where the run has no motor, or nothing within the window.
    """
    scene, span = result.case.scene(), span_of(result, window)
    if not scene.has_motor:
        raise ValueError("capture is judged of a motor; this run has an ideal source, or no source")
    events = events_within(result, span.window, "t", "kind")
    impacts = events["t"][np.isin(events["kind"], IMPACT_CODES)]
    return capture_of_turns(cycle_ends(result, span.window), impacts, scene, span)


def capture_of_turns(turn_times: np.ndarray, impact_times: np.ndarray, scene: Scene, span: Span) -> Capture:
    """The verdict on a motor, that of `scene`, from the ends of its turns and the impacts, ascending [s]."""
    motor = scene.motor
    assert motor is not None
    no_load = motor.Omega0 / TURN
    if len(turn_times) < FEWEST_TURNS:
        return Capture("undecided", f"too few turns to judge: {len(turn_times)}", span, no_load)
    times, speeds = mean_speeds(turn_times)
    holds = holds_of(times, speeds, motor)
    passed = passages(*_from_start(turn_times, times, speeds, motor, span), scene)
    verdict, reason, hold = _verdict(holds, float(speeds[-1]), impact_times, scene, bool(passed))
    capture = Capture(
        verdict,
        reason,
        span,
        no_load,
        float(speeds[-1]),
        holds=tuple(one for one in holds if one.delay >= DELAY),
        passages=passed,
    )
    if hold is None:
        return capture
    near = near_resonance(hold, impact_times, scene)
    until = None if hold.at_end else hold.end
    return replace(capture, since=hold.begin, until=until, speed_hz=hold.speed_hz, resonance=near)


def _verdict(
    holds: list[Hold], final: float, impacts: np.ndarray, scene: Scene, passed: bool
) -> tuple[str, str, Hold | None]:
    """Verdict, reason, and the hold that decides it."""
    counting = [hold for hold in holds if counts(hold, near_resonance(hold, impacts, scene) is not None)]
    last = holds[-1] if holds and holds[-1].at_end else None
    if last is not None and last in counting:
        return "captured", f"held to the end, {_evidence(last)}", last
    if counting:
        longest = max(counting, key=lambda hold: hold.delay)
        return "escaped", f"{_evidence(longest)}; later at {final:.3g} Hz", longest
    if last is None:
        return "undecided", f"the speed is still changing at the end, at {final:.3g} Hz", None
    if last.below_no_load >= FAR:
        return "undecided", f"the run ends while the motor lingers, {_evidence(last)}", last
    return _settled(holds, last, final, scene, passed)


def _settled(
    holds: list[Hold], last: Hold, final: float, scene: Scene, passed: bool
) -> tuple[str, str, Hold | None]:
    """Verdict on a motor that ends near its no-load speed without having been captured.

    final : the speed over the last turns [Hz], as `Capture.final_speed_hz` has it
    """
    assert scene.motor is not None
    below = 1 - final / (scene.motor.Omega0 / TURN)
    settled = f"settled at {final:.3g} Hz, {100 * below:.2g} % below no-load speed"
    if not passed:
        near = [f", near {one.name} {one.hz:.3g} Hz" for one in all_resonances(scene) if is_near(last, one)]
        return "not met", settled + "".join(near), None
    lingering = [hold for hold in holds if hold is not last and hold.delay >= DELAY]
    if not lingering:
        return "passed", settled, None
    longest = max(lingering, key=lambda hold: hold.delay)
    return "passed", f"lingered, {_evidence(longest)}; {settled}", longest


def counts(hold: Hold, near: bool) -> bool:
    """Whether a hold is a capture."""
    return hold.delay >= CAPTURE and (near or hold.below_no_load >= FAR)


def _evidence(hold: Hold) -> str:
    below = f"{100 * hold.below_no_load:.2g} % below no-load speed"
    return f"{hold.turns:.0f} turns {below}, {hold.delay:.3g} times as long as in a free run-up"


def near_resonance(hold: Hold, impact_times: np.ndarray, scene: Scene) -> Resonance | None:
    """The resonance that a hold lies near; which ones there are depends on whether it has impacts."""
    first, last = np.searchsorted(impact_times, [hold.begin, hold.end])
    near = [one for one in resonances(scene, bool(last > first)) if is_near(hold, one)]
    return min(near, key=lambda one: abs(hold.speed_hz - one.hz), default=None)


def is_near(hold: Hold, resonance: Resonance) -> bool:
    """Whether a hold lies near a resonance."""
    return abs(hold.speed_hz / resonance.hz - 1) <= NEAR


def all_resonances(scene: Scene) -> tuple[Resonance, ...]:
    """With and without impacts, ascending."""
    both = {*resonances(scene, False), *resonances(scene, True)}
    return tuple(sorted(both, key=lambda one: one.hz))


def _from_start(
    turn_times: np.ndarray, times: np.ndarray, speeds: np.ndarray, motor: Motor, span: Span
) -> tuple[np.ndarray, np.ndarray]:
    """The mean speeds [Hz] at `times` [s], with the speeds before them where the span holds the start of the
    run: that at the start itself, then the means over single turns, each in the middle of its turn.
    """
    if span.begin > 0:
        return times, speeds
    first = motor.phi / TURN
    ends = turn_times[turn_times > 0][:TURNS]
    edges = np.concatenate([[0.0], ends])
    angles = np.concatenate([[first], floor(first) + 1 + np.arange(len(ends))])
    middles, means = (edges[1:] + edges[:-1]) / 2, np.diff(angles) / np.diff(edges)
    early = middles < times[0]
    return (
        np.concatenate([[0.0], middles[early], times]),
        np.concatenate([[motor.phidot / TURN], means[early], speeds]),
    )


def passages(times: np.ndarray, speeds: np.ndarray, scene: Scene) -> tuple[Passage, ...]:
    """When the speed [Hz] at `times` [s] last rose through each resonance that it ended well above, on the
    line between two of these times.
    """
    crossings = []
    for one in all_resonances(scene):
        below = np.flatnonzero(speeds < one.hz)
        if len(below) and speeds[-1] > one.hz * (1 + BAND):
            last = slice(int(below[-1]), int(below[-1]) + 2)
            (begin, end), (low, high) = times[last].tolist(), speeds[last].tolist()
            crossings.append(Passage(one, begin + (one.hz - low) / (high - low) * (end - begin)))
    return tuple(crossings)


# What theory says of the load of a motor on a linear support.


ROUNDS = 200  # of the equivalent damping of dry friction, at most
SETTLED = 1e-10  # of the amplitudes: what a round still changes


def averaged_load(scene: Scene, speeds: np.ndarray) -> np.ndarray:
    """Mean torque [N m] that vibration takes from a motor at steady speeds [rad/s] (n), by averaging (n).

    The rotor turns evenly, so m3 e w^2 cos(w t) drives the bodies. The power that dampers and frictions take
    of their harmonic vibration, divided by w, is the load: V. O. Kononenko, Vibrating Systems with a Limited
    Power Supply (Iliffe, London, 1969). A dry friction F counts as the damper 4 F / (pi V), where V is the
    amplitude of its sliding velocity. NaN where a stop would be reached, where friction does not settle, and
    everywhere in scenes with formulas, belts, forces, a moving base or friction that is not constant.
    """
    load = np.full(len(speeds), nan)
    if scene.motor is None or not _is_linear(scene):
        return load
    for i, w in enumerate(np.asarray(speeds, dtype="f8").tolist()):
        force = float(scene.motor.unbalance) * w * w
        amplitudes = _harmonic_response(scene, w, force)
        if amplitudes is not None and not _reaches_a_stop(scene, amplitudes):
            load[i] = force * -amplitudes[scene.motor.on].imag / 2
    return load


def _is_linear(scene: Scene) -> bool:
    plain = all(one.forward == one.backward and not one.belt for one in scene.frictions)
    return plain and not (
        scene.has_formulas or scene.base or scene.forces or len(scene.line) < len(scene.bodies)
    )


def _harmonic_response(scene: Scene, w: float, force: float) -> np.ndarray | None:
    """Complex amplitudes of the bodies [m] under `force` [N] on that of the motor; None: none found."""
    motor, n = scene.motor, len(scene.bodies)
    assert motor is not None
    inertia = np.diag([float(body.m) for body in scene.bodies])
    inertia[motor.on, motor.on] += float(motor.m3)
    parts = [(_joined(link, n), float(link.k) + 1j * w * float(link.c)) for link in scene.links]
    bare = sum((shape * value for shape, value in parts), -w * w * inertia.astype(complex))
    shapes = [_joined(one, n) for one in scene.frictions]
    forces = [float(one.forward) for one in scene.frictions]
    dampings, amplitudes = [0.0] * len(forces), np.zeros(n, dtype=complex)
    for _ in range(ROUNDS):
        before = amplitudes
        matrix = sum((1j * w * c * shape for c, shape in zip(dampings, shapes, strict=True)), bare)
        rows = np.block([[matrix.real, -matrix.imag], [matrix.imag, matrix.real]])
        pushed = [force if i == motor.on else 0.0 for i in range(2 * n)]
        solution, pivot = solved_by_pivots(rows, np.array(pushed))
        if pivot == 0:
            return None
        amplitudes = solution[:n] + 1j * solution[n:]
        if np.abs(amplitudes - before).max() <= SETTLED * np.abs(amplitudes).max():
            return amplitudes
        sliding = [w * abs(apart(one, amplitudes, 0.0)) for one in scene.frictions]
        if not all(sliding):
            return None
        dampings = [4 * held / (pi * v) for held, v in zip(forces, sliding, strict=True)]
    return None


def _joined(part: Link | Friction, n: int) -> np.ndarray:
    """Stiffness matrix (n, n) of n bodies with a unit of stiffness between the ends of a part."""
    row = np.array([float(i == part.P) - float(i == part.Q) for i in range(n)])
    joined: np.ndarray = row[:, None] * row
    return joined


def _reaches_a_stop(scene: Scene, amplitudes: np.ndarray) -> bool:
    return any(abs(apart(stop, amplitudes, 0.0)) >= stop.gap for stop in scene.stops)
