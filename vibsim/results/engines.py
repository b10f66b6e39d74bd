"""Which engine runs a scene: that of mode rows one made of parts, the older one that of two blocks."""

from typing import Any

from vibsim.physics.parts import Scene as PartsScene
from vibsim.physics.scene import Scene as TwoBlocks


def open_run(scene: TwoBlocks | PartsScene, engine: str = "auto", **wishes: Any) -> Any:
    """A run of `scene`, not yet computed; `wishes` as of `open_trajectory` of either engine.

    Returns an object with `engine`, `blocks()` and `totals`; `blocks()` raises EngineError (in
    `vibsim.engine.errors`) when the run fails.
    """
    from vibsim import kernel

    if isinstance(scene, TwoBlocks):
        return kernel.open_trajectory(scene, engine, **wishes)
    from vibsim.engine.trajectory import open_trajectory

    return open_trajectory(scene, kernel.engine_name(engine), **wishes)


def flow_of(scene: TwoBlocks | PartsScene) -> str:
    """The flow of a run: "closed_form", "taylor", or "auto": closed form in the modes that have one, Taylor
    series in the others.
    """
    if isinstance(scene, TwoBlocks):
        from vibsim.kernel import flow_method

        return str(flow_method(scene))
    return "taylor" if scene.has_motor else scene.method
