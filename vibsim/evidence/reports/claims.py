"""Claims of the paper, and the findings on them: pure functions of the table of measured numbers."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise, product
from statistics import median
from typing import Any

# The paper's own words: short quotes with their places, the only ones that the report may use.
#
# Each was read in the paper's text. Whoever changes or adds one reads it there again, and then brings the
# fingerprint in tests/evidence/reports/test_quotes.py up to date.


@dataclass(frozen=True)
class Quote:
    """A few words of the paper, and where they stand."""

    text: str
    place: str


QUOTES = {
    # the models
    "control values": Quote(
        "the first value (3.5 Hz) is below the natural frequency, the second (5.5 Hz) and the third (6.5 Hz) "
        "are above the value of the natural frequency of the vibro-impact model (ωn = 4.1 Hz)",
        "Section 2.2",
    ),
    "similar force": Quote(
        "the force of the non-ideal excitation is similar to the force of the ideal excitation", "Section 2.2"
    ),
    "amplitude": Quote("A = m3eω²", "Eq. (2.11)"),
    "no transition": Quote(
        "The system behaves periodically when there is no abrupt stiffness transition in the two-stage "
        "spring",
        "Section 2.1",
    ),
    "voltage": Quote(
        "Its variation is achieved by altering the current or voltage on the electric motor", "Section 2.2"
    ),
    "torque constant kept": Quote(
        "The torque constant was kept fixed and the angular velocity constant of the motor", "Section 2.2"
    ),
    # regimes
    "chaotic": Quote("For certain values of the parameters of the system, the motion is chaotic", "Abstract"),
    "responses": Quote(
        "the system shows periodic, quasi-periodic and chaotic responses, with and without the occurrence of "
        "abrupt transition of stiffness",
        "Section 2.1",
    ),
    "regular": Quote(
        "both types of excitation, the phase planes tend to become more regular with higher excitation "
        "frequencies",
        "Section 3",
    ),
    "period-1": Quote("with one impact at every cycle (period-1 limit-cycle) at 6.5 Hz", "Section 3"),
    # impacts
    "impacts more frequent": Quote(
        "As the frequency is increased and reaches 6.5 Hz, the impacts are more frequent and start occurring "
        "at every cycle",
        "Section 3",
    ),
    "number of impacts": Quote(
        "the number of impacts does not change considerably compared to the situation with 5.5 Hz",
        "Section 3",
    ),
    "very different": Quote(
        "the models present very different results according to the type of the excitation source, ideal or "
        "non-ideal, regarding the number of impacts and the rate of displacement",
        "Section 3",
    ),
    # drift and size
    "overall rate": Quote(
        "The overall displacement rate of the system increases reasonably as the frequency is increased",
        "Section 3",
    ),
    "cause": Quote("This can be the cause of the perceived increase in the displacement rate", "Section 3"),
    "rates higher": Quote(
        "The displacement rates are considerably higher than for the system with ideal excitation, and this "
        "happens for all analysed frequencies",
        "Section 3",
    ),
    "rate tends": Quote(
        "The displacement rate also tends to increase with higher excitation frequencies", "Section 3"
    ),
    "higher at 5.5": Quote("the situation with 5.5 Hz, which has a higher displacement rate", "Section 3"),
    "until 170 s": Quote(
        "at 6.5 Hz, the displacement increases rapidly until around 170 s, and after that it starts "
        "decreasing",
        "Section 3",
    ),
    "much larger": Quote(
        "The displacements and velocities are much larger for the non-ideal excitation source model",
        "Section 3",
    ),
    "values much larger": Quote(
        "presents values of displacement and velocity much larger in relation to the model with the ideal "
        "excitation source",
        "Section 4",
    ),
    # the motor
    "equilibrium": Quote(
        "Each characteristic curve shows that the motor reaches equilibrium for the system operating at "
        "different angular velocities",
        "Section 2.2",
    ),
    "determines a speed": Quote(
        "Each characteristic curve of the motor determines an angular velocity of the motor axis where the "
        "motor reaches the steady state",
        "Section 2.2",
    ),
    "additional power": Quote(
        "additional power supplied to the motor will only increase the amplitude of the oscillating system "
        "response, with little effect on the angular velocity of the energy source",
        "Section 1",
    ),
    "steady state": Quote(
        "the motor has reached a steady state angular frequency similar to the angular velocity constant of "
        "the motor",
        "Section 4",
    ),
    "Sommerfeld": Quote(
        "in the second and third situations, the motor exhibits the Sommerfeld effect", "Section 4"
    ),
    "cannot escape": Quote(
        "the angular velocity of the motor is captured by the resonance frequency of 4.1 Hz, from which the "
        "motor cannot escape",
        "Section 3",
    ),
    "cannot exceed": Quote(
        "the motor was captured by resonance (4.1 Hz) and cannot exceed this frequency", "Section 3"
    ),
    "initially captured": Quote("the motor is initially captured by resonance at 4.1 Hz", "Section 3"),
    "jumps": Quote(
        "after approximately 100 seconds, the motor reaches a sufficient condition to overcome this "
        "frequency and jumps to a frequency of approximately 6.2 Hz",
        "Section 3",
    ),
    "reaches constant": Quote(
        "manages to overcome it and reaches the value of the angular velocity constant", "Section 3"
    ),
    # conditions, slips and opinions: not judged
    "validity": Quote(
        "it is not valid when the absolute position of block 1 is greater than the absolute position of "
        "block 2",
        "Section 2.1",
    ),
    "smaller": Quote(
        "relative displacement between the blocks is smaller than this gap, impact occurs",
        "Section 2.1",
    ),
    "greater": Quote(
        "when the relative displacement between the blocks is greater than the gap", "Section 2.1"
    ),
    "two regions": Quote("the system is piecewise linear, consisting of two regions", "Section 2.1"),
    "complete": Quote(
        "more realistic, complete and complex than the model with the ideal excitation", "Abstract"
    ),
    "importance": Quote("the importance of using the non-ideal excitation source", "Section 4"),
    "helped": Quote(
        "A relationship between the forces provided by each source was defined which helped the comparison "
        "to be more realistic",
        "Section 4",
    ),
}


def said(*keys: str) -> tuple[Quote, ...]:
    """The quotes of these keys."""
    return tuple(QUOTES[key] for key in keys)


# A claim of the paper, and the finding on it: a pure function of the table of measured numbers.


HOLDS, ONLY_IF, IN_KIND = "holds", "holds only if", "holds in kind"
EXAMPLE, FAILS, OPEN = "holds, for example, with", "does not hold", "undecided"
VERDICTS = (HOLDS, ONLY_IF, IN_KIND, EXAMPLE, FAILS, OPEN)

# whose a criterion is
PAPERS = "the paper's own"
OURS = "ours: the paper gives none"
OUR_MARGIN = "the paper's numbers, our tolerance"

Numbers = dict[str, Any]


@dataclass(frozen=True)
class ClaimVerdict:
    """One of VERDICTS, and with what: the condition, the other numbers, or how it differs in kind."""

    word: str
    condition: str = ""

    def __str__(self) -> str:
        return f"{self.word} {self.condition}".strip()


@dataclass(frozen=True)
class Finding:
    """Verdict on a claim.

    Attributes
    ----------
    verdicts : on the motion from rest and over the perturbed starts; one alone where no start enters
    measured : the numbers it rests on, in words, one line each
    runs : names of the runs that they are from
    remark : what a reader should know besides
    basis : what it rests on besides the runs, or instead
    """

    verdicts: tuple[ClaimVerdict, ...]
    measured: tuple[str, ...]
    runs: tuple[str, ...] = ()
    remark: str = ""
    basis: str = ""

    @property
    def rest(self) -> ClaimVerdict:
        """On the motion from rest, or on what no start enters into."""
        return self.verdicts[0]

    @property
    def starts(self) -> ClaimVerdict | None:
        """Over the perturbed starts; None where no start enters."""
        return self.verdicts[1] if len(self.verdicts) > 1 else None


@dataclass(frozen=True)
class Claim:
    """A statement of the paper and how it is judged.

    Attributes
    ----------
    key : a short name, such as "II-B-captured"
    statement : what it is about, in our words
    quotes : the paper's words, with their places
    criterion : what would make it true, in words
    whose : whose that criterion is: PAPERS, OURS or OUR_MARGIN
    judge : from the table of numbers to the finding
    figures : keys of the figures that show it, such as "fig-16"
    pictures : names of the audit's own pictures that decide it, such as "drift"
    """

    key: str
    statement: str
    quotes: tuple[Quote, ...]
    criterion: str
    whose: str
    judge: Callable[[Numbers], Finding]
    figures: tuple[str, ...] = ()
    pictures: tuple[str, ...] = ()


def holds(true: bool) -> ClaimVerdict:
    """The verdict on a claim without conditions."""
    return ClaimVerdict(HOLDS if true else FAILS)


def with_numbers(true: Sequence[bool], numbers: str) -> ClaimVerdict:
    """The verdict on a claim that is true as printed, or else with other `numbers`, given as an example.

    true : as printed, and with those numbers
    """
    printed, otherwise = true
    return ClaimVerdict(EXAMPLE, numbers) if otherwise and not printed else holds(printed)


def only_if(true: Mapping[str, bool], what: str = "") -> ClaimVerdict:
    """The verdict on a claim about several situations: where it is true of some, with their names behind
    `what`.
    """
    names = [name for name, each in true.items() if each]
    if not names or len(names) == len(true):
        return holds(bool(names))
    return ClaimVerdict(ONLY_IF, f"{what} {words_of(names, 'or')}".strip())


# What the claims rest on, from the table of numbers: holds, ensembles, readings, in words.


MOST = 0.8  # share of an ensemble that makes a property of the system: four in five

True_of = Callable[[Numbers], bool]


def members(numbers: Numbers, name: str) -> list[Numbers]:
    """Numbers of the perturbed starts of a case."""
    outcomes: list[Numbers] = numbers["ensembles"][name]["outcomes"]
    return outcomes


def how_many(numbers: Numbers, name: str, true_of: True_of) -> tuple[int, int]:
    """For how many members of an ensemble something is true, and of how many."""
    outcomes = members(numbers, name)
    return sum(true_of(outcome) for outcome in outcomes), len(outcomes)


def mostly(numbers: Numbers, name: str, true_of: True_of) -> bool:
    """Whether it is true of four members in five."""
    count, total = how_many(numbers, name, true_of)
    return count >= MOST * total


def count_of(numbers: Numbers, name: str, true_of: True_of) -> str:
    """The count in words."""
    return of_all(*how_many(numbers, name, true_of))


def magnitudes(numbers: Numbers, name: str, key: str) -> list[float]:
    """Magnitudes of a number of every member that has it."""
    return [abs(each[key]) for each in members(numbers, name) if each.get(key) is not None]


def middle(numbers: Numbers, name: str, key: str) -> float:
    """Median of those magnitudes; 0 without any."""
    values = magnitudes(numbers, name, key)
    return median(values) if values else 0.0


def share_above(numbers: Numbers, one: str, other: str, key: str) -> float:
    """Share of the pairs of starts, one of each case, in which the first has the greater magnitude."""
    pairs = list(product(*(magnitudes(numbers, name, key) for name in (one, other))))
    return sum(ours > theirs for ours, theirs in pairs) / len(pairs) if pairs else 0.0


def rest_value(numbers: Numbers, name: str, key: str) -> float:
    """Magnitude from rest of what `magnitudes` has of the starts; 0 where undecided."""
    run = numbers["runs"][name]
    value = run["drift"]["rate"] if key == "drift" else run[key]
    return abs(value) if value is not None else 0.0


def commonest_regime(numbers: Numbers, name: str) -> str | None:
    """The regime of most perturbed starts."""
    regimes = Counter(str(each["regime"]) for each in members(numbers, name) if "regime" in each)
    return regimes.most_common(1)[0][0] if regimes else None


def capture_line(numbers: Numbers, name: str) -> str:
    """Verdict, hold, how far the vibration has grown at its end, and final speed, from rest."""
    run = numbers["runs"][name]
    capture, held = run["capture"], ""
    if capture["since"] is not None:
        until = "the end" if capture["until"] is None else seconds(capture["until"])
        held = f", held at {hz(capture['speed_hz'])} from {seconds(capture['since'])} to {until}{_reach(run)}"
    return f"{name} from rest: {capture['verdict']}{held}; final speed {hz(capture['final_speed_hz'])}"


def _reach(run: Numbers) -> str:
    reach = run["held"]["reach"]
    if reach["last"] is None or reach["before"] is None:
        return ""
    growth = 100 * (reach["last"] / reach["before"] - 1)
    return f", when x1 − x2 reaches {mm(reach['last'])} ({growth:+.1f} % in 50 s)"


def in_reading(numbers: Numbers, name: str) -> str:
    """The numbers that a reading changes, in words."""
    changes = numbers["runs"][name]["changes"]
    return typeset(
        " and ".join(f"{key} = {now} (printed: {printed})" for key, (now, printed) in changes.items())
    )


# Outcomes of a motor, from rest or from a perturbed start: settled, held, captured, let go.


NATURAL_HZ, NEAR_HZ = 4.1, 0.1  # the frequency at which the paper has motors captured, and how near that is
ABOUT_100 = (67.0, 150.0)  # [s] a factor 1.5 to either side
NO_LOAD_HZ, NEARLY_ESCAPED = 6.5, 0.02  # no-load speed of II-C, relative distance of a final speed from it


def is_settled(outcome: Numbers) -> bool:
    """Whether the mean speed stays within the band up to the end."""
    return outcome.get("verdict") not in (None, "undecided")


def is_held(outcome: Numbers) -> bool:
    """Whether the motor lingers below its no-load speed for a while."""
    return outcome.get("since") is not None


def is_captured(outcome: Numbers) -> bool:
    """Whether the motor is held up to the end."""
    return outcome.get("verdict") == "captured"


def near_natural(speed: float | None) -> bool:
    """Whether a motor is held at the paper's 4.1 Hz."""
    return speed is not None and abs(speed - NATURAL_HZ) <= NEAR_HZ


