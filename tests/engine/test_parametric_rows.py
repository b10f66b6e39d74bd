"""Packed modes that follow from numbers of the scene are those that are made anew."""

import gc
import weakref
import zlib
from contextlib import suppress
from dataclasses import replace
from fractions import Fraction
from math import sqrt

import numpy as np
import pytest

from tests.engine import runs
from tests.engine.random_formulas import formula_scene
from tests.engine.runs import run
from tests.formula_cases import case_of
from tests.random_scenes import Draws
from vibsim.cases import load_case
from vibsim.engine import c_engine
from vibsim.engine.errors import EngineError, start_of
from vibsim.engine.modes import formula_rows
from vibsim.engine.modes import mode_table as tables
from vibsim.engine.modes.mode_table import ModeTable
from vibsim.engine.modes.parametric_rows import differences
from vibsim.engine.tangent.carrying_run import CarryingRun
from vibsim.engine.tangent.monodromy import Carrier
from vibsim.physics.numbers import Doubles
from vibsim.physics.traced_numbers import NotRecorded, Record, RecordedNumbers


def test_a_record_is_repeated_on_other_numbers():
    record = Record([3.0, 4.0])
    a, b = record.inputs
    c = RecordedNumbers.sqrt(a * a + b * b) / 2 - abs(-a) if a < b else a
    for x, y in ((3.0, 4.0), (0.1, 0.7)):
        assert record.repeated([x, y])[c.place] == sqrt(x * x + y * y) / 2 - abs(-x)
    assert record.repeated([2.0, 1.0]) is None  # a comparison falls out otherwise
    with pytest.raises(NotRecorded):
        float(c)


def test_keys_stay_equal_and_different():
    record = Record([Fraction(1, 3), Fraction(1, 3), Fraction(1, 5)])
    known = dict.fromkeys((*record.inputs, record.constant(Fraction(1, 7))))
    assert len(known) == 3
    one, two, seventh, three = (Fraction(1, n) for n in (11, 13, 7, 3))
    assert record.repeated([one, one, two]) and record.repeated([three, three, three / 2])
    for inputs in ([one, two, seventh / 2], [one, one, one], [seventh, seventh, one]):
        assert record.repeated(inputs) is None
    assert record.repeated([Fraction(2)] * 2 + [one]) is None  # a formula may have a 2 of its own


def with_links(scene, c, k=1.0):
    """The scene with other dampers and springs, by factors."""
    return replace(scene, links=tuple(replace(one, k=k * one.k, c=c * one.c) for one in scene.links))


@pytest.mark.parametrize(
    ("name", "repeats"), [("I-A", True), ("II-B", True), ("gallery/two-masses-with-friction", False)]
)
def test_modes_follow_from_their_recipes(name, repeats, monkeypatch):
    """Where Jacobi's rotations take other steps, as with two masses on two springs, they are made anew."""
    of = load_case(name).scene()
    first = CarryingRun(of)
    other = with_links(of, 1.37, 1.01)
    numbers = differences(of, other)
    assert numbers
    table, anew = first.table.retuned(other, numbers), ModeTable(other)
    anew.keys = first.table.keys
    start = first.automaton.initial(start_of(of, Doubles))[0]
    statuses = {start, *(start.with_stop(i, 1) for i, _ in of.elastic_stops)}
    statuses |= {start.with_frictions(dict.fromkeys(range(len(of.frictions)), s)) for s in (-1, 0, 1)}
    for status in statuses:
        first.table.packed(status)  # the order of keys
        with monkeypatch.context() as patched:
            if repeats:
                patched.setattr(ModeTable, "_pack", lambda *_: pytest.fail("made anew"))
            packed = table.packed(status)
        assert packed == anew.packed(status)


def test_scenes_over_a_damping_share_one_run(monkeypatch):
    made = []
    begin = c_engine.CRun.__init__
    monkeypatch.setattr(
        c_engine.CRun,
        "__init__",
        lambda self, *args, **how: (made.append(self), begin(self, *args, **how))[1],
    )
    of = load_case("I-A").scene()
    first = Carrier(of)
    for factor in (1.0, 1.1, 0.9):
        first.of(with_links(of, factor)).carry([0.0, 0.0, 0.2, 0.0], 1.0)
    assert len(made) == 1


def test_a_run_goes_with_its_carriers():
    """Without the collector of cycles: branches open many."""
    of = load_case("I-A").scene()
    gc.collect()
    gc.disable()
    try:
        first = Carrier(of)
        second = first.of(with_links(of, 1.1))
        for one in (first, second):
            one.carry([0.0, 0.0, 0.2, 0.0], 1.0)
        run = weakref.ref(first._shared.run)
        del first, second, one
        assert run() is None
    finally:
        gc.enable()


