"""Scales of the rounding of modal coordinates, at the point that a `ClosedForm` evaluated last.

A response is a difference of terms that may cancel while their rounding stays: 1 - cos of a motion from rest
is zero after each period, cos - cos of two close frequencies after each beat. So there are two measures:

plain : what each response adds to the coordinate; vanishes where that does
close : the terms that responses, loads and starts are themselves sums of; right to the rounding everywhere

Steps far from every zero need no more than the plain one; `reaches.py` tells how far that is.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Generic, cast

from vibsim.engine.flows.closed.responses import QUARTER, Oscillator, Responses
from vibsim.physics.numbers import N, abs

if TYPE_CHECKING:
    from vibsim.engine.flows.closed.closed_form import ClosedForm


Pair = tuple[N, N]
Triple = tuple[N, N, N]


@dataclass
class Scales(Generic[N]):
    """By coordinate, magnitudes of the terms of q, of q' and of q''; those of the last are None where what is
    summed is not told.
    """

    q: list[N]
    u: list[N]
    a: list[N] | None


def plain_scales(flow: ClosedForm[N]) -> Scales[N]:
    """The plain measure."""
    scales: Scales[N] = Scales([], [], None)
    for m, constants in enumerate(flow.modal.constants):
        q0, u0, load, tau = abs(flow.q0[m]), abs(flow.u0[m]), flow.load[m], flow.tau
        if constants.coordinate.free:
            q, u = q0 + abs(flow.u0[m] * tau) + abs(load * (tau * tau / 2)), u0 + abs(load * tau)
        else:
            q = q0 + abs(flow.u0[m] * flow.impulse[m]) + abs(load * flow.steady[m])
            u = u0 + abs(flow.q0[m] * flow.stiff[m]) + abs(load * flow.impulse[m])
        for i, h in enumerate(constants.driven):
            hc, hs, dc, ds = flow.responses[m][i]
            size = abs(constants.coordinate.sines[h]) + abs(constants.coordinate.cosines[h])
            q = q + size * (abs(hc) + abs(hs))
            u = u + size * (abs(dc) + abs(ds))
        scales.q.append(q)
        scales.u.append(u)
    return scales


def close_scales(flow: ClosedForm[N]) -> Scales[N]:
    """The close measure."""
    scales: Scales[N] = Scales([], [], accelerations := [])
    for m in range(len(flow.modal.constants)):
        q, u, a = _close(flow, m)
        scales.q.append(q)
        scales.u.append(u)
        accelerations.append(a)
    return scales


def _starts(flow: ClosedForm[N], m: int) -> Triple[N]:
    """Terms of a coordinate's displacement, rate and load at the start of the segment."""
    coordinate, zero = flow.modal.coordinates[m], flow.kit.number(0)
    q, u, load = zero, zero, coordinate.load_size
    for (P, Q), weight in coordinate.sources:
        q = q + abs(weight * (flow.x0[P] if Q is None else flow.x0[P] - flow.x0[Q]))
        u = u + abs(weight * (flow.v0[P] if Q is None else flow.v0[P] - flow.v0[Q]))
    for factor, plus, minus in coordinate.shifts:
        places = zero
        for _, c in (*plus, *minus):
            places = places + abs(flow.x0[c])
        load = load + abs(factor) * places
    return q, u, load


def _close(flow: ClosedForm[N], m: int) -> Triple[N]:
    constants, tau = flow.modal.constants[m], flow.tau
    coordinate, osc = constants.coordinate, constants.oscillators[0]
    q0, u0, load = _starts(flow, m)
    if coordinate.free:
        q, u, a = q0 + u0 * tau + load * (tau * tau / 2), u0 + load * tau, load
        swing = impulse = flow.kit.number(0)
    else:
        swing, impulse, steady = _swinging(osc, tau, flow.steady[m])
        q = q0 + u0 * impulse + load * steady
        u = u0 * (1 + 2 * osc.a * impulse) + q0 * (osc.b * impulse) + load * impulse
        a = load
    for i, h in enumerate(constants.driven):
        osc, responses, terms = constants.oscillators[i], flow.responses[m][i], coordinate.sizes[h]
        if coordinate.free:
            place, rate = _free_response(osc, tau, responses)
        else:
            place, rate = _response(osc, tau, swing, impulse, responses)
        q, u, a = q + terms * place, u + terms * rate, a + terms
    return (q, u, a) if coordinate.free else (q, u, a + 2 * coordinate.a * u + coordinate.b * q)


def _swinging(osc: Oscillator[N], tau: N, steady: N) -> Triple[N]:
    """Terms of C [-], S [s] and I [s^2].

    Zeros of C and S are those of a cosine and a sine, whose phase is rounded: what counts is how far they
    swing. That phase has been rounded to eps wd t, so S to no more than swing * min(t, 1 / w0) beside itself,
    however close to critical damping.
    """
    release, impulse = osc.release_and_impulse(tau)
    quotient = osc.settling * (tau * tau) >= QUARTER
    release, impulse = abs(release), abs(impulse)
    if osc.oscillates:
        release = release + (osc.a + osc.wd) * impulse
        impulse = impulse + release * (tau if osc.w0 * tau < 1 else 1 / osc.w0)
    return release, impulse, (1 + release) * osc.per_b if quotient else abs(steady)


def _response(osc: Oscillator[N], tau: N, swing: N, impulse: N, responses: Responses[N]) -> Pair[N]:
    """Terms of the response to a harmonic load [s^2] and of its rate [s]."""
    omega = osc.omega
    if osc.is_quotient(tau * tau):
        inverse = abs(osc.inverse_r) + abs(osc.inverse_i)
        place = (2 + swing + omega * impulse) * inverse
        return place, (osc.b * impulse + omega * (2 + swing + 2 * osc.a * impulse)) * inverse
    place = abs(responses[0]) + abs(responses[1])
    return place, impulse + omega * place


def _free_response(osc: Oscillator[N], tau: N, responses: Responses[N]) -> Pair[N]:
    """As `_response`, of a free mass."""
    angle = osc.omega * tau
    if angle * angle >= QUARTER:
        return (3 + angle) * abs(osc.inverse_r), 3 / osc.omega
    return abs(responses[0]) + abs(responses[1]), abs(responses[2]) + abs(responses[3])


# Magnitudes of sums and products: what their rounding is proportional to, however much they cancel.


class Magnitude(Generic[N]):
    """A number of which only the magnitude counts: |a + b| and |a - b| are taken as |a| + |b|.

    What is written for numbers gives, on magnitudes, the sum of the magnitudes of its terms. Such a number is
    zero only where every term is.
    """

    __slots__ = ("size",)

    def __init__(self, value: N | int) -> None:
        self.size = abs(value)

    def __add__(self, other: Any) -> Magnitude[N]:
        return Magnitude(self.size + size_of(other))

    __radd__ = __sub__ = __rsub__ = __add__

    def __mul__(self, other: Any) -> Magnitude[N]:
        return Magnitude(self.size * size_of(other))

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Magnitude[N]:
        return Magnitude(self.size / size_of(other))

    def __neg__(self) -> Magnitude[N]:
        return self

    def __eq__(self, other: object) -> bool:
        return bool(self.size == other)

    __hash__ = None  # type: ignore[assignment]


def size_of(value: Any) -> Any:
    """The magnitude of a number, or of a `Magnitude` what it stands for."""
    return value.size if isinstance(value, Magnitude) else abs(value)


def magnitudes(values: list[N]) -> list[N]:
    """The numbers as magnitudes, for what is written for numbers."""
    return cast("list[N]", [Magnitude(value) for value in values])
