"""Truth runs for the tests: end states of shipped cases, to many digits."""

from decimal import Decimal
from functools import cache

import vibsim
from vibsim.engine.truth import open_truth

SPARSE = "50 s"  # samples cost as much as events; where only the end counts there need not be any


def case(name, t_end, method="auto", every=SPARSE, **changes):
    """A shipped case, cut short; further values as excitation__A="0.1 N"."""
    values = {key.replace("__", "."): value for key, value in changes.items()}
    return vibsim.load_case(name, {"run.t_end": t_end, "run.every": every, "run.method": method, **values})


@cache
def true_end(name, t_end, digits, method="auto"):
    """Totals of a run, and its end state by name, as Decimals of all its digits."""
    trajectory = open_truth(case(name, t_end, method).exact_scene, digits)
    for block in trajectory.blocks():
        last = block.event_digits
    return trajectory.totals, {name: Decimal(texts[-1].decode()) for name, texts in last.items()}
