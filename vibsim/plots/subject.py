"""The subject of a picture (a run, a case, a sweep or a branch, with its name), and the view of it."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vibsim.cases.problems import one_line

if TYPE_CHECKING:
    from vibsim.physics.parts import Scene
    from vibsim.results.columns import Tables


@dataclass(frozen=True)
class Subject:
    """One file or case to be shown.

    Attributes
    ----------
    path : as the user gave it
    name : its name in legends, safe to draw as it is (see `user_text`)
    reads : "trajectory", "sweep", "branch", "locus", "fit", "bench" or "case", see `registry.Kind.reads`
    case : the Case, as far as it is known
    result : the open result file (None for a case)
    """

    path: str
    name: str
    reads: str
    case: Any
    result: Any = None

    @property
    def title(self) -> str:
        """Title of its case, safe to draw as it is."""
        return as_text(self.case.title)

    @property
    def stem(self) -> str:
        """Beginning of the names of its pictures: the file's name without suffix, or the name of the case."""
        return self.case.name if self.reads == "case" else file_stem(self.path)

    @property
    def holds_orbit(self) -> bool:
        """Whether it is one period of a periodic orbit."""
        return getattr(self.result, "orbit", None) is not None

    @cached_property
    def scene(self) -> Scene:
        """The scene behind it, made of parts."""
        scene: Scene = self.case.scene()
        return scene

    @cached_property
    def tables(self) -> Tables:
        """The columns of its run."""
        from vibsim.results.columns import tables_of

        return tables_of(self.scene)

    def columns_in(self, unit: str) -> tuple[str, ...]:
        """Names of the sampled states of bodies, of those that turn too: displacements for m, velocities for
        m/s.
        """
        return {"m": self.tables.displacements, "m/s": self.tables.velocities}[unit]

    def columns_alike(self, unit: str) -> list[tuple[str, ...]]:
        """The same in groups of one unit: of bodies that move along the line, and of those that turn."""
        columns = self.columns_in(unit)
        groups = [tuple(name for name in columns if self.turns(name) is turn) for turn in (False, True)]
        return [group for group in groups if group]

    def turns(self, column: str) -> bool:
        """Whether a displacement or velocity is that of a body that turns."""
        return (self.tables.samples[column].units or "").startswith("rad")

    def unit(self, unit: str, column: str) -> str:
        """The unit that stands for m, m/s or N in the motion of a column: rad, rad/s or N m of what turns."""
        return unit_for(unit, self.turns(column))

    def word(self, unit: str, column: str) -> str:
        """The quantity measured in the unit that stands for m, m/s or N in the motion of a column."""
        return measured(unit, self.turns(column))


# by the unit of what moves along the line: its name there; unit and name of what turns
TURNED = {
    "m": ("displacement", "rad", "angle"),
    "m/s": ("velocity", "rad/s", "angular velocity"),
    "N": ("force", "N m", "torque"),
}


def unit_for(unit: str, turns: bool) -> str:
    """The unit that stands for m, m/s or N: rad, rad/s or N m where bodies turn."""
    return TURNED[unit][1] if turns else unit


def measured(unit: str, turns: bool) -> str:
    """The quantity measured in m, m/s or N, or in the units that stand for them where bodies turn."""
    return TURNED[unit][2 if turns else 0]


def open_subject(path: str) -> Subject:
    """The subject that `path` names: an HDF5 file of vibsim, a YAML case file or a shipped case's name.

    Raises ResultFileError or CaseError when it is none of these.
    """
    from vibsim.results import names_a_result
    from vibsim.results.simulation import open_result

    if names_a_result(path):
        result = open_result(path)
        kind = str(result.attrs.get("vibsim_kind", "trajectory"))
        case = result.case
        return Subject(path, as_text(case.name), kind, case, result)
    from vibsim.cases import load_case

    case = load_case(path)
    return Subject(path, as_text(case.name), "case", case)


def subject_of(result: Any) -> Subject:
    """The subject that a result or a case in memory is; its path is the name of its case.

    Raises PlotError for anything else.
    """
    from vibsim.cases import Case

    if isinstance(result, Case):
        return Subject(result.name, as_text(result.name), "case", result)
    result = getattr(result, "run", result)  # an orbit is shown by the run of one period
    attrs = getattr(result, "attrs", {})
    if "vibsim_kind" not in attrs:
        raise PlotError(f"must be a result of vibsim or a case, got {result!r:.80}")
    case = result.case
    return Subject(case.name, as_text(case.name), str(attrs["vibsim_kind"]), case, result)


def open_subjects(paths: Sequence[str]) -> list[Subject]:
    """Subjects of several paths; where case names repeat, they go by as much of their paths as differs."""
    return told_apart([open_subject(path) for path in paths], paths)


