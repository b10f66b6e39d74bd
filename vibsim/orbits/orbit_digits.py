"""An orbit and its multipliers in many digits, by Newton's method on the multi-digit engine.

The start are doubles, right to some 15 digits; each step doubles their number. The matrix is carried along in
the same digits, so the multipliers are as right as the orbit, but for their condition.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import isfinite, isnan, log10, pi
from typing import Any

import numpy as np

from vibsim.cases.problems import counted
from vibsim.cases.quantities import number
from vibsim.engine.number_forms import WordsForm
from vibsim.engine.tangent.monodromy import Carrier
from vibsim.orbits.coordinates import OrbitError
from vibsim.orbits.orbit import Orbit
from vibsim.orbits.stability import characteristic_polynomial, refined_roots, solved
from vibsim.orbits.words import Word, spelled, word_of
from vibsim.physics.connections import paces_of
from vibsim.physics.numbers import Number, decimal_text
from vibsim.physics.parts import IMPACTS
from vibsim.physics.precision import MOST_DIGITS, DigitsKit, number_kit

GUARD = 15  # digits beyond those asked for: what components much smaller than the largest need
LONGEST = 40  # events of a word that is spelled
STEPS = 14  # 15 digits doubled so often are more than there can be
DOUBLES_ONLY = "orbits that chatter or graze are known in doubles only"
NO_DERIVATIVE = f"in many digits the motion has no derivative; {DOUBLES_ONLY}"


@dataclass(frozen=True)
class OrbitDigits:
    """Decimal texts of an orbit.

    digits : how many; period [s]; coordinates : the unknowns by name; state : on the section by name of the
    column; multipliers : (re, im) of each, in the order of the orbit's; correction : the last step, relative
    to the size of the unknowns
    """

    digits: int
    period: str
    coordinates: dict[str, str]
    state: dict[str, str]
    multipliers: list[tuple[str, str]]
    correction: float

    @property
    def multiplier_texts(self) -> tuple[list[str], list[str]]:
        """Real parts and imaginary parts."""
        return [re for re, _ in self.multipliers], [im for _, im in self.multipliers]

    def lines(self) -> list[tuple[str, str]]:
        """Label and text."""
        heads = [("digits", f"{self.digits} of period, state and multipliers"), ("", f"T  {self.period}")]
        states = [("", f"{name}  {text}") for name, text in self.coordinates.items()]
        return heads + states + [("", f"mu  {re}  {im} i") for re, im in self.multipliers]

    def object(self) -> dict[str, Any]:
        """The same for JSON."""
        return {
            "digits": self.digits,
            "period_digits": self.period,
            "state_digits": self.state,
            "coordinates_digits": self.coordinates,
            "multipliers_digits": [list(each) for each in self.multipliers],
            "last_correction": self.correction,
        }


def refine(orbit: Orbit, digits: int) -> OrbitDigits:
    """The orbit to so many digits. Raises OrbitError where Newton's method does not get there, or takes
    another order of events, and MultiprecisionMissing where the engine was not built on words.
    """
    kit = number_kit(min(digits + GUARD, MOST_DIGITS))
    exact = _ExactMap(orbit, kit)
    X, T = [kit.number(x) for x in orbit.X.tolist()], exact.start_time(orbit)
    size = max(abs(x) for x in orbit.X.tolist()) or 1.0
    for _ in range(STEPS):
        step, longer, derivative = exact.step(X, T)
        if not all(isfinite(float(dx)) for dx in step):
            raise OrbitError(NO_DERIVATIVE)
        X = [x + dx for x, dx in zip(X, step, strict=True)]
        T = T + longer
        correction = max(abs(float(dx)) for dx in step) / size
        if correction == 0 or log10(correction) < -digits - GUARD // 3:
            break
    else:
        raise OrbitError(
            f"the orbit does not come to {digits} digits: the last step was {number(correction, 2)}"
        )
    if exact.word != orbit.events:
        raise OrbitError(
            f"in many digits the orbit has other events, {_brief(orbit, exact.word)} in place of "
            f"{_brief(orbit, orbit.events)}; {DOUBLES_ONLY}"
        )
    roots = _multipliers(kit, derivative, orbit.multipliers.tolist())
    return OrbitDigits(
        digits,
        _text(kit, T, digits),
        dict(zip(exact.at.names, (_text(kit, x, digits) for x in X), strict=True)),
        _by_column(exact.at.components, [_text(kit, x, digits) for x in exact.lifted(X)]),
        [(_text(kit, re, digits), _text(kit, im, digits)) for re, im in roots],
        correction,
    )


def _by_column(components: Sequence[str | None], texts: Sequence[str]) -> dict[str, str]:
    """Components by name of the column, those left out that are not shown."""
    return {name: text for name, text in zip(components, texts, strict=True) if name is not None}


def _brief(orbit: Orbit, word: Word) -> str:
    """A word in letters, or how many impacts where it is long."""
    if len(word) <= LONGEST:
        return spelled(orbit.scene, word) or "none"
    return counted(sum(kind in IMPACTS for kind, _ in word), "impact")


class _ExactMap:
    """The return map in numbers of a kit."""

    def __init__(self, orbit: Orbit, kit: DigitsKit[Number]) -> None:
        if orbit.case is None:
            raise OrbitError("an orbit of a scene alone is known to 16 digits: its numbers are doubles")
        self.kit, self.at, self.n = kit, orbit.end.coordinates, orbit.n
        self.section = orbit.return_map.section
        self.word: Word = ()
        self.scene = orbit.case.exact_scene(kit.number, kit.pi)
        self.carrier = Carrier(self.scene, WordsForm(kit))
        self.vectors = [[kit.number(value) for value in row] for row in self.at.disturbances.tolist()]

    def start_time(self, orbit: Orbit) -> Number:
        """Period [s]: exact where the source tells it, else the double."""
        period = self.section.period
        if period is None:
            return self.kit.number(orbit.period)
        terms = zip(orbit.scene.harmonics, self.scene.harmonics, strict=True)
        cycles = next((exact.cycles for term, exact in terms if term.cycles == period.cycles), None)
        frequency = self._of_formula(period.cycles) if cycles is None else self.kit.number(cycles)
        return self.kit.number(self.n * period.turns) / frequency

    def _of_formula(self, cycles: float) -> Number:
        """The frequency [Hz] of a formula of time whose double is `cycles`."""
        kit, half = self.kit, Fraction(1, 2)
        pace = next(one for one in paces_of(self.scene) or () if one.cycles[0] == cycles)
        frequency = kit.number(pace.factor * half)
        for _ in range(abs(pace.power - 1)):
            frequency = frequency * kit.pi if pace.power > 1 else frequency / kit.pi
        return frequency

    def step(self, X: list[Number], T: Number) -> tuple[list[Number], Number, list[list[Number]]]:
        """Newton's step (change of X, change of T), and the derivative of the map at X."""
        kit, m, p = self.kit, self.at.count, self.section.pinned
        moved = self.carrier.carried(self.lifted(X), T, self.vectors)
        if not isnan(moved.undefined_at):
            raise OrbitError(NO_DERIVATIVE)
        self.word = word_of(moved.events)
        end = moved.state
        image, vectors = self._unknowns(end), [self._unknowns(one) for one in moved.vectors]
        matrix = [[vectors[j][i] for j in range(m)] for i in range(m)]
        right = [a - b for a, b in zip(image, X, strict=True)]
        for i in self.at.angles.tolist():
            right[i] = right[i] - kit.number(round(float(right[i]) / (2 * pi))) * kit.two_pi
        if p is not None:
            rate = moved.rate
            rates, slopes = self._unknowns(rate), [one[p] / rate[p] for one in moved.vectors]
            ahead = (end[p] if self.section.turning else end[p] - self.n * kit.two_pi) / rate[p]
            matrix = [[matrix[i][j] - rates[i] * slopes[j] for j in range(m)] for i in range(m)]
            right = [value - rates[i] * ahead for i, value in enumerate(right)]
        less = [[(1 if i == j else 0) - matrix[i][j] for j in range(m)] for i in range(m)]
        change = solved(kit, less, right)
        longer = kit.number(0)
        if p is not None:
            longer = -ahead - sum((s * dx for s, dx in zip(slopes, change, strict=True)), longer)
        return change, longer, matrix

    def lifted(self, X: list[Number]) -> list[Number]:
        """State components on the section."""
        rows = self.at.put.tolist()
        return [sum((x for x, one in zip(X, row, strict=True) if one), self.kit.number(0)) for row in rows]

    def _unknowns(self, state: np.ndarray) -> list[Number]:
        rows, zero = self.at.take.tolist(), self.kit.number(0)
        return [sum((int(a) * s for a, s in zip(row, state, strict=True) if a), zero) for row in rows]


def _multipliers(
    kit: DigitsKit[Number], matrix: list[list[Number]], starts: list[complex]
) -> list[tuple[Number, Number]]:
    """Eigenvalues of a matrix from those in doubles; as many as are 0 there are 0."""
    zeros = sum(1 for z in starts if z == 0)
    polynomial = characteristic_polynomial(kit, matrix)[zeros:]
    zero = kit.number(0)
    roots = refined_roots(kit, polynomial, [z for z in starts if z != 0], STEPS)
    noise = 10.0 ** (GUARD // 3 - kit.digits)
    roots = [(re, zero if abs(float(im)) < noise * abs(float(re)) else im) for re, im in roots]
    return [*roots, *[(zero, zero)] * zeros]


def _text(kit: DigitsKit[Number], value: Number, digits: int) -> str:
    return decimal_text(kit.parts(value), digits) if value != 0 else "0"
