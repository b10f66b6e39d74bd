"""Cases in the long form give the scene of parts that they describe; the short form gives its own."""

from fractions import Fraction
from math import pi
from pathlib import Path

import h5py
import pytest

import vibsim
from tests.scenes import falling
from vibsim.cases import CaseError, hard_case_names, load_case, shipped_case_names
from vibsim.cases.case import load_case_text
from vibsim.cases.part_rules import COLUMNS, GROUPS, WORDS
from vibsim.cases.schema import CaseFile
from vibsim.orbits.orbit import save_orbit
from vibsim.physics.parts import (
    AT_FORCE,
    AT_GAP,
    BASE,
    COMPRESSION,
    EXPONENTIAL,
    EXTENSION,
    GROUND,
    HYPERBOLIC,
    Body,
    Clearance,
    Force,
    Friction,
    Harmonic,
    Link,
    Motor,
    Scene,
    Stop,
    columns_of,
)
from vibsim.results.simulation import simulate, simulate_to_file
from vibsim.sweeps.axes import read_axis

VALID = Path(__file__).parent / "valid"
HAMMER = VALID / "hammer.yaml"
RPM = 2 * pi * 3.5  # 210 rpm


def test_every_part_of_the_long_form():
    assert load_case(HAMMER).scene() == Scene(
        bodies=(Body("ram", 2.0, 0.001, 0.0), Body("tool", 0.5, 0.0, -0.002)),
        links=(Link("spring", 0, GROUND, 4000.0, 2.0), Link("strut", 0, 1, 0.0, 1.0)),
        stops=(
            Stop("anvil", 0, 1, 0.002, COMPRESSION, 1e6, 0.0, AT_GAP),
            Stop("wall", 1, BASE, -0.001, EXTENSION, 1e6, 20.0, AT_FORCE),
        ),
        frictions=(
            Friction("guide", 1, GROUND, 0.6, 0.6, 0.0, 0.78, 0.78),
            Friction("weight", 0, 1, 1.962, 1.962, 0.0),
            Friction("moon", 0, BASE, 0.5508, 1.0368, -0.2, 0.66096, None),
            falling(Friction("rail", 0, GROUND, 0.19, 0.19, 0.0), (HYPERBOLIC, 0.18, 18.0), load=2),
            falling(Friction("seal", 1, GROUND, 0.19, 0.4, 0.0), (EXPONENTIAL, 0.14, 4.0), None, load=2),
        ),
        forces=(
            Force("drive", 0, -2.0, (Harmonic(10.0, 50 * pi, 25.0, 0.0, pi / 2),)),
            Force("push", 1, 1.0, ()),
            Force("rule", 1, 0.0, (Harmonic(0.03 * 0.11 * 22**2, 22.0, *rate(22), 0.0),)),
            Force(
                "chord", 1, 0.0, (Harmonic(1.0, 6 * pi, 3.0, 0.0, 0.0), Harmonic(2.0, RPM, 3.5, 0.0, pi / 2))
            ),
        ),
        base=(Harmonic(1e-4, 314.1592653589793, 50.0, 0.0, 0.5235987755982989),),
        motor=Motor(1, 0.03, 0.11, 0.001, 0.005, 34.55751918948773, 0.0, 2 * pi),
        clearances=(Clearance("room", 0, 1, 0.08),),
        stop_on_violation=True,
        t_end=10.0,
        every_num=1,
        every_den=60,
    )


def rate(per_second):
    """Cycles of a rate in rad/s as a double-double, from 60 digits."""
    import mpmath

    with mpmath.workdps(60):
        cycles = per_second / (2 * mpmath.pi)
        return float(cycles), float(cycles - float(cycles))


def test_a_child_replaces_what_it_names_and_what_stands_in_its_place():
    scene = load_case(VALID / "child.yaml").scene()
    assert [stop.name for stop in scene.stops] == ["anvil"]
    assert scene.motor is None
    guide, weight, moon, rail, seal = scene.frictions
    assert rail == Friction("rail", 0, GROUND, 0.6, 0.6, 0.0)
    assert seal == falling(Friction("seal", 1, GROUND, 0.25, 0.25, 0.0), (HYPERBOLIC, 0.25, 2.0), load=2)
    assert (guide.forward, guide.backward) == (0.05, 0.15)
    assert (moon.forward, moon.backward, weight.forward) == (2.0, 2.0, 1.962)
    drive, _, _, chord = scene.forces
    assert (drive.constant, [term.amplitude for term in drive.terms]) == (-2.0, [1.0])
    assert [term.amplitude for term in chord.terms] == [7.0]
    assert [term.amplitude for term in scene.base] == [0.001]


OTHERS = [
    {"rest_distance.value": "80 mm", "on_violation": "stop"},
    {"m2": "fixed", "friction": "none", "rest_distance.value": "80 mm"},
    {"stop": "none", "excitation": "none", "x1": "1 mm"},
    {"acts": "compression", "mu": "0", "phi": "90 deg"},
]


