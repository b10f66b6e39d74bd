"""Small disturbances through formulas and rotors on bodies in the C engine: equal to the Python engine."""

from array import array
from dataclasses import replace
from math import exp, pi

import numpy as np
import pytest

from tests.engine.random_formulas import formula_scene
from vibsim.engine import _engine
from vibsim.engine.c_engine import CRun
from vibsim.engine.errors import EngineError
from vibsim.engine.flows.closed.modal import pitches
from vibsim.engine.modes.packing import pack_scene, packed_mode
from vibsim.engine.tangent.monodromy import Carrier
from vibsim.engine.tangent.packing_tangent import pack_slopes
from vibsim.engine.tangent.tangent_space import dimension
from vibsim.engine.trajectory import open_trajectory
from vibsim.physics.formulas import (
    ONE,
    PI,
    TIME,
    ZERO,
    absolute,
    add,
    call,
    choose,
    div,
    mul,
    num,
    power,
    sub,
)
from vibsim.physics.parts import (
    BASE,
    COMPRESSION,
    GROUND,
    ROTOR,
    STATE,
    Body,
    Force,
    Friction,
    Harmonic,
    Link,
    Motor,
    RigidStop,
    Rotor,
    Scene,
    Stop,
)

X, V = ("x", 0), ("v", 0)
OF_CARRIED = ("state", "rate", "vectors", "happened", "table")


def oscillator(law, *parts, x=1.0, v=0.0, t_end=3.0, **more):
    """A body of 1 kg on a link with a law."""
    link = Link("spring", 0, GROUND, 0.0, 0.0, law)
    return Scene(
        (Body("a", 1.0, x, v), *parts), links=(link,), t_end=t_end, every_num=1, every_den=50, **more
    )


def start_of(scene):
    """Components of the start of a scene."""
    rotor = (scene.motor.phi, scene.motor.phidot) if scene.motor is not None else ()
    return [*(b.x for b in scene.bodies), *(b.v for b in scene.bodies), *rotor]


def carried(carrier, start, end):
    """What a motion with all unit disturbances comes to, or the sentence with which it fails."""
    try:
        return carrier.carry(start, end)
    except EngineError as error:
        return str(error)


def carried_alike(scene, carriers=None, start=None):
    """What the C engine comes to, which is what Python does."""
    start = start_of(scene) if start is None else start
    carriers = carriers or (Carrier(scene, "c"), Carrier(scene, "python"))
    assert [one.engine for one in carriers] == ["c", "python"]
    fast, slow = (carried(one, start, scene.t_end) for one in carriers)
    if isinstance(fast, str) or isinstance(slow, str):
        assert fast == slow
        return fast
    for name in OF_CARRIED:
        assert getattr(fast, name).tobytes() == getattr(slow, name).tobytes(), name
    assert (fast.events, fast.uncertified, fast.margin) == (slow.events, slow.uncertified, slow.margin)
    return fast


def grown(scene, engine):
    """Totals of a run with all exponents, or the sentence with which it fails."""
    trajectory = open_trajectory(scene, engine, tangent=dimension(scene))
    assert trajectory.engine == engine
    try:
        for _ in trajectory.blocks():
            pass
    except EngineError as error:
        return str(error)
    return trajectory.totals


def grown_alike(scene):
    """Totals of the C engine, which are those of Python."""
    fast, slow = grown(scene, "c"), grown(scene, "python")
    if isinstance(fast, str) or isinstance(slow, str):
        assert fast == slow
        return fast
    assert fast.keys() == slow.keys()
    for name, value in fast.items():
        assert np.asarray(value).tobytes() == np.asarray(slow[name]).tobytes(), name
    return fast


def sine(amplitude, omega):
    return Harmonic(amplitude, omega, omega / (2 * 3.141592653589793), 0.0, 0.3)


def duffing():
    law = add(add(X, mul(X, mul(X, X))), mul(num("1/10"), V))
    return oscillator(law, forces=(Force("f", 0, 0.0, (sine(0.3, 1.4),)),), t_end=5.0)


def mathieu():
    """The law varies so fast with time that pieces are halved."""
    stiffness = add(num(4), mul(num(3), call("cos", mul(num(9), TIME))))
    return oscillator(add(mul(stiffness, X), mul(num("1/10"), V)), x=0.0, v=0.0)


