"""Names, folders and settings as nobody plans them: one line that names what was given, never a traceback."""

import builtins
import errno
import json
import os
import shutil
from copy import copy
from pathlib import Path

import click
import h5py
import matplotlib
import pytest
from matplotlib import font_manager

import vibsim
from tests.command_line.made import call, process, refused
from tests.command_line.test_ro_crate import graph
from vibsim.command_line.main import group
from vibsim.command_line.options import FILE, CaseSource


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """The file of a run."""
    case = vibsim.load_case("II-B", {"run.t_end": "2 s"})
    return vibsim.simulate(case).save(tmp_path_factory.mktemp("run") / "a.h5")


@pytest.fixture
def files(run, here):
    """A folder with a run in it, where commands are called."""
    shutil.copy(run, "a.h5")
    return here


@pytest.mark.parametrize("name", ["sur\udcffrogate.h5", "two words 50%.h5", "grüße.h5", "new\nline.h5"])
def test_a_crate_of_a_file_of_any_name(files, name):
    os.rename("a.h5", name)
    for force in ([], ["--force"]):
        done = call("export", name, "--ro-crate", "-o", "crate", *force)
        assert (done.exit_code, done.stderr) == (0, "crate written\n")
    assert {*os.listdir("crate")} == {"case-resolved.yaml", "case.yaml", name, "ro-crate-metadata.json"}
    (result,) = (each for each in graph("crate").values() if str(each.get("@id")).endswith(".h5"))
    assert result["@id"].isascii() and "%" in result["@id"] and " " not in result["@id"]
    assert vibsim.open_result(f"crate/{name}").complete


OUTPUTS = [
    "run I-A --t-end 1s -o {}.h5", "sweep I-A --omega 3,4 --t-end 1s -j 1 -o {}.h5", "plot FILE -o {}.png",
    "plot FILE -o {}.html", "export FILE -o {}.csv", "export FILE -o {}.parquet", "export FILE -o {}.mat",
    "export FILE --ro-crate -o {}", "animate FILE --window 0:0.2 -o {}.gif", "new {}",
    "cases II-B --draw -o {}.pdf",
    "orbit I-C -s omega=4.2Hz -o {}.h5", "bench I-A --t-end 0.1s --methods rk4 -o {}.h5", "paper -o {}",
    "continue I-C -s omega=4.2Hz --omega 4:4.3 -o {}.h5",
    "fit II-B --free c=0.001:0.05 --want captured -o {}.h5",
]  # fmt: skip


@pytest.mark.parametrize("words", OUTPUTS)
def test_an_output_in_a_folder_that_was_deleted(files, words, monkeypatch):
    os.mkdir("gone")
    monkeypatch.chdir("gone")
    os.rmdir(files / "gone")
    try:
        done = call(*words.replace("FILE", str(files / "a.h5")).format("x").split())
    finally:
        os.chdir(files)
    assert done.exit_code == 6, done.stderr
    assert done.stderr.splitlines()[-1].endswith(": cannot write: No such file or directory")


@pytest.mark.parametrize("words", OUTPUTS[:11])
def test_an_output_where_nothing_can_be_made_is_called_as_it_was_given(files, words):
    given = words.replace("FILE", "a.h5").format("/proc/x").split()
    done = call(*given)
    assert done.exit_code == 6 and len(done.stderr.splitlines()) == 1
    assert "/proc/x" in done.stderr and "partial" not in done.stderr and "lock" not in done.stderr


def test_a_file_that_is_no_case_is_not_told_line_by_line(files):
    Path("secrets").write_text("".join(f"user{i}: secret{i}\n" for i in range(40)))
    Path("a.yaml").write_text("name: a\nextends: ./secrets\n")
    for words in ("check a.yaml", "run a.yaml"):
        done = call(*words.split())
        assert done.exit_code == 3 and "secret0" not in done.output.replace("secrets", "")
        assert "secrets:1:1: is no case file: none of its 40 keys is one of a case" in done.output
    Path("b.yaml").write_text("name: b\n" + "".join(f"key{i}: {i}\n" for i in range(40)))
    done = call("check", "b.yaml")
    assert len(done.stdout.splitlines()) == 27 and "and 17 more problems" in done.stdout
    with pytest.raises(vibsim.CaseError) as caught:
        vibsim.load_case("b.yaml")
    assert len(caught.value.problems) == 42 and len(str(caught.value).splitlines()) == 26