def in_the_short_form(names):
    return [name for name in names if isinstance(load_case(name).model, CaseFile)]


@pytest.mark.parametrize("name", in_the_short_form([*shipped_case_names(), *hard_case_names()]))
def test_the_short_form_gives_the_numbers_of_its_symbols(name):
    case = load_case(name)
    assert case.scene() == case.two_blocks().as_parts()


@pytest.mark.parametrize("changes", OTHERS)
def test_the_short_form_with_other_sections(changes):
    case = load_case("II-B", changes)
    assert case.scene() == case.two_blocks().as_parts()


def test_exact_scenes_round_to_the_same_scene():
    for source in (HAMMER, "II-B", "I-A-eq211"):
        case = load_case(source)
        exact, rounded = case.exact_scene(Fraction), case.scene()
        assert [float(body.m) for body in exact.bodies] == [body.m for body in rounded.bodies]
        pairs = zip(exact.frictions, rounded.frictions, strict=True)
        assert all(float(a.forward) == b.forward and float(a.backward) == b.backward for a, b in pairs)
        terms = [term for force in exact.forces for term in force.terms]
        doubles = [term for force in rounded.forces for term in force.terms]
        assert [(float(t.amplitude), float(t.omega)) for t in terms] == [
            (t.amplitude, t.omega) for t in doubles
        ]


def test_names_of_columns():
    assert columns_of("ram") == ("x_ram", "v_ram")
    assert columns_of("2") == ("x2", "v2")


@pytest.mark.parametrize(
    ("changes", "key", "number"),
    [
        ({"stops.wall.k": "2 MN/m"}, "stops.wall.k", 2e6),
        ({"wall.k": "2 MN/m"}, "stops.wall.k", 2e6),
        ({"bodies.ram": "3 kg"}, "bodies.ram", 3.0),
        ({"forces.chord.terms.2.A": 5}, "forces.chord.terms.2.A", 5.0),
        ({"forces.rule.A.e": "1 m"}, "forces.rule.A.e", 1.0),
        ({"base.a": "1 mm"}, "base.a", 0.001),
        ({"Omega0": "6 Hz"}, "motor.Omega0", 12 * pi),
        ({"initial.tool.x": "1 mm"}, "initial.tool.x", 0.001),
        ({"friction.guide.g": "1 m/s^2"}, "friction.guide.g", 1.0),
        ({"friction.weight.N": "7 N"}, "friction.weight.N", 7.0),
        ({"friction.weight.plus.mu": "0.3", "friction.weight.minus.mu": "0.4"}, "weight.minus.mu", 0.4),
        ({"distance": "9 mm"}, "clearances.room.distance", 0.009),
    ],
)
def test_a_path_reaches_each_number(changes, key, number):
    case = load_case(HAMMER, changes)
    assert case.number(key) == number
    assert load_case(HAMMER).with_values(changes).scene() == case.scene() != load_case(HAMMER).scene()


def test_parts_are_taken_out_and_added():
    case = load_case(HAMMER, {"stops.wall": "none", "friction": "none", "motor": "none", "base": "none",
                              "initial.motor": "none"})  # fmt: skip
    assert ([stop.name for stop in case.scene().stops], case.scene().frictions) == (["anvil"], ())
    added = load_case(HAMMER, {"links.tie.between": "[tool, ground]", "links.tie.k": "1 N/m"})
    assert added.scene().links[-1] == Link("tie", 1, GROUND, 1.0, 0.0)


def test_what_can_be_swept():
    keys = load_case(HAMMER).numeric_keys()
    assert {
        "bodies.ram", "stops.wall.gap", "friction.moon.plus.mu", "friction.weight.g", "base.phase", "motor.J",
        "forces.chord.terms.1.omega", "initial.motor.phi", "clearances.room.distance",
    } <= set(keys)  # fmt: skip


def test_sources_and_frequencies():
    assert [load_case(name).source_kind for name in ("II-B", "I-A", HAMMER)] == ["motor", "harmonic", "motor"]
    base = load_case(VALID / "base_by_terms.yaml")
    assert (base.source_kind, base.frequency()) == ("base", None)
    assert str(base.with_values({"base.terms.2.omega": "1 Hz"}).frequency()) == "1 Hz"
    assert (load_case(VALID / "one_body.yaml").source_kind, load_case("I-A").frequency().text) == (
        "none",
        "3.5 Hz",
    )


def test_a_scene_of_parts_has_no_symbols_of_the_paper():
    for make in ("two_blocks", "exact_two_blocks"):
        with pytest.raises(CaseError, match="bodies: named parts have no symbols of the paper"):
            getattr(load_case(HAMMER), make)(*([Fraction] if make == "exact_two_blocks" else []))


