"""Rooms and their order: imports point down, those by name too; no circle of files, one class of a name."""

import ast
import re
import sys
from functools import cache
from pathlib import Path

import pytest

import vibsim

PACKAGE = Path(vibsim.__file__).parent
GROUND = ["lazy", "signals", "physics", "engine"]
# each may import those before it, and the ground floor
MIDDLE = ["cases", "results", "orbits", "analysis", "sweeps", "fitting"]
MIDDLE += ["evidence", "evidence.peers", "evidence.verification", "evidence.benchmark"]
TOP = {"command_line", "plots", "evidence.reports"}
FRONT = {"__init__", "__main__"}  # modules of the package itself: above all rooms
DATA = "shipped_cases"  # a package without modules
# What the evidence may use of the engine: ways of running it, and what a state is. How a mode is made and
# moved is not for it: its independence is its worth.
OF_ENGINE = {"blocks_ahead", "c_engine", "columns", "errors", "number_forms", "state"}
OF_ENGINE |= {"tangent.error_growth", "tangent.monodromy", "tangent.tangent_space"}
OF_ENGINE |= {"trajectory", "truth", "_engine"}  # the last by name, to ask whether it is there
# rooms of the engine -> rooms beside them that they may not import
WITHIN = {
    "engine.events.roots": {"impacts"},
    "engine.flows.closed": {"series"},
    "engine.flows.series": {"closed"},
    "engine.tangent.flows": {"events", "bundle"},
    "engine.tangent.events": {"bundle"},
}
LIGHT = {"numpy"}  # what the ground floor may import besides the standard library
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


class Reading(ast.NodeVisitor):
    """What a module imports and defines, read once.

    named : full names of all that it imports or names, anywhere, except for type checking only. What a
    package imports for that is imported when it is used.
    at_once, later : names that it imports from modules of vibsim when it is loaded, and those that functions
    of it import, each with its module; classes, bases : names of its classes, and of the bases of each
    """

    def __init__(self, path):
        self.is_package, self.path, self.for_types = path.name == "__init__.py", path, False
        self.named, self.at_once, self.later, self.classes, self.bases = [], [], [], [], []
        tree = ast.parse(path.read_text(encoding="utf-8"))
        self.top = {id(node) for node in tree.body}
        self.visit(tree)

    def visit_If(self, node):
        before = self.for_types
        self.for_types = before or "TYPE_CHECKING" in vars(node.test).values()  # id or attr
        for statement in node.body:
            self.visit(statement)
        self.for_types = before
        for statement in node.orelse:
            self.visit(statement)

    def visit_Import(self, node):
        if self.is_package or not self.for_types:
            self.named += [alias.name for alias in node.names]

    def visit_ImportFrom(self, node):
        assert node.level == 0, f"{self.path}: relative import"
        names = [(node.module, alias.name) for alias in node.names]
        if self.is_package or not self.for_types:
            self.named += [".".join(name) for name in names]
        if node.module.startswith("vibsim") and not self.for_types:
            (self.at_once if id(node) in self.top else self.later).extend(names)

    def visit_Constant(self, node):
        if isinstance(node.value, str) and MODULE_NAME.fullmatch(node.value):
            self.named.append(node.value.partition(":")[0])

    def visit_ClassDef(self, node):
        self.classes.append(node.name)
        self.bases.append([ast.unparse(base) for base in node.bases])
        self.generic_visit(node)


reading = cache(Reading)


def points_up(room, names):
    """Whether vibsim.NAMES is in a room that modules of `room` may not import: C stands below them all."""
    if ".".join(names).startswith("engine._engine"):
        return False
    return room_of(names) not in allowed(room) and names not in (["__version__"], [DATA])


def leans_on_engine(room, names):
    """Whether the evidence would read how the engine makes its modes."""
    told = {".".join(names[1:2]), ".".join(names[1:3])} & OF_ENGINE
    return room.startswith("evidence") and names[0] == "engine" and not told


def misplaced(path, room):
    """The imports of a module of `room` that point up or sideways, or that its floor may not have."""
    for name in reading(path).named:
        first, *rest = name.split(".")
        if first == "vibsim":
            if points_up(room, rest) or leans_on_engine(room, rest):
                yield name
        elif room in GROUND and first not in sys.stdlib_module_names | LIGHT:
            yield name


def test_imports_point_down():
    upward = {}
    for path in MODULES:
        names = path.relative_to(PACKAGE).with_suffix("").parts
        if names[0] not in FRONT:
            upward[path] = list(misplaced(path, room_of([name for name in names if name != "__init__"])))
    assert len(upward) > 200 and {path: found for path, found in upward.items() if found} == {}


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
        upward = [name for name in reading(path).named if ".".join(name.split(".")[:depth]) in barred]
        assert upward == [], path.name