def told_apart(subjects: Sequence[Subject], paths: Sequence[str]) -> list[Subject]:
    """The subjects under different names."""
    subjects = list(subjects)
    names = [subject.name for subject in subjects]
    repeated = [i for i, name in enumerate(names) if names.count(name) > 1]
    for i, name in zip(repeated, distinct_names([paths[i] for i in repeated]), strict=True):
        subjects[i] = replace(subjects[i], name=as_text(name))
    return subjects


def file_stem(path: str) -> str:
    """The name of a file without folder and suffix; II-B of runs/II-B.h5 and of II-B.h5.partial."""
    return Path(Path(path).name.removesuffix(".partial")).stem


def distinct_names(paths: Sequence[str]) -> list[str]:
    """The shortest ends of the paths, without suffix, that tell them apart; numbers where a file repeats."""
    parts = [(*Path(path).absolute().parent.parts, file_stem(path)) for path in paths]
    names = [file_stem(path) for path in paths]
    for length in range(1, max((len(each) for each in parts), default=0) + 1):
        names = ["/".join(each[-length:]) for each in parts]
        if len(set(names)) == len(set(parts)):
            break
    return [
        f"{name} ({names[: i + 1].count(name)})" if names.count(name) > 1 else name
        for i, name in enumerate(names)
    ]


# What the user asked to see: window, detail, width.


Span = tuple[float, float]

WIDTHS_CM = {"column": 8.6, "page": 17.8}
PAGE_FROM_CM = 14.0  # width from which panels stand side by side
SMALLEST_CM, LARGEST_CM = 3.0, 120.0


@dataclass(frozen=True)
class View:
    """How to look at the subjects.

    Attributes
    ----------
    window : first and last instant [s], or None: what suits the kind
    detail : the span enlarged in time histories [s], or None: the last seconds with impacts
    width : "column" (8.6 cm), "page" (17.8 cm), or None: what suits the kind
    size_cm : width and height [cm] of the picture, or None: what suits the kind
    x, y : the two columns that are drawn against each other, in the place of a kind
    canvas : what makes a figure, called as `matplotlib.figure.Figure` is; None: that
    poincare : whether phase portraits carry the points at which the periods of the source end
    """

    window: Span | None = None
    detail: Span | None = None
    width: str | None = None
    size_cm: tuple[float, float] | None = None
    x: str | None = None
    y: str | None = None
    canvas: Callable[..., Any] | None = None
    poincare: bool = False

    @property
    def width_cm(self) -> float:
        return self.size_cm[0] if self.size_cm else WIDTHS_CM[self.width or "column"]

    def for_kind(self, width: str) -> View:
        """The view, with the width that suits the kind unless the user says otherwise."""
        if self.size_cm:
            return replace(self, width="page" if self.size_cm[0] >= PAGE_FROM_CM else "column")
        return replace(self, width=self.width or width)


def parse_size(text: str) -> tuple[float, float]:
    """`12x8` as width and height [cm]. Raises PlotError."""
    width, times, height = text.lower().partition("x")
    try:
        size = float(width), float(height)
    except ValueError:
        size = (math.nan, math.nan)
    if not times or not all(SMALLEST_CM <= length <= LARGEST_CM for length in size):
        allowed = f"each {SMALLEST_CM:g} to {LARGEST_CM:g} cm"
        raise PlotError(f"{text!r} is no size: write WIDTHxHEIGHT in cm, such as 12x8, {allowed}")
    return size


def parse_span(text: object) -> Span:
    """`100:110`, `:20`, `100:` or (100, 110) as (first, last) [s], an open end infinite. Raises PlotError."""
    from vibsim.results.result import read_window

    try:
        return read_window(text)
    except ValueError as error:
        raise PlotError(str(error)) from None


# What a user can get wrong about a picture.


class PlotError(Exception):
    """One line, ready to print: an unknown or unfit kind, a window outside the run, an unknown suffix.

    >>> import vibsim
    >>> try:
    ...     vibsim.plot("II-B", "phase-portrait")
    ... except vibsim.PlotError as error:
    ...     print(str(error).partition(":")[0])
    unknown kind 'phase-portrait'
    """


# Names and titles of the user's in a picture: shown as they are, never obeyed.
#
# matplotlib takes text between two $ for mathematics, leaves labels that begin with _ out of legends, and
# writes control characters into SVG files, which no XML parser then reads.


HAIR_SPACE = "\u200a"


def check_one_unit(what: str, units: Sequence[tuple[str, str]]) -> None:
    """Raise PlotError where `what` has not the same unit in all files; units : of (path, unit)."""
    (first, unit), *rest = units
    for path, other in rest:
        if other != unit:
            raise PlotError(
                f"{what}: in {unit or 'no unit'} in {first}, in {other or 'no unit'} in {path}; draw them in "
                "pictures of their own"
            )


def as_text(text: object) -> str:
    """A user's text as matplotlib draws it letter by letter, on one line."""
    line = one_line(text).replace("$", r"\$")
    return HAIR_SPACE + line if line.startswith("_") else line