@pytest.mark.parametrize(
    ("key", "text", "name"),
    [
        ("stops.wall.k", "1:2/3 MN/m", "wall_k"),
        ("ram", "1:2/3", "m_ram"),
        ("forces.chord.terms.2.omega", "1:2/3 Hz", "chord_terms_2_omega"),
        ("motor.Omega0", "1:2/3 Hz", "omega0"),
    ],
)
def test_axes_of_a_sweep_are_named_after_their_part(key, text, name):
    assert read_axis(load_case(HAMMER), key, text).name == name


def test_static_of_1_is_no_static_friction():
    plain, told = (
        load_case("gallery/friction-oscillator", changes) for changes in ({}, {"floor.static": "1"})
    )
    assert told.scene() == plain.scene()


def started(gap, ram, base=""):
    """A ram at a rigid stop, by its gap, its displacement and a base at the other end."""
    end = "base" if base else "ground"
    stop = f"{{between: [{end}, ram], gap: {gap}, acts: compression, law: rigid, e: 0.5}}"
    lines = ["bodies: {ram: 1 kg}", f"stops: {{stop: {stop}}}", f"initial: {{ram: {{x: {ram}}}}}", base]
    return "\n".join(lines)


@pytest.mark.parametrize(
    ("gap", "ram", "base"),
    (
        ("-0.30000000000000004 m", "0.3 m", ""),  # 0.1 + 0.2
        ("0 m", "0.0006427876096865393 m", "base: {a: 1 mm, omega: 1 Hz, phase: 40 deg}"),  # sin, in doubles
        ("0 m", "0.0006427876096865384 m", "base: {a: 1 mm, omega: 1 Hz, phase: 40 deg}"),
    ),
)
def test_what_rounding_of_doubles_leaves_inside_a_rigid_stop_touches_it(tmp_path, gap, ram, base):
    path = tmp_path / "case.yaml"
    path.write_text(started(gap, ram, base))
    pushed = {"run.t_end": "0.1 s", "forces.push.on": "ram", "forces.push.F0": "-10 N"}
    result = simulate(load_case(path, pushed))
    assert abs(result["x_ram"][-1] - result["x_ram"][0]) < 2e-3  # 50 mm without a stop
    path.write_text(started(gap, f"{float(ram.split()[0]) - 1e-9} m", base))
    with pytest.raises(CaseError, match="inside this rigid stop"):
        load_case(path)


def test_a_scene_that_no_result_file_can_hold_is_told(tmp_path):
    path = tmp_path / "case.yaml"
    path.write_text("bodies: {" + ", ".join(f"b{i}: 1 kg" for i in range(2001)) + "}")
    with pytest.raises(CaseError, match="make 4002 columns; a result file has room for 4000"):
        load_case(path)


# Names that a part may not have: every column and group that a file may hold.


SCENE = """
bodies: {{m: 1 kg}}
links: {{spring: {{between: [m, ground], k: 100 N/m}}}}
stops: {{{name}: {{between: [m, ground], law: rigid, e: 0.5, gap: 1 mm, acts: compression}}}}
motor: {{on: m, m3: 10 g, e: 1 cm, J: 1 g m^2, M0: 0.1 N m, Omega0: 5 Hz}}
run: {{t_end: 0.2 s, every: 10 ms}}
"""


def scene(name):
    return load_case_text(SCENE.format(name=name))


def names_in(path):
    """Names at the root of a file and of its events, but those of bodies and of the stop `wall`."""
    with h5py.File(path) as file:
        names = {*file, *file["events"]}
    return {name for name in names if name != "wall" and not name.endswith(("_m",))}


def test_all_columns_and_groups_of_files_are_taken(tmp_path):
    """With a motor, rigid stops, an estimate, digits, an orbit; and the column of the paper's stop."""
    simulate_to_file(scene("wall"), tmp_path / "run.h5")
    simulate_to_file(scene("wall"), tmp_path / "digits.h5", digits=20)
    simulate_to_file(scene("stop"), tmp_path / "stop.h5")
    save_orbit(vibsim.orbit("I-C"), tmp_path / "orbit.h5")
    names = set().union(*(names_in(tmp_path / f"{name}.h5") for name in ("run", "digits", "stop")))
    with h5py.File(tmp_path / "orbit.h5") as file:
        groups = {name for name in file if isinstance(file[name], h5py.Group)}
    assert names | groups == {*COLUMNS, *GROUPS}


@pytest.mark.parametrize("name", [*WORDS, *COLUMNS, *GROUPS])
def test_a_part_of_a_taken_name_is_refused_with_the_others(name):
    with pytest.raises(vibsim.CaseError) as caught:
        scene(name)
    (problem,) = caught.value.problems
    others = WORDS if name in WORDS else COLUMNS + GROUPS
    assert f"stops.{name}: the name is taken" in str(problem)
    assert all(other in str(problem) for other in others)
