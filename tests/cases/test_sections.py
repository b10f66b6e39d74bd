"""Sections of a case: what their annotations ask for, what is wrong told at its place, defaults."""

import os
import pickle
from pathlib import Path
from typing import Annotated, Literal

import pytest

from vibsim.cases import CaseError, load_case
from vibsim.cases.quantities import Quantity
from vibsim.cases.schema import Section, key
from vibsim.cases.schema_keys import case_schema
from vibsim.cases.schema_kinds import Fault, Measured, TextKind, WholeNumber


class Inner(Section):
    """A section in another."""

    mass: Annotated[Quantity, Measured("mass", above="0")]
    order: Annotated[int, WholeNumber(4, 40)] = key(default=20)


class Outer(Section):
    """A section with all that there is."""

    inner: Inner
    parts: dict[str, Inner] = key(default={})
    other: Inner | None = key(default=None)
    how: Literal["one", "two"] = "one"
    name: Annotated[str, TextKind(5, "[a-z]+", "letters")] = key(default="case")


def read(values):
    faults: list[Fault] = []
    return Outer.read(values, (), faults), [(fault.what, ".".join(fault.location)) for fault in faults]


def test_a_section_is_read_with_its_defaults():
    outer, faults = read({"inner": {"mass": "2 kg"}, "parts": {"a": {"mass": 1, "order": "7"}}})
    assert faults == []
    assert (outer.inner.mass.value, outer.inner.order, outer.parts["a"].order) == (2, 20, 7)
    assert (outer.other, outer.how, outer.name) == (None, "one", "case")


def test_every_fault_is_told_in_the_order_of_the_keys():
    _, faults = read(
        {
            "inner": {"mass": "0 kg", "order": "41", "more": 1},
            "parts": {"a": "1 kg", "b": {}},
            "other": [],
            "how": "three",
            "name": "Too long",
            "what": {},
        }
    )
    assert faults == [
        ("value", "inner.mass"), ("value", "inner.order"), ("unknown", "inner.more"),
        ("no mapping", "parts.a"), ("missing", "parts.b.mass"), ("no mapping", "other"), ("value", "how"),
        ("value", "name"), ("unknown", "what"),
    ]  # fmt: skip
    assert read({})[1] == [("missing", "inner")] and read("a text") == (None, [("no mapping", "")])


def test_sections_of_the_same_content_are_equal_and_do_not_share_what_could_change():
    one, other = (read({"inner": {"mass": "2 kg"}})[0] for _ in range(2))
    assert one == other and one.parts is not other.parts
    assert hash(one.inner) == hash(other.inner) and pickle.loads(pickle.dumps(one)) == one
    assert one != read({"inner": {"mass": "3 kg"}})[0]
    for change in (lambda: setattr(one, "how", "two"), lambda: delattr(one, "how")):
        with pytest.raises(AttributeError, match="does not change"):
            change()


def test_what_no_case_can_hold_is_a_fault_of_the_schema():
    class Wrong(Section):
        number: complex

    with pytest.raises(TypeError, match="no kind of value is known for <class 'complex'>"):
        Wrong.read({"number": "1"}, (), [])


def test_a_rate_that_may_be_left_out_keeps_its_description():
    omega = case_schema()["$defs"]["BodyForce"]["properties"]["omega"]
    assert omega["description"] == "frequency"
    assert omega["anyOf"][0]["description"].startswith("number and unit: Hz")


# extends: child over parent, key by key.