def is_brief_hold(capture: Numbers) -> bool:
    """Held and let go after about 100 s, by either reading of the words; however long a free run-up takes."""
    return is_released_at_100(capture) or is_held_for_100(capture)


def is_released_at_100(capture: Numbers) -> bool:
    """Let go about 100 s after the start."""
    return _let_go(capture) and ABOUT_100[0] <= capture["until"] <= ABOUT_100[1]


def is_held_for_100(capture: Numbers) -> bool:
    """Let go after a hold of about 100 s."""
    return _let_go(capture) and ABOUT_100[0] <= capture["until"] - capture["since"] <= ABOUT_100[1]


def _let_go(capture: Numbers) -> bool:
    """Whether a hold has ended; that the speed is still changing at the end does not undo it."""
    return capture.get("until") is not None


def is_near_no_load(speed_hz: float | None) -> bool:
    """Whether a final speed is that of the motor's constant."""
    return speed_hz is not None and abs(speed_hz / NO_LOAD_HZ - 1) <= NEARLY_ESCAPED


# Numbers as the report writes them.


def grows(values: Iterable[float]) -> bool:
    """Whether each value is greater than the one before it."""
    return all(below < above for below, above in pairwise(values))


def hz(value: float | None) -> str:
    """A frequency to 10 mHz."""
    return "unknown" if value is None else f"{value:.2f} Hz"