def hertz():
    """A ball falls on a contact with p^1.5 and damping."""
    law = mul(mul(num(10**5), power(sub(X, num("1/1000")), num("3/2"))), add(ONE, mul(num("1/5"), V)))
    wall = Stop("wall", 0, GROUND, 0.001, COMPRESSION, 0.0, 0.0, force=law)
    return Scene((Body("ball", 1.0, 0.0, 0.3),), stops=(wall,), forces=(Force("g", 0, 9.0, ()),), t_end=0.2)


def bouc_wen():
    """z' = v - |v| z |z| / 2 - v z^2 / 2 with the force z."""
    z = ("v", 1)
    decay = mul(mul(absolute(V, "abs(v)"), z), absolute(z, "abs(z)"))
    rate = sub(V, mul(num("1/2"), add(decay, mul(V, mul(z, z)))))
    forces = (Force("z", 1, 0.0, (), rate), Force("f", 0, 0.0, (sine(2.0, 1.3),)))
    return oscillator(
        add(mul(num(2), X), mul(num(3), z)), Body("z", 1.0, 0.0, 0.0, STATE), forces=forces, t_end=5.0
    )


def belt():
    """A body on a belt whose friction falls with the speed: it sticks and slips."""
    slips, holds = [], []
    for sense in (1, -1):
        s = mul(num(sense), sub(V, num("1/2")))
        slips.append(mul(num(5), add(num("1/5"), mul(num("1/5"), call("exp", mul(num(-3), s))))))
        holds.append(mul(num(5), num("2/5")))
    friction = Friction("f", 0, GROUND, 0.0, 0.0, 0.5, slips=tuple(slips), holds=tuple(holds))
    return oscillator(add(mul(num(4), X), mul(num("1/10"), V)), frictions=(friction,), x=0.1, t_end=9.0)


def jump():
    """A force that turns with the sign of v beside one that only bends."""
    sign = choose(V, ONE, num(-1), "sign(v)")
    law = add(mul(num(9), X), mul(num("1/5"), add(sign, absolute(X, "abs(x)"))))
    return oscillator(law, x=1.3, t_end=4.0)


def motor():
    """A link that reads the angle and the speed of a motor."""
    law = add(mul(num(30), X), mul(call("sin", ("phi",)), mul(num("1/20"), ("w",))))
    return oscillator(law, motor=Motor(0, 0.1, 0.02, 1e-4, 1e-3, 9.0, 0.5, 6.0), x=0.01)


def steep():
    """Derivatives whose series fail before those of the motion do."""
    return oscillator(add(X, call("tanh", mul(num(8), X))), x=2.0, v=0.5, t_end=4.0)


def two_bodies():
    """Two bodies that a formula and a link couple, one of them on a cubic damper."""
    d, v = sub(X, ("x", 1)), sub(V, ("v", 1))
    links = (
        Link("k", 0, 1, 0.0, 0.0, add(mul(num(5), mul(d, mul(d, d))), mul(v, mul(v, v)))),
        Link("g", 1, GROUND, 20.0, 0.3),
        Link("e", 0, GROUND, 0.0, 0.0, div(mul(num(3), X), add(ONE, mul(V, V)))),
    )
    return Scene((Body("a", 1.0, 0.7, 0.0), Body("b", 2.0, 0.0, 0.4)), links=links, t_end=4.0)


def rotors():
    """Two rotors on one body, one of which a circuit drives, and one on another that friction holds."""
    bodies = (
        Body("frame", 3.0, 0.0, 0.0),
        Body("block", 1.0, 0.0, 0.1),
        Body("left", 2e-3, 1.0, 0.0, ROTOR),
        Body("right", 2e-3, 7.0, 30.0, ROTOR),
        Body("other", 1e-3, 0.0, 20.0, ROTOR),
        Body("i", 1.0, 0.0, 0.0, STATE),
    )
    current = mul(num(100), sub(sub(num(12), mul(num(2), ("v", 5))), mul(num("1/20"), ("v", 2))))
    forces = (
        Force("left", 2, 0.0, (), sub(mul(num("1/20"), ("v", 5)), mul(num("1/10000"), ("v", 2)))),
        Force("right", 3, 0.0, (), mul(num("-1/50"), call("cos", ("x", 3)))),
        Force("i", 5, 0.0, (), current),
    )
    links = (Link("spring", 0, GROUND, 900.0, 2.0), Link("tie", 0, 1, 40.0, 0.1))
    friction = (Friction("f", 1, GROUND, 1.5, 1.5, 0.0),)
    on = (Rotor(2, 0, 0.01), Rotor(3, 0, 0.02), Rotor(4, 1, 0.005))
    return Scene(bodies, links, (), friction, forces, rotors=on, t_end=0.4)


