"""Random scenes with formulas: events and states as a second solver has them, with equations of its own."""

import os
from dataclasses import replace

import pytest

from tests.formulas import against_second_solver
from tests.formulas.against_second_solver import compared
from tests.formulas.drawn_models import Drawn

FEW = range(1000, 1005)
MANY = range(2000, 2000 + int(os.environ.get("VIBSIM_SCENES", "400")))


def agreement(seed):
    result = compared(seed)
    assert not result.disagreements, "\n".join([result.case, *result.disagreements[:6]])
    return result


@pytest.mark.parametrize("seed", FEW)
def test_a_scene_with_formulas(seed):
    agreement(seed)


def test_no_stick_follows_a_release_at_once():
    """A damper has its kink where the friction beside it lets go: the sliding velocity is zero at both."""
    agreement(1187)


@pytest.mark.slow
@pytest.mark.timeout(7200)
def test_many_scenes_with_formulas():
    results = [agreement(seed) for seed in MANY]
    followed = [result for result in results if not result.skipped]
    assert len(followed) > 0.95 * len(results)
    assert sum(result.events for result in followed) > 5 * len(followed)


def test_a_force_that_is_off_by_a_millionth_is_noticed(monkeypatch):
    """The comparison can fail."""

    class Heavier(Drawn):
        def __init__(self, seed):
            super().__init__(seed)
            bodies = {name: (m * (1 + 1e-6), x, v) for name, (m, x, v) in self.model.bodies.items()}
            self.model = replace(self.model, bodies=bodies)

    monkeypatch.setattr(against_second_solver, "Drawn", Heavier)
    assert sum(bool(compared(seed).disagreements) for seed in FEW[:3]) >= 2
