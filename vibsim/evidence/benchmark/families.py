"""Who takes part: the families of methods, each with a ladder of settings from fast to accurate.

A new peer is one entry here and one module in `vibsim.evidence.peers.solvers`. Nothing here imports the
peers: `--methods` and its completion read this table.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any

from vibsim.cases.spelling import nearest
from vibsim.evidence.benchmark.errors import BenchError
from vibsim.evidence.peers.solvers.tolerances import SHARE, TIGHTEST
from vibsim.lazy_names import named
from vibsim.physics.parts import Scene

Setting = tuple[str, Mapping[str, Any]]  # as shown, as given to the peer

OWN = "vibsim.evidence.benchmark.own_engine:OwnEngine"
EVENTS = "vibsim.evidence.peers.solvers.solve_ivp_events:EventSolver"
EVENTLESS = "vibsim.evidence.peers.solvers.solve_ivp_eventless:EventlessSolver"
COMPILED: Any = {
    "needs": "vibsim.engine._engine",
    "remedy": "not in this installation: install vibsim with a C compiler",
}
FULL = 2.0**-53


@dataclass(frozen=True)
class Family:
    """One family of methods.

    Attributes
    ----------
    name, label, mark : on the command line, in tables, beside the curves of pictures
    peer : module and class that run it
    fixed : settings that all its rows share
    ladder : what varies from row to row
    needs : module that has to be installed, or None; remedy : what to do where it is not
    motor, rigid_stops : whether it can take a motor, and rigid stops
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
    own: bool = False

    def refusal(self, scene: Scene) -> str | None:
        """Why the family cannot run the scene; None where it can."""
        if scene.has_motor and not self.motor:
            return "left out: it needs an ideal source, and the case has a motor"
        if scene.rigid_stops and not self.rigid_stops:
            return "left out: the case has rigid stops, which need located events"
        return None

    @property
    def installed(self) -> bool:
        """Whether what it needs is here."""
        return self.needs is None or find_spec(self.needs) is not None

    def opener(self, scene: Scene, setting: str) -> Callable[[], Any]:
        """What makes the peer for `scene` at a setting when called; its module is imported here."""
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
    Family(
        "closed-form", "vibsim, closed form", "vibsim, closed form",
        OWN, {"engine": "c", "method": "closed_form"}, [("C engine", {})],
        motor=False, own=True, **COMPILED,
    ),
    Family(
        "taylor", "vibsim, Taylor series of order 20", "vibsim, Taylor",
        OWN, {"engine": "c", "method": "taylor"}, _tols(1e-3, 1e-6, 1e-9, 1e-12, FULL),
        own=True, **COMPILED,
    ),
    Family(
        "orders", "vibsim, Taylor series to round-off", "vibsim, other orders",
        OWN, {"engine": "c", "method": "taylor"}, [(f"order {n}", {"order": n}) for n in (8, 12, 16, 24, 32)],
        own=True, **COMPILED,
    ),
    Family(
        "python", "vibsim, Python engine", "vibsim in Python",
        OWN, {"engine": "python", "method": "auto"}, [("as by default", {})],
        own=True,
    ),
    Family(
        "heyoka", "heyoka.py with events", "heyoka",
        "vibsim.evidence.peers.solvers.heyoka_events:HeyokaEvents", {}, _tols(1e-6, 1e-9, 1e-12, 2.0**-52),
        needs="heyoka", remedy="not installed: pip install 'vibsim[bench]'",
    ),
    Family(
        "dop853", "DOP853 with events", "DOP853",
        EVENTS, {"method": "DOP853"}, _rtols(1e-3, 1e-6, 1e-9, 1e-12, TIGHTEST),
    ),
    Family(
        "lsoda", "LSODA with events", "LSODA",
        EVENTS, {"method": "LSODA"}, _rtols(1e-3, 1e-6, 1e-9, 1e-12),
    ),
    Family(
        "radau", "Radau with events", "Radau",
        EVENTS, {"method": "Radau"}, _rtols(1e-3, 1e-5, 1e-7),
    ),
    Family(
        "rk45", "RK45, sgn, no events", "RK45, sgn",
        EVENTLESS, {"method": "RK45"},
        [("rtol 1e-3 (default)", {"rtol": 1e-3, "atol": 1e-6}), *_plain(1e-6, 1e-9)],
        rigid_stops=False,
    ),
    Family(
        "tanh", "LSODA, tanh, no events", "LSODA, tanh",
        EVENTLESS, {"method": "LSODA", "rtol": 1e-8, "atol": 1e-11},
        [(f"width {_short(width)} m/s", {"width": width}) for width in (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)],
        rigid_stops=False,
    ),
    Family(
        "rk4", "RK4, sgn, no events", "RK4, sgn",
        "vibsim.evidence.peers.solvers.runge_kutta4:RungeKutta4", {},
        [(f"step {1e3 * step:g} ms", {"step": step}) for step in (2e-3, 1e-3, 5e-4, 2e-4, 1e-4)],
        rigid_stops=False,
    ),
)  # fmt: skip


def families_named(names: Sequence[str]) -> list[Family]:
    """The families of these names, in the order of the table; all for none. Raises BenchError."""
    known = [family.name for family in FAMILIES]
    for name in names:
        if name not in known:
            near = nearest(name, known)
            hint = f"did you mean {near}? " if near else ""
            raise BenchError(f"unknown method {name!r}: {hint}The methods are {', '.join(known)}")
    return [family for family in FAMILIES if not names or family.name in names]


def family_of(name: str) -> Family:
    """The family called `name`; one without settings where another version of vibsim has measured it."""
    return next((family for family in FAMILIES if family.name == name), Family(name, name, name, "", {}, ()))
