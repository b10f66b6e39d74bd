"""The orbits of n periods of a case over one of its numbers: n + 1 scaled unknowns, and what closes an orbit.

Unknowns are those of the orbit (`vibsim.orbits.coordinates`), the time of return where a motor
leaves it free, and the parameter. The residual is P(X) - X and what is missing of the turn. Its derivative
by the state and by the time is that of the motion, exact; that by the parameter is a difference quotient.
An error d of it, relative to its size, changes no solution: it multiplies what is left after a Newton step
by d, and turns the tangent by d.
"""

from collections import OrderedDict
from collections.abc import Iterator, Mapping, Sequence
from decimal import Decimal
from fractions import Fraction
from itertools import combinations
from math import sqrt
from typing import Any

import numpy as np
from numpy.polynomial import chebyshev

from vibsim.cases import Case, CaseError
from vibsim.cases.quantities import UNITS, Quantity, in_own_unit, number
from vibsim.cases.scene_building import DOUBLES, SceneBuilder, build_parts
from vibsim.cases.schema_kinds import Measured
from vibsim.engine.errors import EngineError
from vibsim.lazy import once
from vibsim.orbits import OrbitError, ReturnMap
from vibsim.orbits.branches.correction import ContinuationError, NoCase
from vibsim.orbits.coordinates import case_on_orbit
from vibsim.orbits.newton import tolerance
from vibsim.orbits.stability import (
    NoEigenvalues,
    determinant,
    directions,
    dot,
    eigenvalues,
    length_of,
    modulus,
    multipliers_of,
    product,
    square_root,
)
from vibsim.orbits.words import circle
from vibsim.physics.parts import Scene

# The scenes of a case over one of its numbers, made fast.
#
# The places where the number stands in the long form of the case are found once; from then on a scene is
# built with another value in these places, exact and rounded once, without the case being checked as a whole
# again. So where the bodies start, which is none of an orbit's business, need not suit every value.


BESIDE = Fraction(1, 2**30)  # share by which the value is changed to see where it stands


class ScenePath:
    """Scenes of a case by the value of a parameter.

    keys : of the case, all of that value; unit : of the parameter
    """

    def __init__(self, case: Case, keys: Sequence[str], unit: str):
        self.keys, self.unit = tuple(keys), unit
        self._unit = UNITS[unit]
        self._measured = case.measured(self.keys[0])
        self._values = case.long_values()
        before, after = dict(leaves(self._values)), dict(leaves(self._beside(case).long_values()))
        self._places = [place for place in before if before[place] != after[place]]
        self._sections = list(dict.fromkeys(section for section, *_ in self._places))
        self._scene: Scene | None = None  # the first, whose other parts all have

    def _beside(self, case: Case) -> Case:
        """The case with the parameter a little changed."""
        own = case.quantity(self.keys[0])
        for share in (BESIDE, -BESIDE):
            value = own.value * (1 + share) if own.value else share
            try:
                return case.with_values(dict.fromkeys(self.keys, in_own_unit(own, value)))
            except CaseError as error:
                refused = error
        raise refused

    def scene(self, value: float) -> Scene:
        """The scene at a value. Raises ValueError where the key does not allow it."""
        quantity = self._quantity(float(value))
        broken = self._measured.broken_bound(quantity.value) if self._measured else None
        if broken:
            raise ValueError(f"{self.keys[0]} must be {broken}, got {number(value, 6)} {self.unit}".rstrip())
        values, scene = self._values, self._scene
        for place in self._places:
            values = replaced(values, place, quantity)
        if scene is None:
            scene = self._scene = build_parts(values)
            return scene
        return SceneBuilder(values, DOUBLES).rebuilt(scene, self._sections)

    def _quantity(self, value: float) -> Quantity:
        """Result of `parse_quantity` for a value and the unit, faster for ordinary numbers."""
        if not 1e-200 < abs(value) < 1e200:
            measured = self._measured or Measured("number")
            return measured.parsed(f"{value!r} {self.unit}".strip())
        text, unit = repr(value), self._unit
        exact = Fraction(*Decimal(text).as_integer_ratio())
        in_si = exact if unit.factor == 1 else exact * unit.factor
        return Quantity(f"{text} {unit.name}".strip(), in_si, unit.per_turn)


