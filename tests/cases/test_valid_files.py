"""Every file in valid/ gives a scene with the numbers that its first lines expect (as Python values)."""

import ast
import io
import sys
from pathlib import Path

import pytest

from vibsim.cases import load_case

FOLDER = Path(__file__).parent / "valid"
FILES = sorted(path.name for path in FOLDER.glob("*.yaml"))
MARK = "# expect: "


def expected_numbers(path):
    lines = path.read_text(encoding="utf-8").splitlines()
    words = [line.removeprefix(MARK).split(maxsplit=1) for line in lines if line.startswith(MARK)]
    return {name: ast.literal_eval(value) for name, value in words}


@pytest.mark.parametrize("name", FILES)
def test_valid_file_gives_its_numbers(name):
    path = FOLDER / name
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
