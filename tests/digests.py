"""Digests of what orbits, branches, loci, fits, sweeps and verdicts come to, a line each.

`python -m tests.digests` prints them: every machine, every BLAS and every vector unit must print the same.
`python -m tests.digests units` prints the vector units that numpy chooses code for on this machine: what
NPY_DISABLE_CPU_FEATURES may name. `python -m tests.digests quick` leaves out
what takes longer than half a second.
"""

import hashlib
import sys

import numpy as np

import vibsim
from tests.fitting.made import done, light_motor, numbers_of, plan_of

BALL = {"stops.table.e": "0", "base.phase": "200 deg", "base.a": "1.5 mm"}
LOSSLESS = {"excitation": "none", "coupling.c": "0", "friction": "none", "x1": "1.2 mm"}
WHOLE = {"t_end": "60 s"}
FREE = """
bodies: {a: 1 kg, b: 2 kg, c: 0.5 kg, d: 1.5 kg}
links:
  ab: {between: [a, b], k: 100 N/m, c: 0.2 N s/m}
  bc: {between: [b, c], k: 70 N/m}
  cd: {between: [c, d], k: 120 N/m, c: 0.1 N s/m}
  d0: {between: [d, ground], k: 90 N/m, c: 0.3 N s/m}
stops: {wall: {between: [a, ground], gap: 5 mm, acts: extension, k: 1 kN/m}}
forces: {drive: {on: d, A: 2 N, omega: 1.1 Hz}}
initial: {a: {x: 1 mm}}
run: {t_end: 40 s, every: 10 ms}
"""


def chain():
    """Four bodies, one stop."""
    from vibsim.cases.case import load_case_text

    return load_case_text(FREE, name="chain")


def points_of(curve):
    """Points of a branch or a locus, and its special points."""
    return curve.points, getattr(curve, "specials", ()), curve.ends


def branch(case, key, span, overrides=None, **how):
    """Points of a branch from an orbit that the case settles to."""
    start = vibsim.orbit(case, overrides) if how.pop("settled", True) else vibsim.load_case(case, overrides)
    return points_of(vibsim.continue_branch(start, key, span, **how))


def doubling():
    """A doubling in two parameters, and the branch that leaves it."""
    start = vibsim.orbit("I-C", {"omega": "4.2 Hz", "c": "0.001 N s/m"}, period=1)
    along = vibsim.continue_branch(start, "omega", "4:4.3 Hz")
    locus = vibsim.continue_locus(along, {"c": "0.001:0.0012 N s/m"}, label="PD1", max_points=6)
    left = vibsim.continue_branch(along, switch="PD1", max_points=8)
    return points_of(along), points_of(locus), points_of(left)


def orbit(case, overrides=None, **how):
    """Start, multipliers and their neighbours of an orbit."""
    at = vibsim.orbit(case, overrides, **how)
    return at.X.tolist(), at.period, at.multipliers.tolist()


def monodromy():
    at = vibsim.monodromy(
        "II-B", state={"x1": 0.001, "phidot": 30.0}, T=0.4, parameters=("c", "excitation.Omega0")
    )
    return at.matrix.tolist(), {key: row.tolist() for key, row in at.by_parameter.items()}, at.lines()


def fitted():
    statements = ["passes 3 Hz between 4 and 6 s", "impacts at most 0"]
    free = {"J": "0.2:5 g m^2", "M0": "2:10 mN m"}
    plan = plan_of([light_motor(run__t_end="6 s")], free, statements, candidates=4, fresh=1)
    return numbers_of(done(plan, jobs=1))


def columns(table):
    """Every column that can be reproduced."""
    names = sorted(name for name in table if name != "wall_time")
    return [(name, np.asarray(table[name]).tolist()) for name in names]


def every_quantity(name, **axis):
    """All that a sweep can compute of a point."""
    case = vibsim.load_case(name, {"run.t_end": "60 s"})
    return columns(vibsim.sweep(case, axis, compute="all", jobs=2))


def long_point():
    """A BLAS shares out products of more than 10,000 numbers."""
    return columns(vibsim.sweep("II-B", {"Omega0": "6 Hz"}, overrides={"t_end": "4000 s"}, jobs=1))


def runs():
    """Samples and events of runs of every kind of source."""
    names = ("I-C", "II-B", "gallery/impact-oscillator", "gallery/belt-oscillator")
    results = [vibsim.simulate(name, overrides={"t_end": "20"}) for name in names]
    return [(columns(result), columns(result.events), result.attrs["events"]) for result in results]


def with_horizon():
    """A run with its trust horizon."""
    run = vibsim.simulate("II-B", overrides={"t_end": "30 s"})
    return columns(run), run.trust_horizon, run.attrs["error_estimate_max"]


CASES = {
    "orbit of the machine": lambda: orbit("II-B", {"c": "0.03", "excitation.Omega0": "5 Hz"}),
    "orbit of a chain": lambda: orbit(chain()),
    "branch of the machine": lambda: branch(
        "II-B", "Omega0", "4.6:5.4 Hz", {"c": "0.03", "excitation.Omega0": "5 Hz"}, max_points=12
    ),
    "branch of a chain": lambda: branch(chain(), "drive.omega", "1:1.2 Hz", max_points=8),
    "branch of a ball that rests": lambda: branch(
        "gallery/ball-on-shaken-table", "base.a", "0.95:1.5 mm", BALL
    ),
    "branch with slips": lambda: branch(
        "gallery/two-masses-with-friction", "drive.A", "0.9545:0.956 N", {"drive.A": "0.956 N"}, settled=False
    ),
    "branch of chatter": lambda: branch(
        "gallery/drifting-oscillator", "drive.F0", "4.34:4.45 N", {"drive.F0": "4.35 N"}
    ),
    "branch without loss": lambda: points_of(
        vibsim.continue_branch(vibsim.load_case("I-A", LOSSLESS), energy="0.08:0.2 mJ", max_points=10)
    ),
    "doubling in two parameters": doubling,
    "monodromy": monodromy,
    "sweep of the machine": lambda: every_quantity("II-B", Omega0="6 Hz"),
    "sweep of a force": lambda: every_quantity("I-C-eq211", omega="6.5 Hz"),
    "sweep over a long time": long_point,
    "fit": fitted,
    "verdicts on the machine": lambda: vars(vibsim.analyse(vibsim.load_case("II-B", WHOLE))),
    "runs": runs,
    "run with its trust horizon": with_horizon,
    "verdicts on a chain": lambda: vars(vibsim.analyse(chain())),
}


LONG = {
    "branch of a ball that rests",
    "branch with slips",
    "branch of chatter",
    "fit",
    "sweep over a long time",
}


def digest(value):
    """Of numbers within records, written so that each double has its own text."""
    return hashlib.sha256(repr(value).encode()).hexdigest()


def vector_units():
    """Vector units beyond those that numpy needs, for which it has code of their own."""
    try:
        from numpy._core import _multiarray_umath as core
    except ImportError:  # before numpy 2
        from numpy.core import _multiarray_umath as core
    return [unit for unit in core.__cpu_dispatch__ if core.__cpu_features__.get(unit)]


if __name__ == "__main__" and sys.argv[1:] == ["units"]:
    print(*vector_units())
elif __name__ == "__main__":
    np.set_printoptions(floatmode="unique", threshold=2**31)
    for name, made in CASES.items():
        if name in LONG and sys.argv[1:] == ["quick"]:
            continue
        print(f"{name}: {digest(made())}", flush=True)
