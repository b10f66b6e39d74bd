"""Imports point down, those by name too: command line, plots, reports; ...; results; cases; numbers."""

import ast
import re
import sys
from pathlib import Path

import pytest

import vibsim

PACKAGE = Path(vibsim.__file__).parent
GROUND = ["lazy_names", "once", "physics", "engine"]
# each may import those before it, and the ground floor
MIDDLE = ["cases", "files", "labelled", "results", "orbits", "branches", "analysis"]
MIDDLE += [f"sweeps.{room}" for room in ("statistics", "computations", "plan", "points", "store", "schedule")]
MIDDLE += ["sweeps", "fitting"]
MIDDLE += ["evidence", "evidence.peers", "evidence.verification", "evidence.benchmark", "opening"]
TOP = {"command_line", "plots", "evidence.reports"}
FRONT = {"__init__", "__main__"}  # modules of the package itself: above all rooms
DATA = "shipped_cases"  # a package without modules
# What the evidence may use of the engine: ways of running it, and what a state is. How a mode is made and
# moved is not for it: its independence is its worth.
OF_ENGINE = {"choice", "columns", "driver", "errors", "state"}
OF_ENGINE |= {"flows.flow", "tangent.error_growth", "tangent.tangent_space"}
OF_ENGINE |= {"trajectory", "truth", "_engine"}  # the last by name, to ask whether it is there
# rooms within others -> rooms beside them that they may not import: what serves all pictures and all commands
# knows none of them, and a run is recorded by way of what stands below
WITHIN = {
    "engine.events.roots": {"impacts"},
    "engine.flows.closed": {"series"},
    "engine.flows.series": {"closed"},
    "engine.tangent.flows": {"events", "bundle"},
    "engine.tangent.events": {"bundle"},
    "cases.values": {"schema", "parts", "reading"},
    "cases.schema": {"reading"},
    "cases.parts": {"reading"},
    "results.motion": {"trust", "stored", "recording", "many_digits"},
    "results.trust": {"stored", "recording", "many_digits"},
    "results.stored": {"recording", "many_digits"},
    "results.recording": {"many_digits"},
    "orbits.returns": {"search", "slopes"},
    "orbits.slopes": {"search"},
    "branches.curve": {"special", "tracing", "loci", "store"},
    "branches.special": {"tracing", "loci", "store"},
    "branches.tracing": {"loci", "store"},
    "fitting.goals": {"store"},
    "evidence.peers.equations": {"automaton", "solvers"},
    "evidence.peers.automaton": {"solvers"},
    "evidence.verification.bounds": {"truths", "vibrations", "impacts", "friction", "laws", "hard"},
    "evidence.verification.truths": {"vibrations", "impacts", "friction", "laws", "hard"},
    "evidence.reports.measured": {"claims", "pages", "figures"},
    "evidence.reports.claims": {"pages", "figures"},
    "evidence.reports.pages": {"figures"},
    "plots.page": {"motion", "runs", "cases", "sweeps", "branches", "machine", "animation", "live"},
    "plots.motion": {"runs", "cases", "sweeps", "branches", "machine", "animation", "live"},
    "plots.machine": {"motion", "runs", "cases", "sweeps", "branches", "animation", "live"},
    "command_line.terminal": {"commands", "jobs", "text", "options"},
    "command_line.options": {"commands", "jobs", "text"},
    "command_line.text": {"commands"},
    "command_line.jobs": {"commands"},
}
LIGHT = {"numpy"}  # what the ground floor may import besides the standard library
OPTIONAL = {"multiprecision.py": {"flint"}, "big_floats.py": {"mpmath"}}  # and who is there for it
MODULES = sorted(PACKAGE.rglob("*.py"))
MODULE_NAME = re.compile(r"vibsim(\.[a-z_0-9]+)+(:\w+)?")


def room_of(names):
    """The room of a module of vibsim, by the parts of its name behind `vibsim`."""
    inner = ".".join(names[:2])
    return inner if inner in MIDDLE or inner in TOP else names[0]


def allowed(room):
    """Rooms of vibsim that modules of `room` may import."""
    floors = [*GROUND, *MIDDLE]
    return set(floors[: floors.index(room) + 1]) if room in floors else {*floors, *TOP}


def imports(path):
    """Full names of all that a module imports or names, anywhere in it, except for type checking only."""
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
        elif isinstance(node, ast.Constant) and MODULE_NAME.fullmatch(str(node.value)):
            yield str(node.value).partition(":")[0]


def points_up(room, names):
    """Whether vibsim.NAMES is in a room that modules of `room` may not import."""
    return room_of(names) not in allowed(room) and names not in (["__version__"], [DATA])


def leans_on_engine(room, names):
    """Whether the evidence would read how the engine makes its modes."""
    told = {".".join(names[1:2]), ".".join(names[1:3])} & OF_ENGINE
    return room.startswith("evidence") and names[0] == "engine" and not told


def misplaced(path, room):
    """The imports of a module of `room` that point up or sideways, or that its floor may not have."""
    for name in imports(path):
        first, *rest = name.split(".")
        if first == "vibsim":
            if points_up(room, rest) or leans_on_engine(room, rest):
                yield name
        elif room in GROUND and first not in sys.stdlib_module_names | LIGHT | OPTIONAL.get(path.name, set()):
            yield name


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_imports_point_down(path):
    names = path.relative_to(PACKAGE).with_suffix("").parts
    if names[0] not in FRONT:
        assert list(misplaced(path, room_of([name for name in names if name != "__init__"]))) == []


def test_every_room_has_its_floor():
    folders = {path.parent.relative_to(PACKAGE).parts for path in MODULES if path.parent != PACKAGE}
    assert {room_of(names) for names in folders} <= {*GROUND, *MIDDLE, *TOP}


@pytest.mark.parametrize("room", WITHIN)
def test_what_serves_all_knows_none_of_them(room):
    top, depth = room.rpartition(".")[0], room.count(".") + 2
    barred = {f"vibsim.{top}.{other}" for other in WITHIN[room]}
    modules = sorted((PACKAGE / room.replace(".", "/")).glob("*.py"))
    assert modules
    for path in modules:
        upward = [name for name in imports(path) if ".".join(name.split(".")[:depth]) in barred]
        assert upward == [], path.name


@pytest.mark.parametrize(
    ("room", "line"),
    [
        ("physics", "import scipy"),
        ("engine", "def f():\n    from vibsim.cases import Case"),
        ("cases", "from vibsim.results import Result"),
        ("physics", "from vibsim.engine.modes.status import OPEN"),
        ("results", "from vibsim import sweeps"),
        ("results", "import vibsim.plots.style"),
        ("analysis", "from vibsim.sweeps.plan.axis import Axis"),
        ("results", "import vibsim.command_line"),
        ("results", "from vibsim import load_case"),
        ("results", "from vibsim.opening import open_result"),
        ("sweeps.plan", "from vibsim.sweeps.points.point import Point"),
        ("results", 'READERS = {"sweep": ("vibsim.sweeps", "open_sweep")}'),
        ("evidence.peers", 'OWN = "vibsim.evidence.benchmark.own_engine:OwnEngine"'),
        ("fitting", "from vibsim.evidence.benchmark.truth import Truth"),
        ("evidence.verification", "from vibsim.engine.modes.rows import rows_of"),
        ("evidence.benchmark", "from vibsim.engine.flows import modal"),
    ],
)
def test_what_is_misplaced_is_found(tmp_path, room, line):
    (tmp_path / "module.py").write_text(line)
    assert len(list(misplaced(tmp_path / "module.py", room))) == 1
