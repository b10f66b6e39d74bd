"""The Python calls that continue a branch, and a special point of one in two parameters."""

import warnings
from collections.abc import Mapping
from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from vibsim.orbits.branches.branch import Branch, BranchStore, SpecialPoint, read_branch
from vibsim.orbits.branches.correction import ContinuationError
from vibsim.orbits.branches.curve import C, CurveStore, complete
from vibsim.orbits.branches.family import Family
from vibsim.orbits.branches.interpolant import shift
from vibsim.orbits.branches.locus_result import MOST_POINTS as MOST_LOCUS_POINTS
from vibsim.orbits.branches.locus_result import Locus, LocusStore, locus_plan
from vibsim.orbits.branches.node import Node, node_at
from vibsim.orbits.branches.plan import (
    BranchError,
    BranchPlan,
    energy_plan,
    parameter_within,
    plan_from,
    read_span,
)
from vibsim.orbits.branches.special_points import BRANCHING, DOUBLING, NAMES
from vibsim.orbits.branches.tracing import MOST_POINTS
from vibsim.orbits.coordinates import check_count
from vibsim.orbits.orbit import Orbit
from vibsim.orbits.search import opened, orbit
from vibsim.orbits.stability import directions, length_of, product
from vibsim.orbits.words import cyclic

Span = tuple[float, float] | tuple[tuple[float, float], str]


def continue_branch(
    orbit: Any,
    ranges: Mapping[str, str | Span] | str | None = None,
    span: str | Span = "",
    *,
    switch: str | None = None,
    energy: str | None = None,
    max_points: int = MOST_POINTS,
    out: str | PathLike[str] | None = None,
    force: bool = False,
) -> Branch:
    """Follow a periodic orbit over a parameter, both ways, through folds.

    Parameters
    ----------
    orbit : an `Orbit`, or what `vibsim.orbit` takes to find one: a case, a run, a stored orbit
    ranges : key of the case -> range of its values, such as {"Omega0": "3:9 Hz"}; KEY=KEY for several of one
        value; a range is a text, (0.01, 0.05) or ((3, 9), "Hz"); bare numbers are SI, a frequency needs its
        unit. A key alone has its range in `span`
    switch : label of a special point, such as "PD1": `orbit` is a Branch (or its file), and the branch that
        leaves it there is followed over the same range
    energy : range of the energy, such as "1e-5:0.1 J", in place of `ranges`: the backbone curve of a
        scene without damping, friction and source is followed; `orbit` may be a case that starts displaced
    max_points : of the branch, on both sides of the start together
    out : HDF5 file; one that holds a part of this very branch is completed, any other is an error unless
        `force`

    Returns a `Branch`. Raises BranchError, OrbitError, CaseError, UnknownKeyError, ResultFileError.

    >>> import vibsim
    >>> branch = vibsim.continue_branch("gallery/friction-oscillator", {"drive.A": "1.4:1.6 N"}, max_points=6)
    >>> len(branch["period"]) <= 6
    True
    """
    check_count("max_points", max_points, 2)
    _check_out(out)
    key, span = _one_range(ranges, span)
    if switch is not None:
        _leave_out("switch: its branch says what is followed", ranges=key, span=span, energy=energy)
        plan = switched(_branch(orbit, "switch"), switch)
    elif energy is not None:
        _leave_out("energy: it is what varies", ranges=key, span=span)

        plan = energy_plan(orbit, _as_text(energy, "0.01:1 J"))
    else:
        case, source = case_of(orbit)
        asked = read_span(case, key, _as_text(span))
        parameter_within(case, *asked)
        plan = plan_from(orbit_from(source), *asked)
    return _followed(BranchStore(plan, None if out is None else Path(out), force), max_points)


def continue_locus(
    branch: Branch | str | PathLike[str],
    ranges: Mapping[str, str | Span],
    *,
    label: str,
    max_points: int = MOST_LOCUS_POINTS,
    out: str | PathLike[str] | None = None,
    force: bool = False,
) -> Locus:
    """Follow a special point of a branch in the branch's parameter and a second one, both ways.

    Parameters
    ----------
    branch : a Branch, or its file
    ranges : the second parameter and its range, as in `continue_branch`: {"c": "0.001:0.1"}
    label : of a fold, doubling, Neimark-Sacker point, grazing or begin of sticking on it, such as "PD1"
    max_points : of the locus, on both sides of the start together
    out : HDF5 file; one that holds a part of this very locus is completed, any other is an error unless
        `force`

    Returns a `Locus`. Raises BranchError, UnknownKeyError, ResultFileError.

    >>> import vibsim
    >>> orbit = vibsim.orbit("I-C", {"omega": "4.2 Hz"}, period=1)
    >>> branch = vibsim.continue_branch(orbit, {"omega": "4:4.3 Hz"})
    >>> locus = vibsim.continue_locus(branch, {"c": "0.001:0.003 N s/m"}, label="PD1", max_points=8)
    >>> bool(locus["second"][-1] > locus["second"][0]), locus.kind
    (True, 'doubling')
    """
    check_count("max_points", max_points, 2)
    _check_out(out)
    start = _branch(branch, "a locus")
    key, span = _one_range(ranges, "")
    plan = locus_plan(start, label, *read_span(start.case, key, _as_text(span)))
    return _followed(LocusStore(plan, None if out is None else Path(out), force), max_points)


def _one_range(ranges: Any, span: str | Span) -> tuple[str, str | Span]:
    """The key that varies, and its range. Raises BranchError for more than one."""
    if not isinstance(ranges, Mapping):
        return ranges or "", span
    if len(ranges) != 1 or span:
        raise BranchError(f"one key varies along a curve, such as {{'Omega0': '3:9 Hz'}}, got {ranges!r:.60}")
    return next(iter(ranges.items()))