OVER_FORMULAS = [
    ("bouc-wen", ("parameters.k", "parameters.r"), [0.0, 0.0, 0.5, 0.0], 1.0),
    (
        "coupled-clutches",
        ("friction.clutch1.F", "friction.clutch2.F", "bodies.disc2"),
        [0.0] * 4 + [10.0, 0.0, 0.0, 0.0],
        1.2,
    ),
    ("brake-squeal", ("parameters.k3", "friction.belt.mu"), [0.57, -0.16, 0.0, 0.0], 60.0),
    ("hertz-chain", ("parameters.K",), [0.0] * 4 + [1.0, 0.0, 0.0, 0.0], 3.0),
    ("gear-pair", ("links.mesh.k1", "parameters.w", "links.mesh.b"), [0.9, 0.0], 30.0),
    ("duffing-hardening", ("links.spring.k", "links.spring.k3"), [1.0, 0.0], 10.0),
    ("pendulum-on-cart", ("parameters.g", "bodies.cart"), [0.0] * 4, 2.0),
    ("lugre-friction", ("parameters.s0", "parameters.Fc"), [0.0] * 4, 0.05),
    ("captured-motor", ("states.i.L", "motor.Kt"), [0.0] * 8, 3.0),
]


@pytest.mark.parametrize("name, keys, start, end", OVER_FORMULAS, ids=[one[0] for one in OVER_FORMULAS])
def test_scenes_over_numbers_of_formulas_share_one_run(name, keys, start, end):
    """With the bits of runs whose modes are made anew."""
    draw, shared = Draws(zlib.crc32(name.encode())), None
    case = load_case(f"gallery/{name}")
    for _ in range(3):
        values = {}
        for key in keys:
            number, _, unit = case.values[key].text.partition(" ")
            values[key] = f"{draw.between(0.8, 1.2) * float(number)!r} {unit}".rstrip()
        scene = case.with_values(values).scene()
        shared = shared or Carrier(scene)
        taking_turns, alone = shared.of(scene), Carrier(scene)
        one, other = (carrier.carry(start, end) for carrier in (taking_turns, alone))
        for what in ("state", "rate", "vectors", "table"):
            assert np.array_equal(getattr(one, what), getattr(other, what)), what


def test_numbers_of_formulas_that_come_to_be_equal():
    """Or to be 1, which a product leaves out: the modes are made anew."""
    case = case_of("""\
bodies: {mass: 1 kg}
links:
  spring: {between: [mass, ground], force: "max(a*d, b*d) + c*d*abs(d)", a: 2.2 N/m, b: 3.5 N/m, c: 1.5 N/m^2}
run: {t_end: 1 s, every: 10 ms}
""")
    first = Carrier(case.scene())
    first.carry([0.1, 0.0], 1.0)
    for values, shares in (({"a": "2.1 N/m"}, True), ({"a": "3.5 N/m"}, False), ({"c": "1 N/m^2"}, False)):
        scene = case.with_values({f"links.spring.{key}": value for key, value in values.items()}).scene()
        other = first.of(scene)
        assert (other is not None) is shares
        if shares:
            one, alone = (carrier.carry([0.1, 0.0], 1.0) for carrier in (other, Carrier(scene)))
            assert np.array_equal(one.state, alone.state) and np.array_equal(one.vectors, alone.vectors)


def test_belts_by_formulas():
    """Scenes with them could not be compared."""
    case = case_of("""\
bodies: {block: 1 kg}
links: {spring: {between: [block, ground], k: 100 N/m}}
friction:
  belt: {between: [block, ground], N: 10 N, mu: 1, belt: "u*(1 + sin(w*t)/8)", u: 0.5 m/s, w: 1 Hz}
run: {t_end: 1 s, every: 10 ms}
""")
    first = Carrier(case.scene())
    for values in ({"friction.belt.u": "0.6 m/s"}, {"links.spring.k": "110 N/m"}):
        scene = case.with_values(values).scene()
        one, alone = (carrier.carry([0.0, 0.0], 3.0) for carrier in (first.of(scene), Carrier(scene)))
        assert np.array_equal(one.state, alone.state) and np.array_equal(one.table, alone.table)
        assert len(one.table) > 0


