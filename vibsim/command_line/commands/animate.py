"""vibsim animate: the machine of a run, moving."""

from __future__ import annotations

import click

from vibsim.cases.problems import counted
from vibsim.command_line.options import FILE, WINDOW, FiniteRange, examples
from vibsim.command_line.terminal import PROGRESS_AFTER, Progress, print_json, say
from vibsim.signals import interrupted_with


@click.command(
    "animate",
    short_help="Show the machine of a run, moving.",
    epilog=examples(
        "vibsim animate II-B.h5 -o II-B.mp4                        # the last 10 s, in real time",
        "vibsim animate II-B.h5 -o impact.gif --window 30:31 --speed 0.1",
        "vibsim animate capsule.h5 -o capsule.html                 # a page to stop and turn back",
    ),
)
@click.argument("file", metavar="FILE", type=FILE)
@click.option(
    "-o", "--output", metavar="FILE", type=FILE, required=True, help="The film: .mp4, .gif or .html."
)
@click.option(
    "--window", type=WINDOW, metavar="A:B", help="Show only this span [s]. [default: the last 10 s]"
)
@click.option(
    "--speed", type=FiniteRange(1e-5, 1e4), metavar="S",
    help="Seconds of motion per second of the film: 1 is real time, 0.1 ten times slower. "
    "[default: real time, or so much slower that the film lasts 5 s]",
)  # fmt: skip
@click.option("--force", is_flag=True, help="Replace an existing file.")
@click.pass_context
def command(
    ctx: click.Context,
    file: str,
    output: str,
    window: tuple[float, float] | None,
    speed: float | None,
    force: bool,
) -> None:
    """Write a moving picture of the run in FILE: the machine beside its phase portrait and time history.

    Springs stretch, stops light up where they touch, the rotor turns; gaps and displacements are to one
    scale. A page (.html) needs no network and can be stopped, slowed and turned back; an .mp4 needs ffmpeg,
    or vibsim[video].
    """
    from vibsim.plots.animated_machine import speed_text
    from vibsim.plots.animation import FilmWish, animate, too_short
    from vibsim.results.output_files import check_output

    check_output(output, force)
    with (
        Progress(not ctx.obj.quiet, PROGRESS_AFTER) as progress,
        interrupted_with(lambda: f"{output} is not written"),
    ):
        written = animate(
            file, output, FilmWish(window, speed), force, lambda n, of: progress.show(output, n, of)
        )
    if ctx.obj.json:
        print_json({"written": [output], "frames": written.frames, "speed": written.speed})
    elif not ctx.obj.quiet:
        frames, speed_words = counted(written.frames, "frame"), speed_text(written.speed)
        say(f"{output}: {frames}, {speed_words}{too_short(output, written)}")