def _followed(store: CurveStore[Any, C], most: int) -> C:
    """Curve that a store holds in the end. Raises BranchError where a branch or a locus does not begin."""
    for note in store.notes:
        warnings.warn(note, stacklevel=3)
    try:
        return complete(store, most)[0]
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
    """Argument of a user, in one line."""
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

    if isinstance(source, Branch):
        raise BranchError(
            "a branch is no orbit: give the case of one of its points, such as branch.case_at(0), "
            "or switch= to follow what leaves it"
        )
    if isinstance(source, Orbit) and source.case is not None:
        return source.case, source
    case, result = opened(source, None)
    return case, case if result is None else result


def orbit_from(source: Any) -> Any:
    """An orbit with its case. Raises OrbitError, CaseError."""

    if isinstance(source, Orbit) and source.case is not None:
        return source

    return orbit(source)


# From a special point of a branch to the branch that leaves it there.
#
# At a period doubling the orbits of 2 n periods leave along the eigenvector of the multiplier -1: seen over 2
# n periods the doubling is a pitchfork, whose other curve has the tangent (v, 0) at first. At a branch point
# the other branch leaves along what of the kernel the known branch does not span.


FIRST, TRIES = 2.0**-8, 8  # scaled distance of the first orbit from the special point, halved so often


def switched(branch: Branch, label: str, span: tuple[float, float] | None = None) -> BranchPlan:
    """The plan of the branch that leaves another at its special point `label`.

    span : range of the parameter; that of the branch where it is left out

    Raises BranchError for a label that is none, or from which no branch leaves.
    """
    try:
        special = branch.special(label)
    except KeyError as error:
        raise BranchError(str(error.args[0])) from None
    if special.kind not in (DOUBLING, BRANCHING):
        raise BranchError(
            f"{label} is {NAMES[special.kind]}: branches leave doublings (PD) and branch points (BP)"
        )
    plan, times = branch.plan, 2 if special.kind == DOUBLING else 1
    longer = replace(plan, n=times * plan.n, span=span or plan.span)
    family = replace(longer, period=times * plan.period).family()
    orbit = special.orbit
    z = family.unknowns(np.array(orbit.state), times * orbit.period, orbit.parameter)
    node = _first(family, special, z)
    values = node.z * family.scale
    state = tuple(values[: len(special.orbit.state)].tolist())
    away = (node.z - z) / length_of(node.z - z)
    heading = () if times == 1 and _goes_through(family, z, node, away) else tuple(away.tolist())
    return replace(longer, state=state, period=node.point.period, parameter=node.parameter, heading=heading)


def _first(family: Family, special: SpecialPoint, z: np.ndarray) -> Node:
    """An orbit beside the special point z on the branch that leaves it. Raises BranchError."""
    direction = _direction(family, special, z)
    size, other = FIRST, None
    for _ in range(TRIES):
        try:
            node = node_at(family, z + size * direction, direction, None, 8 * size)
        except ContinuationError:
            size /= 2
            continue
        if length_of(node.z - z) > size / 2 and _is_new(family, special, node, size):
            if _begins_there(special, node):
                return node
            other = other or node
        size /= 2
    if other is None:
        raise BranchError(f"no orbit was found on the branch that leaves {special.label}")
    return other


def _goes_through(family: Family, z: np.ndarray, node: Node, away: np.ndarray) -> bool:
    """Whether the branch that leaves a branch point z by a node, along a unit vector, has orbits on the other
    side of its parameter, too.
    """
    size = length_of(node.z - z)
    try:
        other = node_at(family, z - size * away, away, None, 8 * size)
    except ContinuationError:
        return False
    return bool((node.z[-1] - z[-1]) * (other.z[-1] - z[-1]) < 0)


def _begins_there(special: SpecialPoint, node: Node) -> bool:
    """Whether an orbit has the order of events with which the branch leaves: one with another lies beyond a
    change of order, and may be on the far side of a fold, or of another branch.
    """
    times = 2 if special.kind == DOUBLING else 1
    return node.word in [cyclic(word * times) for word in (special.before, special.after)]


def _is_new(family: Family, special: SpecialPoint, node: Node, size: float) -> bool:
    """Whether an orbit is none of the branch that is left: at a doubling, none that repeats itself before."""
    if special.kind != DOUBLING:
        return True
    return length_of(shift(family, node, family.n // 2)) > size / 8


def _direction(family: Family, special: SpecialPoint, z: np.ndarray) -> np.ndarray:
    """Unit vector, scaled, along which the branch leaves."""
    if special.kind == DOUBLING:
        return _of_doubling(family, special, z)
    point = family(z)
    known = np.array(special.tangent)
    _, vectors, _ = directions(point.jacobian())
    across = product(vectors[-2:], known)
    direction = across[1] * vectors[-2] - across[0] * vectors[-1]
    return np.asarray(direction / length_of(direction))


def _of_doubling(family: Family, special: SpecialPoint, z: np.ndarray) -> np.ndarray:
    """The eigenvector of -1, with the change of the time of return that goes with it: none at first."""
    count = len(special.orbit.state)
    half = family.map(special.orbit.parameter).of(family.n // 2)
    end = half(np.array(special.orbit.state), None if half.section.timed else special.orbit.period)
    scale = family.scale[:count]
    matrix = end.derivative * (scale / scale[:, None])
    _, vectors, _ = directions(matrix + np.eye(count))
    direction: Any = np.zeros(len(z))
    direction[:count] = vectors[-1]
    return np.asarray(direction)