def rotors_alone():
    """Rotors on bodies without any formula."""
    bodies = (Body("frame", 3.0, 0.01, 0.0), Body("r", 2e-3, 1.0, 25.0, ROTOR))
    return Scene(bodies, (Link("spring", 0, GROUND, 900.0, 2.0),), rotors=(Rotor(1, 0, 0.01),), t_end=1.0)


SCENES = {
    one.__name__: one
    for one in (
        duffing, mathieu, hertz, bouc_wen, belt, jump, motor, steep, two_bodies, rotors, rotors_alone,
    )
}  # fmt: skip


@pytest.mark.parametrize("name", SCENES)
def test_disturbances_are_carried_as_in_python(name):
    told = carried_alike(SCENES[name]())
    assert np.isfinite(told.vectors).all() and np.isfinite(told.rate).all()


@pytest.mark.parametrize("name", SCENES)
def test_exponents_are_those_of_python(name):
    totals = grown_alike(SCENES[name]())
    assert np.isfinite(totals["exponents"]).any()


def test_what_happens_on_the_way_is_met():
    """The scenes are not empty: contacts, turns of switches, ends of sticking, pieces within steps."""
    assert len(carried_alike(hertz()).events) > 3
    assert {"stick_begin", "stick_end"} <= {kind for kind, _ in carried_alike(belt()).events}
    for scene in (mathieu(), steep()):
        totals = grown_alike(scene)
        assert totals["tangent_pieces"] > totals["steps"]


# the first of them always, all by `make verify`
FIRSTS = [pytest.param(first, marks=pytest.mark.slow if first >= 30 else ()) for first in range(0, 60, 10)]


@pytest.mark.parametrize("first", FIRSTS)
def test_random_scenes_are_those_of_python(first):
    compared = 0
    for seed in range(first, first + 10):
        scene = replace(formula_scene(seed), t_end=0.05)
        if scene.rotors and scene.rigid_stops:
            continue
        told = carried_alike(scene)
        compared += not isinstance(told, str)
        if seed % 5 == 0:
            grown_alike(scene)
    assert compared > 2


def test_one_run_carries_disturbances_of_scenes_that_differ_in_numbers():
    """The frequency of a force, and the gap of a stop beside a formula."""
    one = duffing()
    wall = replace(one, stops=(Stop("wall", 0, GROUND, 0.5, COMPRESSION, 50.0, 1.0),))
    faster = replace(one, forces=(Force("f", 0, 0.0, (sine(0.3, 1.7),)),))
    nearer = replace(wall, stops=(replace(wall.stops[0], gap=0.25),))
    for first, other in ((one, faster), (wall, nearer)):
        of_first = Carrier(first, "c")
        carried_alike(first, (of_first, Carrier(first, "python")))
        carried_alike(other, (of_first.of(other), Carrier(other, "python")))
        carried_alike(first, (of_first, Carrier(first, "python")), [0.4, -0.3])


def test_a_volume_shrinks_as_liouville_says():
    """det M = exp(-c T) for any law of displacement and time."""
    for scene, factor in ((duffing(), exp(-0.1 * 5.0)), (mathieu(), exp(-0.1 * 3.0))):
        matrix = Carrier(scene, "c").carry(start_of(scene), scene.t_end).matrix
        assert np.linalg.det(matrix) == pytest.approx(factor, rel=1e-13)


