"""What every kind of result can do: show itself, and be handed on as xarray Dataset or pandas DataFrame."""

from collections.abc import Iterable
from typing import Any

from vibsim.labelled.arrays import Arrays
from vibsim.labelled.shown import Shown
from vibsim.lazy_names import FRONT, named

LISTED = 10  # names of columns that are listed


def few(names: Iterable[str]) -> str:
    """The first names, and how many more there are."""
    first = list(names)
    more = len(first) - LISTED
    return ", ".join(first[:LISTED]) + (f" and {more} more" if more > 0 else "")


class Labelled(Shown):
    """A result made of labelled arrays.

    A kind of result says three things: `arrays()`, `heading()` and `lines()`; the rest follows.

    >>> import vibsim
    >>> isinstance(vibsim.simulate("I-A", overrides={"run.t_end": "2 s"}), vibsim.Labelled)
    True
    """

    def arrays(self) -> Arrays:
        """Its arrays, with dimensions, units and attributes."""
        raise NotImplementedError

    def to_xarray(self) -> Any:
        """The result as an xarray Dataset: dimensions, coordinates, units and attributes as in the file.

        Raises MissingExtra (an ImportError) where xarray is not installed.

        >>> import vibsim
        >>> result = vibsim.simulate(vibsim.load_case("II-B", {"run.t_end": "2 s"}))
        >>> data = result.to_xarray()
        >>> data["x1"].dims, data["x1"].attrs["units"]
        (('time',), 'm')
        """
        from vibsim.labelled.xarray_dataset import dataset_of

        return dataset_of(self.arrays())

    def to_dataframe(self, along: str = "") -> Any:
        """The result as a pandas DataFrame, one row per point, codes as words; units in `attrs["units"]`.

        along : name of a dimension that only some arrays have, such as "section" of a sweep: the table holds
            these, with a row for each position along it

        Raises MissingExtra (an ImportError) where pandas is not installed, and ValueError for a dimension
        that there is not.

        >>> import vibsim
        >>> case = vibsim.load_case("II-B", {"run.t_end": "2 s"})
        >>> sweep = vibsim.sweep(case, {"c": [0.01, 0.02]}, section=3, jobs=1)
        >>> list(sweep.to_dataframe().index.names)
        ['c', 'direction']
        >>> len(sweep.to_dataframe("section"))
        6
        """
        from vibsim.labelled.dataframe import dataframe_of

        return dataframe_of(self.arrays(), along)

    def plot(self, kind: str | None = None, **how: Any) -> Any:
        """Draw the result and return the matplotlib axes: those of its one panel, or a list of several.

        Everything that `vibsim.plot` takes, by name: `ax`, `window`, `detail`, `style`, `size` and so on.

        >>> import vibsim
        >>> result = vibsim.simulate(vibsim.load_case("II-B", {"run.t_end": "2 s"}))
        >>> axes = result.plot(kind="relative", window=(1, 2))
        >>> axes.get_xlabel()
        'Relative displacement $x_1 - x_2$ (µm)'
        """
        return named(FRONT["plot"])(self, kind, **how)

    def _repr_html_(self) -> str:
        from vibsim.labelled.html import html_of

        return html_of(f"{type(self).__name__} {self.heading()}", self.lines(), self.arrays())
