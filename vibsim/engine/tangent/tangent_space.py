"""A small disturbance of the state of a scene: dx of each body, dv of each body, then dphi, dw with a motor.

Two sorts of directions in which a disturbance neither grows nor shrinks are left out. A set of bodies that
links, stops and formulas join to each other, but not to ground or base, may be shifted as a whole without any
force feeling it: there dx is measured from the last body of the set, its reference, whose dx is 0. So is the
angle of a rotor that no force feels, and what would be the x of a state. And a disturbance of the state is
none of time, whose direction ideal sources would add.

In a mode with ties only some disturbances are possible: those in which tied bodies have one dv, and bodies
tied to the ground or the base have none. Bodies that rigid stops at rest tie have one dx as well. They are
the tangent space of the mode.
"""

from vibsim.engine.modes.ties import Groups
from vibsim.physics.connections import felt_angles, felt_pairs
from vibsim.physics.numbers import Kit, N
from vibsim.physics.parts import BASE, GROUND, ROTOR, Scene
from vibsim.physics.rates import fastest_of_formulas, mobility


def references(scene: Scene[N]) -> list[int | None]:
    """By body: its reference, or None where a part ties its set to the ground or the base; a rotor whose
    angle nothing feels is its own reference, as is a state.
    """
    joined = (*scene.links, *scene.stops, *felt_pairs(scene))
    n = len(scene.bodies)
    groups = Groups(n, [(i, _column(part.P, n), _column(part.Q, n)) for i, part in enumerate(joined)])
    felt = set(felt_angles(scene))
    return [
        max(groups.members[groups.leader[c]]) if groups.moves(c) and c not in felt else None for c in range(n)
    ]


def _column(end: int, n: int) -> int:
    """Column of an end of a part; the base is as good as the ground here."""
    return end if end >= 0 else n


def components(scene: Scene[N]) -> list[int]:
    """Indices of the components that the scene has, in the order in which disturbances at the start take
    them.
    """
    n, reference = len(scene.bodies), references(scene)
    rotor = [2 * n, 2 * n + 1] if scene.motor is not None else []
    return [*(c for c in range(n) if reference[c] != c), n, *rotor, *range(n + 1, 2 * n)]


def length(scene: Scene[N]) -> int:
    """Number of entries of a disturbance."""
    return 2 * len(scene.bodies) + (2 if scene.motor is not None else 0)


def dimension(scene: Scene[N]) -> int:
    """Number of Lyapunov exponents of the scene."""
    return len(components(scene))


def natural_rate(scene: Scene[N], kit: Kit[N]) -> N:
    """Rate [rad/s] that compares displacements with velocities: that of the two ends of a link on its spring,
    the largest of them; of a stop where no link has a spring, 1 without either.
    """
    elastic, moves = [stop for _, stop in scene.elastic_stops], scene.base_moves
    for parts in (scene.links, elastic):
        springs: dict[frozenset[int], N] = {}
        for part in parts:
            ends = frozenset(GROUND if end == BASE and not moves else end for end in (part.P, part.Q))
            springs[ends] = springs[ends] + part.k if ends in springs else part.k
        squares: list[N] = [k * mobility(scene, ends) for ends, k in springs.items() if k > 0]
        if squares:
            return kit.sqrt(max(squares))
    return kit.number(fastest_of_formulas(scene) or 1)


def weights(scene: Scene[N], kit: Kit[N], rate: N | None = None) -> list[N]:
    """Weights of the squared components: each is measured as a velocity [m/s], dx by the natural rate, dw by
    the arm e of the unbalanced mass, dphi by both; states by 1. rate: the natural one, where it is known
    """
    n, one = len(scene.bodies), kit.number(1)
    rate = natural_rate(scene, kit) if rate is None else rate
    values = [rate * rate] * n + [one] * n
    for c, square in _squared_arms(scene, kit).items():
        values[c], values[n + c] = square * (rate * rate), square
    if scene.motor is not None:
        arm = scene.motor.e
        values += [(arm * rate) * (arm * rate), arm * arm]
    return values


def _squared_arms(scene: Scene[N], kit: Kit[N]) -> dict[int, N]:
    """By number of a rotor the square of the arm [m^2] by which its angle is measured: J / m of the rotor
    and its body, or 1 where it is on none.
    """
    if not any(body.kind == ROTOR for body in scene.bodies):
        return {}
    on = {rotor.column: rotor.on for rotor in scene.rotors}
    return {
        i: body.m / scene.bodies[on[i]].m if i in on else kit.number(1)
        for i, body in enumerate(scene.bodies)
        if body.kind == ROTOR
    }


def plainly_weighed_alike(one: Scene[N], other: Scene[N]) -> bool:
    """Whether two scenes whose parts have the same ends have plainly the same weights: the same bodies and
    stops, springs of links and arm of the motor.
    """
    if one.bodies is not other.bodies or one.stops is not other.stops:
        return False
    if one.has_formulas and not (one.links is other.links and one.forces is other.forces):
        return False
    springs = one.links is other.links or [link.k for link in one.links] == [link.k for link in other.links]
    return springs and (one.motor and one.motor.e) == (other.motor and other.motor.e)
