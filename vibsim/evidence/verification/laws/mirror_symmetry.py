"""V8: a scene seen in a mirror gives the mirrored trajectory, bit for bit."""

from collections.abc import Iterator
from functools import partial

import numpy as np

from vibsim.cases import Case, shipped_case_names
from vibsim.cases.values.quantities import Quantity
from vibsim.evidence.verification.check import Check
from vibsim.evidence.verification.row import Row, counted_row
from vibsim.evidence.verification.runs import flows_of, named_case, run

SPAN = "60 s"
NAMES = ("hard/contact-lost-as-it-sticks", "hard/separatrix-passage")  # with a start that is not at rest
FLIPPED: tuple[str, ...] = ("excitation.A", "excitation.A.e", "excitation.F0", "excitation.e")
FLIPPED += tuple(f"initial.{name}" for name in ("x1", "v1", "x2", "v2"))
ODD = ("x1", "v1", "x2", "v2", "friction")  # change sign; all else stays


def checks() -> list[Check]:
    """One check per case and flow."""
    listed = []
    for name in (*shipped_case_names(), *NAMES):
        case = mirrored_case(name)
        listed += [
            Check(f"V8/{name.rpartition('/')[2]}/{flow}", f"{name} in a mirror", partial(rows, name, flow))
            for flow in flows_of(case)
        ]
    return listed


def mirrored_case(name: str) -> Case:
    """The case that is mirrored."""
    return named_case(name, **({} if name.startswith("hard/") else {"run__t_end": SPAN}))


def mirrored(case: Case) -> Case:
    """The case in a mirror: signs of state and of A, F0 or e, and the stop on the other side."""
    changes = {}
    for key in FLIPPED:
        value = case.values.get(key)
        if isinstance(value, Quantity):
            text = value.text
            changes[key] = text[1:] if text.startswith("-") else f"-{text}"
    acts = case.values.get("stop.acts")
    if acts is not None:
        changes["stop.acts"] = "compression" if acts == "extension" else "extension"
    return case.with_values(changes)


def rows(name: str, flow: str, engine: str) -> Iterator[Row]:
    """How many numbers of samples and events are not the mirror images of the others."""
    case = mirrored_case(name)
    ours, theirs = (run(scene, engine, flow) for scene in (case, mirrored(case)))
    wrong = sum(
        differing(table[column], image[column], -1 if column in ODD else 1)
        for table, image in ((ours, theirs), (ours.events, theirs.events))
        for column in table
    )
    because = "the equations are odd, and so is rounding"
    yield counted_row(f"V8/{name.rpartition('/')[2]}/{flow}", "numbers that differ", 0, wrong, because)


def differing(values: np.ndarray, image: np.ndarray, sign: int) -> int:
    """Numbers that are not `sign` times their image; all of them where the lengths differ."""
    if len(values) != len(image):
        return max(len(values), len(image))
    return int(np.count_nonzero(values != sign * image))
