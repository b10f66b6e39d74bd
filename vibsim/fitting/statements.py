"""A statement on the runs of a case: what is measured, which range it should be in, from how many starts."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from math import inf, pi
from typing import TYPE_CHECKING

from vibsim.cases.problems import CaseError, did_you_mean, shown
from vibsim.cases.quantities import NUMBER, UNITS, Quantity, QuantityError, parse_quantity
from vibsim.cases.schema_keys import UnknownKeyError
from vibsim.fitting.measures import (
    OBSERVABLES,
    VIBRATION,
    Bounds,
    FitError,
    Observable,
    missing_of,
    observable_of,
)
from vibsim.physics.elementary import exp, log, log10
from vibsim.physics.parts import columns_of
from vibsim.results.result import Window
from vibsim.sweeps.axes import read_axis, scale_name

if TYPE_CHECKING:
    from vibsim.cases import Case


MOST = 0.8  # share of the starts from which a statement should hold, unless it says otherwise


@dataclass(frozen=True)
class Asked:
    """An observable of a run by name, with its argument and window if it has them."""

    name: str
    argument: float = 0.0
    window: Window | None = None
    last: float = 0.0  # [s] before the end, in place of a window

    @property
    def observable(self) -> Observable:
        """The observable, and how it is measured."""
        return observable_of(self.name)

    def window_in(self, t_end: float) -> Window | None:
        """The window [s] in a run of this length."""
        if self.last:
            return max(0.0, t_end - self.last), t_end
        return None if self.window is None else (self.window[0], min(self.window[1], t_end))


@dataclass(frozen=True)
class Statement:
    """One statement.

    Attributes
    ----------
    text : as given, without the name of the case
    case : position of its case
    asked, bounds : what is measured, and where it should be
    share : of the starts from which it should hold
    weight : against the other statements
    """

    text: str
    case: int
    asked: Asked
    bounds: Bounds
    share: float = MOST
    weight: float = 1.0

    def check_window(self, cases: Sequence[Case]) -> None:
        """Raises FitError where its span of time ends behind the run of its case."""
        t_end = cases[self.case].number("run.t_end")
        if self.asked.window is not None and t_end < self.asked.window[1] < inf:
            what = f"its span of time is not within the run, 0 to {t_end:g} s (run.t_end)"
            raise FitError(f"statement {self.text!r}: {what}")

    def shortfall(self, value: float) -> float:
        """0 where a measured value fulfils it, up to 1 where it is far off."""
        if self.asked.observable.words is not None:
            return 0.0 if self.bounds.contain(value) else 1.0
        return self.bounds.shortfall(value)

    def decided_at(self, value: float, t_reached: float) -> float:
        """Time [s] up to which a run must be right for the value to be."""
        if self.asked.observable.instant and value == value:
            return value
        window = self.asked.window_in(t_reached)
        return t_reached if window is None else window[1]


# The language of statements, read.
#
# [CASE:] WHAT [RANGE] [WINDOW] [from SHARE of the starts] [, weight N]
#
# captured until the end                             released between 80 and 120 s
# II-C: settles between 6.1 and 6.3 Hz               passes 4.5 Hz before 120 s
# drift rate at least 0.1 mm/s after 100 s           regime is periodic from every start


@dataclass(frozen=True)
class Phrase:
    """Beginning of a statement: the words, the observable they stand for, and the verdict they name."""

    words: str
    name: str
    verdict: str = ""


# longer phrases stand before those that they begin with
PHRASES = (
    Phrase("captured until the end", "capture", "captured"),
    *(Phrase(verdict, "capture", verdict) for verdict in ("captured", "escaped", "passed", "not met")),
    Phrase("escapes", "capture", "escaped"),
    *(Phrase(f"{be}{word}", "regime", word)
      for word in ("periodic", "quasi-periodic", "chaotic") for be in ("regime is ", "")),
    Phrase("settles", "final speed"),
    Phrase("drifts", "drift rate"),
    Phrase("released", "released"),
    Phrase("passes", "passes"),
    *(Phrase(name, name) for name in sorted(OBSERVABLES, key=len, reverse=True)
      if name not in ("capture", "regime", "released", "passes")),
)  # fmt: skip

_VIBRATION = re.compile(rf"(?i:{VIBRATION})(?P<names>\w+(?: - \w+)?)")
_SHARE = re.compile(
    rf"\s+from\s+(?:at\s+least\s+)?(?:(?P<every>every)\s+start|(?P<share>{NUMBER})\s*%(?:\s+of\s+the\s+starts)?)$"
)
_WEIGHT = re.compile(rf"\s*,\s*weight\s+(?P<weight>{NUMBER})$")
_LAST = re.compile(r"\s+in\s+the\s+last\s+(?P<last>.+)$")
_AFTER = re.compile(r"\s+after\s+(?P<after>.+)$")
_OVER = re.compile(r"\s+over\s+(?P<low>.+?)\s+to\s+(?P<high>.+)$")
_BETWEEN = re.compile(r"(?:between\s+(?P<a>.+?)\s+and\s+|(?P<b>.+?)\s+to\s+)(?P<high>.+)$")
_ONE_SIDED = re.compile(r"(?P<side>at\s+least|at\s+most|above|below|after|before)\s+(?P<end>.+)$")
UPPER = {"at most", "below", "before"}

FORM = "[CASE:] WHAT [RANGE] [over A to B s] [from P % of the starts] [, weight N]"
RANGES = "between A and B, at least A, at most A, before A or after A, with a unit"


def parse_statement(text: str, cases: Sequence[Case]) -> Statement:
    """The statement that `text` makes on one of the cases. Raises FitError with what is allowed."""
    try:
        return _parsed(" ".join(text.split()), cases)
    except QuantityError as error:
        raise FitError(f"statement {text!r}: {error}") from None
    except FitError as error:
        raise FitError(f"statement {text!r}: {error}") from None


def _parsed(text: str, cases: Sequence[Case]) -> Statement:
    position, rest = _case_of(text, cases)
    claim = rest
    claim, weight = _weight(claim)
    claim, share = _share(claim)
    named = _vibration_phrase(claim, cases[position]) if cases[position].is_long else None
    phrase, dimension = named or (_phrase_of(claim), "length")
    observable = observable_of(phrase.name, dimension)
    missing = missing_of(observable, cases[position])
    if missing:
        raise FitError(f"{phrase.name} needs {' and '.join(missing)}; {cases[position].name} lacks it")
    tail, argument = _argument(claim[len(phrase.words) :].strip(), phrase, observable)
    tail, asked = _windowed(tail, Asked(phrase.name, argument), observable, cases[position])
    return Statement(rest, position, asked, _bounds(tail, phrase, observable), share, weight)


def _case_of(text: str, cases: Sequence[Case]) -> tuple[int, str]:
    """Position of the case that a statement is on, and the rest of it."""
    names = [case.name for case in cases]
    label, colon, rest = text.partition(":")
    if colon:
        if label.strip() not in names:
            hint = did_you_mean(label.strip(), names)
            raise FitError(f"no case {shown(label.strip())}{hint}; the cases are {', '.join(names)}")
        return names.index(label.strip()), rest.strip()
    if len(cases) > 1:
        raise FitError(f"say of which case it is, as in {names[0]}: {text}")
    return 0, text


def _weight(claim: str) -> tuple[str, float]:
    match = _WEIGHT.search(claim)
    if match is None:
        return claim, 1.0
    weight = float(match["weight"])
    if not 0 < weight < inf:
        raise FitError(f"the weight must be positive, got {match['weight']}")
    return claim[: match.start()], weight


def _share(claim: str) -> tuple[str, float]:
    match = _SHARE.search(claim)
    if match is None:
        return claim, MOST
    share = 1.0 if match["every"] else float(match["share"]) / 100
    if not 0 < share <= 1:
        raise FitError(f"the share of the starts must be above 0 and at most 100 %, got {match['share']} %")
    return claim[: match.start()], share


def _vibration_phrase(claim: str, case: Case) -> tuple[Phrase, str] | None:
    """The phrase "vibration of x_ram" or "... x_ram - x_tool" with the dimension of both; None of others.

    Raises FitError with the displacements of the scene for another name.
    """
    match = _VIBRATION.match(claim)
    if match is None:
        return None
    scene = case.scene()
    units = {columns_of(body.name)[0]: scene.unit_of(body) for body in scene.line}
    names = match["names"].split(" - ")
    for name in names:
        if name not in units:
            hint = did_you_mean(name, list(units))
            raise FitError(f"{name} is no displacement of {case.name}{hint}; there are {', '.join(units)}")
    if len({units[name] for name in names}) > 1:
        raise FitError(f"{match['names']}: one is a length and one an angle")
    phrase = Phrase(match[0], VIBRATION + match["names"])
    return phrase, "angle" if units[names[0]] == "rad" else "length"


def _phrase_of(claim: str) -> Phrase:
    lower = claim.lower()
    for phrase in PHRASES:
        if lower == phrase.words or lower.startswith(f"{phrase.words} "):
            return phrase
    words = list(dict.fromkeys(phrase.words for phrase in PHRASES))
    near = did_you_mean(" ".join(re.split(r"\b(?:is|between|at|above|below)\b", lower)[0].split()), words)
    raise FitError(f"unknown words{near}; a statement is {FORM}, WHAT one of: {', '.join(words)}")


def _argument(tail: str, phrase: Phrase, observable: Observable) -> tuple[str, float]:
    """The quantity behind the phrase, such as the 4.5 Hz that are passed, and what follows it."""
    if not observable.argument:
        return tail, 0.0
    match = re.match(rf"({NUMBER}\s*\S+)(?:\s+|$)", tail)
    if match is None:
        raise FitError(f"{phrase.words} what? Such as {phrase.words} 4.5 Hz before 120 s")
    return tail[match.end() :], _number(match[1], observable.argument)


def _windowed(tail: str, asked: Asked, observable: Observable, case: Case) -> tuple[str, Asked]:
    """The tail without the window that it names, and the observable within that window."""
    padded, t_end = f" {tail}", case.number("run.t_end")
    last, over = _LAST.search(padded), _OVER.search(padded)
    after = _AFTER.search(padded) if observable.dimension != "time" else None
    match = last or over or after
    if match is None:
        return tail, asked
    if not observable.windowed:
        raise FitError(f"{asked.name} is of the whole run; it takes no span of time")
    if last:
        asked = Asked(asked.name, asked.argument, last=_number(last["last"], "time"))
        begin, end = t_end - asked.last, t_end
    else:
        begin, end = (
            _ends(over["low"], over["high"], "time") if over else (_number(match["after"], "time"), inf)
        )
        asked = Asked(asked.name, asked.argument, (begin, end))
    if not 0 <= begin < min(end, t_end):
        raise FitError(f"its span of time is not within the run, 0 to {t_end:g} s (run.t_end)")
    return padded[: match.start()].strip(), asked


def _bounds(tail: str, phrase: Phrase, observable: Observable) -> Bounds:
    if observable.words is not None:
        if tail:
            raise FitError(f"{shown(tail)} after {phrase.words}: a verdict takes no range")
        code = float(observable.words[phrase.verdict])
        return Bounds(code, code)
    one_sided, between = _ONE_SIDED.fullmatch(tail), _BETWEEN.fullmatch(tail)
    if one_sided:
        end = _number(one_sided["end"], observable.dimension)
        return Bounds(high=end) if " ".join(one_sided["side"].split()) in UPPER else Bounds(low=end)
    if between is None:
        tail_text = f", got {shown(tail)}" if tail else ""
        raise FitError(f"{phrase.words} needs a range: {RANGES}{tail_text}")
    return Bounds(*_ends(between["a"] or between["b"], between["high"], observable.dimension))


def _ends(low: str, high: str, dimension: str) -> tuple[float, float]:
    """Both ends; the lower one may leave its unit to the upper."""
    unit = re.sub(rf"^{NUMBER}\s*", "", high)
    bare = re.fullmatch(NUMBER, low.strip()) is not None
    ends = _number(f"{low} {unit}" if bare else low, dimension), _number(high, dimension)
    if ends[0] > ends[1]:
        raise FitError(f"a range must rise, got {low} to {high}")
    return ends


def _number(text: str, dimension: str) -> float:
    """A quantity as statements count it: SI, but Hz for an angular rate."""
    if dimension == "share":
        number, percent, rest = text.partition("%")
        if percent and not rest.strip():
            return parse_quantity(number, "number").number() / 100
        return parse_quantity(text, "number").number()
    quantity: Quantity = parse_quantity(text, dimension)
    if dimension == "angular rate":
        return float(quantity.value) if quantity.per_turn else float(quantity.value) / (2 * pi)
    return quantity.number()


# A reading: values put in place of printed ones, such as J=0.006 kg m^2, c=0.005 N s/m.
#
# It is judged beside what a search finds.


PRINTED = "as given"
READING, SEARCHED = "reading", "search"


@dataclass(frozen=True)
class Candidate:
    """A candidate: the values that it changes in every case.

    Attributes
    ----------
    number : in the order in which candidates were made
    origin : PRINTED, READING or SEARCHED
    changes : dotted key -> text with unit
    leaving : what leaving the printed values costs
    """

    number: int
    origin: str
    changes: dict[str, str]
    leaving: float

    def __str__(self) -> str:
        named = (f"{key.rpartition('.')[2]} = {text}" for key, text in self.changes.items())
        return ", ".join(named) or PRINTED


def read_reading(cases: list[Case], text: str) -> dict[str, str]:
    """The changes that `text` spells, tried in every case. Raises FitError."""
    changes: dict[str, str] = {}
    for part in text.split(","):
        key, equals, value = (word.strip() for word in part.partition("="))
        if not key or not equals or not value:
            raise FitError(
                f"reading {text!r}: {part.strip()!r} is not KEY=VALUE, such as J=0.006 kg m^2, c=0.005 N s/m"
            )
        try:
            full = cases[0].full_key(key)
            for case in cases:
                case.quantity(full)
                case.with_values({full: value})
        except UnknownKeyError as error:
            raise FitError(f"reading {text!r}: {key}: {error}") from None
        except CaseError as error:
            raise FitError(
                f"reading {text!r}: {error.problems[0].key}: {error.problems[0].message}"
            ) from None
        if full in changes:
            raise FitError(f"reading {text!r}: {key} is given twice")
        changes[full] = value
    return changes


def leaving_price(cases: list[Case], changes: dict[str, str], free: tuple[FreeParameter, ...]) -> float:
    """Penalty of the changes: of a free parameter its own, of another number that of a usual free one."""
    prices = {each.key: each for each in free}
    return sum(
        sum(_price(case, key, text, prices.get(key)) for case in cases) / len(cases)
        for key, text in changes.items()
    )


def _price(case: Case, key: str, text: str, free: FreeParameter | None) -> float:
    changed, printed = case.with_values({key: text}).quantity(key), case.quantity(key)
    if free is not None:
        return free.price(float(changed.value / UNITS[free.unit].factor))
    return LEAVE * _decades(changed, printed)


def _decades(value: Quantity, printed: Quantity) -> float:
    """Powers of ten between two values; 1 where there is no ratio, 0 for the same."""
    a, b = value.number(), printed.number()
    return abs(log10(a / b)) if a * b > 0 else float(a != b)


# A parameter that a fit may change: its range, how the range is divided, and what leaving its value costs.
#
# J=0.5:20 g m^2          from 0.5 to 20 g m^2; by ratio, as the ends are positive and 5 times apart or more
# c=linear 0.001:0.05     in equal steps;  c=log 1e-3:2e-3  by ratio


LEAVE = 0.1  # penalty for a factor of 10, or of the whole width of a range in equal steps
DIGITS = 4  # significant ones of a value that is tried, so that it can be written down
FAR_APART = 5.0  # ratio of the ends from which a range is divided by ratio
SCALES = ("log", "linear")


@dataclass(frozen=True)
class FreeParameter:
    """One parameter.

    Attributes
    ----------
    key : dotted key of the case
    unit : of the numbers
    low, high : ends of the range
    by_ratio : whether the search divides the range by ratio
    printed : value in each case
    leave : penalty for leaving it by a factor of 10 (by the whole width where not `by_ratio`)
    """

    key: str
    unit: str
    low: float
    high: float
    by_ratio: bool
    printed: tuple[float, ...]
    leave: float = LEAVE

    @property
    def name(self) -> str:
        """The last part of the key; of a named body or part as an axis of a sweep is called."""
        section, *names = self.key.split(".")
        return scale_name(self.key) if section == "bodies" or len(names) > 1 else names[-1]

    def value(self, place: float) -> float:
        """The value at a place from 0 to 1 of the range, rounded to DIGITS digits and within it."""
        if self.by_ratio:
            value = exp(log(self.low) + place * (log(self.high) - log(self.low)))
        else:
            value = self.low + place * (self.high - self.low)
        return min(self.high, max(self.low, float(f"{value:.{DIGITS}g}")))

    def text(self, value: float) -> str:
        """The value as a case takes it."""
        return f"{value!r} {self.unit}".strip()

    def price(self, value: float) -> float:
        """Penalty for leaving the printed value for this one, on the average of the cases."""
        return self.leave * sum(self._distance(value, each) for each in self.printed) / len(self.printed)

    def _distance(self, value: float, printed: float) -> float:
        if self.by_ratio and printed > 0:
            return abs(log10(value / printed))
        return abs(value - printed) / (self.high - self.low)

    def __str__(self) -> str:
        printed = " and ".join(dict.fromkeys(f"{value:g}" for value in self.printed))
        how = "by ratio" if self.by_ratio else "in equal steps"
        return (
            f"{self.name} {self.low:g} to {self.high:g} {self.unit}".strip() + f", {how}, printed {printed}"
        )


def read_free(cases: list[Case], key: str, text: str, leave: float | None = None) -> FreeParameter:
    """The parameter that `key` and the range `text` describe, both ends tried in every case.

    Raises FitError for a text that is no range and a key that is not one of a case's, CaseError where
    a case does not allow an end.
    """
    words = text.split(maxsplit=1)
    scale = words[0] if words[:1] and words[0] in SCALES else ""
    amount = text.strip().removeprefix(scale).strip()
    if amount.count(":") != 1:
        raise FitError(f"{key}={text}: a range is FROM:TO with a unit at the end, such as J=0.5:20 g m^2")
    try:
        axes = [read_axis(case, key, amount.replace(":", ",", 1), argument="free") for case in cases]
    except UnknownKeyError as error:
        raise FitError(f"free {key}: {error}") from None
    except ValueError as error:
        raise FitError(f"{key}={text}: {error}") from None
    full, unit = axes[0].key, axes[0].unit
    low, high = (float(value) for value in axes[0].values)
    if low > high:
        raise FitError(f"{key}={text}: a range must rise, got {low:g} to {high:g}")
    if scale == "log" and low <= 0:
        raise FitError(f"{key}={text}: a range by ratio must begin above 0")
    by_ratio = scale == "log" or (not scale and low > 0 and high / low >= FAR_APART)
    if leave is not None and not 0 <= leave < float("inf"):
        raise FitError(f"leave {key}={leave:g}: a penalty is at least 0")
    printed = tuple(printed_value(case, full, unit) for case in cases)
    return FreeParameter(full, unit, low, high, by_ratio, printed, LEAVE if leave is None else leave)


def printed_value(case: Case, key: str, unit: str) -> float:
    """The value of a case in that unit."""
    quantity = case.quantity(key)
    if quantity.value and quantity.per_turn != UNITS[unit].per_turn:
        raise FitError(f"{key}: {case.name} has {quantity}; turns and radians do not go together in a range")
    return float(quantity.value / UNITS[unit].factor)