KINKED = mul(num("1/30"), absolute(call("sin", mul(num(11), TIME)), "abs(sin(11 t))"))
ON_KINKED_BASES = {
    "struck": oscillator(
        mul(num(90), sub(X, ("x", BASE))),
        stops=(Stop("s", 0, BASE, 0.004, COMPRESSION, 900.0, 2.0, "force"),),
        base_formula=KINKED,
        t_end=2.0,
    ),
    "struck as it rests": Scene(
        (Body("a", 1.0, 0.0, 0.0),),
        links=(Link("spring", 0, GROUND, 90.0, 0.0),),
        stops=(RigidStop("s", 0, BASE, 0.004, COMPRESSION, 0.0),),
        base_formula=KINKED,
        t_end=2.0,
    ),
    "rubbed from the start": Scene(
        (Body("a", 1.0, 0.0, 0.0),),
        links=(Link("spring", 0, GROUND, 90.0, 0.0),),
        frictions=(Friction("f", 0, BASE, 0.4, 0.4, 0.0),),
        base_formula=mul(num("1/30"), call("sin", mul(num(7), TIME))),
        t_end=2.0,
    ),
    "rubbed, of a base whose velocity is given": Scene(
        (Body("a", 1.0, 0.0, 0.0),),
        links=(Link("spring", 0, GROUND, 90.0, 0.0), Link("damper", 0, BASE, 0.0, 2.0)),
        frictions=(Friction("f", 0, BASE, 0.4, 0.4, 0.0),),
        base_formula=mul(num(10), KINKED),
        base_is_rate=True,
        t_end=2.0,
    ),
}


@pytest.mark.parametrize("name", ON_KINKED_BASES)
def test_a_base_by_a_formula_is_that_of_python(name):
    scene = ON_KINKED_BASES[name]
    assert len(carried_alike(scene).events) > 3
    grown_alike(scene)
    pairs = [(0, GROUND if scene.base_is_rate else BASE)], 0.5
    fast, slow = (open_trajectory(scene, engine, ledger=True, extremes=pairs) for engine in ("c", "python"))
    for one in (fast, slow):
        assert len(list(one.blocks())) > 0
    assert fast.extremes == slow.extremes
    assert fast.totals == slow.totals
    assert abs(fast.totals["energy_residual"]) < 1e-12


def test_disturbances_over_a_base_by_a_formula_are_those_of_harmonics():
    """The same motion of the base, said in two ways."""
    wave = Harmonic(0.01, 2 * pi, 1.0, 0.0, 0.0)
    wall = Stop("s", 0, BASE, 0.004, COMPRESSION, 900.0, 2.0)
    bodies, links = (Body("m", 1.0, 0.002, 0.1),), (Link("k", 0, BASE, 90.0, 0.5),)
    said = {"base": (wave,)}, {"base_formula": mul(num("1/100"), call("sin", mul(mul(num(2), PI), TIME)))}
    one, other = (Scene(bodies, links, stops=(wall,), t_end=3.0, **base) for base in said)
    one, other = (Carrier(scene, "c").carry(start_of(scene), 3.0) for scene in (one, other))
    assert len(one.events) == len(other.events) > 5
    assert other.matrix == pytest.approx(one.matrix, abs=1e-12)


def derivatives():
    """A run that waits for the derivatives of a mode, and these, packed."""
    motion = add(call("sin", mul(X, TIME)), mul(call("tanh", V), mul(X, V)))
    scene = oscillator(add(motion, absolute(sub(X, V), "abs(x - v)")))
    of = CRun(scene)
    packed = pack_scene(scene, pitches(scene)), packed_mode(of.rows_of(0), dict(of.keys)).packed
    run = _engine.Run(*packed[0])
    run.add_mode(*packed[1])
    return run, pack_slopes(of.rows_of(0))


def test_no_index_of_a_derivative_reaches_beyond_its_table():
    """Each whole number in turn is far out: it is refused, or what it says does no harm."""
    _, (ints, doubles) = derivatives()
    refused = 0
    for place in range(len(ints) // 4):
        for value in (2**31 - 1, 10**6, -(10**6), -(2**31)):
            values = array("i", ints)
            values[place] = value
            run, _ = derivatives()
            try:
                run.set_slopes(0, values.tobytes(), doubles)
            except (ValueError, MemoryError):
                refused += 1
    assert refused > 2 * len(ints) // 4


def test_derivatives_are_told_once_and_whole():
    run, (ints, doubles) = derivatives()
    for short in ((ints[:-4], doubles), (ints, doubles[:-8])):
        with pytest.raises(ValueError, match="no derivatives"):
            run.set_slopes(0, *short)
    with pytest.raises(ValueError, match="waits"):
        run.set_slopes(1, ints, doubles)
    run.set_slopes(0, ints, doubles)
    with pytest.raises(ValueError, match="waits"):
        run.set_slopes(0, ints, doubles)


def test_a_law_without_motion_in_it_carries_nothing():
    scene = oscillator(ZERO, forces=(Force("f", 0, 0.0, (), call("sin", TIME)),))
    assert carried_alike(scene).matrix.tolist() == [[1.0, 3.0], [0.0, 1.0]]
