"""Motions that others published, by numbers that vibsim did not make."""

from math import pi

import numpy as np
import pytest

from tests.engine.runs import run
from vibsim.physics.parts import (
    AT_GAP,
    COMPRESSION,
    GROUND,
    Body,
    Force,
    Friction,
    Harmonic,
    Link,
    Scene,
    Stop,
)


def oscillator(omega, amplitude, damping, t_end, **parts):
    """x'' + damping x' + x = amplitude cos(omega t) - ..., from rest."""
    cosine = Harmonic(amplitude, omega, omega / (2 * pi), 0.0, pi / 2)
    return Scene(
        (Body("m", 1.0, 0.0, 0.0),),
        links=(Link("l", 0, GROUND, 1.0, damping),),
        forces=(Force("drive", 0, 0.0, (cosine,)),),
        t_end=t_end,
        every_num=1,
        every_den=10,
        **parts,
    )


def test_bilinear_oscillator_impacts_once_in_two_periods():
    """x'' + 0.02 x' + x + 29 max(x - 1, 0) = f cos(0.8 t), f = 0.9 0.64 / 1.26: the bilinear demo of
    PWSDDE-cont.

    Velocities at which the stable orbit enters and leaves contact, by an independent solver.
    """
    stop = Stop("spring", 0, GROUND, 1.0, COMPRESSION, 29.0, 0.0, AT_GAP)
    period = 2 * pi / 0.8
    result = run(oscillator(0.8, 0.9 * 0.64 / 1.26, 0.02, 400 * period, stops=(stop,)))
    kinds, v, t = (result.events[name] for name in ("kind", "v_m", "t"))
    begins = kinds == 1
    assert v[begins][-3:] == pytest.approx([1.073267857664968] * 3, abs=1e-11)
    assert v[kinds == 2][-3:] == pytest.approx([-1.067358714677524] * 3, abs=1e-11)
    assert np.diff(t[begins])[-3:] == pytest.approx([2 * period] * 3, rel=1e-12)


@pytest.mark.parametrize(("amplitude", "impacts"), ((0.36035538014, False), (0.36035538015, True)))
def test_bilinear_oscillator_grazes_at_the_amplitude_of_linear_theory(amplitude, impacts):
    """The orbit without impacts touches x = 1 at f = sqrt((1 - 0.64)^2 + 0.016^2) = 0.3603553801457667.

    Started on that orbit, a hair below it never meets the stop and a hair above does.
    """
    stop = Stop("spring", 0, GROUND, 1.0, COMPRESSION, 29.0, 0.0, AT_GAP)
    scene = oscillator(0.8, amplitude, 0.02, 200.0, stops=(stop,))
    response = amplitude / complex(1 - 0.64, 0.016)
    start = Body("m", 1.0, response.real, -0.8 * response.imag)
    result = run(Scene(**{**vars(scene), "bodies": (start,)}))
    assert (result.totals["impacts"] > 0) == impacts


def test_friction_oscillator_slides_through():
    """x'' + 0.1 x' + x = 1.5 cos(0.9 t) - sgn(x'): the symmetric orbit without sticking of PWSDDE-cont's
    friction demo has the amplitude 2.42023635057437 (independent solver).
    """
    friction = Friction("f", 0, GROUND, 1.0, 1.0, 0.0)
    result = run(oscillator(0.9, 1.5, 0.1, 100 * 2 * pi / 0.9, frictions=(friction,)))
    turns = result.events["kind"] == 3
    assert abs(result.events["x_m"][turns][-1]) == pytest.approx(2.42023635057437, abs=1e-11)
    sticks = result.events["t"][result.events["kind"] == 4]
    assert sticks.max() < 20 * 2 * pi / 0.9  # in the transient only
