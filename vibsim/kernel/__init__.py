"""The engines: one contract, two implementations that agree bit for bit on doubles.

trajectory = open_trajectory(scene, engine="auto")
for block in trajectory.blocks(): ...
trajectory.totals
"""

import sys
from types import ModuleType

from vibsim.kernel.block import EVENT_STATE, Block, event_columns, section_columns
from vibsim.kernel.errors import KernelError
from vibsim.physics.disturbance import dimension

__all__ = [
    "EVENT_STATE",
    "Block",
    "KernelError",
    "engine_name",
    "event_columns",
    "flow_method",
    "open_trajectory",
    "section_columns",
    "state_at",
]

_noticed = False


def _built() -> ModuleType | None:
    try:
        from vibsim.kernel import _kernel
    except ImportError:
        return None
    return _kernel


_c_engine = _built()  # once, with this package: threads that ask for it later never meet a half-made module


def compiled() -> bool:
    """Whether the C engine was built with this installation."""
    return _c_engine is not None


def engine_name(engine="auto"):
    """The engine that `engine` ("auto", "c", "python") stands for: "c" or "python".

    "auto" falls back on Python with one notice on stderr. Raises ValueError for another name, RuntimeError
    for "c" where it was not built.
    """
    global _noticed
    if engine not in ("auto", "c", "python"):
        raise ValueError(f"engine must be auto, c or python, got {engine!r}")
    if engine == "python" or compiled():
        return "python" if engine == "python" else "c"
    if engine == "c":
        raise RuntimeError("the C engine was not built; install with a C compiler, or use engine python")
    if not _noticed:
        print(
            "vibsim: no C engine in this installation, running on the Python engine"
            " (same results, some 100 times slower)",
            file=sys.stderr,
        )
        _noticed = True
    return "python"


def flow_method(scene):
    """The flow that the scene's method stands for: auto takes the closed form where it exists.

    Raises ValueError for closed_form with a motor, which has none.
    """
    if scene.method == "auto":
        return "taylor" if scene.has_motor else "closed_form"
    if scene.method == "closed_form" and scene.has_motor:
        raise ValueError("method closed_form needs an ideal source; with a motor use taylor or auto")
    if scene.method not in ("closed_form", "taylor"):
        raise ValueError(f"method must be auto, closed_form or taylor, got {scene.method!r}")
    return scene.method


def open_trajectory(
    scene, engine="auto", resume=None, section=False, ledger=False, tangent=0, tangent_from=0.0
):
    """A run of `scene` from its start, not yet computed.

    Parameters
    ----------
    scene : Scene
    engine : "auto", "c" or "python"
    resume : one stored event row (t, states, phase, contact, friction by name) to go on from, or None
    section : whether the blocks carry the stroboscopic section, the state at the end of every excitation
    period
    ledger : whether the totals carry the energy ledger (costs about half as much again)
    tangent : number of Lyapunov exponents that the totals carry, the largest first, 0 to `dimension(scene)`
    (in vibsim.physics.disturbance)
    tangent_from : time [s] from which they count; before it the disturbances turn into their directions

    Returns an object with `engine`, `method`, `blocks()` (an iterator of `Block`s; the run stops between two
    of them when it is abandoned) and `totals`. `blocks()` raises KernelError when the run fails. Raises
    ValueError for a method, an engine or a number of exponents that there is not.
    """
    method = flow_method(scene)
    if not 0 <= tangent <= dimension(scene):
        raise ValueError(f"tangent must be 0 to {dimension(scene)} for this scene, got {tangent}")
    if engine_name(engine) == "c":
        from vibsim.kernel.c_engine import CTrajectory

        return CTrajectory(scene, method, resume, section, ledger, (tangent, tangent_from))
    from vibsim.kernel.python_engine import PythonTrajectory

    return PythonTrajectory(scene, method, resume, section, ledger, (tangent, tangent_from))


def state_at(scene, row, times, engine="auto"):
    """States at `times` [s], restarted from the stored event `row`.

    row: one row of the events table by column name; times: ascending, from row["t"] to before the next
    event. Returns arrays by column name.
    """
    return open_trajectory(scene, engine, resume=row).state_at(times)
