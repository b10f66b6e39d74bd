"""Runs of scenes made of parts with tangent bundles, and in many digits."""

from dataclasses import fields, is_dataclass, replace

from vibsim.engine.driver import Driver
from vibsim.engine.tangent.tangent_space import dimension
from vibsim.engine.trajectory import open_trajectory
from vibsim.physics.parts import Harmonic

PER_PIECE = 400 * 2.0**-53  # of the volume: cut-off 1.65**20 / 20! = 9e-15, rounding of the vectors


def totals(scene, count=None, begin=0.0, engine="auto"):
    """Totals of the run of `scene` with `count` exponents (None: all) from the time `begin` [s]."""
    count = dimension(scene) if count is None else count
    trajectory = open_trajectory(scene, engine, tangent=count, tangent_from=begin)
    for _ in trajectory.blocks():
        pass
    return trajectory.totals


def exact(value, kit):
    """A scene, or a part of one, in numbers of the kit."""
    if isinstance(value, float):
        return kit.number(value)
    if isinstance(value, tuple):
        return tuple(exact(one, kit) for one in value)
    if isinstance(value, Harmonic):  # both as doubles would be of two frequencies
        cycles = kit.number(value.cycles) + value.cycles_lo
        amplitude, phase = kit.number(value.amplitude), kit.number(value.phase)
        return Harmonic(amplitude, kit.exact(2 * kit.pi * cycles), cycles, kit.number(0), phase)
    if is_dataclass(value):
        return replace(value, **{f.name: exact(getattr(value, f.name), kit) for f in fields(value)})
    return value


def in_digits(scene, kit):
    """The scene in numbers of the kit, without samples."""
    return replace(exact(scene, kit), tol=scene.tol, every_num=1000, every_den=1)


def started(scene, shift):
    """The scene with its start shifted by (dx, dv, dphi, dw)."""
    n, motor = len(scene.bodies), scene.motor
    bodies = tuple(replace(b, x=b.x + shift[i], v=b.v + shift[n + i]) for i, b in enumerate(scene.bodies))
    if motor is not None:
        motor = replace(motor, phi=motor.phi + shift[-2], phidot=motor.phidot + shift[-1])
    return replace(scene, bodies=bodies, motor=motor)


def finished(scene, kit, disturbance=None):
    """The driver at the end of a run, which may carry one disturbance along."""
    driver = Driver(scene, kit, tangent=(int(disturbance is not None), 0.0))
    if disturbance is not None:
        driver.tangent.vectors = [disturbance]
    while not driver.finished:
        driver.run(10**6)
    return driver


def course(driver):
    """What happened, without the times."""
    return [(kind, part, status) for kind, part, _, status, *_ in driver.events]
