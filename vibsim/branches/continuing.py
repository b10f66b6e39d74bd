"""The Python calls that continue a branch, and a special point of one in two parameters."""

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from os import PathLike
from pathlib import Path
from typing import Any

from vibsim.branches.branch import Branch
from vibsim.branches.curve.arclength import ContinuationError
from vibsim.branches.loci.locus_plan import locus_plan
from vibsim.branches.loci.locus_result import MOST_POINTS as MOST_LOCUS_POINTS
from vibsim.branches.loci.locus_result import Locus
from vibsim.branches.plan import BranchError, parameter_within, plan_from
from vibsim.branches.span import read_span
from vibsim.branches.store.branch_file import read_branch
from vibsim.branches.store.branch_store import BranchFileStore, BranchStore
from vibsim.branches.store.locus_file import LocusStore
from vibsim.branches.switching import switched
from vibsim.branches.tracing.tracing import MOST_POINTS, Watch, trace
from vibsim.orbits.errors import check_count

Span = tuple[float, float] | tuple[tuple[float, float], str]


def continue_branch(
    orbit: Any,
    key: str = "",
    span: str | Span = "",
    *,
    switch: str | None = None,
    energy: str | None = None,
    max_points: int = MOST_POINTS,
    engine: str = "auto",
    out: str | PathLike[str] | None = None,
    force: bool = False,
) -> Branch:
    """Follow a periodic orbit over a parameter, both ways, through folds.

    Parameters
    ----------
    orbit : an `Orbit`, or what `vibsim.orbit` takes to find one: a case, a run, a stored orbit
    key : of the case, such as "excitation.Omega0", or KEY=KEY for several of one value
    span : range of its values, such as "3:9 Hz", (3, 9) or ((3, 9), "Hz"); bare numbers are in SI units,
        those of an angular rate in Hz
    switch : label of a special point, such as "PD1": `orbit` is a Branch (or its file), and the branch that
        leaves it there is followed over the same range
    energy : range of the energy, such as "1e-5:0.1 J", in place of `key` and `span`: the backbone curve of a
        scene without damping, friction and source is followed; `orbit` may be a case that starts displaced
    max_points : of the branch, on both sides of the start together
    out : HDF5 file; one that holds a part of this very branch is completed, any other is an error unless
        `force`

    Returns a `Branch`. Raises BranchError, OrbitError, CaseError, UnknownKeyError, ResultFileError.

    >>> import vibsim
    >>> branch = vibsim.continue_branch("gallery/friction-oscillator", "drive.A", "1.4:1.6 N", max_points=6)
    >>> len(branch["period"]) <= 6
    True
    """
    check_count("max_points", max_points, 2)
    _check_out(out)
    if switch is not None:
        _leave_out("switch: its branch says what is followed, and how far", key=key, span=span, energy=energy)
        plan = switched(_branch(orbit, "switch"), switch)
    elif energy is not None:
        _leave_out("energy: it is what varies", key=key, span=span)
        from vibsim.branches.backbone import energy_plan

        plan = energy_plan(orbit, _as_text(energy, "0.01:1 J"), engine)
    else:
        case, source = case_of(orbit)
        asked = read_span(case, key, _as_text(span))
        parameter_within(case, *asked)
        plan = plan_from(orbit_from(source, engine), *asked)
    store = BranchStore(plan, engine) if out is None else BranchFileStore(plan, Path(out), engine, force)
    for note in store.notes:
        warnings.warn(note, stacklevel=2)
    with _as_branch_error():
        return complete(store, max_points, engine)[0]


