"""vibsim info: what a result file holds."""

from collections.abc import Callable, Mapping
from typing import Any

import click

from vibsim.command_line.options import FILE, Settings, examples
from vibsim.command_line.terminal import print_json, say
from vibsim.command_line.text import heading, print_lines, result_lines, size, summary_object
from vibsim.results import Result, kind_of
from vibsim.results.hdf5_reading import plain
from vibsim.results.simulation import open_result


@click.command(
    "info",
    short_help="Say what a result file holds.",
    epilog=examples(
        "vibsim info II-B.h5",
        "vibsim info runs/*.h5 --json | jq .impacts",
        "vibsim info II-B.h5 --case > again.yaml       # the case file as it was given",
    ),
)
@click.argument("files", metavar="FILE...", nargs=-1, required=True, type=FILE)
@click.option("--case", "case_only", is_flag=True, help="Print the case file that was run, and nothing else.")
@click.pass_context
def command(
    ctx: click.Context,
    files: tuple[str, ...],
    case_only: bool,
) -> None:
    """Say what each result FILE holds, where it comes from and what came of the run."""

    for path in files:
        if case_only:
            print_case(path, ctx.obj)
        else:
            print_description(path, ctx.obj)


# Describe a result file: a trajectory here, a sweep by the sweeps, others by their tables.


TOLD = (
    "case_yaml",
    "case_resolved_json",
    "case_name",
    "title",
    "case_sha256",
    "date_created",
    "platform",
    "doubts_json",
)
LONGEST = 80  # characters of an attribute


def print_case(path: str, settings: Settings) -> None:
    """Print the YAML text that a result file was computed from."""
    text = open_result(path).attrs["case_yaml"]
    if settings.json:
        print_json({"file": path, "case_yaml": text})
    else:
        say(text, nl=False, lines=True)


def print_description(path: str, settings: Settings) -> None:
    """Print what a result file holds."""
    kind = kind_of(path)
    printers = {"bench": _print_bench, "fit": _print_fit, "branch": _print_branch, "locus": _print_locus}
    if kind in printers:
        printers[kind](path, settings)
        return
    if kind != "trajectory":
        _print_sweep(path, settings)
        return
    result = open_result(path)
    if settings.json:
        print_json(summary_object(result, path))
    elif not settings.quiet:
        _print_trajectory(result, path, settings)


def _print_sweep(path: str, settings: Settings) -> None:
    from vibsim.sweeps import describe

    lines, facts = describe(path)
    if settings.json:
        print_json({"file": path, **facts})
    elif not settings.quiet:
        print_lines([*lines, *(attribute_lines(facts) if settings.verbose else ())])


def _print_bench(path: str, settings: Settings) -> None:
    from vibsim.command_line.commands.bench import print_bench
    from vibsim.evidence.benchmark.bench_result import facts

    bench = open_result(path)
    if settings.json:
        print_json({"file": path, **facts(bench)})
    elif not settings.quiet:
        print_bench(bench, path, more=attribute_lines(bench.attrs) if settings.verbose else ())


def _print_fit(path: str, settings: Settings) -> None:
    from vibsim.command_line.commands.fit import print_fit
    from vibsim.fitting.fit_result import facts

    _print_whole(path, settings, facts, print_fit)


def _print_branch(path: str, settings: Settings) -> None:
    from vibsim.command_line.commands.continuation import print_branch
    from vibsim.orbits.branches.branch import facts

    _print_whole(path, settings, facts, print_branch)


def _print_locus(path: str, settings: Settings) -> None:
    from vibsim.command_line.commands.continuation import print_locus
    from vibsim.orbits.branches.locus_result import locus_facts

    _print_whole(path, settings, locus_facts, print_locus)


def _print_whole(
    path: str, settings: Settings, facts: Callable[[Any], dict[str, Any]], show: Callable[..., None]
) -> None:
    """The summary printed when the file was made, with its attributes if asked for."""
    result = open_result(path)
    if settings.json:
        print_json({"file": path, **facts(result)})
    elif not settings.quiet:
        more = attribute_lines(result.attrs) if settings.verbose else ()
        show(result, f"{path} ({size(path)})", more)


def _print_trajectory(result: Result, path: str, settings: Settings) -> None:
    attrs = result.attrs
    say(heading(attrs["case_name"], attrs["title"]))
    print_lines(
        [
            *result_lines(result),
            ("samples", f"{len(result)} x {', '.join(result.keys())}"),
            ("events", f"{len(result.events['t'])} x {', '.join(result.events)}"),
            ("written", written_text(attrs)),
            ("fingerprint", attrs["case_sha256"]),
            *(attribute_lines(attrs) if settings.verbose else ()),
            ("file", f"{path} ({size(path)})"),
        ]
    )


def attribute_lines(attrs: Mapping[str, Any]) -> list[tuple[str, str]]:
    """The attributes of the file that the other lines do not tell, by their names."""
    items = ((name, plain(value)) for name, value in attrs.items() if name not in TOLD)
    texts = [f"{name} = {value}" for name, value in items if len(str(value)) < LONGEST]
    return [("" if i else "attributes", text) for i, text in enumerate(texts)]


def written_text(attrs: Mapping[str, Any]) -> str:
    """When, by what and where a file was written."""
    took = f" in {attrs['wall_time_s']:.3g} s" if "wall_time_s" in attrs else ""
    parts = ("vibsim", "Python", "numpy")
    versions = ", ".join(f"{part} {attrs[f'{part.lower()}_version']}" for part in parts)
    return f"{attrs['date_created']}{took}; {versions}; {attrs['platform']}"
