"""No number of a result comes from arithmetic of numpy that differs between machines.

Products of matrices go to a BLAS, sums follow numpy's release, and sines, logarithms and the like use
whatever vector unit there is; those of the C library, which `math` offers too, differ in last bits between
libraries and between processors with and without fused products. What ends in a result takes
`vibsim.physics.elementary`, and matrices of `vibsim.orbits.stability`.
"""

import ast
import os
import platform
import re
import subprocess
import sys
from pathlib import Path

import pytest

import vibsim
from tests.digests import vector_units

PACKAGE = Path(vibsim.__file__).parent
RESULTS = ("physics", "engine", "results", "analysis", "sweeps", "fitting")
RESULTS += ("orbits", "evidence/reports")
ELEMENTARY = {"sin", "cos", "tan", "arcsin", "arccos", "arctan", "arctan2", "sinh", "cosh", "tanh", "hypot"}
ELEMENTARY |= {"exp", "exp2", "expm1", "log", "log2", "log10", "log1p", "power", "cbrt", "float_power"}
LIBRARY = ELEMENTARY - {"hypot"} | {"asin", "acos", "atan", "atan2", "pow"}  # Python has a hypot of its own
SUMS = {"sum", "nansum", "mean", "nanmean", "average", "std", "var", "nanstd", "nanvar", "prod", "trapezoid"}
PRODUCTS = {"dot", "vdot", "inner", "outer", "einsum", "matmul", "tensordot", "convolve", "correlate"}
PRODUCTS |= {"polyfit", "lstsq", "norm", "solve", "corrcoef", "cov"}
WATCHED = ELEMENTARY | LIBRARY | SUMS | PRODUCTS
WHOLE_NUMBERS = {  # sums and products of whole numbers are exact in any order
    "results/hdf5_writing.py": {"sum", "@"},
    "sweeps/sweep_plan.py": {"prod"},
    "engine/tangent/monodromy.py": {"sum"},  # whether all are finite
    "sweeps/points.py": {"sum"},
    "orbits/branches/branch.py": {"sum"},
}
ROUNDED = {  # what becomes whole digits; products one by one; the functions of that name of our own
    "orbits/stability.py": {"dot"},
    "orbits/orbit_digits.py": {"log10"},
    "orbits/return_map.py": {"outer"},
}
LIBRARIES = {  # libraries whose arithmetic a result takes, each with the reason why it may
    "analysis/comparison.py": {"scipy.special"},  # stdtrit: half widths, 2e-11 apart between releases
    "analysis/analysis.py": {"scipy.fft", "scipy.signal"},  # one code for all processors; a search
    "analysis/sections.py": {"numpy.fft"},  # the same; correlations to 1e-3
    "orbits/branches/family.py": {"numpy.polynomial"},  # sums and products in the order of its code
    "fitting/plan.py": {"scipy"},  # its version, which a file names
    "fitting/search.py": {"scipy.optimize", "scipy.stats"},  # draws candidates, under the version in the file
    "results/result.py": {"scipy.io"},  # writes what there is
}
ARITHMETIC = ("linalg", "fft", "polynomial")  # of numpy


def nodes_of(text):
    """All nodes of a module."""
    return list(ast.walk(ast.parse(text)))


def uses(nodes):
    """Names of the operations in a module that the order of arithmetic matters to."""
    imports = [node for node in nodes if isinstance(node, ast.ImportFrom) and node.module == "math"]
    of_library = {alias.name for node in imports for alias in node.names} & LIBRARY
    for node in nodes:
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.MatMult):
            yield "@"
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr in WATCHED:
            name, owner = node.func.attr, ast.unparse(node.func.value)
            of_numpy = owner in ("np", "numpy", "np.linalg", "np.add")
            if (of_numpy and name in ELEMENTARY) or (name in PRODUCTS and owner != "np.subtract"):
                yield name
            if name in SUMS and owner != "math":
                yield name
            if owner == "math" and name in LIBRARY:
                yield name
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in of_library:
            yield from [node.func.id] * any(not isinstance(argument, ast.Constant) for argument in node.args)


def is_numpy(node):
    return isinstance(node, ast.Name) and node.id in ("np", "numpy")


def libraries(nodes):
    """Modules of numpy with arithmetic of a library, and of scipy, that a module uses."""
    for node in nodes:
        if isinstance(node, ast.Attribute) and node.attr in ARITHMETIC and is_numpy(node.value):
            yield f"numpy.{node.attr}"
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name.partition(".")[0] == "scipy")
        if isinstance(node, ast.ImportFrom):
            first, _, inner = (node.module or "").partition(".")
            if first == "scipy" or (first == "numpy" and inner in ARITHMETIC):
                yield node.module


