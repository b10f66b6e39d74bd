"""The two blocks of `tests.scenes` as a scene made of parts."""

from vibsim.physics.parts import (
    AT_GAP,
    GROUND,
    Body,
    Clearance,
    Force,
    Friction,
    Harmonic,
    Link,
    Motor,
    Scene,
    Stop,
)


def parts_of(scene, kit):
    """The scene made of parts that the two-block `scene` is."""
    zero = kit.number(0)
    bodies = [Body("1", scene.m1, scene.x1, scene.v1)]
    other = GROUND
    if scene.has_block2:
        bodies.append(Body("2", scene.m2, scene.x2, scene.v2))
        other = 1
    links = (Link("coupling", 0, other, scene.k1, scene.c),)
    stops: tuple[Stop, ...] = ()
    frictions: tuple[Friction, ...] = ()
    forces: tuple[Force, ...] = ()
    clearances: tuple[Clearance, ...] = ()
    if scene.has_stop:
        stops = (Stop("stop", 0, other, scene.G, scene.stop_sign, scene.k2, zero, AT_GAP, scene.at_stop),)
    if scene.has_friction:
        frictions = (Friction("friction", 1, GROUND, scene.N, scene.N, zero),)
    if scene.source == "harmonic":
        term = Harmonic(scene.A, scene.omega, scene.cycles, scene.cycles_lo, zero)
        forces = (Force("excitation", 0, scene.F0, (term,)),)
    motor = None
    if scene.has_motor:
        motor = Motor(0, scene.m3, scene.e, scene.J, scene.M0, scene.Omega0, scene.phi, scene.phidot)
    if scene.rest_distance is not None:
        clearances = (Clearance("rest_distance", 0, other, scene.rest_distance, scene.at_rest_distance),)
    return Scene(
        tuple(bodies),
        links,
        stops,
        frictions,
        forces,
        (),
        motor,
        clearances,
        scene.stop_on_violation,
        scene.t_end,
        scene.every_num,
        scene.every_den,
        scene.method,
        scene.order,
        scene.tol,
    )
