"""vibsim orbit: the periodic motions of a case, stable or not."""

import click

from vibsim.command_line.options.examples import examples
from vibsim.command_line.options.parameters import CASE, FILE, OrbitDigitCount, set_option
from vibsim.command_line.options.shared_options import engine_option


@click.command(
    "orbit",
    short_help="Find periodic motions, stable or not, and their multipliers.",
    epilog=examples(
        "vibsim orbit I-A                              # where the run of the case goes to",
        "vibsim orbit II-B.h5 -o orbit.h5              # where a stored run goes to",
        "vibsim orbit II-B -s Omega0=5.1Hz --from orbit.h5   # the same orbit at another speed",
        "vibsim orbit I-A --at-start                   # near its initial state: another one",
        "vibsim orbit gallery/bilinear-oscillator --search 50 --seed 1",
        "vibsim orbit I-C --digits 40 --json",
        "vibsim run orbit.h5 --t-end 60s               # start on it",
        before="Events are spelled b e (contact begins, ends), r (reversal), s u (stick begins, ends), i t c "
        "(impact, blow passed on, chatter), h o (rest begins, ends), with the number of the part where there "
        "are several.",
    ),
)
@click.argument("source", metavar="CASE|FILE", type=CASE)
@set_option
@click.option("--from", "start", type=FILE, metavar="FILE", help="A stored orbit near which to look.")
@click.option(
    "--at-start",
    is_flag=True,
    help="Look near the initial state of the case, not where its run leads.",
)
@click.option(
    "--period", type=click.IntRange(min=1), metavar="N",
    help="Periods of the source, or turns of the motor. [default: as the run repeats itself]",
)  # fmt: skip
@click.option(
    "--search",
    type=click.IntRange(min=1),
    metavar="K",
    help="Look from K random starts, and list all orbits.",
)
@click.option("--seed", type=click.IntRange(min=0), metavar="S", help="Of the random starts. [default: 0]")
@click.option(
    "--digits", type=OrbitDigitCount(), metavar="D", help="Refine orbit and multipliers to so many digits."
)
@engine_option
@click.option("-o", "--output", type=FILE, metavar="FILE", help="Store the orbit; of several NAME-1.h5, ...")
@click.option("--force", is_flag=True, help="Replace existing output files.")
@click.pass_context
def command(
    ctx: click.Context,
    source: str,
    changes: tuple[tuple[str, str], ...],
    start: str | None,
    at_start: bool,
    period: int | None,
    search: int | None,
    seed: int | None,
    digits: int | None,
    engine: str,
    output: str | None,
    force: bool,
) -> int:
    """Find the periodic orbit that CASE or the run in FILE goes to, by Newton's method on the return map.

    The section is phase 0 of forces and base, phi = 0 of a motor, or where a body turns round that nothing
    drives. The orbit need not be stable. It is
    periodic up to a drift of bodies that nothing ties to ground or base.
    """
    from vibsim.command_line.jobs.orbit import Wish, find_one, search_all

    wish = Wish(source, dict(changes), start, at_start, period, digits, engine, output, force)
    wish.check()
    if at_start and (start is not None or search is not None):
        raise click.UsageError(
            f"--at-start is a start of its own; leave {'--from' if start else '--search'} out"
        )
    if search is None:
        if seed is not None:
            raise click.UsageError("--seed draws the starts of --search, which is not given")
        return find_one(wish, ctx.obj)
    if start is not None:
        raise click.UsageError("--search draws its own starts; leave --from out")
    return search_all(wish, search, seed or 0, ctx.obj)
