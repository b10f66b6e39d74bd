"""The picture of a stored orbit."""

import numpy as np
import pytest

import vibsim
from tests.plots.artists import clipped_texts, letters, lines, points
from vibsim.orbits.orbit import save_orbit
from vibsim.plots import style
from vibsim.plots.portraits import POINTS, orbit_portrait_picture
from vibsim.plots.registry import choose, kind_named
from vibsim.plots.samples import last_half
from vibsim.plots.subject import PlotError, View, open_subject


@pytest.fixture(scope="module")
def stored(tmp_path_factory):
    path = tmp_path_factory.mktemp("orbits") / "orbit.h5"
    orbit = vibsim.orbit("I-A")
    save_orbit(orbit, path)
    return orbit, open_subject(str(path))


@pytest.mark.parametrize("width", ["column", "page"])
def test_what_is_drawn(stored, width):
    orbit, subject = stored
    with style.applied():
        figure = orbit_portrait_picture([subject], View(width=width))
        figure.draw_without_rendering()
    assert letters(figure) == ["(a)", "(b)"] and clipped_texts(figure) == []
    (curve,) = lines(figure, "orbit")
    y, u = points(curve)  # in mm and mm/s
    assert len(y) >= POINTS and abs(y[0] - y[-1]) < 1e-9 and abs(u[0] - u[-1]) < 1e-8  # it closes
    (returns,) = lines(figure, "section")
    np.testing.assert_allclose(points(returns)[0], 1e3 * orbit.points[:, 0], rtol=0, atol=1e-9)
    (impacts,) = lines(figure, "impacts")
    np.testing.assert_allclose(points(impacts)[0], -1.0, rtol=1e-9)
    assert len(points(impacts)[0]) == 3
    inside, outside = lines(figure, "multipliers")
    shown = [complex(*pair) for pair in zip(*points(inside), strict=True)]
    np.testing.assert_array_equal(np.sort_complex(shown), np.sort_complex(orbit.multipliers))
    assert len(points(outside)[0]) == 0
    first, second = (axes.get_position() for axes in figure.axes)
    assert first.width > 0.4 and second.height > 0.2


def test_it_is_what_an_orbit_is_drawn_as(stored, tmp_path):
    _, subject = stored
    assert [kind.name for kind in choose(None, [subject])] == ["orbit-portrait"]
    assert "overview" in {kind.name for kind in choose(["all"], [subject])}
    run = vibsim.simulate(vibsim.load_case("I-A", {"run.t_end": "1 s"}))
    run.save(tmp_path / "run.h5")
    with pytest.raises(PlotError, match="it needs a periodic orbit"):
        choose(["orbit-portrait"], [open_subject(str(tmp_path / "run.h5"))])


def test_the_settled_part_of_an_orbit_is_all_of_it(stored):
    """Not its last half: that is no period."""
    _, subject = stored
    figure = kind_named("impact-velocity").draw([subject], View(width="column"))
    assert [len(points(line)[0]) for line in lines(figure, "impacts")] == [3, 3]  # over time, over phase
    assert last_half(subject, (0.0, 1.0)) == (0.0, 1.0)
