"""Hypothesis for the whole suite: the same draws in every run, no deadlines.

VIBSIM_HYPOTHESIS=search draws afresh, for hunting.
"""

import os

from hypothesis import HealthCheck, settings

COMMON = {"deadline": None, "database": None, "suppress_health_check": [HealthCheck.too_slow]}

settings.register_profile("repeatable", derandomize=True, **COMMON)
settings.register_profile("search", **COMMON)
settings.load_profile(os.environ.get("VIBSIM_HYPOTHESIS", "repeatable"))
