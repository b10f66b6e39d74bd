"""Hypothesis for the whole suite: the same draws in every run of a test, whatever the order and the tests
beside it, and no deadlines. Ctrl-C as on a terminal.

VIBSIM_HYPOTHESIS=search draws afresh, for hunting.
"""

import gc
import os
import signal
import sys

import pytest
from hypothesis import HealthCheck, settings

COMMON = {"deadline": None, "database": None, "suppress_health_check": [HealthCheck.too_slow]}

settings.register_profile("repeatable", derandomize=True, **COMMON)
settings.register_profile("search", **COMMON)
settings.load_profile(os.environ.get("VIBSIM_HYPOTHESIS", "repeatable"))
# Later versions also draw numbers that stand in the modules of vibsim that happen to be loaded.
providers = sys.modules.get("hypothesis.internal.conjecture.providers")
if hasattr(providers, "_get_local_constants"):
    providers._get_local_constants = lambda: providers._local_constants  # none
# Workers and commands begin with memory that holds something: numbers that C reads and never computed show.
os.environ.setdefault("MALLOC_PERTURB_", "170")

# A shell starts what runs in the background deaf to Ctrl-C, and children inherit that; tests send it.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture
def here(tmp_path, monkeypatch):
    """An empty folder that is the present one."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """A file's tests run in one process: what they share is computed once."""
    from xdist.scheduler import LoadFileScheduling

    config.option.loadscopereorder = False  # those of many seconds and few tests would come last
    return LoadFileScheduling(config, log)


@pytest.hookimpl(wrapper=True)
def pytest_collection():
    """No search for garbage while tests are collected (a third of it), nor later among what is there."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.enable()
        gc.freeze()
