"""The drawing of a scene: bodies, springs, dampers, stops, frictions and what drives them, as a schematic."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from vibsim.cases import Case


def draw_machine_file(case: Case, out: str, force: bool = False) -> str:
    """Draw the machine of a case of either form into a picture, .png, .pdf or .svg; returns its name.

    Raises PlotError for another format and ResultFileError where the file exists (unless `force`) or cannot
    be written.
    """
    from vibsim.plots import style
    from vibsim.plots.machine.drawing import machine_figure
    from vibsim.plots.picture import write_figure

    with style.applied():
        write_figure(machine_figure(case.long_values()), out, force)
    return out
