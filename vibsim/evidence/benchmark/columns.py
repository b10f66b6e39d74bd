"""The columns of a bench file: what each row of it holds."""

from dataclasses import dataclass

from vibsim.evidence.benchmark.scoring import FAITHFUL


@dataclass(frozen=True)
class Column:
    """HDF5 type, UDUNITS unit and meaning of one number per row; missing : value that stands for none."""

    dtype: str
    units: str
    long_name: str
    missing: int | None = None


ROW = {
    "wall_time": Column("f8", "s", "wall time of a run, median"),
    "cpu_time": Column("f8", "s", "CPU time of a run, median"),
    "setup_time": Column("f8", "s", "wall time before the first run, such as compiling"),
    "runs": Column("i4", "1", "runs of which the median is taken"),
    "steps": Column("i8", "1", "steps of a run", -1),
    "evaluations": Column("i8", "1", "right-hand sides evaluated in a run", -1),
    "t_reached": Column("f8", "s", "time of the motion until which the method ran"),
    "faithful_time": Column(
        "f8", "s", f"time until which the error of the displacements is within {FAITHFUL:g} m"
    ),
}
TEXTS = {
    "method": "family of methods",
    "label": "family of methods in words",
    "setting": "setting of the method",
    "problem": "why the method failed",
}
COUNTS = {
    "found": "true events found, up to faithful_time",
    "missed": "true events missed, up to faithful_time",
    "spurious": "events reported that are not, up to faithful_time",
}
