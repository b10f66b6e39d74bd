"""Sections of a case: what their annotations ask for, what is wrong told at its place, defaults."""

import pickle
from typing import Annotated, Literal

import pytest

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
        ("value", "inner.mass"),
        ("value", "inner.order"),
        ("unknown", "inner.more"),
        ("no mapping", "parts.a"),
        ("missing", "parts.b.mass"),
        ("no mapping", "other"),
        ("value", "how"),
        ("value", "name"),
        ("unknown", "what"),
    ]
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