def test_results_take_no_arithmetic_that_differs_between_machines():
    modules = [path for room in RESULTS for path in sorted((PACKAGE / room).rglob("*.py"))]
    modules.remove(PACKAGE / "physics/elementary.py")
    assert len(modules) > 100
    found = {}
    for path in modules:
        name = path.relative_to(PACKAGE).as_posix()
        allowed = (WHOLE_NUMBERS | ROUNDED).get(name, set()) | LIBRARIES.get(name, set())
        nodes = nodes_of(path.read_text(encoding="utf-8"))
        odd = {*uses(nodes), *libraries(nodes)} ^ allowed  # what is allowed is there, too
        if odd:
            found[name] = odd
    assert found == {}


def test_the_check_sees_what_it_is_for():
    text = "from math import log, pi; log(x); log(2); math.sin(1.0); math.hypot(x, y); "
    text += "float(t @ t); np.sin(x); points.mean(); np.linalg.norm(x); np.add(a, b); x.max()"
    assert sorted(uses(nodes_of(text))) == ["@", "log", "mean", "norm", "sin", "sin"]
    text = (
        "import scipy.linalg; from scipy.linalg import lapack; np.linalg.svd(x); from numpy.fft import rfft"
    )
    assert sorted(libraries(nodes_of(text))) == ["numpy.fft", "numpy.linalg", "scipy.linalg", "scipy.linalg"]


def test_the_engine_in_c_takes_no_functions_of_the_c_library_that_differ_between_machines():
    calls = re.compile(r"(?<![\w.>])(" + "|".join(sorted(ELEMENTARY | LIBRARY | {"fma"})) + r")f?\(")
    sources = [path for kind in ("*.c", "*.h") for path in (PACKAGE / "engine").rglob(kind)]
    assert len(sources) > 30
    programs = {
        path.name: re.sub(r'/\*.*?\*/|"[^"\n]*"', "", path.read_text(encoding="utf-8"), flags=re.S)
        for path in sources
    }
    assert [name for name, program in programs.items() if calls.search(program)] == []


SETS_OF_NUMBERS = {  # whose order is the same in every process
    "engine/events/impacts/rigid_stops.py",
    "engine/flows/accelerations.py",
    "engine/flows/closed/modal_maker.py",
    "engine/modes/ties.py",
    "plots/overview.py",
}


def orders_of_sets(nodes):
    """Lines in which something is done in the order of a set: of texts it differs from process to process."""
    for node in nodes:
        ordered = []
        if isinstance(node, ast.For | ast.comprehension):
            ordered = [node.iter]
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr == "join":
            ordered = node.args
        for one in ordered:
            is_call = (
                isinstance(one, ast.Call)
                and isinstance(one.func, ast.Name)
                and one.func.id in ("set", "frozenset")
            )
            if is_call or isinstance(one, ast.Set | ast.SetComp):
                yield one.lineno


def test_nothing_is_done_in_the_order_of_a_set_of_texts():
    found = {}
    for path in sorted(PACKAGE.rglob("*.py")):
        nodes = nodes_of(path.read_text(encoding="utf-8"))
        if lines := list(orders_of_sets(nodes)):
            found[path.relative_to(PACKAGE).as_posix()] = lines
    assert found.keys() == SETS_OF_NUMBERS, found
    seen = "', '.join({a}); for a in set(b): pass"
    assert len(list(orders_of_sets(nodes_of(seen.replace("; ", "\n"))))) == 2


def digests_of_results(words, **switches):
    """What `tests.digests` prints under switches of the environment."""
    environment = {name: value for name, value in os.environ.items() if name not in SWITCHES} | switches
    program = [sys.executable, "-m", "tests.digests", *words]
    root = PACKAGE.parent
    return subprocess.run(
        program, env=environment, cwd=root, capture_output=True, text=True, check=True
    ).stdout


SWITCHES = ("OPENBLAS_CORETYPE", "OPENBLAS_NUM_THREADS", "NPY_DISABLE_CPU_FEATURES", "GLIBC_TUNABLES")


@pytest.mark.skipif(
    platform.machine() not in ("x86_64", "AMD64"), reason="kernels and vector units of x86-64"
)
@pytest.mark.parametrize(
    ("words", "count"), [(["quick"], 13), pytest.param([], 18, marks=pytest.mark.slow)], ids=("quick", "all")
)
def test_all_results_have_the_same_bits_whatever_the_blas_and_the_vector_units(words, count):
    """Nor without the fused products of the C library. Orbits were right to rounding, which differed, and
    decided which special points a branch has.
    """
    units = " ".join(vector_units())
    off = {"NPY_DISABLE_CPU_FEATURES": units} if units else {}
    if platform.libc_ver()[0] == "glibc":
        off["GLIBC_TUNABLES"] = "glibc.cpu.hwcaps=-FMA,-AVX2,-FMA4"
    plain = digests_of_results(words, OPENBLAS_CORETYPE="Haswell", OPENBLAS_NUM_THREADS="2")
    assert plain.count("\n") == count
    assert digests_of_results(words, OPENBLAS_CORETYPE="Prescott", OPENBLAS_NUM_THREADS="1", **off) == plain