PARENT = """\
name: parent
title: The parent
blocks: {m1: 0.297 kg, m2: 2.94 kg}
coupling: {k1: 200 N/m, c: 0.001 N s/m}
stop: {k2: 12400 N/m, G: 1 mm}
excitation: {kind: harmonic, A: {rule: m3 e omega^2, m3: 0.03 kg, e: 0.11 m}, omega: 3.5 Hz}
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "parent.yaml").write_text(PARENT)
    return tmp_path


def child(folder, text, name="child.yaml"):
    path = folder / name
    path.parent.mkdir(exist_ok=True)
    path.write_text(text)
    return load_case(path)


def test_a_child_with_nothing_of_its_own_is_its_parent(folder):
    case = child(folder, "extends: parent.yaml\n")
    assert case.two_blocks() == load_case(folder / "parent.yaml").two_blocks()
    assert case.sha256 == load_case(folder / "parent.yaml").sha256


def test_name_and_title_are_not_inherited(folder):
    case = child(folder, "extends: parent.yaml\n")
    assert (case.name, case.title) == ("child", "")


def test_keys_are_replaced_one_by_one(folder):
    case = child(folder, "extends: parent.yaml\ncoupling: {c: 0.03 N s/m}\nexcitation: {A: {e: 0.22 m}}\n")
    assert case.number("k1") == 200.0
    assert case.number("c") == 0.03
    assert case.number("A") == 2 * load_case(folder / "parent.yaml").number("A")


def test_a_value_replaces_a_rule_and_a_rule_a_value(folder):
    assert child(folder, "extends: parent.yaml\nexcitation: {A: 0.1 N}\n").number("A") == 0.1
    text = "extends: I-A\nexcitation: {A: {rule: m3 e omega^2, m3: 0.03 kg, e: 0.11 m}}\n"
    assert child(folder, text).two_blocks().A == load_case("I-A-eq211").two_blocks().A


def test_another_kind_replaces_the_excitation(folder):
    text = "extends: parent.yaml\nexcitation: {kind: none}\n"
    assert child(folder, text).two_blocks().source == "none"
    same = child(folder, "extends: parent.yaml\nexcitation: {kind: harmonic, omega: 7 Hz}\n")
    assert same.number("A") == pytest.approx(4 * load_case(folder / "parent.yaml").number("A"), rel=1e-15)


def test_none_switches_a_section_off_and_a_grandchild_on_again(folder):
    assert not child(folder, "extends: parent.yaml\nstop: none\n", "off.yaml").two_blocks().has_stop
    on = child(folder, "extends: off.yaml\nstop: {k2: 1 N/m, G: 0 m}\n")
    assert on.two_blocks().k2 == 1.0


def test_paths_count_from_the_file_that_extends(folder, monkeypatch):
    monkeypatch.chdir("/")
    assert child(folder, "extends: ../parent.yaml\n", "below/child.yaml").number("k1") == 200.0
    assert child(folder, f"extends: {folder / 'parent.yaml'}\n").number("k1") == 200.0
    (folder / "grandchild.yaml").write_text("extends: below/child.yaml\n")
    assert load_case(folder / "grandchild.yaml").number("k1") == 200.0


def test_a_shipped_name_is_no_file_beside_the_child(folder):
    (folder / "II-B").write_text("no case at all")
    assert child(folder, "extends: II-B\n").number("Omega0") == load_case("II-B").number("Omega0")


def test_eight_files_may_extend_one_another_and_nine_not(folder):
    for level in range(1, 9):
        above = "parent.yaml" if level == 1 else f"{level - 1}.yaml"
        (folder / f"{level}.yaml").write_text(f"extends: {above}\n")
    assert load_case(folder / "7.yaml").number("k1") == 200.0
    with pytest.raises(CaseError) as caught:
        load_case(folder / "8.yaml")
    [problem] = caught.value.problems
    assert (Path(problem.file).name, problem.line) == ("1.yaml", 1)
    assert problem.message == "more than 8 files extend one another"


def test_a_circle_through_a_link_is_found(folder):
    (folder / "a.yaml").write_text("extends: b.yaml\n")
    (folder / "b.yaml").symlink_to(folder / "a.yaml")
    with pytest.raises(CaseError, match="goes round in a circle"):
        load_case(folder / "a.yaml")


def test_the_text_of_the_case_is_the_childs(folder):
    text = "extends: parent.yaml   # as given\n"
    assert child(folder, text).text == text


def test_a_childs_override_hides_a_mistake_of_the_parent(folder):
    (folder / "parent.yaml").write_text(PARENT.replace("200 N/m", "200 furlongs"))
    assert child(folder, "extends: parent.yaml\ncoupling: {k1: 100 N/m}\n").number("k1") == 100.0


@pytest.mark.parametrize(
    ("target", "told"),
    [
        ("x" * 300, "extends: xxxx"),
        ("a/" + "x" * 300 + ".yaml", "extends: "),
        ("a\\e[2Jb", "extends: a\\x1b[2Jb: is no shipped case"),
        ("a/\\0\\e[2J.yaml", "extends: "),
        ("waiting.yaml", "waiting.yaml: is no regular file"),
        ("/dev/zero", "/dev/zero: is no regular file"),
    ],
)
def test_what_cannot_be_extended_is_said_in_one_line(tmp_path, target, told):
    os.mkfifo(tmp_path / "waiting.yaml")
    child = tmp_path / "child.yaml"
    child.write_text(f'extends: "{target}"\n', encoding="utf-8")
    with pytest.raises(CaseError) as caught:
        load_case(child)
    [line] = str(caught.value).splitlines()
    assert line.startswith(f"{child}:1:10: ") and told in line and line.isprintable()
    assert len(line) < len(str(child)) + 500
