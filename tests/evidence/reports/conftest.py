"""Short real runs of the paper's cases."""

import pytest

from vibsim.cases import load_case
from vibsim.evidence.reports.measurements import PAPER_RUNS
from vibsim.plots import style
from vibsim.plots.subject import Subject
from vibsim.results import simulate


@pytest.fixture(scope="session")
def short_runs():
    """The first 12 s of every case, by name."""
    return {name: simulate(load_case(name, {"run.t_end": "12 s"}), trust=True) for name in PAPER_RUNS}


@pytest.fixture(scope="session")
def subjects(short_runs):
    """The same as subjects of pictures."""
    return {name: Subject(name, name, "trajectory", run.case, run) for name, run in short_runs.items()}


@pytest.fixture
def house_style():
    """Figures are drawn under the settings of the plots."""
    with style.applied():
        yield