def test_what_decides_on_the_form_of_modes():
    of = load_case("I-A").scene()
    assert differences(of, with_links(of, 2.0)) == {("links", 0, "c"): 2.0 * of.links[0].c}
    assert differences(of, replace(of, t_end=1.0)) == {}
    assert differences(of, with_links(of, 0.0)) is None
    assert differences(belted(of, 0.1), belted(of, 0.2)) == {("frictions", 0, "belt"): 0.2}
    assert differences(belted(of, 0.1), belted(of, -0.1)) is None
    several = load_case("gallery/stack-of-blocks").scene()
    assert len(several.frictions) > 1 and differences(belted(several, 0.1), belted(several, 0.2)) is None


def belted(scene, speed):
    """The scene with frictions on belts of a speed [m/s]."""
    return replace(scene, frictions=tuple(replace(one, belt=speed) for one in scene.frictions))


@pytest.mark.parametrize("name", ["gallery/belt-oscillator", "gallery/block-on-belt"])
def test_scenes_over_the_speed_of_a_belt_share_one_run(name):
    """Through sticks and slips, with the bits of runs of their own."""
    plain = {"law": "coulomb", "mu": "0.8", "static": "1.25"}
    of = load_case(name, {f"friction.belt.{key}": value for key, value in plain.items()}).scene()
    speed = of.frictions[0].belt
    shared = Carrier(of)
    for factor in (0.8, 1.3, 0.5):
        other = belted(of, factor * speed)
        for v in (0.0, 0.9 * factor * speed, factor * speed):
            taking_turns, alone = (
                carrier.carry([0.1, v], 20.0) for carrier in (shared.of(other), Carrier(other))
            )
            assert np.array_equal(taking_turns.state, alone.state)
            assert np.array_equal(taking_turns.table, alone.table)
            assert np.array_equal(taking_turns.vectors, alone.vectors)
    assert len(alone.table) > 0


# Runs that share what is known of their modes are the runs that do not.


def changed_speed(scene):
    return replace(
        scene, motor=replace(scene.motor, Omega0=1.01 * scene.motor.Omega0, m3=1.02 * scene.motor.m3)
    )


def changed_start(scene):
    return replace(scene, bodies=tuple(replace(body, x=body.x + 1e-3) for body in scene.bodies), t_end=7.0)


@pytest.fixture
def no_tables(monkeypatch):
    monkeypatch.setattr(tables, "_tables", type(tables._tables)())


@pytest.mark.parametrize(
    ("name", "change"), (("II-B", changed_speed), ("II-B", changed_start), ("I-A", changed_start))
)
def test_a_run_is_the_same_whatever_ran_before(no_tables, name, change):
    scene = replace(load_case(name).scene(), t_end=8.0)
    alone = run(change(scene), ledger=True)
    tables._tables.clear()
    run(scene, ledger=True, momentum=True)
    after = run(change(scene), ledger=True)
    assert len(tables._tables) == 1
    assert runs.differences(after, alone) == []


def test_the_tape_of_a_mode_is_the_same_whatever_modes_were_made_before(no_tables, monkeypatch):
    modes = 0
    for seed in range(8):
        scene = replace(formula_scene(seed), t_end=0.2)
        with suppress(EngineError):
            runs.run(scene, most=20)
        made = list(tables.mode_table(scene).maker.by_status.values())
        for most in (formula_rows.MOST_OPERATIONS, 0):  # operations that are kept from mode to mode
            backwards = tables.ModeTable(scene).maker
            with monkeypatch.context() as patched:
                patched.setattr(formula_rows, "MOST_OPERATIONS", most)
                again = [backwards.rows(rows.status) for rows in reversed(made)]
            assert [one.tape for one in reversed(again)] == [one.tape for one in made]
            assert [[event.terms for event in one.events] for one in reversed(again)] == [
                [event.terms for event in one.events] for one in made
            ]
        modes += len(made)
    assert modes > 20


def test_scenes_of_other_modes_share_nothing(no_tables):
    scene = replace(load_case("I-A").scene(), t_end=0.1)
    softer = replace(scene, stops=(replace(scene.stops[0], k=1.0),))
    louder = replace(scene, forces=(replace(scene.forces[0], constant=1e-3),))
    opposite = replace(scene, frictions=(replace(scene.frictions[0], belt=-0.0),))
    for one in (scene, softer, louder, opposite):
        run(one)
    assert len(tables._tables) == 4


def test_few_tables_are_kept(no_tables):
    scene = replace(load_case("I-A").scene(), t_end=0.1)
    for k in range(tables.SCENES + 5):
        run(replace(scene, stops=(replace(scene.stops[0], k=1.0 + k),)))
    assert len(tables._tables) == tables.SCENES
