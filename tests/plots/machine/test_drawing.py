"""The drawing of a machine shows every part of the scene, once, where it belongs."""

from functools import cache
from pathlib import Path

import pytest

from vibsim.cases import gallery_case_names, load_case, shipped_case_names
from vibsim.cases.case import load_case_text
from vibsim.plots import style
from vibsim.plots.machine import draw_machine_file, layout, machine_figure
from vibsim.plots.machine_symbols import elements, short

HAMMER = Path(__file__).parents[2] / "cases/parts/valid/hammer.yaml"
RIGID = Path(__file__).with_name("rigid_stops.yaml")
ALL = [*shipped_case_names(), *gallery_case_names(), str(HAMMER), str(RIGID)]


def drawn(case):
    """The axes of the drawing of a case."""
    with style.applied():
        figure = machine_figure(case.long_values())
        figure.canvas.draw()
    return figure.axes[0]


@cache
def drawing(source):
    """The case of a file or a name, and the axes of its drawing, which are only read."""
    case = load_case(source)
    return case, drawn(case)


def gids(axes):
    return {artist.get_gid() for artist in axes.get_children()} - {None}


def texts(axes):
    return {text.get_text() for text in axes.texts}


def part_keys(values):
    sections = ("bodies", "links", "stops", "friction", "forces", "clearances")
    keys = {f"{section}.{name}" for section in sections for name in values.get(section, {})}
    return keys | ({"motor"} & set(values)) | ({"base"} & set(values))


@pytest.mark.parametrize("source", ALL, ids=lambda source: Path(source).stem)
def test_every_part_is_drawn_and_named_and_nothing_leaves_the_sheet(source):
    case, axes = drawing(source)
    values = case.long_values()
    assert part_keys(values) <= gids(axes)
    said = " ".join(texts(axes))
    for key in part_keys(values):
        section, _, name = key.partition(".")
        assert (name or section) in said
    for name, mass in values["bodies"].items():
        assert {name, str(mass).replace("m^2", "m²")} <= texts(axes)
    sheet = axes.get_figure().bbox
    for text in axes.texts:
        box = text.get_window_extent()
        assert sheet.x0 - 1 <= box.x0 <= box.x1 <= sheet.x1 + 1
        assert sheet.y0 - 1 <= box.y0 <= box.y1 <= sheet.y1 + 1


def test_values_stand_beside_their_parts():
    said = texts(drawn(load_case("gallery/impact-damper")))
    assert {"k = 394.78 N/m", "c = 1.26 N s/m", "left: gap 10 mm", "k = 50 kN/m, c = 20 N s/m"} <= said
    assert "drive: 0.2 N at 1 Hz" in said
    assert {"motor: 0.005 N m, 5.5 Hz", "µ = 0.001"} <= texts(drawn(load_case("II-B")))


def one_body(stop):
    return load_case_text(
        f"bodies: {{a: 1 kg}}\nstops: {{wall: {{between: {stop[0]}, gap: 1 mm, acts: {stop[1]}, k: 1}}}}\n"
    )


@pytest.mark.parametrize(
    ("ends", "acts", "left", "right"),
    [
        ("[a, ground]", "compression", "a", "ground"),  # met at x = +gap
        ("[a, ground]", "extension", "ground", "a"),
        ("[ground, a]", "compression", "ground", "a"),  # met at x = -gap
        ("[ground, a]", "extension", "a", "ground"),
    ],
)
def test_a_wall_stands_where_its_stop_is_met(ends, acts, left, right):
    [element] = elements(one_body((ends, acts)).long_values())
    assert (element.kind, element.left, element.right) == ("stop", left, right)


@pytest.mark.parametrize(
    ("ends", "acts", "kind"),
    [
        ("[a, b]", "compression", "stop"),
        ("[a, b]", "extension", "hook"),
        ("[b, a]", "compression", "hook"),
        ("[b, a]", "extension", "stop"),
    ],
)
def test_bodies_meet_or_pull(ends, acts, kind):
    text = f"bodies: {{a: 1, b: 1}}\nstops: {{s: {{between: {ends}, gap: 0, acts: {acts}, k: 1}}}}\n"
    [element] = elements(load_case_text(text).long_values())
    assert (element.kind, element.left, element.right) == (kind, "a", "b")


def test_parts_between_neighbours_stand_in_the_gap_and_others_above():
    text = """
bodies: {a: 1, b: 1, c: 1}
links:
  near: {between: [a, b], k: 1, c: 1}
  far: {between: [c, a], k: 1}
  middle: {between: [b, ground], k: 1}
  first: {between: [a, ground], k: 1}
  last: {between: [c, ground], k: 1}
"""
    plan = layout(load_case_text(text).long_values())
    assert [[element.key for element in slot] for slot in plan.slots] == [
        ["links.first"], ["links.near", "links.near"], [], ["links.last"],
    ]  # fmt: skip
    assert [element.key for element in plan.above] == ["links.far", "links.middle"]
    assert all(left.right <= right.x for left, right in zip(plan.boxes, plan.boxes[1:], strict=False))


@pytest.mark.parametrize("suffix", [".png", ".svg", ".pdf"])
def test_the_same_drawing_is_the_same_file(suffix, tmp_path):
    files = [tmp_path / f"{name}{suffix}" for name in "ab"]
    for file in files:
        draw_machine_file(load_case("gallery/drifting-capsule"), str(file))
    assert files[0].read_bytes() == files[1].read_bytes()


def test_a_rigid_stop_is_named_by_its_restitution():
    text = (
        "name: ball\nbodies: {ball: 1 kg}\n"
        "stops: {table: {between: [ground, ball], gap: 0 m, acts: compression, law: rigid, e: 0.8}}\n"
    )
    (stop,) = [one for one in elements(load_case_text(text).long_values()) if one.kind == "stop"]
    assert stop.value == "rigid, e = 0.8"


def test_labels_have_no_more_digits_than_there_is_room_for():
    values = load_case("gallery/energy-sink").long_values()
    drive, body = values["forces"]["drive"], values["bodies"]["body"]
    assert str(drive["omega"]) == "54.772255750516614 rad/s" and short(drive["omega"]) == "54.7723 rad/s"
    assert short(body) == "4 kg"
    as_written = {"k": "394.78 N/m", "A": "16/35 N", "N": "0.0000125 N", "m": "1.00000 kg", "e": "0.8"}
    for text in as_written.values():
        assert short(text) == text
    assert short("-1234567.5 N") == "-1.23457e+06 N"
