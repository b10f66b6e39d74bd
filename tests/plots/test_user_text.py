"""Titles and file names of the user's in pictures: shown letter by letter, whatever they hold."""

import shutil
import xml.etree.ElementTree as ElementTree

import pytest
from matplotlib.cbook import is_math_text
from matplotlib.text import Text

from tests.formula_cases import MACHINE, case_of
from vibsim.cases import load_case
from vibsim.plots.picture import draw_files
from vibsim.plots.registry import kind_named
from vibsim.plots.subject import View, as_text, open_subject, open_subjects
from vibsim.results import simulate_to_file

NASTY = [
    "$x^{2 $", "{brace $\\frac{1}$", "\\$5 and \\\\$6$ \\alpha", "x\x1b[2J\x1b]0;PWN\x07",
    "control \x01\x0b\x7f\x9b", "100 % _under_ ^{up} <b>&amp;", "振動 \U0001f600",
]  # fmt: skip


def drawn(text):
    """What matplotlib makes of a text that it takes for no mathematics."""
    assert not is_math_text(text)
    return text.replace(r"\$", "$")


@pytest.mark.parametrize("title", NASTY)
def test_a_title_is_drawn_letter_by_letter(title):
    text = drawn(as_text(title))
    assert text.isprintable()
    assert [ch for ch in title if not ch.isprintable() or ch not in text] == [
        ch for ch in title if not ch.isprintable()
    ]


def test_a_name_stays_in_the_legend():
    assert not as_text("_run").startswith("_")
    assert as_text("_run").strip() == "_run"


@pytest.fixture(scope="module", params=[NASTY[0], " ".join(NASTY)], ids=["power", "all"])
def nasty_run(request, tmp_path_factory):
    """A run whose title and file name are hostile."""
    title = request.param
    path = tmp_path_factory.mktemp("nasty") / f"_{title[:40]}.h5"
    simulate_to_file(load_case("II-B", {"title": title, "run.t_end": "0.5 s"}), path)
    return str(path)


def test_pictures_of_hostile_files_can_be_read(nasty_run, tmp_path):
    [svg] = draw_files([nasty_run], None, View(), str(tmp_path / "one.svg"))
    ElementTree.parse(svg)
    other = str(tmp_path / "again.h5")
    shutil.copy(nasty_run, other)
    for kind in ("motor", "stiffness"):
        [svg] = draw_files([nasty_run, other], [kind], View(), str(tmp_path / f"{kind}.svg"))
        ElementTree.parse(svg)


MACHINE_KINDS = ["rotor-speed", "states"]  # of runs with rotors and states; of the others see test_kinds.py


@pytest.fixture(scope="module")
def brief_machine(tmp_path_factory):
    path = tmp_path_factory.mktemp("machine") / "brief.h5"
    simulate_to_file(case_of(MACHINE, {"run.t_end": "0.2 s"}), path)
    return str(path)


@pytest.mark.parametrize("kind", MACHINE_KINDS)
def test_no_kind_lets_matplotlib_read_a_name(kind, brief_machine, tmp_path):
    paths = [str(tmp_path / f"{name}.h5") for name in ("a$\\frac$", "b_{$")]
    for path in paths:
        shutil.copy(brief_machine, path)
    figure = kind_named(kind).draw(open_subjects(paths), View(width="column"))
    figure.draw_without_rendering()  # raises where a name is taken for mathematics and is none
    names = [text.get_text() for text in figure.findobj(Text) if "frac" in text.get_text()]
    assert all(r"\$\frac\$" in name for name in names)


def test_names_are_told_apart(runs, tmp_path):
    folders = [tmp_path / name for name in ("a", "b")]
    for folder in folders:
        folder.mkdir()
        shutil.copy(runs["motor"], folder / "run.h5")
    paths = [str(folder / "run.h5") for folder in folders]
    assert [subject.name for subject in open_subjects(paths)] == ["a/run", "b/run"]
    assert [subject.stem for subject in open_subjects(paths)] == ["run", "run"]


def test_pictures_are_called_after_their_files(runs, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("II-B.h5", "faster.h5", "killed.h5.partial"):
        shutil.copy(runs["motor"], name)
    for name, stem in (("II-B.h5", "II-B"), ("faster.h5", "faster"), ("killed.h5.partial", "killed")):
        assert draw_files([name], ["motor"], View()) == [f"{stem}-motor.png"]
    assert draw_files(["II-B.h5", "faster.h5"], ["motor"], View()) == ["II-B+faster-motor.png"]
    assert open_subject("II-C").stem == "II-C"
