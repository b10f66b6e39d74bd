"""Imports point down: command line, plots, reports; cases <- results <- analysis <- sweeps ...; numbers."""

import ast
import sys
from pathlib import Path

import pytest

import vibsim

PACKAGE = Path(vibsim.__file__).parent
GROUND = {"physics", "flows", "events", "kernel", "engine"}
# each may import those before it
MIDDLE = ["cases", "results", "analysis", "sweeps", "fitting", "peers", "verification", "benchmark"]
TOP = {"command_line", "plots", "reports"}
LIGHT = {"numpy"}  # what the ground floor may import besides the standard library
OPTIONAL = {"multiprecision.py": {"flint"}, "big_floats.py": {"mpmath"}}  # and who is there for it

MODULES = sorted(PACKAGE.rglob("*.py"))


def allowed(room):
    """Rooms of vibsim that modules of `room` may import."""
    if room in GROUND:
        return GROUND
    if room in MIDDLE:
        return GROUND | set(MIDDLE[: MIDDLE.index(room) + 1])
    return GROUND | set(MIDDLE) | TOP


def imports(path):
    """Full names of everything that a module imports, anywhere in it, except for type checking only."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    for_types = {
        child
        for node in ast.walk(tree)
        if isinstance(node, ast.If) and ast.unparse(node.test).endswith("TYPE_CHECKING")
        for statement in node.body
        for child in ast.walk(statement)
    }
    for node in ast.walk(tree):
        if node in for_types:
            continue
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def misplaced(path, room):
    """The imports of a module of `room` that point up or sideways, or that its floor may not have."""
    for name in imports(path):
        first, *rest = name.split(".")
        if first == "vibsim":
            if rest[0] not in allowed(room) and rest != ["__version__"]:
                yield name
        elif room in GROUND and first not in sys.stdlib_module_names | LIGHT | OPTIONAL.get(path.name, set()):
            yield name


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_imports_point_down(path):
    room = path.relative_to(PACKAGE).parts[0]
    assert list(misplaced(path, room)) == []


def test_every_room_has_its_floor():
    rooms = {path.relative_to(PACKAGE).parts[0] for path in MODULES if path.parent != PACKAGE}
    assert rooms <= GROUND | set(MIDDLE) | TOP


@pytest.mark.parametrize(
    ("room", "line"),
    [
        ("physics", "import scipy"),
        ("kernel", "def f():\n    from vibsim.cases import Case"),
        ("cases", "from vibsim.results import Result"),
        ("results", "from vibsim import sweeps"),
        ("results", "import vibsim.plots.style"),
        ("analysis", "from vibsim.sweeps.axis import Axis"),
        ("results", "import vibsim.command_line"),
        ("results", "from vibsim import load_case"),
    ],
)
def test_what_is_misplaced_is_found(tmp_path, room, line):
    (tmp_path / "module.py").write_text(line)
    assert len(list(misplaced(tmp_path / "module.py", room))) == 1
