"""vibsim new: a case file of one's own to start from."""

import textwrap
from collections.abc import Iterator
from pathlib import Path
from shlex import quote
from typing import Any

import click

from vibsim.cases import Case, load_case
from vibsim.cases.schema import Section
from vibsim.cases.schema_keys import holds_names, section_models
from vibsim.cases.short_form import HEAD, flow, scalar
from vibsim.cases.validation import nested_values
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
def command(ctx: click.Context, name: str, source: str, force: bool) -> None:
    """Write NAME.yaml, a case file in which every key says what it is.

    The file holds the values of the case that it begins from and, in comments, the keys that may be added.
    """
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


# A case as YAML text in which every key says what it is: a file to start one's own from.
#
# The comments are the descriptions of the schema. Keys that may be left out and are stand in comments, with
# an example.


COLUMN = 34  # where comments begin
LONGEST = 96  # characters of a line of a comment


def commented_text(case: Case, name: str) -> str:
    """The text, to be a file called `name`; reads back to the same motion."""
    return "\n".join([*_head(case, name), *_sections(case)]) + "\n"


def _head(case: Case, name: str) -> Iterator[str]:
    yield f"# A case of vibsim, begun from {case.name}."
    yield "#"
    yield f"#   vibsim check {name}            is everything right?"
    yield f"#   vibsim cases {name} --draw     what the machine looks like"
    yield f"#   vibsim run {name}"
    yield "#"
    yield "# Numbers without a unit are SI; angular rates need one (Hz, rpm, rad/s)."
    yield ""
    yield _line("", f"title: {scalar(case.title or case.name)}", "one line on what the case shows")


def _sections(case: Case) -> Iterator[str]:
    values, model = nested_values(case.model), case.model
    for section, field in type(model).keys.items():
        if section in (*HEAD, "extends"):
            continue
        yield ""
        if not values.get(section):
            yield "\n#   ".join(textwrap.wrap(f"# {section}: {field.description}", COLUMN + LONGEST))
        elif holds_names(field.annotation):
            yield _line("", f"{section}:", field.description)
            yield from _parts(field.annotation, values[section])
        else:
            content = type(getattr(model, section))
            yield _line("", f"{section}:", _summary(content))
            yield from _keys(content, "  ", values[section], suggest=False)


def _parts(annotation: Any, parts: dict[str, Any]) -> Iterator[str]:
    """Parts by name; what the keys mean, and which more there are, is said at the first."""
    models = [model for _, model in section_models(annotation)]
    for place, (name, part) in enumerate(parts.items()):
        if not models:
            yield f"  {scalar(name)}: {flow(part)}"
            continue
        yield f"  {scalar(name)}:"
        yield from _keys(models[0], "    ", part, explain=place == 0, suggest=place == 0)


def _keys(
    model: type[Section], indent: str, values: dict[str, Any], explain: bool = True, suggest: bool = True
) -> Iterator[str]:
    """The keys of a section, those that it may have too.

    explain : whether to say what the keys mean
    suggest : whether to name those that it has not, with an example
    """
    free = [key for key in values if key not in model.keys]
    for key, field in model.keys.items():
        if key in values:
            yield _line(indent, f"{key}: {flow(values[key], key)}", field.description if explain else "")
        elif suggest and field.examples and not free:
            yield _line(indent, f"# {key}: {field.examples[0]}", field.description)
    for key in free:
        yield _line(indent, f"{key}: {flow(values[key], key)}", "number of the formula" if explain else "")


def _line(indent: str, text: str, comment: str | None) -> str:
    """A key and what it means; a meaning that is longer than a line goes on below, in the same column."""
    line = f"{indent}{text}"
    if not comment:
        return line
    first, *more = textwrap.wrap(comment, LONGEST)
    return "\n".join([f"{line:{COLUMN}}  # {first}", *(f"{'':{COLUMN}}  #   {rest}" for rest in more)])


def _summary(model: type[Section]) -> str:
    return (model.__doc__ or "").strip().splitlines()[0]
