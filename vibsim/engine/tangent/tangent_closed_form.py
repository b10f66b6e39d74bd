"""How small disturbances move inside a mode of the closed-form flow.

A mode with a closed form is linear with loads that depend on time alone, so a disturbance obeys the
homogeneous equations of its modal coordinates. Where bodies are tied, the disturbed distance between them is
a constant load on what holds them.
"""

from collections.abc import Iterable, Sequence
from typing import Generic

from vibsim.engine.flows.closed.closed_form import ClosedForm
from vibsim.engine.flows.closed.modal import ModalPlace, Source
from vibsim.engine.flows.closed.responses import Oscillator
from vibsim.physics.numbers import Kit, N
from vibsim.physics.parts import Scene

E_FOLDS = 8  # of decay in one piece: neighbouring directions then part by 3 of the 16 digits at most


class ClosedFormTangent(Generic[N]):
    """Moves disturbances along the stretch that `flow` has just done."""

    def __init__(self, scene: Scene[N], kit: Kit[N], flow: ClosedForm[N]) -> None:
        self.scene, self.kit, self.flow = scene, kit, flow
        self.n = len(scene.bodies)
        self.event_at: N | None = None  # time of the event that ends the stretch [s]

    is_too_long = is_undefined = False  # no stretch is: the closed form knows no order and no formula

    def piece_end(self, t: N, end: N, mark: N) -> N:
        """End [s] of the piece from t that is moved at once: at most `end`, not beyond `mark` where that is
        ahead, and short enough that no direction is lost below round-off.
        """
        decay = self.kit.number(0)
        for osc in self._oscillators():
            fastest = osc.a if osc.oscillates else osc.a + osc.wd
            decay = fastest if fastest > decay else decay
        ahead = t + E_FOLDS / decay if decay > 0 else end
        ahead = mark if t < mark < ahead else ahead
        return ahead if t < ahead < end else end

    def _oscillators(self) -> list[Oscillator[N]]:
        return [c.oscillators[0] for c in self.flow.modal.constants if not c.coordinate.free]

    def prepare(self, t: N, end: N, late: N | int = 0) -> None:
        """Responses of the coordinates over the piece from t to `late` behind `end` [s], as (q by q0, u0,
        load; u by the same).
        """
        tau, one, zero = (end - t) + late, self.kit.number(1), self.kit.number(0)
        self.responses: list[tuple[N, N, N, N, N, N]] = []
        for constants in self.flow.modal.constants:
            if constants.coordinate.free:
                self.responses.append((one, tau, tau * tau / 2, zero, one, tau))
                continue
            osc = constants.oscillators[0]
            release, impulse = osc.release_and_impulse(tau)
            steady = osc.constant_response(tau, release)
            rate, stiff = release - 2 * osc.a * impulse, osc.b * impulse
            self.responses.append((release, impulse, steady, -stiff, rate, impulse))

    def moved(self, vector: Sequence[N]) -> list[N]:
        """The disturbance that `vector`, of the tangent space of the mode, becomes over the piece prepared
        last.
        """
        n, zero = self.n, self.kit.number(0)
        x, v = [*vector[:n], zero, zero], [*vector[n : 2 * n], zero, zero]
        q: list[N] = []
        u: list[N] = []
        for coordinate, response in zip(self.flow.modal.coordinates, self.responses, strict=True):
            q0, u0 = self._weighted(coordinate.sources, x), self._weighted(coordinate.sources, v)
            load = zero
            for factor, plus, minus in coordinate.shifts:
                load = load + factor * self._sum((*plus, *((-sign, c) for sign, c in minus)), x)
            a, b, c, d, e, f = response
            q.append(q0 * a + u0 * b + load * c)
            u.append(q0 * d + u0 * e + load * f)
        places = self.flow.modal.places[:n]
        dx = [self._sum(place.fixed, x) + self._shaped(place, q) for place in places]
        dv = [self._shaped(place, u) for place in places]
        return [*dx, *dv]

    def _weighted(self, sources: Iterable[Source[N]], values: Sequence[N]) -> N:
        total = self.kit.number(0)
        for (P, Q), weight in sources:
            total = total + weight * (values[P] if Q is None else values[P] - values[Q])
        return total

    def _sum(self, places: Iterable[tuple[int, int]], values: Sequence[N]) -> N:
        total = self.kit.number(0)
        for sign, column in places:
            total = total + sign * values[column]
        return total

    def _shaped(self, place: ModalPlace[N], values: Sequence[N]) -> N:
        total = self.kit.number(0)
        for m, share in place.shape.items():
            total = total + share * values[m]
        return total
