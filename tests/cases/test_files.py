"""Every file in invalid/ gives exactly the problems that its first lines expect, all of them and no other;
every file in valid/ gives a scene with the numbers that its first lines expect (as Python values).
"""

import ast
import io
import sys
from pathlib import Path

import pytest

from vibsim.cases import CaseError, load_case

FOLDER = Path(__file__).parent / "invalid"
FILES = [*sorted(FOLDER.glob("*.yaml")), *sorted(FOLDER.parent.glob("parts/invalid/*.yaml"))]
MARK = "# expect: "


def expected_problems(path):
    lines = path.read_text(encoding="utf-8").splitlines()
    return [line.removeprefix(MARK) for line in lines if line.startswith(MARK)]


def problems_of(source, **overrides):
    with pytest.raises(CaseError) as caught:
        load_case(source, overrides)
    return [str(problem) for problem in caught.value.problems]


@pytest.mark.parametrize("path", FILES, ids=lambda path: f"{path.parents[1].name}/{path.stem}")
def test_invalid_file_gives_its_problems(path, monkeypatch):
    monkeypatch.chdir(path.parent)
    found = [line.removeprefix(f"{path.name}:") for line in problems_of(path.name)]
    assert found == expected_problems(path)


def test_there_are_many_invalid_files_and_each_expects_something():
    assert len(FILES) >= 65
    assert all(map(expected_problems, FILES))


def test_the_text_of_the_error_is_one_line_per_problem():
    with pytest.raises(CaseError) as caught:
        load_case(FOLDER / "many_problems.yaml")
    lines = str(caught.value).splitlines()
    assert len(lines) == len(caught.value.problems) == 9
    assert all(line.startswith(f"{FOLDER / 'many_problems.yaml'}:") for line in lines)


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        (b"", "{file}:1:1: is empty; a case needs at least blocks and coupling, or bodies"),
        (b"name: caf\xe9\n", "{file}:1:10: is not UTF-8 text (byte 0xe9); save the file as UTF-8"),
        (
            "name: trial\n".encode("utf-16"),
            "{file}:1:1: is not UTF-8 text (byte 0xff); save the file as UTF-8",
        ),
        (b"name: a\nb\x00c", "{file}:2:2: holds the control character 0x00; is it a binary file?"),
        (b"\x89HDF\r\n\x1a\n" + bytes(100), "{file}: is an HDF5 file, not a YAML case file"),
        (b"#" * 1_000_001, "{file}: is larger than 1 MB; a case file has about 2 kB"),
        (b"a: {b: 1}\n" + b"b: 1\n" * 10001, None),
    ],
    ids=["empty", "latin-1", "utf-16", "null byte", "hdf5", "large", "many values"],
)
def test_files_that_are_no_case_files(content, expected, tmp_path):
    path = tmp_path / "trial.yaml"
    path.write_bytes(content)
    found = problems_of(path)
    if expected is None:
        assert f"{path}:9999:4: more than 10000 values; a case needs about 40" in found
    else:
        assert found == [expected.format(file=path)]


def test_a_file_of_exactly_one_megabyte_is_read(tmp_path):
    path = tmp_path / "trial.yaml"
    text = "blocks: {m1: 1 kg, m2: 1 kg}\ncoupling: {k1: 1 N/m}\n"
    path.write_text(text + "#" * (1_000_000 - len(text)))
    assert load_case(path).two_blocks().m1 == 1.0


@pytest.mark.parametrize(
    "text", ["[" * 500_000, "{a: " * 200_000, "- " * 300_000, "a: !!x " * 1000, "? " * 300_000, "&a " * 1000]
)
def test_deep_nesting_ends_quickly_with_a_problem(text, tmp_path):
    path = tmp_path / "deep.yaml"
    path.write_text(text)
    assert problems_of(path)


def test_a_folder_is_told_with_what_is_in_it(here):
    """Where the folder of shipped models is meant, and is not here, its models are named."""
    for source, begin in (
        ("gallery/", "gallery: no such file; shipped are gallery/ball-on-shaken-table, "),
        ("gallery", "gallery: is no shipped case; shipped are gallery/ball-on-shaken-table, "),
        ("hard/", "hard: no such file; shipped are hard/a-million-seconds, "),
    ):
        (line,) = problems_of(source)
        assert line.startswith(begin)
    folder = here / "mine"
    folder.mkdir()
    assert problems_of("mine/") == ["mine: is a folder, not a case file"]
    (folder / "a.yml").touch()
    assert problems_of("mine") == ["mine: is a folder, not a case file; for those in it write mine/*.yml"]
    (folder / "b.yaml").touch()
    assert problems_of("mine/")[0].endswith("; for those in it write mine/*.yaml mine/*.yml")


