"""vibsim new: a case file of one's own to start from."""

from pathlib import Path
from shlex import quote

import click

from vibsim.command_line.options import CASE, FILE, examples
from vibsim.command_line.terminal import print_json, say

DEFAULT = "gallery/drifting-capsule"  # two bodies, a link, a stop, a friction, forces: a bit of everything


@click.command(
    "new",
    short_help="Begin a case file of your own.",
    epilog=examples(
        "vibsim new capsule                           # capsule.yaml, from a scene with a bit of everything",
        "vibsim new my-motor --from II-B",
        "vibsim new cases/hammer.yaml --from gallery/pile-driver",
    ),
)
@click.argument("name", metavar="NAME", type=FILE)
@click.option(
    "--from", "source", metavar="CASE", type=CASE, default=DEFAULT, show_default=True,
    help="The case to begin from: a shipped one, a file, or - for standard input.",
)  # fmt: skip
@click.option("--force", is_flag=True, help="Replace a file that exists.")
@click.pass_context
def command(
    ctx: click.Context,
    name: str,
    source: str,
    force: bool,
) -> None:
    """Write NAME.yaml, a case file in which every key says what it is.

    The file holds the values of the case that it begins from and, in comments, the keys that may be added.
    """
    from vibsim.cases import load_case
    from vibsim.cases.case import commented_text
    from vibsim.results.output_files import output_file

    if not any(character.isalnum() for character in Path(name).name):
        raise click.BadParameter(f"a file needs a name, such as capsule; got {name!r}", param_hint="NAME")
    path = name if Path(name).suffix.lower() in (".yaml", ".yml") else f"{name}.yaml"
    text = commented_text(load_case(source), path)
    with output_file(path, force, "utf-8") as file:
        file.write(text)
    if ctx.obj.json:
        print_json({"written": [path], "from": source})
    elif not ctx.obj.quiet:
        say(f"{path} written; vibsim check {quote(str(path))} says whether it is right")
