"""Hypothesis for the whole suite: the same draws in every run of the same tests (it also draws numbers that
stand in the modules loaded so far, so other tests beside them change them), no deadlines. Ctrl-C as on a
terminal.

VIBSIM_HYPOTHESIS=search draws afresh, for hunting.
"""

import os
import signal

from hypothesis import HealthCheck, settings

COMMON = {"deadline": None, "database": None, "suppress_health_check": [HealthCheck.too_slow]}

settings.register_profile("repeatable", derandomize=True, **COMMON)
settings.register_profile("search", **COMMON)
settings.load_profile(os.environ.get("VIBSIM_HYPOTHESIS", "repeatable"))

# A shell starts what runs in the background deaf to Ctrl-C, and children inherit that; tests send it.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    # a suite started in the background inherits this, and its children would never hear Ctrl-C
    signal.signal(signal.SIGINT, signal.default_int_handler)
