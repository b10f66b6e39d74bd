"""Runs that share what is known of their modes are the runs that do not."""

from dataclasses import replace

import pytest

from tests.engine.runs import differences, run
from vibsim.cases import load_case
from vibsim.engine.modes import mode_table as tables


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
    assert differences(after, alone) == []


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
