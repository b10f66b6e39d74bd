"""Sweeps of scenes of named parts, against runs sampled so finely that nothing lies between the samples."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

from tests.sweeps.made import assert_same_points, complete, in_memory, short_plan, swept
from vibsim.analysis.cycles import parse_discard
from vibsim.cases import load_case
from vibsim.cases.case import load_case_text
from vibsim.engine.trajectory import open_trajectory
from vibsim.physics.parts import EVENT_KINDS, columns_of
from vibsim.results.simulation import open_result
from vibsim.sweeps.points import Measurement
from vibsim.sweeps.quantities import FAILED
from vibsim.sweeps.statistics import sampled_for_statistics
from vibsim.sweeps.sweep_file import SweepStore
from vibsim.sweeps.sweep_plan import PlanError, PointSettings
from vibsim.sweeps.sweeping import sweep

SIEVE = """
bodies: {deck: 3 kg, lump: 1 kg}
links: {spring: {between: [deck, base], k: 8 kN/m, c: 40 N s/m}}
stops:
  floor: {between: [lump, deck], gap: 1 mm, acts: extension, k: 40 kN/m, c: 30 N s/m, release: force}
  roof: {between: [deck, lump], gap: 3 mm, acts: extension, k: 40 kN/m}
friction: {side: {between: [lump, ground], N: 5 N, mu: 0.1, belt: 0.05 m/s}}
forces: {weight: {on: lump, F0: -8 N}}
base: {terms: {1: {a: 8 mm, omega: 6 Hz}, 2: {a: 2 mm, omega: 9 Hz, phase: 40 deg}}}
run: {t_end: 3 s}
"""
FEEDER = """
bodies: {trough: 4 kg, lid: 500 g}
links: {mount: {between: [trough, ground], k: 5 kN/m, c: 10 N s/m}}
stops: {seat: {between: [lid, trough], gap: 0 m, acts: extension, k: 50 kN/m, c: 40 N s/m}}
friction: {side: {between: [lid, trough], N: 1 N, mu: 0.2}}
forces: {weight: {on: lid, F0: -1.5 N}}
motor: {on: trough, m3: 0.5 kg, e: 0.02 m, J: 0.001 kg m^2, M0: 0.5 N m, Omega0: 9 Hz}
initial: {motor: {phidot: 8 Hz}}
run: {t_end: 3 s}
"""
GALLERY = {
    "drifting-capsule": {"run.t_end": "6 s"},
    "stack-of-blocks": {"run.t_end": "2 s"},
    "percussive-drill": {"run.t_end": "1 s"},
    "impact-damper": {"run.t_end": "16 s", "initial.body.x": "25 mm"},
}
FINE = 20_000  # samples per second


MACHINE = ("I-A", "I-B", "I-C-eq211", "II-A", "II-B", "II-C")  # of the paper, in the long form


def case_named(name):
    if name in MACHINE:
        return load_case_text(load_case(name, {"run.t_end": "24 s"}).long_text(), name=name)
    written = {"sieve": SIEVE, "feeder": FEEDER}
    return load_case_text(written[name], name=name) if name in written else load_case(
        f"cases/gallery/{name}.yaml", GALLERY[name]
    )  # fmt: skip


def measured(case, *names, discard="50 %", section=10):
    """Values and arrays of one run by name."""
    settings = PointSettings(case, False, parse_discard(discard), section, None, names)
    return Measurement(sampled_for_statistics(case.scene()), settings, None).values()


def fine_run(case):
    """Samples, events and section of the whole run, with displacements and velocities of the base as X, V."""
    scene = replace(case.scene(), every_num=1, every_den=FINE)
    trajectory = open_trajectory(scene, section=True, ledger=True)
    blocks = list(trajectory.blocks())
    samples, events, section = (
        {name: np.concatenate([table[name] for table in tables]) for name in tables[0]}
        for tables in zip(*((b.samples, b.events, b.section) for b in blocks), strict=True)
    )
    for table, clock in ((samples, "time"), (events, "t"), (section, "time")):
        angles = [(h, h.omega * table[clock] + h.phase) for h in scene.base]
        table["X"] = sum((h.amplitude * np.sin(angle) for h, angle in angles), np.zeros(len(table[clock])))
        table["V"] = sum((h.amplitude * h.omega * np.cos(a) for h, a in angles), np.zeros(len(table[clock])))
    return samples, events, section, trajectory.totals


PAIRS = {
    "drifting-capsule": {"relative_anvil": ("hammer", "capsule")},
    "stack-of-blocks": {},
    "percussive-drill": {"relative_shank": ("hammer", "bit")},
    "impact-damper": {"relative_left": ("ball", "body")},
    "sieve": {"relative_floor": ("lump", "deck"), "relative_spring": ("deck", "base")},
    "feeder": {"relative_seat": ("lid", "trough")},
    **{name: {"relative_stop": ("1", "2")} for name in MACHINE},
}


def naive(case, begin):
    """The statistics of the time from `begin` on [s], from samples alone."""
    samples, events, section, _ = fine_run(case)
    scene = case.scene()
    marks = [t for t in section["time"].tolist() if t >= begin]
    rows = {name: np.concatenate([samples[name], section[name]]) for name in section}
    places = {body.name: columns_of(body.name)[0] for body in scene.bodies} | {"base": "X"}
    motions = {column: rows[column] for column in places.values() if column != "X"}
    for name, (P, Q) in PAIRS[case.name].items():
        motions[name] = rows[places[P]] - rows[places[Q]]
    late, values = rows["time"] >= begin, {"periods": len(marks) - 1}
    for name, x in motions.items():
        halves = [
            np.ptp(x[(rows["time"] >= first) & (rows["time"] <= last)]) / 2
            for first, last in itertools.pairwise(marks)
        ]
        values |= {f"amplitude_{name}": np.mean(halves), f"amplitude_{name}_max": max(halves)}
        values |= {f"{name}_min": x[late].min(), f"{name}_max": x[late].max()}
    for body in scene.bodies:
        points = section["time"] >= begin
        x = section[places[body.name]][points]
        line = np.polynomial.Polynomial.fit(section["time"][points], x, 1)
        values[f"drift_rate_{places[body.name]}"] = line.convert().coef[1]
    names = [part.name for part in (*scene.stops, *scene.frictions)]
    inside = (events["t"] >= marks[0]) & (events["t"] < marks[-1])
    for what, kind, parts in (
        ("impacts", "contact_begin", scene.stops),
        ("sticks", "stick_begin", scene.frictions),
    ):
        counted = inside & (events["kind"] == EVENT_KINDS[kind])
        values |= {f"{what}_per_period": counted.sum() / values["periods"]}
        for part in parts:
            of_part = counted & (events["part"] == names.index(part.name))
            values[f"{what}_per_period_{part.name}"] = of_part.sum() / values["periods"]
    if scene.has_motor:
        speed = rows["phidot"][late] / (2 * math.pi)
        values |= {"min_speed": speed.min(), "max_speed": speed.max()}
        values["mean_speed"] = values["periods"] / (marks[-1] - marks[0])
    steps = [np.abs(np.diff(samples[columns_of(body.name)[1]])).max() for body in scene.bodies]
    return values, 2 * max(steps) / FINE / 8  # samples miss an extreme by a h^2 / 8 at most


@pytest.mark.parametrize("name", PAIRS)
def test_every_statistic_is_that_of_a_finely_sampled_run(name):
    case = case_named(name)
    begin = case.scene().t_end / 2
    values, _ = measured(case)
    expected, missed = naive(case, begin)
    assert expected["periods"] >= 3
    assert expected.keys() <= values.keys()
    for key, value in expected.items():
        tolerance = 1e-3 if key.endswith("speed") else missed
        assert values[key] == pytest.approx(value, abs=tolerance), key


@pytest.mark.parametrize("name", MACHINE)
def test_two_blocks_have_the_statistics_of_their_long_form(name):
    """Under names of their own: of the relative motion at the stop, and of the drift of block 2."""
    short, _ = measured(load_case(name, {"run.t_end": "24 s"}))
    long, _ = measured(case_named(name))
    renamed = {key: key.replace("relative", "relative_stop") for key in short}
    renamed["drift_rate"] = "drift_rate_x2"
    assert short == {key: long[other] for key, other in renamed.items()}
    assert short["periods"] > 30


@pytest.mark.parametrize("name", ["sieve", "feeder"])
def test_what_is_stored_has_the_names_of_bodies_and_parts(name):
    case = case_named(name)
    computed = ["power", "impact-velocity", "contact-section", "grazing"]
    values, arrays = measured(case, *computed)
    plan = short_plan({"run.t_end": "3 s"}, case, compute=computed)
    stored = set(plan.columns) - {"wall_time"}
    assert stored <= values.keys() | arrays.keys() | {key for key in stored if key.startswith("grazing")}
    if name == "sieve":
        assert {"x_deck_min", "amplitude_relative_floor_max", "drift_rate_x_lump", "end_v_deck"} <= stored
        assert {"section_relative_spring", "section_velocity_floor", "section_v_lump"} <= stored
        assert {"impacts_per_period_roof", "sticks_per_period_side", "power_force_weight"} <= stored
        assert {"power_belt_side", "power_stop_floor", "power_damper_spring", "power_friction_side"} <= stored
        assert {"impact_velocity_roof", "contact_velocity_floor", "contact_phase_roof"} <= stored
    else:
        assert {"mean_speed", "power_motor", "contact_speed_seat", "end_phi", "section_speed"} <= stored


@pytest.mark.parametrize("name", ["sieve", "feeder", "percussive-drill", "stack-of-blocks"])
def test_the_powers_of_the_parts_add_up_and_balance(name):
    values, _ = measured(case_named(name), "power", "certificate")
    powers = {key: value for key, value in values.items() if key.startswith("power_")}

    def parts(begin):
        return sum(value for key, value in powers.items() if key.startswith(begin))

    given = powers["power_source"] + powers["power_base"] + powers["power_belts"]
    taken = powers["power_damper"] + powers["power_stops"] + powers["power_friction"] + powers["power_stored"]
    size = max(map(abs, powers.values()))
    assert given == pytest.approx(taken, abs=1e-11 * size)
    assert parts("power_force_") + powers.get("power_motor", 0) == pytest.approx(powers["power_source"])
    for of_each, of_all in {
        "belt": "belts",
        "damper": "damper",
        "stop": "stops",
        "friction": "friction",
    }.items():
        assert parts(f"power_{of_each}_") == pytest.approx(powers[f"power_{of_all}"], abs=1e-15 * size)
    assert values["uncertified"] == 0


def test_the_power_of_a_force_is_its_work_in_whole_runs():
    """Ledgers of two whole runs, up to the ends of the window, differ by the work within it."""
    case = case_named("percussive-drill")
    values, _ = measured(case, "power")
    _, _, section, _ = fine_run(case)
    marks = section["time"][section["time"] >= 0.5]
    works = []
    for t_end in (marks[0], marks[-1]):
        trajectory = open_trajectory(replace(case.scene(), t_end=float(t_end)), ledger=True)
        list(trajectory.blocks())
        works.append({name: trajectory.totals[name] for name in ("work.forces.feed", "loss.stops.shank")})
    for name, column in (("work.forces.feed", "power_force_feed"), ("loss.stops.shank", "power_stop_shank")):
        expected = (works[1][name] - works[0][name]) / (marks[-1] - marks[0])
        assert values[column] == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("name", ["sieve", "impact-damper"])
def test_contacts_are_those_of_the_events_of_each_stop(name):
    case = case_named(name)
    scene = case.scene()
    values, arrays = measured(case, "impact-velocity", "contact-section")
    _, events, section, _ = fine_run(case)
    marks = section["time"][section["time"] >= scene.t_end / 2]
    for i, stop in enumerate(scene.stops):
        P, Q = (f"v_{scene.bodies[end].name}" for end in (stop.P, stop.Q))
        at = (events["kind"] == EVENT_KINDS["contact_begin"]) & (events["part"] == i)
        at &= events["t"] >= scene.t_end / 2
        speeds = (events[P] - events[Q])[at]
        assert arrays[f"contact_velocity_{stop.name}"].tolist() == speeds[-10:].tolist()
        inside = (events["t"][at] >= marks[0]) & (events["t"][at] < marks[-1])
        assert inside.sum() > 3
        mean = np.abs(speeds[inside]).mean()
        assert values[f"impact_velocity_mean_{stop.name}"] == pytest.approx(mean, rel=1e-13)
        turns = events["t"][at][-10:] / (marks[1] - marks[0])
        np.testing.assert_allclose(arrays[f"contact_phase_{stop.name}"], turns % 1, atol=1e-9)


def test_a_mirrored_scene_has_mirrored_statistics():
    """All displacements, forces and senses turned round: least becomes greatest, bit for bit."""
    mirrored = {
        "stops.floor.acts": "compression",
        "stops.roof.acts": "compression",
        "friction.side.belt": "-0.05 m/s",
        "forces.weight.F0": "8 N",
        "base.terms.1.a": "-8 mm",
        "base.terms.2.a": "-2 mm",
    }
    case = case_named("sieve")
    here, there = (measured(each, "grazing")[0] for each in (case, case.with_values(mirrored)))
    assert here["impacts"] > 20
    for key, value in here.items():
        if key.endswith("_min"):
            assert value == -there[key.replace("_min", "_max")], key
        elif key.startswith(("amplitude", "impacts", "sticks", "grazing")):
            assert value == there[key], key
        elif key.startswith("drift"):
            assert value == -there[key], key


def test_friction_swept_through_zero_keeps_its_columns():
    result = sweep(case_named("drifting-capsule"), {"floor.mu": "0, 0.1"}, compute="power", jobs=1)
    assert result["floor_mu"].tolist() == [0.0, 0.1] and result["status"].ravel().tolist() == [1, 1]
    assert result["sticks_per_period_floor"][0, 0] == 0 == result["power_friction_floor"][0, 0]
    assert result["sticks_per_period_floor"][1, 0] > 0 < result["power_friction_floor"][1, 0]


def test_a_sweep_that_carries_the_state_goes_on_where_it_was(tmp_path):
    case = case_named("percussive-drill").with_values({"run.t_end": "0.5 s"})
    axes = {"feed.A": "50, 60, 70 N", "bodies.bit": "0.5, 0.6 kg"}
    plan = short_plan(axes, case, carry_state=True, direction="both")
    result = swept(plan, tmp_path / "drill.h5")
    for index, before in (((1, 0, 0), (0, 0, 0)), ((2, 1, 1), (2, 1, 0)), ((0, 1, 1), (1, 1, 1))):
        start = result.case_at(index).scene()
        for body in start.bodies:
            assert (body.x, body.v) == tuple(result[f"end_{state}_{body.name}"][before] for state in "xv")
    assert result["feed_A"].tolist() == [50, 60, 70] and result["m_bit"].tolist() == [0.5, 0.6]
    with SweepStore(plan, tmp_path / "part.h5") as store:
        store.add([result.table.point(index) for index in ((0, 0, 0), (1, 0, 0), (2, 0, 0), (0, 1, 0))])
    again, computed = complete(plan, tmp_path / "part.h5")
    assert len(computed) == 8
    assert_same_points(again.table, result.table)
    assert_same_points(open_result(tmp_path / "part.h5").table, result.table)


def test_ensembles_spread_what_bodies_and_parts_have(tmp_path):
    spread = {"initial.body.x": "1 mm", "initial.ball.x": "0:2 mm", "stops.left.gap": "normal 0.1 mm"}
    axes = {"links.spring.k": "300, 394.78 N/m"}
    case = case_named("impact-damper")
    result = sweep(case, axes, ensemble=3, seed=5, spread=spread, out=tmp_path / "e.h5", jobs=2)
    assert {"member_body_x", "member_ball_x", "member_left_gap"} <= set(result)
    assert result["amplitude_x_ball"].shape == (2, 3, 1)
    one = result.case_at((1, 2, 0)).scene()
    assert one.bodies[0].x == result["member_body_x"][2] * 1e-3 and one.stops[0].gap != one.stops[1].gap
    values, _ = measured(result.case_at((1, 2, 0)))
    assert values["amplitude_x_ball"] == result["amplitude_x_ball"][1, 2, 0]
    assert result.over_members("impacts").count.tolist() == [[3], [3]]
    rotor = sweep(case_named("feeder").with_values({"run.t_end": "0.2 s"}), ensemble=2)
    assert "member_motor_phi" in rotor


def test_one_axis_may_set_several_keys():
    case = case_named("drifting-capsule").with_values({"run.t_end": "2 s"})
    result = sweep(case, {"push.omega=reaction.omega": "5, 6 Hz"}, jobs=1)
    assert result["push_omega"].tolist() == [5, 6]
    at = result.case_at((1, 0))
    assert {at.number(f"forces.{name}.omega") for name in ("push", "reaction")} == {2 * math.pi * 6}
    assert result["periods"].ravel().tolist() == [5, 6]
    assert result.plan.settings["axes"][0]["also"] == ["forces.reaction.omega"]


def test_what_cannot_be_carried_is_refused_or_fails_alone():
    sieve, feeder = case_named("sieve"), case_named("feeder")
    push = {"forces.push.on": "lid", "forces.push.A": "1 N", "forces.push.omega": "2 Hz"}
    driven = feeder.with_values(push)
    with pytest.raises(PlanError, match="a motor beside forces or a base that vibrate has no state to carry"):
        short_plan({"motor.Omega0": "3, 4 Hz"}, driven, carry_state=True)
    result = in_memory(short_plan({"base.terms.2.omega": "20, 21 rad/s"}, sieve, carry_state=True))
    assert (result.status == FAILED).all()
    assert all("no common period" in text for text in result.error.ravel())


def test_two_columns_of_one_name_are_refused():
    text = "bodies: {a: 1 kg, a_max: 1 kg}\nlinks: {s: {between: [a, a_max], k: 1 N/m}}"
    with pytest.raises(PlanError, match="two columns would be called amplitude_x_a_max: give a body"):
        short_plan({"s.k": "1, 2"}, load_case_text(text, name="twins"))


def test_what_a_scene_has_not_is_not_computed():
    free = load_case_text("bodies: {a: 1 kg}\nlinks: {s: {between: [a, ground], k: 1 N/m}}", name="free")
    needs = {"power": "a source", "grazing": "a stop", "capture": "a motor", "regime": "a source"}
    for name, part in needs.items():
        with pytest.raises(PlanError, match=f"{name} is for cases with {part}; free is another kind of case"):
            short_plan({"s.k": "1, 2"}, free, compute=[name])


def test_rigid_stops_have_impacts_with_the_velocity_in_front_of_them():
    """A ball on a shaken rigid table: each blow takes (1 - e^2) m u^2 / 2, u the velocity in front of it."""
    text = """
    bodies: {ball: 0.1 kg}
    stops: {table: {between: [ball, base], gap: 0 m, acts: extension, law: rigid, e: 0.6}}
    forces: {weight: {on: ball, F0: -0.981 N}}
    base: {a: 2 mm, omega: 20 Hz}
    initial: {ball: {x: 5 mm}}
    run: {t_end: 2 s}
    """
    case = load_case_text(text, name="bouncer")
    values, arrays = measured(case, "power", "impact-velocity", "contact-section", section=1000)
    speeds = arrays["contact_velocity_table"]
    assert len(speeds) > 30 and (speeds < 0).all() and values["impacts"] > 60
    assert values["impacts_per_period"] == values["impacts_per_period_table"] > 1
    assert values["relative_table_min"] == pytest.approx(0, abs=1e-15)
    count = round(values["impacts_per_period"] * values["periods"])
    lost = (1 - 0.6**2) * 0.1 * np.sum(speeds[:count] ** 2) / 2  # the first whole period begins at 1 s
    assert values["power_stop_table"] * values["periods"] / 20 == pytest.approx(lost, rel=1e-9)
