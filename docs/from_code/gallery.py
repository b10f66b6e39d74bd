"""The gallery's pages: every case is run and drawn while the site is built, and its numbers measured."""

import re
from collections.abc import Callable
from pathlib import Path

from from_code.gallery_equations import equations
from from_code.gallery_numbers import NUMBERS, Number, agreement
from from_code.gallery_studies import STUDIES
from from_code.markdown import code, fence, plain, table, with_code
from from_code.page_runs import fresh_processes, output
from vibsim import load_case, simulate
from vibsim.cases import Case
from vibsim.cases.sources import gallery_case_names
from vibsim.plots.machine import draw_machine_file
from vibsim.plots.picture import draw_files
from vibsim.plots.subject import View

HEAD = """# Gallery

Models of the literature and of mechanics, each run while this site was built. A page has the drawing, the
equations, the case, pictures of the motion and of a sweep or a phase portrait, what to try, and a number
that this run measured beside what it must be; the build fails where the two differ by more than the bound
that the page states. What it must be is of one of four kinds: a formula that the cited publication states,
a closed form of mechanics, what an independent solver found at the parameters of the source, or, where no
number comes from elsewhere, a law of conservation.

"""
Write = Callable[[Path, str], None]


def write_gallery(folder: Path, write: Write) -> None:
    """Write the index, and for each case a page with its pictures."""
    folder.mkdir(exist_ok=True)
    cases = [load_case(name) for name in gallery_case_names()]
    measured = {case.name: _measured(case.name) for case in cases}
    with fresh_processes() as pool:
        list(pool.map(draw, [case.name for case in cases], [folder] * len(cases)))
    for case in cases:
        write(folder / f"{case.name}.md", _page(case, measured[case.name]))
    write(folder / "index.md", _index(cases, measured))


def _measured(name: str) -> list[tuple[Number, float]]:
    return [(number, number.measured(name)) for number in NUMBERS[name]]


def draw(name: str, folder: Path) -> None:
    """The overview of a run, the machine alone, and the picture of its study, by the commands on its page."""
    case, study = load_case(f"gallery/{name}"), STUDIES[name]
    draw_machine_file(case, str(folder / f"{name}-machine.png"), True)
    run = folder / f"{name}.h5"
    simulate(case).save(run, force=True)
    draw_files([str(run)], None, View(), str(folder / f"{name}.png"), True)
    if study.sweep:
        output(f"vibsim sweep gallery/{name} {study.sweep} -o '{run}' --force -q")
    output(f"vibsim plot '{run}' --kind {study.kind} -o '{folder / name}-study.png' --force")
    run.unlink()


def _index(cases: list[Case], measured: dict[str, list[tuple[Number, float]]]) -> str:
    lines = [
        (
            f"[![{plain(case.name)}]({case.name}-machine.png)]({case.name}.md)",
            f"[{plain(case.name)}]({case.name}.md)<br>{plain(case.title)}",
            "; ".join(f"{plain(number.what)}: {agreement(number, value)}" for number, value in rows),
            "; ".join(dict.fromkeys(number.kind.value for number, _ in rows)),
        )
        for case, rows in ((case, measured[case.name]) for case in cases)
    ]
    names = "\n".join(case.name for case in cases)
    contents = f"```{{toctree}}\n:hidden:\n\n{names}\n```\n"
    return HEAD + table(("", "case", "agreement with what it must be", "which is"), lines) + "\n" + contents


def _page(case: Case, measured: list[tuple[Number, float]]) -> str:
    source, looked_at = (comment(case.text, label) for label in ("Source", "What to look at"))
    study = STUDIES[case.name]
    command = f"vibsim run gallery/{case.name}\nvibsim plot {case.name}.h5"
    first = f"vibsim sweep gallery/{case.name} {study.sweep} -o study.h5\n" if study.sweep else ""
    second = f"{first}vibsim plot {'study' if first else case.name}.h5 --kind {study.kind}"
    tries = [
        f"- `vibsim run gallery/{case.name} {options}`: {plain(words)}." for options, words in study.tries
    ]
    return "\n".join(
        [
            f"# {case.name}",
            "",
            f"{plain(case.title)}.",
            "",
            f"**Source.** {with_code(source)}",
            "",
            f"**What to look at.** {with_code(looked_at)}",
            "",
            f"![Drawing of {case.name}, with names and values]({case.name}-machine.png)",
            "",
            "## Equations",
            "",
            equations(case.text),
            "",
            "## The case",
            "",
            fence(_withoutcomment(case.text), "yaml"),
            "## A run",
            "",
            fence(command, "sh"),
            f"![Overview of a run of {case.name}: the machine, and its motion]({case.name}.png)",
            "",
            "## A sweep" if study.sweep else "## Another picture",
            "",
            fence(second, "sh"),
            f"{study.shows}.",
            "",
            f"![{study.shows}]({case.name}-study.png)",
            "",
            "## The number",
            "",
            _numbers(measured),
            "## What to try",
            "",
            *tries,
            "",
        ]
    )


def _numbers(measured: list[tuple[Number, float]]) -> str:
    rows = [
        (
            plain(number.what),
            code(f"{number.expected:.14g} {number.unit}".strip()),
            code(f"{value:.14g} {number.unit}".strip()),
            f"{agreement(number, value)}; bound "
            f"{plain(f'{number.within:g} {number.unit}')}: {number.because}",
            f"{number.kind.value}: {plain(number.origin)}",
        )
        for number, value in measured
    ]
    return table(("quantity", "expected", "vibsim", "agreement", "expected by"), rows)


def comment(text: str, label: str) -> str:
    """A paragraph of the comment at the top of a case file."""
    comment = re.sub(r"(?m)^# ?", "", text.partition("\n\nname:")[0])
    paragraphs = comment.split("\n\n")
    paragraph = next(each for each in paragraphs if each.startswith(f"{label}: ")).removeprefix(f"{label}: ")
    return paragraph[0].upper() + paragraph[1:]


def _withoutcomment(text: str) -> str:
    """A case file from its name on."""
    return text[text.index("\nname:") + 1 :]
