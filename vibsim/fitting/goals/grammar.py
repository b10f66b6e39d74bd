"""The language of statements, read.

[CASE:] WHAT [RANGE] [WINDOW] [from SHARE of the starts] [, weight N]

captured until the end                             released between 80 and 120 s
II-C: settles between 6.1 and 6.3 Hz               passes 4.5 Hz before 120 s
drift rate at least 0.1 mm/s after 100 s           regime is periodic from every start
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from math import inf, pi
from typing import TYPE_CHECKING

from vibsim.cases.problems import shown
from vibsim.cases.spelling import did_you_mean
from vibsim.cases.values.quantities import NUMBER, Quantity, QuantityError, parse_quantity
from vibsim.fitting.errors import FitError
from vibsim.fitting.goals.bounds import Bounds
from vibsim.fitting.goals.observables import OBSERVABLES, Observable, missing_of
from vibsim.fitting.goals.statement import MOST, Asked, Statement

if TYPE_CHECKING:
    from vibsim.cases import Case


@dataclass(frozen=True)
class Phrase:
    """How a statement begins: the words, the observable they stand for, and the verdict they name."""

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
    phrase = _phrase_of(claim)
    observable = OBSERVABLES[phrase.name]
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
    """What is left of the tail, and what is asked within the window that it names."""
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
        raise FitError(f"its span of time is not within the run, 0 to {t_end:g} s")
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
