"""Names, folders and settings as nobody plans them: one line that names what was given, never a traceback."""

import json
import os
import shutil
from copy import copy

import matplotlib
import pytest
from matplotlib import font_manager

import vibsim
from tests.command_line.made import call, process
from tests.command_line.test_ro_crate import graph


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """The file of a run."""
    case = vibsim.load_case("II-B", {"run.t_end": "2 s"})
    return vibsim.simulate(case).save(tmp_path_factory.mktemp("run") / "a.h5")


@pytest.fixture
def files(run, tmp_path, monkeypatch):
    """A folder with a run in it, where commands are called."""
    monkeypatch.chdir(tmp_path)
    shutil.copy(run, "a.h5")
    return tmp_path


@pytest.mark.parametrize("name", ["sur\udcffrogate.h5", "two words 50%.h5", "grüße.h5", "new\nline.h5"])
def test_a_crate_of_a_file_of_any_name(files, name):
    os.rename("a.h5", name)
    for force in ([], ["--force"]):
        done = call("export", name, "--ro-crate", "-o", "crate", *force)
        assert (done.exit_code, done.stderr) == (0, "crate written\n")
    assert sorted(os.listdir("crate")) == sorted(
        ["case-resolved.yaml", "case.yaml", name, "ro-crate-metadata.json"]
    )
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
    with open("secrets", "w") as file:
        file.write("".join(f"user{i}: secret{i}\n" for i in range(40)))
    with open("a.yaml", "w") as file:
        file.write("name: a\nextends: ./secrets\n")
    for words in ("check a.yaml", "run a.yaml"):
        done = call(*words.split())
        assert done.exit_code == 3 and "secret0" not in done.output.replace("secrets", "")
        assert "secrets:1:1: is no case file: none of its 40 keys is one of a case" in done.output
    with open("b.yaml", "w") as file:
        file.write("name: b\n" + "".join(f"key{i}: {i}\n" for i in range(40)))
    done = call("check", "b.yaml")
    assert len(done.stdout.splitlines()) == 27 and "and 17 more problems" in done.stdout
    with pytest.raises(vibsim.CaseError) as caught:
        vibsim.load_case("b.yaml")
    assert len(caught.value.problems) == 42 and len(str(caught.value).splitlines()) == 26


def test_a_style_sheet_of_an_impossible_name(files):
    done = call("plot", "a.h5", "--style", "x" * 300)
    assert done.exit_code == 2 and done.stderr.endswith(
        ": must be a file, or a style of matplotlib such as ggplot\n"
    )


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