def leaves(values: Mapping[str, Any], place: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Any]]:
    """(path, value) of every value of nested values."""
    for name, value in values.items():
        if isinstance(value, dict):
            yield from leaves(value, (*place, name))
        else:
            yield (*place, name), value


def replaced(values: Mapping[str, Any], place: tuple[str, ...], quantity: Quantity) -> dict[str, Any]:
    """Nested values with one of them replaced."""
    name, *inner = place
    new = replaced(values[name], tuple(inner), quantity) if inner else quantity
    return {**values, name: new}


# Multipliers of conservative orbits: some are 1 because energy and momenta are kept, the others come as
# mu and 1 / mu.
#
# What is kept gives left eigenvectors of the derivative P' with eigenvalue 1, and disturbances that change
# nothing of it stay such. Restricted to these P' has the other multipliers alone. Their characteristic
# polynomial q is palindromic (the restricted map is symplectic): q(x) = x^k Q(x + 1/x), with a polynomial Q
# of degree k in tau = mu + 1/mu. An orbit is spectrally stable while all tau are real and within [-2, 2]. It
# loses that where a tau passes 2 (a branch point, or the energy turns round), where one passes -2 (period
# doubling), or where two within that interval meet and become complex: four multipliers leave the circle at
# once (Krein 1950; stability of nonlinear normal modes by multipliers: Peeters et al. 2009).


