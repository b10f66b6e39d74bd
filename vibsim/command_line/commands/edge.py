"""vibsim edge: what lies between two attractors, and how far an attractor is from its edge."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import click

from vibsim.cases.problems import counted
from vibsim.cases.quantities import number
from vibsim.command_line.commands.orbit import Lines, orbit_lines, orbit_object
from vibsim.command_line.commands.run import hdf5_name
from vibsim.command_line.main import FILE_TROUBLE, told
from vibsim.command_line.options import CASE, FILE, Settings, examples, set_option
from vibsim.command_line.terminal import print_json, say
from vibsim.command_line.text import heading, print_lines, size
from vibsim.orbits.orbit import save_orbit
from vibsim.results.hdf5_reading import ResultFileError
from vibsim.results.output_files import check_output
from vibsim.signals import interrupted_with

if TYPE_CHECKING:
    from vibsim.sweeps.basin_edges import BasinEdge, UnstableRest
    from vibsim.sweeps.basin_shocks import FatalShock
    from vibsim.sweeps.basin_starts import BasinEnd


@click.command(
    "edge",
    short_help="Find what lies between two attractors: the saddle on their boundary.",
    epilog=examples(
        "vibsim edge cantilever.h5 --between 0,1 -o saddle.h5     # attractors of a sweep",
        "vibsim edge gallery/cantilever --between clear.h5,strikes.h5    # stored orbits or runs, or cases",
        "vibsim continue saddle.h5 --param base.omega=12.5:14Hz   # the saddle over the frequency",
        "vibsim edge cantilever.h5 --shock 1                      # the least shock that ends motion 1",
        "vibsim edge cantilever.h5 --shock 1 --along tip.v",
        "vibsim edge belt.h5 --changes                            # over a parameter: births and deaths",
        before="Numbers are attractors of a sweep with --compute attractor; 2m is the mirror image of 2.",
    ),
)
@click.argument("source", metavar="CASE|SWEEP", type=CASE)
@click.option("--between", metavar="A,B", help="Two attractors of SWEEP, or two starts.")
@click.option("--shock", metavar="A", help="The smallest shock that takes a motion out of its basin.")
@click.option("--along", metavar="KEY", help="Of --shock: in this initial value alone, such as tip.v.")
@click.option(
    "--changes", "births", is_flag=True, help="Births and deaths over SWEEP's parameter, and by what."
)
@set_option
@click.option("-o", "--output", type=FILE, metavar="FILE", help="Store the saddle orbit.")
@click.option("--force", is_flag=True, help="Replace an existing output file.")
@click.pass_context
def command(
    ctx: click.Context,
    source: str,
    between: str | None,
    shock: str | None,
    along: str | None,
    births: bool,
    changes: tuple[tuple[str, str], ...],
    output: str | None,
    force: bool,
) -> int:
    """Find the saddle orbit on the boundary between the basins of two attractors, by edge tracking.

    A and B are numbers of attractors in the file of a sweep with --compute attractor, or starts: files of
    orbits, files of runs or cases, of which the initial state counts. Starts are brought together by
    bisection and followed along the boundary until they stay near an orbit, which Newton's method then finds.
    Its two sides are run to their ends. Where there is none, a sentence says what lies on the boundary.
    """
    if sum((between is not None, shock is not None, births)) != 1:
        raise click.UsageError("give one of --between A,B, --shock A and --changes")
    wish = EdgeWish(source, dict(changes), output, force)
    if shock is not None:
        if output is not None:
            raise click.UsageError("--shock finds no orbit, so -o has nothing to store")
        return find_shock(wish, shock, along, ctx.obj)
    if births:
        if along is not None or output is not None or changes:
            raise click.UsageError("--changes reads SWEEP alone; leave --along, -o and -s out")
        return find_changes(wish, ctx.obj)
    if along is not None:
        raise click.UsageError("--along is the direction of --shock, which is not given")
    if output is not None:
        check_output(hdf5_name(output), force)
    return find_edge(wish, _two_names(between or ""), ctx.obj)


@dataclass(frozen=True)
class EdgeWish:
    """Options of a command line that every search of `vibsim edge` takes."""

    source: str
    changes: dict[str, str]
    output: str | None
    force: bool


def _two_names(text: str) -> tuple[str, str]:
    names = [name.strip() for name in text.split(",")]
    if len(names) != 2 or not all(names):
        raise click.BadParameter(
            f"{text!r} is not A,B: two attractors of a sweep such as 0,1, or two starts such as a.h5,b.h5",
            param_hint="'--between'",
        )
    return names[0], names[1]


def find_edge(wish: EdgeWish, names: tuple[str, str], settings: Settings) -> int:
    """Find the saddle between two attractors, print and store it; returns the exit code."""
    from vibsim.sweeps.basin_edges import edge

    with interrupted_with(lambda: f"{wish.output} is not written" if wish.output else ""):
        found = edge(wish.source, *names, wish.changes or None)
        trouble = _stored(found, wish)
    if settings.json:
        print_json({**({"file": wish.output} if wish.output and not trouble else {}), **edge_object(found)})
    elif not settings.quiet:
        say(heading(found.case.name, found.case.title))
        print_lines(edge_lines(found))
        if wish.output and not trouble and found.orbit is not None:
            print_lines([("file", f"{wish.output} ({size(wish.output)})")])
    return 0 if trouble is None else told(f"Error: {trouble}", FILE_TROUBLE, as_json=False)


def _stored(found: BasinEdge, wish: EdgeWish) -> ResultFileError | None:
    """Store the orbit where that is asked for; why it could not be."""
    if wish.output is None:
        return None
    if found.orbit is None:
        return ResultFileError(f"{wish.output}: not written; a state of rest is no orbit")
    try:
        save_orbit(found.orbit, wish.output, wish.force)
    except ResultFileError as error:
        return error
    return None


def find_shock(wish: EdgeWish, name: str, along: str | None, settings: Settings) -> int:
    """Find the smallest shock that takes a motion out of its basin, and print it; returns the exit code."""
    from vibsim.sweeps.basin_shocks import fatal_shock

    shock = fatal_shock(wish.source, name, along, wish.changes or None)
    if settings.json:
        print_json(shock_object(shock))
    elif not settings.quiet:
        say(heading(shock.case.name, shock.case.title))
        print_lines(shock_lines(shock))
    return 0


def find_changes(wish: EdgeWish, settings: Settings) -> int:
    """Locate births and deaths of the attractors of a sweep over a parameter, and print them."""
    from vibsim.sweeps.attractor_changes import attractor_changes
    from vibsim.sweeps.sweep_result import open_sweep

    sweep = open_sweep(wish.source)
    changes = attractor_changes(sweep)
    if settings.json:
        print_json({"file": wish.source, "changes": [change.plain() for change in changes]})
    elif not settings.quiet:
        say(heading(sweep.case.name, sweep.case.title))
        print_lines([change.line(sweep.attractors.words(change.attractor)) for change in changes])
        if not changes:
            say("  every attractor is there at all values of the parameter")
    return 0


# What was found, for people and for programs.


def edge_lines(found: BasinEdge) -> Lines:
    """Label and text of what lies on the boundary."""
    one, other = found.between
    lines = [("between", f"{one.words}; and {other.words}")]
    if set(found.sides) != set(found.between):
        lines.append(("", "on the way from one to the other lies another basin, beside which the saddle is"))
    lines.append(
        ("sides", f"beside the saddle starts end on {' and on '.join(end.words for end in found.sides)}")
    )
    lines.append(("boundary", _pair_text(found)))
    lines.append(("search", f"{counted(found.rounds, 'bisection')}, {counted(found.runs, 'run')}"))
    if found.orbit is not None:
        return [*lines, *orbit_lines(found.orbit)]
    assert found.rest is not None
    return [*lines, *_rest_lines(found.rest)]


def _pair_text(found: BasinEdge) -> str:
    """Point at which the boundary was met first, in words."""
    inside = found.pair[0]
    return "met at " + ", ".join(f"{name} {number(value, 10)}" for name, value in inside.items())


def _rest_lines(rest: UnstableRest) -> Lines:
    state = ", ".join(f"{name} {number(value, 10)}" for name, value in rest.state.items())
    rates = ", ".join(number(rate, 6) for rate in rest.rates)
    return [("saddle", f"an unstable state of rest, no orbit: {state}"), ("exponents", f"{rates} 1/s")]


def edge_object(found: BasinEdge) -> dict[str, Any]:
    """The same as plain data, numbers in SI."""
    facts: dict[str, Any] = {
        "between": [_end_object(end) for end in found.between],
        "sides": [_end_object(end) for end in found.sides],
        "boundary": list(found.pair),
        "bisections": found.rounds,
        "runs": found.runs,
    }
    if found.rest is not None:
        facts["rest"] = {"state": found.rest.state, "exponents": list(found.rest.rates)}
    return facts | (orbit_object(found.orbit) if found.orbit is not None else {})


def _end_object(end: BasinEnd) -> dict[str, Any]:
    """An attractor as plain data."""
    label = end.label
    periodic = label.kind == "periodic"
    return {
        "kind": label.kind,
        "period": int(label.period) if periodic else None,
        "largest_multiplier": label.multiplier if periodic else None,
        "state": end.orbit.state if end.orbit is not None else None,
    }


def shock_lines(shock: FatalShock) -> Lines:
    """Label and text of the smallest shock that ends a motion."""
    lines = [("motion", shock.end.words)]
    if shock.along is None:
        changes = ", ".join(f"{name} {number(value, 8)}" for name, value in shock.change.items())
        lines.append(("least shock", f"{number(shock.size, 8)} m/s: {changes}"))
        lines.append(("", "displacements count by a natural rate, as velocities; the rest in SI"))
    else:
        lines.append(
            ("least shock", f"{number(shock.change[shock.along], 10)} {shock.unit} in {shock.along}")
        )
        other = "none found" if shock.other_way is None else f"{number(shock.other_way, 10)} {shock.unit}"
        lines.append(("other way", other))
    if len(shock.end.points) > 1:
        lines.append(("at", f"return {shock.point + 1} of {len(shock.end.points)} to the section"))
    lines.append(("ends on", shock.destination.words))
    lines.append(("search", counted(shock.runs, "run")))
    return lines


def shock_object(shock: FatalShock) -> dict[str, Any]:
    """The same as plain data, numbers in SI."""
    return {
        "motion": _end_object(shock.end),
        "along": shock.along,
        "shock": shock.change,
        "other_way": shock.other_way,
        "size": shock.size,
        "return": shock.point,
        "ends_on": _end_object(shock.destination),
        "runs": shock.runs,
    }
