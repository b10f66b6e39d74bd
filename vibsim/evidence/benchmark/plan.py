"""Plan of a bench: which case over which span, compared when, by whom, for how long at most."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from importlib.util import find_spec
from math import ceil
from typing import Any

import numpy as np

from vibsim.cases import Case, load_case
from vibsim.cases.problems import nearest
from vibsim.cases.quantities import decimal_text
from vibsim.cases.validation import exact_pairs, fingerprint_of
from vibsim.engine.columns import of_kinds
from vibsim.engine.trajectory import open_trajectory
from vibsim.evidence.peers.solvers import SHARE, TIGHTEST, Attempt, OutOfTime, TimeLimit, kinds_of
from vibsim.evidence.peers.straight_line import two_sided_power
from vibsim.lazy import named
from vibsim.physics.parts import Scene
from vibsim.results.columns import tables_of

# Who takes part: the families of methods, each with a ladder of settings from fast to accurate.
#
# A new peer is one entry here and one module in `vibsim.evidence.peers.solvers`. Nothing here imports the
# peers: `--methods` and its completion read this table.


Setting = tuple[str, Mapping[str, Any]]  # as shown, as given to the peer

OWN = "vibsim.evidence.benchmark.plan:OwnEngine"
EVENTS = "vibsim.evidence.peers.solvers:EventSolver"
EVENTLESS = "vibsim.evidence.peers.solvers:EventlessSolver"
FULL = 2.0**-53


@dataclass(frozen=True)
class SolverFamily:
    """One family of methods.

    Attributes
    ----------
    name, label, mark : on the command line, in tables, beside the curves of pictures
    peer : module and class that run it
    fixed : settings that all its rows share
    ladder : what varies from row to row
    needs : module that has to be installed, or None; remedy : what to do where it is not
    motor, rigid_stops : whether it can take a motor, and rigid stops
    powers : whether it can take powers that have no series at 0 wherever they are 0
    own : whether it is vibsim itself
    """

    name: str
    label: str
    mark: str
    peer: str
    fixed: Mapping[str, Any]
    ladder: Sequence[Setting]
    needs: str | None = None
    remedy: str = ""
    motor: bool = True
    rigid_stops: bool = True
    powers: bool = True
    own: bool = False

    def refusal(self, scene: Scene) -> str | None:
        """Reason why the family cannot run the scene; None where it can."""
        if scene.has_motor and not self.motor:
            return "left out: it needs an ideal source, and the case has a motor"
        if scene.has_formulas and not self.motor:
            return "left out: it needs laws that are linear, and the case has formulas"
        power = None if self.powers else two_sided_power(scene)
        if power is not None:
            return f"left out: {power} has no Taylor series where it is 0, on neither side"
        if scene.rigid_stops and not self.rigid_stops:
            return "left out: the case has rigid stops, which need located events"
        return None

    @property
    def installed(self) -> bool:
        """Whether what it needs is here."""
        return self.needs is None or find_spec(self.needs) is not None

    def opener(self, scene: Scene, setting: str) -> Callable[[], Any]:
        """Function that makes the peer for `scene` at a setting when called; its module is imported here."""
        peer, settings = named(self.peer), dict(self.ladder)[setting]
        return lambda: peer(scene, **self.fixed, **settings)


def _rtols(*values: float) -> list[Setting]:
    return [(f"rtol {_short(value)}", {"rtol": value}) for value in values]


def _short(value: float) -> str:
    """1e-3, 2.3e-14."""
    mantissa, _, exponent = f"{value:.1e}".partition("e")
    return f"{mantissa.removesuffix('.0')}e{int(exponent)}"


def _tols(*values: float) -> list[Setting]:
    return [(f"tol {_short(value)}", {"tol": value}) for value in values]


def _plain(*values: float) -> list[Setting]:
    return [(f"rtol {_short(value)}", {"rtol": value, "atol": SHARE * value}) for value in values]


FAMILIES = (
    SolverFamily(
        "closed-form", "vibsim, closed form", "vibsim, closed form",
        OWN, {"method": "closed_form"}, [("as by default", {})],
        motor=False, own=True,
    ),
    SolverFamily(
        "taylor", "vibsim, Taylor series", "vibsim, Taylor",
        OWN, {"method": "taylor"}, _tols(1e-3, 1e-6, 1e-9, 1e-12, FULL),
        own=True,
    ),
    SolverFamily(
        "orders", "vibsim, Taylor series to round-off", "vibsim, other orders",
        OWN, {"method": "taylor"}, [(f"order {n}", {"order": n}) for n in (8, 12, 16, 24, 32)],
        own=True,
    ),
    SolverFamily(
        "heyoka", "heyoka.py with events", "heyoka",
        "vibsim.evidence.peers.heyoka_events:HeyokaEvents", {}, _tols(1e-6, 1e-9, 1e-12, 2.0**-52),
        needs="heyoka", remedy="not installed: pip install 'vibsim[bench]'", powers=False,
    ),
    SolverFamily(
        "dop853", "DOP853 with events", "DOP853",
        EVENTS, {"method": "DOP853"}, _rtols(1e-3, 1e-6, 1e-9, 1e-12, TIGHTEST),
    ),
    SolverFamily(
        "lsoda", "LSODA with events", "LSODA",
        EVENTS, {"method": "LSODA"}, _rtols(1e-3, 1e-6, 1e-9, 1e-12),
    ),
    SolverFamily(
        "radau", "Radau with events", "Radau",
        EVENTS, {"method": "Radau"}, _rtols(1e-3, 1e-5, 1e-7),
    ),
    SolverFamily(
        "rk45", "RK45, sgn, no events", "RK45, sgn",
        EVENTLESS, {"method": "RK45"},
        [("rtol 1e-3 (default)", {"rtol": 1e-3, "atol": 1e-6}), *_plain(1e-6, 1e-9)],
        rigid_stops=False,
    ),
    SolverFamily(
        "tanh", "LSODA, tanh, no events", "LSODA, tanh",
        EVENTLESS, {"method": "LSODA", "rtol": 1e-8, "atol": 1e-11},
        [(f"width {_short(width)} m/s", {"width": width}) for width in (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)],
        rigid_stops=False,
    ),
    SolverFamily(
        "rk4", "RK4, sgn, no events", "RK4, sgn",
        "vibsim.evidence.peers.solvers:RungeKutta4", {},
        [(f"step {1e3 * step:g} ms", {"step": step}) for step in (2e-3, 1e-3, 5e-4, 2e-4, 1e-4)],
        rigid_stops=False,
    ),
)  # fmt: skip


def families_named(names: Sequence[str]) -> list[SolverFamily]:
    """The families of these names, in the order of the table; all for none. Raises BenchError."""
    known = [family.name for family in FAMILIES]
    for name in names:
        if name not in known:
            near = nearest(name, known)
            hint = f"did you mean {near}? " if near else ""
            raise BenchError(f"unknown method {name!r}: {hint}The methods are {', '.join(known)}")
    return [family for family in FAMILIES if not names or family.name in names]


def family_of(name: str) -> SolverFamily:
    """The family called `name`; one without settings where another version of vibsim has measured it."""
    return next(
        (family for family in FAMILIES if family.name == name), SolverFamily(name, name, name, "", {}, ())
    )


LONGEST = Fraction(
    100
)  # s, unless the user says otherwise: doubles know II-B until then, all peers take minutes
INSTANTS = 2000  # about as many are compared
FEWEST = 10
LIMIT = 20.0  # s per run
SHARES = (0.1, 0.2, 0.5, 1.0)  # of the span: where errors are told
STOPS_A_RUN = ("rest_distance.on_violation", "run.on_violation")
NOT_TRUTH = ("name", "title", "run.trust_tolerance", "run.method", "run.order", "run.tol")


@dataclass(frozen=True)
class BenchPlan:
    """A bench of `case`, whose run settings say span and instants.

    families : who takes part; limit : wall time of a run after which it is stopped [s]
    """

    case: Case
    families: tuple[SolverFamily, ...]
    limit: float

    @property
    def times(self) -> np.ndarray:
        """The instants compared [s]."""
        scene = self.case.scene()
        return np.array([scene.sample_time(i) for i in range(scene.sample_count)])

    @property
    def check_times(self) -> list[float]:
        """The instants at which errors are told [s], some of those compared."""
        times = self.times
        return sorted({float(times[round(share * (len(times) - 1))]) for share in SHARES})

    @property
    def fingerprint(self) -> str:
        """SHA-256 of what the truth depends on: two benches of one fingerprint share it."""
        values = {key: value for key, value in self.case.values.items() if key not in NOT_TRUTH}
        return fingerprint_of(exact_pairs(values))

    def rows(self) -> Iterator[tuple[SolverFamily, str]]:
        """Family and setting of every row that can be run here."""
        scene = self.case.scene()
        for family in self.families:
            if family.installed and family.refusal(scene) is None:
                yield from ((family, setting) for setting, _ in family.ladder)

    def absent(self) -> list[SolverFamily]:
        """Families that could run the scene and are not installed."""
        scene = self.case.scene()
        return [family for family in self.families if not family.installed and family.refusal(scene) is None]


def make_plan(
    case: Case | str, t_end: str | None = None, methods: Sequence[str] = (), limit: float = LIMIT
) -> BenchPlan:
    """The plan of a bench.

    Parameters
    ----------
    case : a Case, or what `load_case` takes
    t_end : end of the span, such as "50 s"; by default that of the case, 100 s at most
    methods : names of families; all for none
    limit : wall time of one run after which it is stopped [s]

    Raises CaseError for the case and its end, BenchError for unknown methods and for a span too short to
    compare.
    """
    case = load_case(case) if isinstance(case, str) else case
    families = tuple(families_named(methods))
    if t_end is None:
        t_end = f"{decimal_text(min(case.quantity('run.t_end').value, LONGEST))} s"
    case = case.with_values({"run.t_end": t_end})
    span, every = case.quantity("run.t_end").value, case.quantity("run.every").value
    changes = {"run.every": f"{decimal_text(every * max(ceil(span / every / INSTANTS), 1))} s"}
    changes |= {key: "warn" for key in STOPS_A_RUN if key in case.values}  # the peers know of no clearance
    plan = BenchPlan(case.with_values(changes), families, limit)
    if len(plan.times) < FEWEST:
        raise BenchError(
            f"{t_end} is too short: a bench needs {FEWEST} samples, one every {case.quantity('run.every')}"
        )
    return plan


# What can be wrong with a bench that is asked for.


class BenchError(ValueError):
    """A wish that no bench can meet: an unknown method, a span too short, a truth of another case."""


# vibsim itself as a contestant, asked for the same states as its peers.


class OwnEngine:
    """A scene by `method`; order, that of the scene where it is None, and tolerance of a Taylor series."""

    def __init__(self, scene: Scene, method: str, order: int | None = None, tol: float = 2.0**-53):
        self.scene = replace(scene, method=method, order=order or scene.order, tol=tol)
        self.names, self.kinds = tables_of(scene).states, kinds_of(scene)
        self.compared = of_kinds(self.kinds)

    def run(self, times: np.ndarray, limit: TimeLimit) -> Attempt:
        """States at `times` [s], which are the instants that the scene is sampled at. Raises EngineError."""
        trajectory = open_trajectory(self.scene)
        blocks, stopped = [], False
        try:
            for block in trajectory.blocks():
                blocks.append(block)
                limit.check()
        except OutOfTime:
            stopped = True
        samples = np.concatenate([np.column_stack([b.samples[name] for name in self.names]) for b in blocks])
        t, kinds = (np.concatenate([block.events[name] for block in blocks]) for name in ("t", "kind"))
        counted = self.compared[kinds]
        events = list(zip(t[counted].tolist(), kinds[counted].tolist(), strict=True))
        steps = int(trajectory.totals["steps"])
        return Attempt(samples, blocks[-1].t_reached, steps, None, events, self.kinds, stopped)
