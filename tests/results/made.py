"""Trajectories for the tests of results: short runs of shipped cases."""

from functools import cache

import vibsim


@cache
def short_case(name="I-A", t_end="5 s", **changes):
    """A shipped case, cut short; further values as excitation__Omega0="6.5 Hz"."""
    values = {key.replace("__", "."): value for key, value in changes.items()}
    return vibsim.load_case(name, {"run.t_end": t_end, **values})


@cache
def short_run(name="I-A", t_end="5 s", **changes):
    """The trajectory of `short_case`, in memory."""
    return vibsim.simulate(short_case(name, t_end, **changes))
