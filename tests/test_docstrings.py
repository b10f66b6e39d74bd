"""The examples in docstrings of public names run and print what they show."""

import doctest
import sys
from importlib import import_module

import pytest

MODULES = [
    "vibsim.analysis.cycles",
    "vibsim.cases.case",
    "vibsim.cases.case",
    "vibsim.results.labelled",
    "vibsim.plots.picture",
    "vibsim.results.result",
    "vibsim.results.result",
    "vibsim.results.simulation",
    "vibsim.sweeps.sweep_result",
    "vibsim.sweeps.sweeping",
]


@pytest.mark.parametrize("name", MODULES)
def test_the_examples_run(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "agg")
    done = doctest.testmod(import_module(name), optionflags=doctest.NORMALIZE_WHITESPACE | doctest.ELLIPSIS)
    assert done.attempted > 0 and done.failed == 0
    if "matplotlib.pyplot" in sys.modules:
        sys.modules["matplotlib.pyplot"].close("all")