def test_a_style_sheet_of_an_impossible_name(files):
    said = refused("plot", "a.h5", "--style", "x" * 300)
    assert said.endswith(": must be a file, or a style of matplotlib such as ggplot\n")


NO_HOME = {"HOME", "XDG_CONFIG_HOME", "XDG_CACHE_HOME", "MPLCONFIGDIR"}
PLAIN = {"LANG": "C", "LC_ALL": "C", "PYTHONUTF8": "0", "COLUMNS": "1"}


def test_pictures_in_any_environment(files):
    """A backend that there is not, no home, a plain locale."""
    there = {key: value for key, value in os.environ.items() if key not in NO_HOME}
    environment = {**there, "MPLBACKEND": "nosuch", **PLAIN}
    done = process("plot", "a.h5", "--kind", "motor", "-o", "a.png", "--json", cwd=files, env=environment)
    assert (done.returncode, done.stderr) == (0, "")
    assert json.loads(done.stdout) == {"written": ["a.png"]}


@pytest.mark.slow
def test_pictures_where_the_list_of_fonts_lacks_those_of_matplotlib(files):
    """Such a list is written while matplotlib is being removed or installed."""
    fonts = copy(font_manager.fontManager)
    own = matplotlib.get_data_path()
    fonts.ttflist = [font for font in fonts.ttflist if not font.fname.startswith(own)]
    fonts.afmlist = []
    (files / "settings").mkdir()
    written = files / "settings" / f"fontlist-v{fonts.__version__}.json"
    font_manager.json_dump(fonts, written)
    before = written.read_bytes()
    environment = {**os.environ, "MPLCONFIGDIR": str(files / "settings")}
    for kind, name in (("motor", "a.png"), ("stiffness", "b.pdf")):
        done = process("plot", "a.h5", "--kind", kind, "-o", name, "--json", cwd=files, env=environment)
        assert (done.returncode, done.stderr) == (0, "")
    assert written.read_bytes() == before  # it was that list which was read


# Files that are not there, or must not be read: one rule for every argument and option that takes one.


CASE_MISSING, RESULT_MISSING, NO_STYLE = 3, 6, 2
EITHER = {"gone.yaml": CASE_MISSING, "gone": CASE_MISSING, "gone.h5": RESULT_MISSING}
CASES = dict.fromkeys(EITHER, CASE_MISSING)
RESULTS = dict.fromkeys(EITHER, RESULT_MISSING)
STYLES = dict.fromkeys(EITHER, NO_STYLE)

# (command, parameter): what it takes, and command lines that read it
INPUTS = {
    ("run", "sources"): (EITHER, ["run {}"]),
    ("sweep", "source"): (EITHER, ["sweep {} --omega0 3,4"]),
    ("orbit", "source"): (EITHER, ["orbit {}", "orbit {} --search 2"]),
    ("edge", "source"): (EITHER, ["edge {} --between a.h5,a.h5"]),
    ("orbit", "start"): (RESULTS, ["orbit I-A --from {}"]),
    ("continue", "source"): (
        EITHER,
        [
            "continue {} --omega0 3:9",
            "continue {} --energy 1:2",
            "continue {} --switch PD1",
            "continue {} --locus NS1 --param c=0.1:0.2",
        ],
    ),
    ("fit", "sources"): (EITHER, ["fit {} --want captured"]),
    ("plot", "files"): (EITHER, ["plot {} -o a.png", "plot {} -o a.html"]),
    ("plot", "sheet"): (STYLES, ["plot II-B --kind stiffness -o a.png --style {}"]),
    ("animate", "file"): (EITHER, ["animate {} -o a.gif"]),
    ("info", "files"): (RESULTS, ["info {}", "info {} --case"]),
    ("analyse", "sources"): (EITHER, ["analyse {}"]),
    ("bench", "source"): (EITHER, ["bench {}"]),
    ("bench", "truth"): (RESULTS, ["bench I-A --truth {}"]),
    ("compare", "a"): (RESULTS, ["compare {} a.h5"]),
    ("compare", "b"): (RESULTS, ["compare a.h5 {}"]),
    ("export", "file"): (RESULTS, ["export {} -o a.csv"]),
    ("new", "source"): (CASES, ["new a --from {}"]),
    ("cases", "names"): (CASES, ["cases {}", "cases {} --resolved", "cases {} --draw"]),
    ("check", "sources"): (CASES, ["check {}"]),
}
WRITING = {"output", "out", "picture", "folder"}
LINES = [(line, takes) for takes, lines in INPUTS.values() for line in lines]


