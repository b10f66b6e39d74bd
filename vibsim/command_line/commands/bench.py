"""vibsim bench: speed against error, vibsim beside its peers."""

from typing import Any

import click
from click.shell_completion import CompletionItem

from vibsim.command_line.options.examples import examples
from vibsim.command_line.options.parameters import CASE, FILE, FiniteRange, set_option
from vibsim.command_line.terminal.printing import say

DEFAULT_CASE = "II-B"
LIMIT = 20.0


class Methods(click.ParamType):
    """Names of families of methods, separated by commas."""

    name = "methods"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> list[str]:
        from vibsim.evidence.benchmark.errors import BenchError
        from vibsim.evidence.benchmark.families import families_named

        names = [name.strip() for name in value.split(",") if name.strip()]
        try:
            families_named(names)
        except BenchError as error:
            self.fail(str(error), param, ctx)
        return names

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        from vibsim.evidence.benchmark.families import FAMILIES

        done, comma, begun = incomplete.rpartition(",")
        names = [family.name for family in FAMILIES if family.name.startswith(begun)]
        return [CompletionItem(done + comma + name) for name in names]


@click.command(
    "bench",
    short_help="Measure speed against error, beside other solvers.",
    epilog=examples(
        "vibsim bench                                   # II-B, into II-B-bench.h5; some minutes",
        "vibsim bench I-C --t-end 20s --plot I-C.png",
        "vibsim bench II-B --methods taylor,heyoka,dop853",
        "vibsim bench gallery/impact-oscillator-coco    # impacts per second, errors beside them",
        "vibsim bench II-B -o again.h5 --truth II-B-bench.h5",
        before="Every method gives the same states, and is judged by a run of many digits (which needs the "
        "extra [reference]). Run it on a quiet machine.",
    ),
)
@click.argument("source", metavar="[CASE]", required=False, type=CASE)
@set_option
@click.option("--t-end", metavar="TIME", help="End of the span. [default: that of the case, at most 100 s]")
@click.option(
    "--methods", type=Methods(), default="", metavar="NAME[,NAME..]",
    help="Who takes part: closed-form, taylor, orders, python, heyoka, dop853, lsoda, radau, rk45, tanh, "
    "rk4. [default: all]",
)  # fmt: skip
@click.option(
    "--limit", type=FiniteRange(min=0, min_open=True), default=LIMIT, metavar="SECONDS",
    show_default=True, help="A run is stopped after so long.",
)  # fmt: skip
@click.option("--truth", type=FILE, metavar="FILE", help="Take the truth from this bench.")
@click.option("-o", "--output", type=FILE, metavar="FILE", help="Output file. [default: NAME-bench.h5]")
@click.option("--plot", "picture", type=FILE, metavar="FILE", help="Draw it too: a .png, .pdf or .svg file.")
@click.option("--force", is_flag=True, help="Replace existing output files.")
@click.pass_context
def command(
    ctx: click.Context,
    source: str | None,
    changes: tuple[tuple[str, str], ...],
    t_end: str | None,
    methods: list[str],
    limit: float,
    truth: str | None,
    output: str | None,
    picture: str | None,
    force: bool,
) -> int:
    """Measure what vibsim and other solvers take for CASE, and how right they are.

    For every method: time, impacts per second, steps, right-hand sides, events found, missed and made up,
    errors, and until when it is faithful (error within 1 mm, or a twentieth of the largest displacement where
    that is less). A method that cannot take the case says so. CASE is a YAML file, the name of a shipped
    case, - for standard input, or the HDF5 file of a run.
    """
    from vibsim.command_line.jobs.bench import read_plan, run_jobs

    if source is None:
        source = DEFAULT_CASE
        if not ctx.obj.quiet:
            say(f"no case given: measuring {source}", err=True)
    plan = read_plan(source, dict(changes), t_end, methods, limit)
    return run_jobs(plan, output, picture, truth, force, ctx.obj)
