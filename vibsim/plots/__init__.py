"""Pictures of runs, cases and sweeps. matplotlib is imported only when something is drawn.

One kind of picture per module: `vibsim.plots.registry.KINDS` names them, and `draw(subjects, view)` in the
module of that name draws one.
"""

from collections.abc import Sequence
from os import PathLike


def plot_run(
    path: str | PathLike[str],
    out: str | PathLike[str],
    kinds: Sequence[str] | None = None,
    force: bool = False,
) -> list[str]:
    """Draw one result file, as `vibsim run --plot` does; the names of the files written.

    Parameters
    ----------
    path : an HDF5 file that vibsim wrote
    out : the picture, .png, .pdf or .svg; several kinds make several files, or the pages of one PDF
    kinds : names of kinds, or None for the overview
    force : replace an existing picture

    Raises PlotError (window, kind, suffix) and ResultFileError (reading and writing).
    """
    from vibsim.plots.picture import draw_files
    from vibsim.plots.subject import View

    return draw_files([str(path)], kinds, View(), str(out), force)