def continue_locus(
    branch: Branch | str | PathLike[str],
    label: str,
    key: str,
    span: str | Span,
    *,
    max_points: int = MOST_LOCUS_POINTS,
    engine: str = "auto",
    out: str | PathLike[str] | None = None,
    force: bool = False,
) -> Locus:
    """Follow a special point of a branch in the branch's parameter and a second one, both ways.

    Parameters
    ----------
    branch : a Branch, or its file
    label : of a fold, doubling, Neimark-Sacker point, grazing or begin of sticking on it, such as "PD1"
    key, span : the second parameter and its range, as in `continue_branch`
    max_points : of the locus, on both sides of the start together
    out : HDF5 file; one that holds a part of this very locus is completed, any other is an error unless
        `force`

    Returns a `Locus`. Raises BranchError, UnknownKeyError, ResultFileError.

    >>> import vibsim
    >>> orbit = vibsim.orbit("I-C", {"omega": "4.2 Hz"}, period=1)
    >>> branch = vibsim.continue_branch(orbit, "omega", "4:4.3 Hz")
    >>> locus = vibsim.continue_locus(branch, "PD1", "c", "0.001:0.003 N s/m", max_points=8)
    >>> bool(locus["second"][-1] > locus["second"][0]), locus.kind
    (True, 'doubling')
    """
    check_count("max_points", max_points, 2)
    _check_out(out)
    start = _branch(branch, "a locus")
    plan = locus_plan(start, label, *read_span(start.case, key, _as_text(span)))
    store = LocusStore(plan, None if out is None else Path(out), engine, force)
    for note in store.notes:
        warnings.warn(note, stacklevel=2)
    with _as_branch_error():
        return store.complete(max_points)[0]


@contextmanager
def _as_branch_error() -> Iterator[None]:
    """What is not found where a branch or a locus begins is told as a BranchError."""
    try:
        yield
    except ContinuationError as error:
        raise BranchError(str(error)) from error


def _check_out(out: Any) -> None:
    """Raise BranchError for what names no file."""
    if out is not None and not isinstance(out, str | PathLike):
        raise BranchError(f"out is the name of a file, such as 'branch.h5', got {_shown(out)}")


def _leave_out(reason: str, **arguments: Any) -> None:
    """Raise BranchError for arguments that would be ignored, for a reason."""
    passed = [
        name
        for name, value in arguments.items()
        if not (value is None or (isinstance(value, str) and not value))
    ]
    if passed:
        raise BranchError(f"{reason}; leave {' and '.join(passed)} out")


def _shown(source: Any) -> str:
    """What a user passed, in one line."""
    return repr(source).partition("\n")[0][:60]


def _branch(source: Any, what: str) -> Branch:
    """A branch, or the one in a file, for what needs one. Raises BranchError, ResultFileError."""
    if isinstance(source, Branch):
        return source
    if not isinstance(source, str | PathLike):
        raise BranchError(f"{what} needs a branch or the file of one, got {_shown(source)}")
    return read_branch(Path(source))


def _as_text(span: str | Span, example: str = "3:9 Hz") -> str:
    """A range as the command line has it. Raises BranchError for what is none."""
    if isinstance(span, str):
        return span
    try:
        ends, unit = span if isinstance(span[1], str) else (span, "")
        low, high = (repr(float(end)) for end in ends)
    except (TypeError, ValueError, IndexError):
        numbers, in_unit = example.split()
        pair = numbers.replace(":", ", ")
        words = f'a range is a text such as "{example}", ({pair}) or (({pair}), "{in_unit}")'
        raise BranchError(f"{words}, got {span!r:.60}") from None
    return f"{low}:{high} {unit}".strip()


def case_of(source: Any) -> tuple[Any, Any]:
    """The case of an orbit, or of what one is looked for from, and that: read, where it was the name of it.

    Raises OrbitError, CaseError, ResultFileError.
    """
    from vibsim.orbits.orbit import Orbit
    from vibsim.orbits.search.seeking import opened

    if isinstance(source, Branch):
        raise BranchError(
            "a branch is no orbit: give the case of one of its points, such as branch.case_at(0), "
            "or switch= to follow what leaves it"
        )
    if isinstance(source, Orbit) and source.case is not None:
        return source.case, source
    case, result = opened(source, None)
    return case, case if result is None else result


def orbit_from(source: Any, engine: str = "auto") -> Any:
    """An orbit with its case. Raises OrbitError, CaseError."""
    from vibsim.orbits.orbit import Orbit

    if isinstance(source, Orbit) and source.case is not None:
        return source
    from vibsim.orbits.search.seeking import orbit

    return orbit(source, engine=engine)


def complete(
    store: BranchStore, most: int, engine: str = "auto", watch: Watch | None = None
) -> tuple[Branch, bool]:
    """Trace what a store lacks of its branch; the branch, and whether that came to an end."""
    with store:
        store.complete = trace(store.plan, store, most, engine, watch)
    return store.branch, store.complete
