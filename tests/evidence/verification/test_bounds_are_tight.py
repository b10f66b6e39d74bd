"""Bounds are no wider than they must be: every hard case notices a mass that is wrong by 1e-13 of itself."""

from dataclasses import replace

import pytest

import vibsim.engine.trajectory
from vibsim.evidence.verification import runs, verify
from vibsim.evidence.verification.catalogue import all_checks
from vibsim.results import recording

WRONG = 1 + 1e-13
JUDGED = ("V1/I-", "V2/", "V3/", "V4/", "V5/", "hard/")


@pytest.mark.parametrize("name", [check.name for check in all_checks() if check.name.startswith(JUDGED)])
def test_a_wrong_mass_is_noticed(name, monkeypatch):
    right = vibsim.engine.trajectory.open_trajectory

    def heavier(scene, *given, **options):
        first, *others = scene.bodies
        return right(replace(scene, bodies=(replace(first, m=first.m * WRONG), *others)), *given, **options)

    monkeypatch.setattr(recording, "open_trajectory", heavier)
    monkeypatch.setattr(runs, "open_trajectory", heavier)
    assert not all(row.passed for row in verify([name], "c"))
