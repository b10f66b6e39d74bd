"""Small fits for the tests: short runs of a motor, and the closed form of its run-up without vibration."""

from math import log

import numpy as np

from vibsim.cases import load_case
from vibsim.fitting.fit_result import run_fit
from vibsim.fitting.plan import Search, make_plan

LIGHT = {"excitation.m3": "1e-9 kg", "run.t_end": "30 s", "run.every": "20 ms"}  # next to no vibration


def light_motor(**changes):
    """II-B with so light an unbalance that the motor runs up by itself."""
    return load_case("II-B", {**LIGHT, **{key.replace("__", "."): value for key, value in changes.items()}})


def run_up(hertz, J=0.001, M0=0.005, no_load=5.5):
    """When a free motor reaches a speed [s]: T ln(W/(W - w)), T = 2 pi W J/M0, in cycles."""
    return 2 * np.pi * no_load * J / M0 * log(no_load / (no_load - hertz))


def plan_of(cases, free=None, statements=(), readings=(), leave=None, ensemble=0, spread=None, **search):
    """A plan; a quick search unless told otherwise."""
    settings = Search(**{"candidates": 16, "confirm": 2, "fresh": 4, **search})
    return make_plan(
        list(cases), free or {}, statements, readings, leave or {}, ensemble, spread or {}, settings
    )


def small_plan(**search):
    """Two free parameters of a free motor, three starts."""
    return plan_of(
        [light_motor(run__t_end="12 s")],
        {"J": "0.2:5 g m^2", "M0": "2:10 mN m"},
        ["passes 3 Hz between 4 and 6 s", "final speed at most 5 Hz", "impacts at most 0"],
        ["J=0.002 kg m^2"],
        ensemble=3,
        **search,
    )


def done(plan, out=None, jobs=2, **options):
    """The whole fit."""
    found, complete = run_fit(plan, out, jobs, **options)
    assert complete
    return found


def numbers_of(fit):
    """Everything that two fits must have in common, bit for bit."""
    runs = {
        index: (point.status, point.sha256, point.error, _without_time(point.values))
        for index, point in sorted(fit.runs.items())  # which come in the order in which they end
    }
    made = [(one.number, one.origin, one.changes, one.leaving) for one in fit.candidates]
    ranking = [(each.candidate.number, each.price, each.starts) for each in fit.ranking]
    return runs, made, ranking


def _without_time(values):
    return {name: repr(value) for name, value in values.items() if name != "wall_time"}
