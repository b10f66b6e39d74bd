"""The drawing of a machine shows every part of the scene, once, where it belongs."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from matplotlib.patches import Circle, FancyBboxPatch, Polygon

from tests.formula_cases import CURRENT, EVERYWHERE, MACHINE, case_of
from tests.plots.artists import notes
from vibsim.cases import gallery_case_names, load_case, shipped_case_names
from vibsim.cases.case import load_case_text
from vibsim.plots import style
from vibsim.plots.animated_machine import (
    Recorder,
    angle_columns,
    channels_of,
    display_list,
    sketch,
    stage_for,
)
from vibsim.plots.machine import draw_machine_file, layout, machine_figure
from vibsim.plots.machine_symbols import LONGEST_FORMULA, elements, short, ways_of
from vibsim.plots.subject import subject_of
from vibsim.results import simulate

HAMMER = Path(__file__).parents[2] / "cases/parts/valid/hammer.yaml"
RIGID = Path(__file__).with_name("rigid_stops.yaml")
ALL = [*shipped_case_names(), *gallery_case_names(), str(HAMMER), str(RIGID)]


def drawn(case):
    """The axes of the drawing of a case."""
    with style.applied():
        figure = machine_figure(case.long_values())
        figure.draw_without_rendering()
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
    said = texts(drawing("gallery/impact-damper")[1])
    assert {"k = 394.78 N/m", "c = 1.26 N s/m", "left: gap 10 mm", "k = 50 kN/m, c = 20 N s/m"} <= said
    assert "drive: 0.2 N at 1 Hz" in said
    assert {"motor: 0.005 N m, 5.5 Hz", "µ = 0.001"} <= texts(drawing("II-B")[1])


@pytest.mark.parametrize(
    ("ends", "acts", "kind", "left", "right"),
    [
        ("[a, ground]", "compression", "stop", "a", "ground"),  # met at x = +gap
        ("[a, ground]", "extension", "stop", "ground", "a"),
        ("[ground, a]", "compression", "stop", "ground", "a"),  # met at x = -gap
        ("[ground, a]", "extension", "stop", "a", "ground"),
        ("[a, b]", "compression", "stop", "a", "b"),  # bodies meet, or pull
        ("[a, b]", "extension", "hook", "a", "b"),
        ("[b, a]", "compression", "hook", "a", "b"),
        ("[b, a]", "extension", "stop", "a", "b"),
    ],
)
def test_a_stop_stands_where_it_is_met(ends, acts, kind, left, right):
    bodies = "{a: 1 kg, b: 1 kg}" if "b" in ends.replace("ground", "") else "{a: 1 kg}"
    text = f"bodies: {bodies}\nstops: {{s: {{between: {ends}, gap: 1 mm, acts: {acts}, k: 1}}}}\n"
    [element] = elements(load_case_text(text).long_values())
    assert (element.kind, element.left, element.right) == (kind, left, right)


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


BALL = """
bodies: {ball: 1 kg}
stops: {table: {between: [ground, ball], gap: 0 m, acts: compression, law: rigid, e: 0.8}}
"""


def test_a_rigid_stop_is_named_by_its_restitution():
    (stop,) = [one for one in elements(load_case_text(BALL).long_values()) if one.kind == "stop"]
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


# Nothing of a drawing, still or moving, runs through a body or over a word; arrows point as forces do.


TOUCH = 1e-6  # cm
PIXEL = 1.0
STOPPED = ["gallery/impact-damper", "gallery/energy-sink", "gallery/captured-motor", "gallery/cantilever",
           "gallery/drifting-capsule", "gallery/chain-with-gaps"]  # fmt: skip


def inside(line, box):
    """Whether a polygon (n, 2) has places within a box (x0, y0, x1, y1)."""
    shares = np.linspace(0, 1, 41)[:, None, None]
    places = (line[:-1] + shares * np.diff(line, axis=0)).reshape(-1, 2)
    x0, y0, x1, y1 = box
    x, y = places.T
    return bool(((x > x0 + TOUCH) & (x < x1 - TOUCH) & (y > y0 + TOUCH) & (y < y1 - TOUCH)).any())


def boxes_of(axes):
    to_data = axes.transData.inverted()
    extents = [body.get_window_extent().transformed(to_data) for body in bodies_of(axes)]
    return [(extent.x0, extent.y0, extent.x1, extent.y1) for extent in extents]


def bodies_of(axes):
    return [patch for patch in axes.patches if str(patch.get_gid()).startswith("bodies.")]


def overlap(one, other):
    """Width and height of the area that two boxes share, below 0 where they lie apart."""
    return min(one.x1, other.x1) - max(one.x0, other.x0), min(one.y1, other.y1) - max(one.y0, other.y0)


@pytest.mark.parametrize("source", ALL, ids=lambda source: Path(source).stem)
def test_no_line_runs_through_a_body(source):
    _, axes = drawing(source)
    boxes = boxes_of(axes)
    assert boxes
    for line in axes.get_lines():
        assert not any(inside(line.get_xydata(), box) for box in boxes), line.get_gid()


@pytest.mark.parametrize("source", ALL, ids=lambda source: Path(source).stem)
def test_no_word_lies_upon_another(source):
    _, axes = drawing(source)
    texts = [text for text in axes.texts if text.get_text()]
    boxes = [text.get_window_extent() for text in texts]
    for i, one in enumerate(boxes):
        for text, other in zip(texts[:i], boxes[:i], strict=True):
            wide, high = overlap(one, other)
            assert wide < PIXEL or high < PIXEL, (texts[i].get_text(), text.get_text())


@pytest.mark.parametrize("source", ALL, ids=lambda source: Path(source).stem)
def test_words_beside_a_body_do_not_lie_upon_it(source):
    case, axes = drawing(source)
    own = {word for name, mass in case.long_values()["bodies"].items() for word in (name, str(mass))}
    bodies = [patch.get_window_extent() for patch in bodies_of(axes)]
    for text in axes.texts:
        box = text.get_window_extent()
        if not text.get_text() or text.get_text() in own or text.get_weight() == "bold":
            continue
        for body in bodies:
            wide, high = overlap(box, body)
            if not (body.x0 < (box.x0 + box.x1) / 2 < body.x1):  # a mass written short stands in its body
                assert wide < 3 * PIXEL or high < PIXEL, text.get_text()


@pytest.mark.parametrize("source", STOPPED, ids=lambda source: Path(source).stem)
def test_no_line_of_a_film_runs_through_a_body_at_any_instant(source):
    """Stops are struck and open wide; their parts stay between the bodies that bear them."""
    case = load_case(source, {"run.t_end": "0.03 s" if "chain" in source else "4 s"})
    subject = subject_of(simulate(case))
    end = float(subject.result.t_reached)
    channels = channels_of(subject, (0.0, end), end / 150, 1.0)
    shapes = display_list(channels)
    bodies = [each for each in shapes if each.shape.key.startswith("bodies.")]
    others = [each for each in shapes if each.shape.kind == "line"]
    assert len(bodies) == len(case.long_values()["bodies"])
    for values in channels.values:
        boxes = [(*each.at(values).min(axis=0), *each.at(values).max(axis=0)) for each in bodies]
        for each in others:
            assert not any(inside(each.at(values), box) for box in boxes), (each.shape.key, each.at(values))


def arrows(axes, gid):
    """x of tail and tip of the arrows of a part, and whether they have two heads."""
    arrows = notes(axes, gid)
    return [(one.xyann[0], one.xy[0], one.arrowprops["arrowstyle"].startswith("<")) for one in arrows]


def test_what_turns_is_a_disc_under_a_bent_arrow():
    """It stands on no wheels; what moves along the line beside it is a box that does."""
    disc = drawn(load_case("gallery/driven-pendulum"))
    cart = drawn(load_case("gallery/duffing-two-well"))
    of_disc, of_cart = bodies_of(disc) + bodies_of(cart)
    assert isinstance(of_disc, Polygon)
    assert isinstance(of_cart, FancyBboxPatch)
    wheels = [len([one for one in axes.patches if isinstance(one, Circle)]) for axes in (disc, cart)]
    assert wheels == [0, 2]
    bent = [
        ["connectionstyle" in text.arrowprops for text in axes.texts if text.get_gid() == "forces.drive"]
        for axes in (disc, cart)
    ]
    assert bent == [[True], [False]]


def test_a_disc_of_a_film_is_a_disc():
    subject = subject_of(simulate(load_case("gallery/driven-pendulum", {"run.t_end": "1 s"})))
    shapes = display_list(channels_of(subject, (0.0, 1.0), 0.1, 1.0))
    [disc] = [each.shape for each in shapes if each.shape.key.startswith("bodies.")]
    assert len(disc.vertices) > 20


def test_a_constant_force_points_as_it_acts():
    [(tail, tip, both)] = arrows(drawing("gallery/bouncing-ball")[1], "forces.weight")
    assert tip < tail and not both
    [(tail, tip, both)] = arrows(drawing("gallery/pile-driver")[1], "forces.weight_of_ram")
    assert tip > tail and not both


@pytest.mark.parametrize(
    ("force", "ways"),
    [
        ("F0: 2 N, A: 1 N, omega: 1 Hz", (False, True)),
        ("F0: 2 N, A: 3 N, omega: 1 Hz", (True, True)),
        ("F0: -2 N, A: 2 N, omega: 1 Hz", (True, False)),
        ("A: 1 N, omega: 1 Hz", (True, True)),
        ("F0: -1 N", (True, False)),
        ("force: F*sin(w*t), F: 1 N, w: 1 rad/s", (True, True)),
    ],
)
def test_which_ways_a_force_points(force, ways):
    case = load_case_text(f"bodies: {{a: 1 kg}}\nforces: {{f: {{on: a, {force}}}}}\nrun: {{t_end: 1 s}}\n")
    assert ways_of(case.long_values()["forces"]["f"]) == ways


def test_a_law_by_a_formula_is_a_box_that_says_what_it_reads():
    case = load_case("gallery/van-der-pol")
    kinds = {element.title: (element.kind, element.law) for element in elements(case.long_values())}
    assert kinds["damper"] == ("law", "f(v, d)") and kinds["spring"] == ("spring", "")
    assert "f(v, d)" in texts(drawn(case))


@pytest.mark.parametrize("name", gallery_case_names())
def test_every_formula_of_a_link_reads_something(name):
    for element in elements(load_case(name).long_values()):
        if element.kind == "law":
            assert element.law.startswith("f(")


# Machines with formulas, rotors and states as drawings.


MOTOR = """\
name: ramp
bodies: {cart: 1 kg}
links: {spring: {between: [cart, ground], k: 400 N/m}}
motor: {on: cart, m3: 0.03 kg, e: 0.01 m, J: 0.0001 kg m^2, M0: 0.01 N m, Omega0: "1 Hz + r*t", r: 2 rad/s^2}
run: {t_end: 2 s, every: 5 ms}
"""


@pytest.fixture(scope="module")
def axes():
    return drawn(case_of(EVERYWHERE))


def test_a_link_with_a_formula_is_one_element_with_its_name():
    """One element, not the spring and the damper that its numbers k and c would be."""
    spring, *others = elements(case_of(EVERYWHERE).long_values())
    assert (spring.kind, spring.key, spring.title) == ("law", "links.spring", "spring")
    assert spring.value == "k*d + k3*d**3 + c*v*abs(v)"
    assert [(one.kind, one.key) for one in others if one.key == "links.arm"] == [
        ("spring", "links.arm"), ("damper", "links.arm"),
    ]  # fmt: skip


def test_every_part_is_there_and_no_state(axes):
    parts = {"links.spring", "links.arm", "stops.wall", "friction.floor", "forces.push"}
    assert {*parts, "rotors.left", "rotors.right", "rotors.pendulum", "base"} <= gids(axes)
    assert not any(gid.startswith("states") for gid in gids(axes))
    assert "i" not in texts(axes)


def test_rotors_are_circles_on_their_bodies_one_above_the_other(axes):
    """Two on the cart at different heights, one on the tip at the height of the first."""
    rotors = [one for one in axes.patches if (one.get_gid() or "").startswith("rotors.")]
    circles = {one.get_gid(): one.center for one in rotors if isinstance(one, Circle)}
    plan = layout(case_of(EVERYWHERE).long_values())
    assert circles["rotors.left"][0] == circles["rotors.right"][0] == pytest.approx(plan.box("cart").centre)
    assert circles["rotors.pendulum"][0] == pytest.approx(plan.box("tip").centre)
    assert circles["rotors.left"][1] == circles["rotors.pendulum"][1] < circles["rotors.right"][1]
    assert max(y for _, y in circles.values()) < plan.roof


def test_labels_say_the_laws(axes):
    said = texts(axes)
    assert {"push: A*sin(w1*t)", "left: Kt*i - b*w", "right: 0.1 N m, 5 Hz"} <= said
    assert "K*p*(1 + lam*pv)" in said and "base: a*sin(w0*t)" in said
    assert any(text.startswith("µ = mu_d + (mu_s") and text.endswith("…, N = m*g") for text in said)


def test_long_formulas_are_cut():
    force = case_of(MACHINE).long_values()["forces"]["push"]["force"]
    assert short(force) == "A*sin(w1*t)*where(t < t1, 1, …" and len(short(force)) == LONGEST_FORMULA


def test_a_motor_with_a_formula_is_drawn_as_one():
    axes = drawn(case_of(MOTOR))
    assert "motor: 0.01 N m, 1 Hz + r*t" in texts(axes)
    assert "motor" in {patch.get_gid() for patch in axes.patches}
    assert angle_columns(case_of(MOTOR).scene()) == {"": "phi"}


def test_moving_rotors_turn_by_their_own_angles():
    """Unbalanced masses lie at the angles of their channels, every other vertex of the rotor stays."""
    case = case_of(EVERYWHERE)
    angles = angle_columns(case.scene())
    assert angles == {"": "", " left": "phi_left", " right": "phi_right", " pendulum": "phi_pendulum"}
    still = np.zeros(1)
    ends = dict.fromkeys(("cart", "tip", "ground", "base"), still)
    stage = stage_for(case.long_values(), ends, {"stops.wall": 0.001})
    at = dict.fromkeys((*ends, "stops.wall", "floor"), 0.0)
    for i, name in enumerate(angles):
        at |= {f"cosine{name}": np.cos(1.0 + i), f"sine{name}": np.sin(1.0 + i)}
    recorder = Recorder()
    sketch(recorder, stage, at)
    arms = {one.key: one.vertices for one in recorder.shapes if one.key.startswith("rotors.")}
    for i, key in enumerate(("rotors.left", "rotors.right", "rotors.pendulum"), 1):
        (x0, y0), (x1, y1) = arms[key]
        assert np.arctan2(y1 - y0, x1 - x0) == pytest.approx(np.arctan2(np.sin(1 + i), np.cos(1 + i)))


def test_a_machine_without_formulas_has_one_rotor_alone():
    assert angle_columns(case_of(CURRENT).scene()) == {"": "", " left": "phi_left"}
