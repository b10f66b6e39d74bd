"""The stroboscopic section: the state at the end of every period of what drives a scene."""

from math import pi

import numpy as np
import pytest

from tests.engine.runs import run, same_bits
from tests.scenes import paper
from vibsim.physics.parts import BASE, GROUND, Body, Force, Harmonic, Link, Scene
from vibsim.physics.rates import common_period

ENGINES = ("c", "python")


def harmonic(amplitude, frequency):
    return Harmonic(amplitude, 2 * pi * frequency, frequency, 0.0, 0.0)


def scene(forces=(), base=(), method="auto", t_end=10.0):
    link = Link("l", 0, BASE if base else GROUND, 30.0, 10.0)
    drives = tuple(Force(f"F{i}", 0, 0.0, (term,)) for i, term in enumerate(forces))
    bodies = (Body("m", 1.0, 0.01, 0.0),)
    return Scene(bodies, (link,), forces=drives, base=base, method=method, t_end=t_end, every_den=4)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("method", ("auto", "taylor"))
def test_harmonics_of_one_force_and_the_base_share_a_period(engine, method):
    """2 and 3 Hz repeat every second, 4 and 6 Hz every half."""
    for frequencies, period in (((2.0, 3.0), 1.0), ((4.0, 6.0), 0.5), ((5.0, 5.0), 0.2)):
        forced, shaken = (harmonic(0.01, f) for f in frequencies)
        drive = scene((forced,), (shaken,), method)
        section = run(drive, engine, section=True).section
        assert section["time"] == pytest.approx(period * np.arange(1, round(10 / period) + 1), rel=1e-15)
        # what is read there is the motion; its transient exp(-5 t) is gone, the steady one repeats
        late = section["x_m"][-3:]
        assert late == pytest.approx([late[-1]] * 3, rel=1e-9)
        samples = run(drive, engine).samples
        at = np.isin(section["time"], samples["time"])
        assert same_bits(section["x_m"][at], samples["x_m"][np.isin(samples["time"], section["time"])])


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("frequencies", [(1.0, 2**0.5), (1.0, 1.0 + 1e-9), ()])
def test_no_section_without_a_common_period(engine, frequencies):
    drive = scene(tuple(harmonic(0.01, f) for f in frequencies))
    assert common_period(drive) is None
    assert len(run(drive, engine, section=True).section["time"]) == 0


def test_frequencies_of_no_exact_double_have_their_period():
    """0.1 and 0.3 Hz as double-doubles: 10 s."""
    slow = Harmonic(1.0, 0.2 * pi, 0.1, -5.551115123125783e-18, 0.0)
    fast = Harmonic(1.0, 0.6 * pi, 0.3, 1.1102230246251565e-17, 0.0)
    period = common_period(scene((fast, slow)))
    assert period.end(1) == 10.0 and period.end(7) == 70.0


@pytest.mark.parametrize("engine", ENGINES)
def test_section_of_a_run_taken_up_again(engine):
    two_blocks = paper("I-C", t_end=5.0)
    drive = two_blocks.as_parts()
    whole = run(drive, engine, section=True)
    row = {name: values[20] for name, values in whole.events.items()}
    rest = run(drive, engine, resume=row, section=True)
    later = whole.section["time"] > row["t"]
    assert 0 < later.sum() < len(later)
    for name, values in rest.section.items():
        assert same_bits(values, whole.section[name][later])
