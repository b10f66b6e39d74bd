"""What tells whether two installations compute the same bits: versions, engine, bits of two short runs.

Versions alone do not: a compiler may fuse products and sums.
"""

import hashlib
import json
from functools import cache

from vibsim import __version__
from vibsim.analysis.discard import HALF
from vibsim.cases import load_case
from vibsim.engine.choice import engine_name
from vibsim.sweeps.computations.registry import fitting
from vibsim.sweeps.plan.recipe import Recipe
from vibsim.sweeps.plan.sweep_plan import STATISTICS
from vibsim.sweeps.points.point import compute_point
from vibsim.sweeps.statistics.columns import NOT_REPRODUCIBLE
from vibsim.sweeps.statistics.quantities import quantities_of

RUNS = ("II-B", "I-B")  # one by Taylor series, one by the closed form
LENGTH = "2 s"  # with impacts, in a few milliseconds


@cache
def signature(engine: str, compute: tuple[str, ...]) -> dict[str, str]:
    """What must be equal here and there, name -> text, for sweeps with these computations.

    Raises RuntimeError where the engine is not there.
    """
    return {
        "vibsim": __version__,
        "statistics": str(STATISTICS),
        "engine": engine_name(engine),
        "bits": hashlib.sha256("".join(_bits(name, engine, compute) for name in RUNS).encode()).hexdigest()[
            :16
        ],
    }


def _bits(name: str, engine: str, compute: tuple[str, ...]) -> str:
    """All numbers of a short run of a shipped case."""
    case = load_case(name, {"run.t_end": LENGTH})
    recipe = Recipe(case, False, HALF, 10, None, fitting(compute, quantities_of(case)))
    point = compute_point(recipe, (), {}, None, engine)
    assert point is not None  # nobody gave it up
    values = {key: value for key, value in point.values.items() if key not in NOT_REPRODUCIBLE}
    arrays = {name: array.tolist() for name, array in point.arrays.items()}
    return json.dumps([point.error, sorted(values.items()), sorted(arrays.items())])
