"""What a sweep stores per point: names, units, definitions. The definitions go into every file."""

from dataclasses import dataclass

from vibsim.files import declarations as files
from vibsim.physics.two_blocks import TwoBlocks

MISSING, DONE, FAILED = 0, 1, 2
STATUS_FLAGS = {"missing": MISSING, "done": DONE, "failed": FAILED}


@dataclass(frozen=True)
class Column(files.Column):
    """A number per point, or one along a further dimension.

    Attributes
    ----------
    needs : what the scene must have, of "motor", "source", "block2", "stop" and "friction"
    dimension : name of the further dimension, such as "section"; empty for a number per point
    """

    needs: str = ""
    dimension: str = ""


_HALF = "half the peak-to-peak of {} in one excitation period, {} over the whole periods after the transient"
_MEAN, _MAX = "mean", "greatest"
RELATIVE = "x1 - x2 (x1 where block 2 is fixed)"

STATISTICS = {
    "mean_speed": Column("Hz", "mean motor speed over the whole periods after the transient", "motor"),
    "min_speed": Column("Hz", "least motor speed after the transient", "motor"),
    "max_speed": Column("Hz", "greatest motor speed after the transient", "motor"),
    "amplitude_x1": Column("m", _HALF.format("x1", _MEAN)),
    "amplitude_x1_max": Column("m", _HALF.format("x1", _MAX)),
    "amplitude_x2": Column("m", _HALF.format("x2", _MEAN), "block2"),
    "amplitude_x2_max": Column("m", _HALF.format("x2", _MAX), "block2"),
    "amplitude_relative": Column("m", _HALF.format("x1 - x2", _MEAN), "block2"),
    "amplitude_relative_max": Column("m", _HALF.format("x1 - x2", _MAX), "block2"),
    "relative_min": Column("m", f"least {RELATIVE} after the transient"),
    "relative_max": Column("m", f"greatest {RELATIVE} after the transient: the rest distance needed"),
    "drift_rate": Column(
        "m s-1",
        "slope of the least-squares line through x2 at the stroboscopic points after the transient",
        "block2",
    ),
    "impacts_per_period": Column(
        "1", "beginnings of contact per excitation period after the transient", "stop"
    ),
    "sticks_per_period": Column(
        "1", "beginnings of stick per excitation period after the transient", "friction"
    ),
    "periods": Column(
        "1", "whole excitation periods after the transient, from which the statistics are taken"
    ),
}
TOTALS = {
    "impacts": Column("1", "beginnings of contact in the whole run", "stop"),
    "sticks": Column("1", "beginnings of stick in the whole run", "friction"),
    "events": Column("1", "events in the whole run"),
    "grazing_margin": Column("m", "smallest gap at a turn without contact in the whole run", "stop"),
    "t_reached": Column("s", "time that the run reached"),
    "wall_time": Column("s", "time that the point took to compute, waiting included"),
}
_END = (
    "{} where a carried sweep goes on: at the end of the run, with a harmonic source at its last whole period"
)
END_STATE = {
    "end_x1": Column("m", _END.format("x1")),
    "end_v1": Column("m s-1", _END.format("v1")),
    "end_x2": Column("m", _END.format("x2"), "block2"),
    "end_v2": Column("m s-1", _END.format("v2"), "block2"),
    "end_phi": Column("rad", _END.format("rotor angle, reduced to one turn,"), "motor"),
    "end_phidot": Column("rad s-1", _END.format("rotor speed"), "motor"),
}
SECTION = {
    "section_displacement": Column("m", f"{RELATIVE} at the last stroboscopic points", "", "section"),
    "section_velocity": Column(
        "m s-1", "v1 - v2 (v1 where block 2 is fixed) at the last stroboscopic points", "", "section"
    ),
    "section_speed": Column("Hz", "motor speed at the last stroboscopic points", "motor", "section"),
}
ALWAYS = {**STATISTICS, **TOTALS, **END_STATE, **SECTION}
NOT_REPRODUCIBLE = ("wall_time",)

DEFINITIONS = (
    "An excitation period runs from one stroboscopic point to the next: t = k/f of a harmonic source, phi "
    "= 2 pi k passed forwards of a motor. Only whole periods between the transient and the end count. "
    "Amplitudes are half the peak-to-peak within one period, so that a drift does not add up; without "
    "periods they are half the peak-to-peak of the whole time after the transient, and what is counted "
    "per period is NaN. Extremes between stored rows are those of the interpolating polynomial. The mean "
    "speed is whole turns over their time. Stroboscopic points are counted back from the last."
)


def columns_of(scene: TwoBlocks, table: dict[str, Column]) -> dict[str, Column]:
    """Those columns that a sweep of this scene has."""
    has = {
        "motor": scene.has_motor,
        "source": scene.source != "none",
        "block2": scene.has_block2,
        "stop": scene.has_stop,
        "friction": scene.has_block2,  # mu may be swept through 0
    }
    return {name: column for name, column in table.items() if all(has[need] for need in column.needs.split())}