def mm(value: float | None) -> str:
    """A length [m] in mm, to three digits."""
    return "unknown" if value is None else f"{1e3 * value:.3g} mm"


def mm_per_s(value: float | None) -> str:
    """A slow velocity [m/s] in mm/s, to three digits."""
    return "undecided" if value is None else f"{1e3 * value:.3g} mm/s"


def drift_rate(drift: Mapping[str, Any]) -> str:
    """A measured drift with its uncertainty."""
    if drift["rate"] is None:
        return "undecided"
    return f"{1e3 * drift['rate']:.3g} ± {1e3 * drift['half_width']:.1g} mm/s"


def seconds(value: float | None) -> str:
    """A time to a second, short ones to three digits."""
    return "unknown" if value is None else f"{value:.0f} s" if value >= 100 else f"{value:.3g} s"


def between(least: float, greatest: float, unit: str) -> str:
    """Two ends to three digits, or the one number that they are."""
    ends = [f"{end:.3g}" for end in (least, greatest)]
    return f"{' to '.join(dict.fromkeys(ends))} {unit}".strip()


def of_all(count: int, total: int) -> str:
    """A count and its total, as "40 of 48"."""
    return f"{count} of {total}"


def percent(share: float) -> str:
    """A share in whole percent."""
    return f"{100 * share:.0f} %"


def words_of(names: Sequence[str], last: str = "and") -> str:
    """A list in words: "a", "a and b", "a, b and c"."""
    return f" {last} ".join(part for part in (", ".join(names[:-1]), *names[-1:]) if part)


def typeset(text: str) -> str:
    """Squares of units as they are printed."""
    return text.replace("^2", "²")
