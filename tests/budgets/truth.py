"""The states that count as true: runs of 40 digits, for the very doubles of the shipped scenes.

python -m tests.budgets.truth prints the table of `true_states.py`. Needs python-flint.
"""

import math
from dataclasses import replace

from vibsim.cases import load_case
from vibsim.engine.truth import open_truth

INSTANTS = {"I-C": (20,), "II-A": (20, 40), "II-B": (20, 50), "II-C": (20, 40)}  # s


def true_states(name, times):
    """{(name, t): state} at `times` [s]."""
    two_blocks = load_case(name).two_blocks()
    of = replace(two_blocks, t_end=float(times[-1]), every_num=math.gcd(*times), every_den=1, method="taylor")
    columns = ("x1", "v1", "x2", "v2", *(("phi", "phidot") if of.source == "motor" else ()))

    def exact(number, pi):
        values = {key: number(value) for key, value in vars(of).items() if isinstance(value, float)}
        if of.source == "harmonic":
            values["omega"] = 2 * pi * (values["cycles"] + values["cycles_lo"])
        return replace(of, **values).as_parts()

    states = {}
    for block in open_truth(exact, 40).blocks():
        rows = zip(*(block.samples[column].tolist() for column in columns), strict=True)
        states |= dict(zip(block.samples["time"].tolist(), rows, strict=True))
    return {(name, t): states[t] for t in times}


if __name__ == "__main__":
    for case, instants in INSTANTS.items():
        for key, values in true_states(case, instants).items():
            print(f"    {key}: {values},", flush=True)