def _names_a_file(parameter):
    words = f"{parameter.metavar or ''}"
    is_file = isinstance(parameter.type, CaseSource | click.Path) or "FILE" in words or "CASE" in words
    return is_file or parameter.type is FILE


def test_every_parameter_that_takes_a_file_is_in_the_table():
    ctx = click.Context(group)
    files = {
        (command, parameter.name)
        for command in group.list_commands(ctx)
        for parameter in group.get_command(ctx, command).params
        if _names_a_file(parameter) and parameter.name not in WRITING
    }
    assert files - {("new", "name")} == set(INPUTS)  # of `new` NAME is what it writes


@pytest.mark.parametrize(("line", "takes"), LINES, ids=[line for line, _ in LINES])
def test_a_missing_file_ends_by_what_is_asked_for(files, line, takes):
    for name, code in takes.items():
        done = call(*line.format(name).split())
        told = done.stderr + done.stdout
        assert (done.exit_code, name in told) == (code, True), told
        if name == "gone.h5" and code == RESULT_MISSING:
            assert told == "Error: gone.h5: No such file or directory\n"
        assert [path.name for path in Path().iterdir()] == ["a.h5"]


@pytest.fixture
def unreadable(files, monkeypatch):
    """A folder with a run and a style sheet that this user must not read; root may read everything."""
    Path("a.mplstyle").write_text("lines.linewidth: 3")
    access, opened = os.access, builtins.open

    def may(path, mode, **options):
        return mode != os.R_OK and access(path, mode, **options)

    def refuse(file, mode="r", *more, **options):
        if str(file) in ("a.h5", "a.mplstyle") and "r" in mode and "+" not in mode:
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), file)
        return opened(file, mode, *more, **options)

    monkeypatch.setattr(os, "access", may)
    monkeypatch.setattr(builtins, "open", refuse)


READ = [line for (takes, lines) in INPUTS.values() if takes in (EITHER, RESULTS) for line in lines]


@pytest.mark.parametrize("line", READ)
def test_a_result_that_must_not_be_read(unreadable, line):
    assert refused(*line.format("a.h5").split(), code=6) == "Error: a.h5: Permission denied\n"


def test_a_file_to_go_on_with_that_must_not_be_read(unreadable):
    done = call("sweep", "II-B", "--omega0", "3,4", "--t-end", "1s", "-o", "a.h5")
    assert (done.exit_code, done.stderr) == (6, "Error: a.h5: Permission denied\n")


def test_an_output_that_must_not_be_read_is_there_all_the_same(unreadable):
    assert refused("run", "I-A", "-o", "a.h5", code=6) == "Error: a.h5: exists; kept (--force replaces it)\n"


def test_a_style_sheet_that_must_not_be_read(unreadable):
    done = call("plot", "I-A", "--style", "a.mplstyle", "-o", "a.png")
    said = "a.mplstyle is no style sheet of matplotlib: Permission denied"
    assert (done.exit_code, done.stderr) == (2, f"Error: {said}\n")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (
            "lines.linewidth: many\n",
            "line 1 ('lines.linewidth: many'): Key lines.linewidth: Could not convert",
        ),
        ("font.size: 9\nfoo.bar: 3\n", "Bad key foo.bar in file a.mplstyle, line 2 ('foo.bar: 3')"),
        ("font.size 9\n", "line 1"),
    ],
)
def test_a_style_sheet_of_which_a_part_would_be_left_out(here, text, said):
    Path("a.mplstyle").write_text(text)
    done = call("plot", "I-A", "--style", "a.mplstyle", "-o", "a.png")
    assert done.exit_code == 2 and not Path("a.png").exists()
    assert done.stderr.startswith("Error: a.mplstyle is no style sheet of matplotlib: ")
    assert said in done.stderr and done.stderr.count("\n") == 1


@pytest.mark.parametrize("line", [line for line in READ if "--truth" not in line])  # which is a bench's
def test_a_result_of_a_later_kind_is_named_by_every_command(files, line):
    with h5py.File("a.h5", "r+") as file:
        file.attrs["vibsim_kind"] = "spiral"
    done = call(*line.format("a.h5").split())
    said = "Error: a.h5: holds a 'spiral', which this vibsim does not read\n"
    assert (done.exit_code, done.stderr) == (6, said)
