"""Exceptions come through pickle, as from a process of a pool: one that does not makes the pool wait."""

import importlib
import inspect
import pickle
import pkgutil

import pytest

import vibsim
from vibsim.cases.formula_text import FormulaError
from vibsim.cases.problems import Problem
from vibsim.engine.errors import State
from vibsim.orbits.coordinates import NotConverged

STATE = State(t=0.5, x=[1.0], v=[2.0], phase=0.0, turns=0.0, w=0.0)
RAISED = {
    "EngineError": vibsim.EngineError("crushed", STATE, "left, right"),
    "CaseError": vibsim.CaseError([Problem("file.yaml", 1, 2, "c", "must be positive")]),
    "FormulaError": FormulaError("no name q", 3, 4),
    "NotConverged": NotConverged("no orbit is near", 0.25),
}


def exceptions_of_vibsim():
    """Exceptions that users may meet whose `__init__` is their own."""
    for module in pkgutil.walk_packages(vibsim.__path__, "vibsim."):
        if "command_line" not in module.name and "__main__" not in module.name:
            try:
                names = vars(importlib.import_module(module.name))
            except ModuleNotFoundError as error:  # a peer that there is not for every machine
                assert error.name == "heyoka"
                continue
            for name, each in names.items():
                own = inspect.isclass(each) and each.__module__ == module.name and "__init__" in vars(each)
                if own and issubclass(each, Exception) and not name.startswith("_"):
                    yield name


def test_all_that_need_care_are_tried():
    assert set(exceptions_of_vibsim()) == set(RAISED)


@pytest.mark.parametrize("name", RAISED)
def test_it_comes_through_pickle(name):
    raised = RAISED[name]
    came = pickle.loads(pickle.dumps(raised))
    assert type(came) is type(raised) and str(came) == str(raised)
    assert vars(came).keys() == vars(raised).keys()


@pytest.mark.parametrize("name", [name for name in vibsim.__all__ if name.endswith("Error")])
def test_each_at_the_front_says_how_it_is_met(name):
    assert ">>>" in getattr(vibsim, name).__doc__
