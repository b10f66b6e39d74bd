import matplotlib.pyplot as plt
import numpy as np
import pytest

from tests.plots.artists import points
from vibsim.plots.sheet import NamedQuantity, write_names


@pytest.fixture
def axes():
    figure, axes = plt.subplots(figsize=(4, 3))
    axes.set(xlim=(0, 10), ylim=(0, 10))
    yield axes
    plt.close(figure)


def boxes(axes):
    return {text.get_text(): text.get_window_extent() for text in axes.texts}


def test_names_of_curves_that_end_at_one_point_stand_apart(axes):
    x = np.array([5.0, 2.0])
    write_names(
        axes, [NamedQuantity(name, x, y * x) for name, y in (("one", 1.0), ("two", 1.0), ("three", 1.0))]
    )
    found = list(boxes(axes).values())
    assert len(found) == 3
    assert not any(a.overlaps(b) for i, a in enumerate(found) for b in found[:i])


def test_no_name_covers_a_curve(axes):
    flat = NamedQuantity("flat", np.array([1.0, 9.0]), np.array([5.0, 5.0]))
    (line,) = axes.plot(flat.x, flat.y)
    write_names(axes, [NamedQuantity("rising", np.array([5.0, 4.0]), np.array([4.9, 1.0])), flat])
    height = axes.transData.transform(np.column_stack(points(line)))[0, 1]
    for box in boxes(axes).values():
        assert box.y1 < height or box.y0 > height or box.x0 > axes.transData.transform((9.0, 5.0))[0]


def test_no_name_leaves_the_axes(axes):
    write_names(axes, [NamedQuantity("corner", np.array([9.9]), np.array([9.9]))])
    (box,) = boxes(axes).values()
    assert box.x1 < axes.bbox.x1 and box.y1 < axes.bbox.y1


def test_where_there_is_no_room_the_first_place_is_taken(axes):
    write_names(axes, [NamedQuantity("x" * 200, np.array([5.0]), np.array([5.0]))])
    (text,) = axes.texts
    assert text.get_ha() == "left" and text.get_va() == "center"
