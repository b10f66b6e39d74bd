"""No number of a result comes from arithmetic of numpy that differs between machines.

Products of matrices go to a BLAS, sums follow numpy's release, and sines, logarithms and the like use
whatever vector unit there is. What ends in a result takes `vibsim.physics.sums`, `vibsim.physics.sines` and
`math`.
"""

import ast
from pathlib import Path

import vibsim

PACKAGE = Path(vibsim.__file__).parent
RESULTS = ("physics", "flows", "events", "kernel", "files", "results", "analysis", "sweeps", "fitting")
RESULTS += ("orbits", "evidence/reports")
ELEMENTARY = {"sin", "cos", "tan", "arcsin", "arccos", "arctan", "arctan2", "sinh", "cosh", "tanh", "hypot"}
ELEMENTARY |= {"exp", "exp2", "expm1", "log", "log2", "log10", "log1p", "power", "cbrt", "float_power"}
SUMS = {"sum", "nansum", "mean", "nanmean", "average", "std", "var", "nanstd", "nanvar", "prod", "trapezoid"}
PRODUCTS = {"dot", "vdot", "inner", "outer", "einsum", "matmul", "tensordot", "convolve", "correlate"}
PRODUCTS |= {"polyfit", "lstsq", "norm", "solve", "corrcoef", "cov"}
WHOLE_NUMBERS = {  # sums and products of whole numbers are exact in any order
    "files/chunk_encoding.py": {"sum", "@"},
    "sweeps/plan/capacity.py": {"prod"},
    "sweeps/ensemble.py": {"sum"},
}
ROOTS = {  # steps to a fixed point, and eigenvalues there: right to rounding, whose bits may differ
    "orbits/coordinates.py": {"@"},
    "orbits/multipliers.py": {"norm"},
    "orbits/newton.py": {"@", "solve", "lstsq"},
    "orbits/return_map.py": {"outer"},
}


def uses(tree):
    """Names of the operations in a module that the order of arithmetic matters to."""
    for node in ast.walk(tree):
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.MatMult):
            yield "@"
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
            name, owner = node.func.attr, ast.unparse(node.func.value)
            of_numpy = owner in ("np", "numpy", "np.linalg", "np.add")
            if (of_numpy and name in ELEMENTARY) or (name in PRODUCTS and owner != "np.subtract"):
                yield name
            if name in SUMS and owner != "math":
                yield name


def test_results_take_no_arithmetic_that_differs_between_machines():
    modules = [path for room in RESULTS for path in sorted((PACKAGE / room).rglob("*.py"))]
    assert len(modules) > 100
    found = {}
    for path in modules:
        name = path.relative_to(PACKAGE).as_posix()
        allowed = (WHOLE_NUMBERS | ROOTS).get(name, set())
        odd = set(uses(ast.parse(path.read_text(encoding="utf-8")))) - allowed
        if odd:
            found[name] = odd
    assert found == {}


def test_the_check_sees_what_it_is_for():
    text = "float(t @ t); np.sin(x); points.mean(); np.linalg.norm(x); np.add(a, b); math.sin(1.0); x.max()"
    assert sorted(uses(ast.parse(text))) == ["@", "mean", "norm", "sin"]