@pytest.mark.parametrize(
    ("room", "line"),
    [("physics", "import scipy"), ("engine", "def f():\n    from vibsim.cases import Case"),
     ("cases", "from vibsim.results import Result"),
     ("physics", "from vibsim.engine.modes.status import OPEN"), ("results", "from vibsim import sweeps"),
     ("results", "import vibsim.plots.style"), ("analysis", "from vibsim.sweeps.axes import Axis"),
     ("results", "import vibsim.command_line"), ("results", "from vibsim import load_case"),
     ("results", 'READERS = {"sweep": ("vibsim.sweeps", "open_sweep")}'),
     ("evidence.peers", 'OWN = "vibsim.evidence.benchmark.plan:OwnEngine"'),
     ("fitting", "from vibsim.evidence.benchmark.running import Truth"),
     ("evidence.verification", "from vibsim.engine.modes.rows import rows_of"),
     ("evidence.benchmark", "from vibsim.engine.flows import modal")],
)  # fmt: skip
def test_what_is_misplaced_is_found(tmp_path, room, line):
    (tmp_path / "module.py").write_text(line)
    assert len(list(misplaced(tmp_path / "module.py", room))) == 1


def test_what_a_package_offers_is_found(tmp_path):
    line = "if TYPE_CHECKING:\n    from vibsim.sweeps.sweeping import sweep as sweep\n"
    (tmp_path / "module.py").write_text(line)
    (tmp_path / "__init__.py").write_text(line)
    assert list(misplaced(tmp_path / "module.py", "results")) == []
    assert list(misplaced(tmp_path / "__init__.py", "results")) == ["vibsim.sweeps.sweeping.sweep"]


@cache
def loaded(name):
    """Modules of vibsim that a module imports when it is loaded, and those that functions of it import."""
    read = reading(NAMES[name])
    return tuple(
        {full if (full := f"{module}.{inner}") in NAMES else module for module, inner in names}
        for names in (read.at_once, read.later)
    )


def name_of(path):
    return ".".join(path.relative_to(PACKAGE.parent).with_suffix("").parts).removesuffix(".__init__")


NAMES = {name_of(path): path for path in MODULES}


def reached(name, seen=None):
    """All modules of vibsim that are loaded with one."""
    seen = set() if seen is None else seen
    if name in NAMES and name not in seen:
        seen.add(name)
        for other in loaded(name)[0]:
            reached(other, seen)
    return seen


def test_no_circle_of_files():
    """Of no two files does each import the other, at once or later, directly or by way of others."""
    order, state = [], {}

    def visit(name, way):
        assert state.get(name) != "open", " -> ".join([*way, name])
        if name in NAMES and name not in state:
            state[name] = "open"
            for other in sorted(loaded(name)[0] | loaded(name)[1]):
                if other != name:
                    visit(other, [*way, name])
            state[name] = "done"
            order.append(name)

    for name in NAMES:
        visit(name, [])
    assert len(order) == len(NAMES)


def test_no_named_tuple_has_another_base():
    """Python 3.10 does not make such a class, and `import vibsim` fails there."""
    for path in MODULES:
        for bases in reading(path).bases:
            assert "NamedTuple" not in bases or len(bases) == 1, path


def test_one_class_of_a_name():
    named = {}
    for path in MODULES:
        for name in reading(path).classes:
            named.setdefault(name, []).append(name_of(path))
    assert {name: where for name, where in named.items() if len(where) > 1} == {}


def test_functions_import_only_what_is_not_loaded_yet():
    """An import within a function spares the start of a command something; else it belongs to the top."""
    idle = {}
    for name in NAMES:
        if not name.startswith("vibsim.engine"):
            modules = {at for at in loaded(name)[1] if NAMES.get(at, PACKAGE).name != "__init__.py"}
            idle[name] = {at for at in modules if reached(at) <= reached(name)} - ALIASED.get(name, set())
    assert len(idle) > 100 and {name: found for name, found in idle.items() if found} == {}


# imports that give one local name to one of several functions
ALIASED = {"vibsim.plots.traces": {"vibsim.results.columns"}}


def test_rooms_are_few_and_modules_are_subjects():
    """At most ten rooms beside the engine, one level of folders in them, few files of fewer than 80 lines."""
    outside = [path for path in MODULES if "engine" not in path.relative_to(PACKAGE).parts]
    depths = {len(path.relative_to(PACKAGE).parts) for path in outside}
    rooms = {path.relative_to(PACKAGE).parts[0] for path in outside if path.parent != PACKAGE}
    assert len(rooms) <= 10 and max(depths) <= 3 and len(outside) <= 200
    short = [path for path in MODULES if len(path.read_text(encoding="utf-8").splitlines()) < 80]
    assert len(short) < 0.15 * len(MODULES)
