"""V1: the paper's cases, against published figures and against stored runs of 40 digits.

Expected: 40- and 60-digit Taylor integrations by a program of its own, equal in all digits shown. Case I is
regular; the others are compared until chaos has taken the digits of a double.
"""

from collections.abc import Iterator
from functools import partial
from math import pi

from vibsim.cases import Case
from vibsim.evidence.verification.check import Check
from vibsim.evidence.verification.hard.hard_cases import BECAUSE, LUCK, UNITS, state_points
from vibsim.evidence.verification.row import Row, compared, counted_row, worst_row
from vibsim.evidence.verification.runs import flows_of, named_case, run
from vibsim.evidence.verification.truths.truth_file import read_truth

# state at 300 s as decimal texts; impacts, sticks, events
CASE_I: dict[str, tuple[dict[str, str], tuple[int, int, int]]] = {
    "I-A": (
        {
            "x1": "0.0049838576146675",
            "x2": "0.0050150524787833",
            "v1": "-0.0017985024624189",
            "v2": "-0.00037796325802528",
        },
        (630, 419, 3780),
    ),
    "I-B": (
        {
            "x1": "-0.0208657036721520",
            "x2": "-0.0233895811558076",
            "v1": "0.0056039388001598",
            "v2": "-0.0015125299416625",
        },
        (1466, 0, 6232),
    ),
    "I-C": (
        {
            "x1": "-0.0846686050797213",
            "x2": "-0.0868864712155865",
            "v1": "0.0795244964939589",
            "v2": "-0.0094857232508406",
        },
        (1948, 0, 7794),
    ),
}
# time [s] -> x2 [m], w / 2 pi [Hz], impacts
II_B = {20: ("0.003511", "4.00240", 115), 50: ("0.014103", "5.27362", 339)}
# until when the others are compared: errors of 1e-16 have then grown to millimetres
SPANS = {
    "I-A-eq211": "40 s",
    "I-B-eq211": "40 s",
    "I-C-eq211": "40 s",
    "II-A": "60 s",
    "II-B": "80 s",
    "II-C": "60 s",
}
PUBLISHED = "half a unit of the last digit published, and twice the stray of runs kicked as doubles round"


def checks() -> list[Check]:
    """One check per case and flow, and one of the checkpoints of II-B."""
    listed = []
    for name in (*CASE_I, *SPANS):
        case = judged_case(name)
        listed += [
            Check(f"V1/{name}/{flow}", case.title, partial(rows, name, flow)) for flow in flows_of(case)
        ]
    return [*listed, Check("V1/II-B-checkpoints/taylor", "II-B at 20 and 50 s, 50 digits", checkpoints)]


def judged_case(name: str) -> Case:
    """A case as it is verified: cut short where it turns chaotic."""
    return named_case(name, **({"run__t_end": SPANS[name]} if name in SPANS else {}))


def rows(name: str, flow: str, engine: str) -> Iterator[Row]:
    """States against the stored truth; Case I against its published figures too."""
    case = judged_case(name)
    result = run(case, engine, flow)
    truth = read_truth(name, case.sha256)
    if name in CASE_I:
        published, counts = CASE_I[name]
        points = [
            compared(
                f"{column} at 300 s",
                float(text),
                float(result[column][-1]),
                last_digit(text) / 2 + LUCK * truth.stray[flow][column][-1],
                UNITS[column],
            )
            for column, text in published.items()
        ]
        yield worst_row(f"V1/{name}/{flow}", points, PUBLISHED)
        for what, expected in zip(("impacts", "sticks", "events"), counts, strict=True):
            yield counted_row(f"V1/{name}/{flow}", what, expected, int(result.attrs[what]), "published count")
    yield worst_row(f"V1/{name}/{flow}", state_points(truth, result, flow), BECAUSE)


def last_digit(text: str) -> float:
    """One unit in the last place of a decimal text."""
    return 10.0 ** -len(text.partition(".")[2])


def checkpoints(engine: str) -> Iterator[Row]:
    """II-B before its chaos: rounding is 1e-13 there, so half a unit of the last digit is all."""
    name = "V1/II-B-checkpoints/taylor"
    for t, (drift, frequency, impacts) in II_B.items():
        result = run(named_case("II-B", run__t_end=f"{t} s"), engine)
        points = [
            compared(f"x2 at {t} s", float(drift), float(result["x2"][-1]), last_digit(drift) / 2, "m"),
            compared(
                f"speed at {t} s",
                float(frequency),
                float(result["phidot"][-1]) / (2 * pi),
                last_digit(frequency) / 2,
                "Hz",
            ),
        ]
        yield worst_row(name, points, "half a unit of the last digit published")
        yield counted_row(
            name, f"impacts until {t} s", impacts, int(result.attrs["impacts"]), "published count"
        )