def test_a_strange_key_stays_on_one_line(tmp_path):
    path = tmp_path / "trial.yaml"
    path.write_text('blocks: {m1: 1 kg, m2: 1 kg, "a\\nb\\e' + "c" * 200 + '": 1}\ncoupling: {k1: 1 N/m}\n')
    [line] = problems_of(path)
    assert line.startswith(f"{path}:1:30: blocks.a b\\x1bccc")
    assert line.endswith("...: unknown key; allowed: m1, m2")


def test_files_that_do_not_exist(here):
    (here / "folder.yaml").mkdir()
    (here / "trial").write_text("")
    assert problems_of("II-B.yaml") == ["II-B.yaml: no such file; the shipped case is called II-B"]
    assert problems_of("other/trial.yml") == ["other/trial.yml: no such file"]
    (here / "machines").mkdir()
    for name in ("folder.yaml", "machines"):
        assert problems_of(name) == [f"{name}: is a folder, not a case file"]
    [line] = problems_of("trial")
    assert line.startswith("trial: is no shipped case; for the file write ./trial; shipped are I-A, ")
    [line] = problems_of("IIB")
    assert line.startswith("IIB: is no shipped case (did you mean II-B?); shipped are")
    for name in ("gallery/bouncing-ball", "hard/zeno-ball"):
        [line] = problems_of(name.partition("/")[2])
        assert f": is no shipped case (did you mean {name}?); shipped are I-A, " in line
    (here / "mine.yaml").write_text("")
    [line] = problems_of("mine")
    assert line.startswith("mine: is no shipped case; did you mean the file mine.yaml?; shipped are I-A, ")
    (here / "run.h5").write_bytes(b"\x89HDF\r\n\x1a\n")
    assert problems_of("run.h5") == [
        "run.h5: is a result and no case file; vibsim info --case prints its case"
    ]
    (here / "text.h5").write_text("name: trial")
    (here / "folder.h5").mkdir()
    assert problems_of("text.h5") == [
        "text.h5: is not an HDF5 file, as its name says; a case file ends in .yaml"
    ]
    assert problems_of("folder.h5") == ["folder.h5: is a folder, not a case file"]
    assert problems_of("nope.h5") == ["nope.h5: no such file"]
    assert problems_of("nul\0.yaml")
    assert problems_of("")


# Files that are valid.


VALID = Path(__file__).parent / "valid"
VALID_FILES = sorted(path.name for path in VALID.glob("*.yaml"))


def expected_numbers(path):
    lines = path.read_text(encoding="utf-8").splitlines()
    words = [line.removeprefix(MARK).split(maxsplit=1) for line in lines if line.startswith(MARK)]
    return {name: ast.literal_eval(value) for name, value in words}


@pytest.mark.parametrize("name", VALID_FILES)
def test_valid_file_gives_its_numbers(name):
    path = VALID / name
    scene = load_case(path).two_blocks()
    expected = expected_numbers(path)
    assert expected
    assert {key: getattr(scene, key) for key in expected} == expected


def test_windows_line_ends_and_byte_order_mark(tmp_path):
    text = "blocks:\r\n  m1: 0.297 kg\r\n  m2: 2.94 kg\r\ncoupling:\r\n  k1: 200 N/m\r\n"
    path = tmp_path / "windows.yaml"
    path.write_bytes(b"\xef\xbb\xbf" + text.encode())
    case = load_case(path)
    assert (case.two_blocks().m1, case.two_blocks().k1, case.text) == (0.297, 200.0, text)


def test_name_comes_from_the_file_where_it_is_not_given(tmp_path):
    for stem, name in [
        ("soft spring", "soft spring"),
        ("a(b)", "a_b_"),
        ("_x", "case_x"),
        ("été", "case_t_"),
    ]:
        path = tmp_path / f"{stem}.yaml"
        path.write_text("blocks: {m1: 1, m2: 1}\ncoupling: {k1: 1}\n")
        assert load_case(path).name == name


def test_standard_input(monkeypatch):
    class Stdin:
        buffer = io.BytesIO(b"blocks: {m1: 1, m2: 1}\ncoupling: {k1: 1}\n")

    monkeypatch.setattr(sys, "stdin", Stdin)
    case = load_case("-")
    assert (case.name, case.source, case.two_blocks().m1) == ("stdin", "stdin", 1.0)
