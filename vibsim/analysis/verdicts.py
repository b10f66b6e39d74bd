"""The words of verdicts, as enumerations whose members are these very texts."""

from enum import Enum


class Verdict(str, Enum):
    """A word out of a few; equal to its text, printed and written as it.

    >>> from vibsim.analysis import CaptureVerdict
    >>> CaptureVerdict.NOT_MET == "not met", f"{CaptureVerdict.NOT_MET}", CaptureVerdict("passed")
    (True, 'not met', <CaptureVerdict.PASSED: 'passed'>)
    """

    __str__ = str.__str__

    def __format__(self, format_spec: str) -> str:
        return str.__format__(self, format_spec)


class CaptureVerdict(Verdict):
    """Was a motor captured: see `vibsim.analysis.capture`."""

    CAPTURED = "captured"
    ESCAPED = "escaped"
    PASSED = "passed"
    NOT_MET = "not met"
    UNDECIDED = "undecided"


class DriftVerdict(Verdict):
    """Which way a body drifts; undecided where the interval of the rate contains 0 and more."""

    FORWARD = "forward"
    BACKWARD = "backward"
    NONE = "none"
    UNDECIDED = "undecided"


class ImpactsVerdict(Verdict):
    """In how many cycles of the source there are impacts, or of a friction sticks."""

    EVERY_CYCLE = "every cycle"
    SOME_CYCLES = "some cycles"
    NO_IMPACTS = "no impacts"
    NO_STICKS = "no sticks"
    UNDECIDED = "undecided"


class RegimeVerdict(Verdict):
    """What kind of motion it is."""

    AT_REST = "at rest"
    PERIODIC = "periodic"
    TRANSIENT = "transient"
    QUASI_PERIODIC = "quasi-periodic"
    CHAOTIC = "chaotic"
    UNDECIDED = "undecided"


class FrequenciesVerdict(Verdict):
    """Whether a displacement has dominant frequencies; still: nothing vibrates."""

    LINES = "lines"
    STILL = "still"
    UNDECIDED = "undecided"


class ComparisonVerdict(Verdict):
    """Whether two runs are the same."""

    IDENTICAL = "identical"
    AGREE = "agree"
    AGREE_UNTIL = "agree_until"
    AGREE_IN_STATISTICS = "agree_in_statistics"
    DIFFER = "differ"


def name_verdict(judged: object, kind: type[Verdict]) -> None:
    """Make the verdict of a frozen dataclass a member of its enumeration. Raises ValueError for others."""
    object.__setattr__(judged, "verdict", kind(judged.verdict))  # type: ignore[attr-defined]