def restricted(matrix: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """A matrix (m, m) on the vectors that `rows` (t, m), left eigenvectors of it, are orthogonal to."""
    _, vectors, _ = directions(rows / np.array([[length_of(row)] for row in rows]))
    within = vectors[len(rows) :]
    return product(product(within, matrix), within.T)


class Reciprocal:
    """The k pairs of multipliers mu, 1 / mu of a restricted derivative (2k, 2k)."""

    def __init__(self, inner: np.ndarray):
        self.inner = inner

    @once
    def series(self) -> np.ndarray:
        """Q(tau) as a Chebyshev series in tau / 2, since x^j + x^-j = 2 T_j(tau / 2)."""
        factors = [1 + 0j]  # of the characteristic polynomial, the highest power first
        for mu in eigenvalues(self.inner) if len(self.inner) else ():
            factors = [one - mu * other for one, other in zip([*factors, 0j], [0j, *factors], strict=True)]
        coefficients = np.array([each.real for each in factors])
        middle = len(self.inner) // 2
        series = (coefficients[middle::-1] + coefficients[middle:]).copy()
        series[0] /= 2
        return np.asarray(series)

    @once
    def traces(self) -> list[complex]:
        """tau = mu + 1/mu of each pair."""
        if len(self.series) < 2:
            return []
        return [2 * root for root in eigenvalues(chebyshev.chebcompanion(self.series))]

    @property
    def fold(self) -> float:
        """det(1 - P') without the kept: Q(2), zero with a pair at 1."""
        return float(chebyshev.chebval(1.0, self.series))

    @property
    def doubling(self) -> float:
        """det(1 + P') without the kept, but for its sign: Q(-2), zero with a pair at -1."""
        return float(chebyshev.chebval(-1.0, self.series))

    @once
    def collision(self) -> float:
        """Discriminant of Q: zero where two pairs meet, negative where two have become complex."""
        product = complex(1.0)
        for one, other in combinations(self.traces, 2):
            product *= (one - other) ** 2
        return product.real

    @property
    def outside(self) -> int:
        """Number of multipliers outside the unit circle: one of each pair whose tau is not in [-2, 2]."""
        return sum(tau.imag != 0 or abs(tau.real) > 2 for tau in self.traces)

    @property
    def multipliers(self) -> list[complex]:
        """All 2k, of each pair the one not inside the circle first."""
        return [mu for tau in self.traces for mu in _pair(tau)]


def _pair(tau: complex) -> Sequence[complex]:
    """mu and 1 / mu of their sum."""
    half = tau / 2
    if tau.imag == 0 and abs(half.real) <= 1:
        rise = sqrt((1 - half.real) * (1 + half.real))
        return complex(half.real, rise), complex(half.real, -rise)
    root = square_root(half * half - 1)
    mu = max(half + root, half - root, key=modulus)
    return mu, 1 / mu


SHIFT = 2.0**-23  # of the parameter, scaled: rounding over it is as small as what it leaves out, 1e-7
NARROW = 2.0**-29  # the same where rounding may have a say
STEEP = 256.0  # scaled derivative by the parameter, above which SHIFT is too wide for it
MAPS = 4  # return maps that are kept


class Family:
    """The orbits of `n` periods of a case over a parameter.

    keys : of the case, which have the same value; unit : of the parameter
    scale : by which each unknown is divided (n + 1)
    conservative : whether nothing changes the energy: multipliers then come as mu and 1 / mu
    """

    conservative = False

    def __init__(self, case: Case, keys: Sequence[str], unit: str, n: int):
        self.case, self.keys, self.unit, self.n = case, tuple(keys), unit, n
        self._maps: OrderedDict[float, ReturnMap] = OrderedDict()
        self.scale = np.ones(0)

    def scaled_by(self, X: np.ndarray, T: float, parameter: float, span: float, travel: float) -> None:
        """Measure unknowns by an orbit: its velocities, its time of return, the parameter or its span."""
        at = self.map(parameter).coordinates
        lengths = travel / at.weights
        times = () if self.map(parameter).section.timed else (T,)
        self.scale = np.array([*lengths, *times, abs(parameter) or span])

    def map(self, parameter: float) -> ReturnMap:
        """The return map at a value of the parameter.

        Raises NoCase where the case does not allow it.
        """
        if parameter in self._maps:
            self._maps.move_to_end(parameter)
            return self._maps[parameter]
        try:
            self._maps[parameter] = self._new_map(self.path.scene(parameter))
        except ValueError as error:
            raise NoCase(str(error)) from error
        if len(self._maps) > MAPS:
            self._maps.popitem(last=False)
        return self._maps[parameter]

    def _new_map(self, scene: Scene) -> ReturnMap:
        """On the run of the map used last, where that can be: numbers that were equal at the first may be
        equal at no other.
        """
        for known in reversed(self._maps.values()):
            return known.at(scene)
        return ReturnMap(scene, self.n)

    def over(self, case: Case) -> "Family":
        """The same of another case."""
        other = Family(case, self.keys, self.unit, self.n)
        other.scale = self.scale
        return other

    @once
    def path(self) -> ScenePath:
        """The scenes over the parameter."""
        return ScenePath(self.case, self.keys, self.unit)

    def at(self, parameter: float) -> Case:
        """The case at a value of the parameter. Raises CaseError where it does not allow it."""
        return self.case.with_values(self._values(parameter))

    def _values(self, parameter: float) -> dict[str, str]:
        return dict.fromkeys(self.keys, f"{float(parameter)!r} {self.unit}".strip())

    def case_on(self, orbit: Any) -> Case:
        """The case that runs one period on a recorded orbit (`OrbitRecord` of `tracing`)."""
        state = self.map(orbit.parameter).coordinates.state(np.array(orbit.state))
        return case_on_orbit(self.case, state, orbit.period, self._values(orbit.parameter))

    def unknowns(self, X: np.ndarray, T: float, parameter: float) -> np.ndarray:
        """Scaled unknowns of an orbit."""
        times = () if self.map(parameter).section.timed else (T,)
        return np.array([*X, *times, parameter]) / self.scale

    @once
    def ratios(self) -> np.ndarray:
        """By which entries of a derivative of one unknown by another are scaled."""
        return np.asarray(self.scale / self.scale[:, None])

    def parameter(self, z: np.ndarray) -> float:
        """The parameter of scaled unknowns."""
        return float(z[-1] * self.scale[-1])

    def __call__(self, z: np.ndarray) -> "FamilyPoint":
        """The motion over one return from scaled unknowns. Raises ContinuationError where it fails."""
        values = z * self.scale
        of = self.map(float(values[-1]))
        count = of.coordinates.count
        T = None if of.section.timed else float(values[count])
        if T is not None and not T > 0:
            raise ContinuationError("Newton's method asks for a time of return below zero")
        try:
            return FamilyPoint(self, z, of(values[:count], T))
        except (EngineError, OrbitError, ValueError) as error:
            raise ContinuationError(str(error)) from error


class FamilyPoint:
    """A motion over one return, as a point of the curve; an orbit where `residual` is zero but for rounding.

    end : of the motion, a `vibsim.orbits.return_map.Return`
    """

    def __init__(self, family: Family, z: np.ndarray, end: Any):
        self.family, self.z, self.end = family, z, end

    @property
    def parameter(self) -> float:
        return self.family.parameter(self.z)

    @property
    def period(self) -> float:
        """Time of return [s]."""
        return float(self.end.T)

    @once
    def residual(self) -> np.ndarray:
        """Of the equations, scaled."""
        return self._scaled(self.end)

    @once
    def matrix(self) -> np.ndarray:
        """Derivative of the section after one return by that before (m x m)."""
        return np.asarray(self.end.derivative)

    @once
    def multipliers(self) -> np.ndarray:
        """Floquet multipliers, the largest first. Raises ContinuationError for a motion without any."""
        try:
            return np.asarray(multipliers_of(self.end))
        except NoEigenvalues as error:
            raise ContinuationError(f"the motion has no derivative there: {error}") from error

    @once
    def reciprocal(self) -> Reciprocal:
        """The multipliers that come in pairs; of conservative families only."""
        raise NotImplementedError

    @once
    def fold(self) -> float:
        """det(P' - I), which is zero with a multiplier 1."""
        return determinant(self.matrix - self.end.coordinates.one)

    @once
    def doubling(self) -> float:
        """det(P' + I), which is zero with a multiplier -1."""
        return determinant(self.matrix + self.end.coordinates.one)

    @once
    def word(self) -> tuple[Any, ...]:
        """Events of one return, as a circle."""
        return circle(self.end.events)

    @property
    def lap(self) -> float:
        """By which the pinned component is divided: a turn of a motor, or the velocity of the scale."""
        at = self.end.coordinates
        return float(self.family.scale[0] * at.weights[0]) if at.section.turning else 2 * np.pi

    def _scaled(self, end: Any) -> np.ndarray:
        count, scale = len(end.X), self.family.scale
        if end.tilt is None:
            return np.asarray(end.difference / scale[:count])
        closing = np.empty(count + 1)
        closing[:count], closing[count] = end.difference / scale[:count], end.ahead / self.lap
        return closing

    @once
    def about(self) -> np.ndarray:
        """About the same as `slope`: what Newton's method took for it, or itself."""
        return self.slope

    @property
    def first_slope(self) -> np.ndarray | None:
        """The derivative by the parameter that Newton's method begins with here."""
        return self.slope

    @once
    def slope(self) -> np.ndarray:
        """Derivative of the residual by the scaled parameter (n)."""
        about = self.__dict__.get("about")  # tells how steep it is, where Newton's method came to one
        slope = self._quotient(SHIFT) if about is None or steepness_of(about) <= STEEP else about
        steepness = steepness_of(slope)
        # near a grazing touch of a rigid stop it is as steep as it is bent
        return slope if steepness <= STEEP else self._quotient(SHIFT / steepness)

    def take_slope(self, near: "FamilyPoint") -> None:
        """Have the derivative by the parameter of a point that is all but this one."""
        if near.word == self.word and steepness_of(near.slope) <= STEEP * max(1.0, length_of(self.z)):
            self.__dict__["slope"] = near.slope

    @property
    def rounded(self) -> bool:
        """Whether the residual is not larger than rounding may make it."""
        return bool(self.end.residual <= tolerance(self.end))

    @property
    def narrow_slope(self) -> np.ndarray | None:
        """The same by a narrow quotient, for where the motion changes within the width of the other, as where
        a grazing and a doubling lie side by side: rounding makes it right to 1e-7. None where all that is
        left of the residual is rounding.
        """
        return None if self.end.residual <= tolerance(self.end) else self._quotient(NARROW)

    def _quotient(self, shift: float) -> np.ndarray:
        """Difference quotient of the residual by the scaled parameter, on the side with the order of events
        of this motion where one side has another, and on the side that the case allows.
        """
        try:
            ahead, slope = self._one_sided(shift)
        except NoCase:
            return self._one_sided(-shift)[1]
        if ahead.events != self.end.events and circle(ahead.events) != self.word:
            try:
                behind, other = self._one_sided(-shift)
            except NoCase:
                return slope
            if circle(behind.events) == self.word:
                return other
        return slope

    def _one_sided(self, shift: float) -> tuple[Any, np.ndarray]:
        """The motion at a shifted scaled parameter, and the quotient."""
        family, value, unit = self.family, self.parameter, float(self.family.scale[-1])
        beside = value + shift * unit
        of = family.map(beside)
        try:
            end = of.plain(self.end.X, None if of.section.timed else self.end.T)
        except (EngineError, OrbitError) as error:
            raise ContinuationError(str(error)) from error
        return end, (self._scaled(end) - self.residual) / ((beside - value) / unit)

    @once
    def flow(self) -> np.ndarray:
        """Derivative of the scaled state at the end by the scaled unknowns without the parameter."""
        end, ratios = self.end, self.family.ratios
        count = len(end.X)
        if end.tilt is None:
            return np.asarray(end.flow_matrix * ratios[:count, :count])
        flow = np.empty((count, count + 1))
        flow[:, :count], flow[:, count] = (
            end.flow_matrix * ratios[:count, :count],
            end.rate * ratios[:count, count],
        )
        return flow

    @once
    def linear(self) -> np.ndarray:
        """Derivative of the residual by z without the parameter (n, n)."""
        return self._closing_matrix()

    def _closing_matrix(self) -> np.ndarray:
        """Derivative of what closes an orbit by z without the parameter."""
        count, scale, one = len(self.end.X), self.family.scale, self.end.coordinates.one
        if self.end.tilt is None:
            return np.asarray(self.flow - one)
        slopes, rate = self.end.tilt
        matrix = np.empty((count + 1, count + 1))
        matrix[:count] = self.flow
        matrix[:count, :count] -= one
        matrix[count, :count], matrix[count, count] = slopes, rate
        matrix[count] *= scale[: count + 1] / self.lap
        return matrix

    def jacobian(self, slope: np.ndarray | None = None) -> np.ndarray:
        """Derivative of the residual by z (n, n + 1); slope: its last column, where one is good enough."""
        n = len(self.z) - 1
        matrix = np.empty((n, n + 1))
        matrix[:, :n], matrix[:, n] = self.linear, self.slope if slope is None else slope
        return matrix

    @once
    def _forgotten(self) -> list[int]:
        """The unknowns at the end that depend on nothing at the start."""
        return [i for i, row in enumerate(self.flow.tolist()) if not any(row)]

    @property
    def settled(self) -> bool:
        """Whether ends that hold on each other at the end of a motion that has forgotten its start have the
        velocity and the distance that they began with, to the bit or as near as scaled unknowns tell.

        A body that sticks across the section would else begin with a speed of rounding, and stick once more.
        All else may go to and fro by rounding.
        """
        if not (self._forgotten and self.end.difference[self._forgotten].any()):
            return True
        nearest = self.end.image / self.family.scale[: len(self.end.X)] == self.z[: len(self.end.X)]
        return all(dot(row, self.end.difference) == 0.0 or nearest[row != 0].all() for row in self.end.held)

    def moved(self, step: np.ndarray, slope: np.ndarray | None = None) -> np.ndarray:
        """z after a Newton step.

        The state is taken as the image under the linearised map, which is z + step but for rounding: so what
        the motion has forgotten, as behind a stick, comes from the image, and a body that sticks across the
        section sticks there to the bit.
        """
        count, scale = len(self.end.X), self.family.scale
        z = self.z + step
        z[:count] = self.end.image / scale[:count] + product(self.flow, step[:-1])
        if step[-1] != 0:
            if slope is None or self._forgotten:  # another orbit's slope may not have forgotten
                slope = self.slope
            z[:count] += slope[:count] * step[-1]
        return np.asarray(z)


def steepness_of(slope: np.ndarray) -> float:
    """The largest derivative by the scaled parameter."""
    return float(max(map(abs, slope.tolist())))
