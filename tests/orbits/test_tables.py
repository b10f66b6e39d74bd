"""An orbit as a table, and as a picture."""

import matplotlib
import numpy as np
import pytest

import vibsim
from tests.branches.made import RESONANT, orbit_of

matplotlib.use("agg")


@pytest.fixture(scope="module")
def orbit():
    return orbit_of(RESONANT)


def test_a_frame_is_one_period_on_it(orbit):
    frame = orbit.to_dataframe()
    assert frame.index.name == "time" and frame.index[-1] <= orbit.period
    assert orbit.run.t_reached == pytest.approx(orbit.period, rel=1e-15)
    assert frame["x1"].to_numpy().tobytes() == orbit.run["x1"].tobytes()
    assert orbit.to_xarray()["v1"].attrs["units"] == "m s-1"
    assert len(vibsim.analyse(orbit.run).regime.multipliers) == len(orbit.multipliers)
    end, start = orbit.run.at(orbit.period), orbit.run.at(0.0)
    assert abs(end["v1"] - start["v1"]) < 1e-9 * np.ptp(orbit.run["v1"])


def test_it_shows_itself(orbit):
    text = repr(orbit)
    assert text.startswith("<Orbit of I-C: period 0.15384") and "stable" in text and "multipliers" in text
    assert "multipliers" in orbit._repr_html_()


def test_a_picture_of_it(orbit):
    import matplotlib.pyplot as pyplot

    _, axes = pyplot.subplots()
    assert orbit.plot("relative", ax=axes) is axes and axes.lines
    assert vibsim.plot([orbit, orbit.run], "relative", ax=axes) is axes
    assert len(orbit.plot()) == 2 and orbit.plot()[1].get_xlabel() == "Real part of the multipliers"
    pyplot.close("all")
