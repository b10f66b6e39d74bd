"""Small disturbances as flat numbers, in the order in which reading_tangent.c reads them."""

from collections.abc import Callable
from math import log2

import numpy as np

from vibsim.engine.modes.packing import Packer
from vibsim.engine.modes.rows import Joined
from vibsim.engine.modes.ties import Edge
from vibsim.engine.tangent.tangent_space import Gauge, components, natural_rate, weights
from vibsim.engine.tangent.tangent_taylor import reach
from vibsim.physics.numbers import Doubles
from vibsim.physics.parts import RigidStop, Scene

Ends = Callable[[Joined], Edge]  # columns of the ends of a part


def pack_bundle(scene: Scene, count: int, begin: float, ends: Ends) -> tuple[bytes, bytes]:
    """A bundle of `count` disturbances whose growth counts from `begin` [s]. ends: columns of the ends of a
    part.
    """
    return _pack(scene, False, count, begin, ends)


class DisturbancePacker:
    """Packs disturbances of one scene that are carried along as they are; what does not depend on them is
    packed once for each number of them.
    """

    def __init__(self, scene: Scene, ends: Ends) -> None:
        self.scene, self.ends = scene, ends
        self.heads: dict[int, tuple[bytes, bytes]] = {}

    def packed(self, vectors: np.ndarray) -> tuple[bytes, bytes]:
        """vectors: an array of one disturbance per row."""
        count = len(vectors)
        if count not in self.heads:
            self.heads[count] = _pack(self.scene, True, count, 0.0, self.ends)
        ints, doubles = self.heads[count]
        return ints, doubles + vectors.tobytes()


def _pack(scene: Scene, given: bool, count: int, begin: float, ends: Ends) -> tuple[bytes, bytes]:
    pack, gauge, present = Packer(), Gauge(scene), components(scene)
    pack.put((given, count, len(scene.stops), len(scene.frictions)))
    pack.put((len(present), len(gauge.shifts), len(gauge.references)))
    pack.put((*present, *(c for c, _ in gauge.shifts), *(r for _, r in gauge.shifts), *gauge.references))
    for stop in scene.stops:
        pack.put(ends(stop), (0.0 if isinstance(stop, RigidStop) else stop.c,))
    for friction in scene.frictions:
        pack.put(ends(friction), friction.starts)
    farthest = reach(Doubles, scene.order, log2(scene.tol))
    pack.put((), (begin, farthest, natural_rate(scene, Doubles), *weights(scene, Doubles)))
    return pack.ints.tobytes(), pack.doubles.tobytes()
