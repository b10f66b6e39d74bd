"""vibsim verify: known cases and hard ones, computed afresh and held against what they should be."""

import click

from vibsim.command_line.options.examples import examples
from vibsim.command_line.options.parameters import CHECK, OneOf

ENGINES = ["auto", "c", "python"]


@click.command(
    "verify",
    short_help="Verify this installation against known cases.",
    epilog=examples(
        "vibsim verify                        # everything",
        "vibsim verify V3 V7                  # the bilinear oscillator, Coulomb friction",
        "vibsim verify hard/stiff -v          # and where the bounds come from",
        "vibsim verify --list",
        "vibsim verify hard --json | jq '.rows[] | select(.verdict != \"ok\")'",
        "vibsim run hard/stiff-stop           # a hard case as any other",
        before="Expected are closed forms, published figures, conservation laws, and for the hard cases runs "
        "of 40 digits that come with vibsim. Bounds follow from rounding and from the conditioning of each "
        "motion.",
    ),
)
@click.argument("names", metavar="[NAME]...", nargs=-1, type=CHECK)
@click.option("--list", "list_checks", is_flag=True, help="List the checks, or those named, and stop.")
@click.option("--engine", type=OneOf(ENGINES), default="auto", help="The engine that is verified.")
@click.pass_context
def command(
    ctx: click.Context,
    names: tuple[str, ...],
    list_checks: bool,
    engine: str,
) -> int:
    """Compute cases with known results, V1 to V21 and the hard ones, and print expected, obtained, error and
    bound of each.

    NAME is a check or how it begins; without any, all are computed (on the Python engine, but for those
    that would take it minutes). Exit code 4 where an error is not within its bound.
    """
    from vibsim.command_line.jobs.run_plan import check_engine
    from vibsim.command_line.jobs.verification import print_list, print_verification
    from vibsim.engine.choice import engine_name
    from vibsim.evidence.verification import UnknownCheckError
    from vibsim.evidence.verification.verifying import chosen_checks

    check_engine(engine)
    computed_by = engine_name(engine)
    try:
        chosen, left_out = chosen_checks(names, computed_by)
    except UnknownCheckError as error:
        raise click.UsageError(str(error)) from error
    if list_checks:
        print_list([*chosen, *left_out], ctx.obj)
        return 0
    return print_verification(chosen, left_out, computed_by, ctx.obj)
