"""What a sweep file must hold, told from its plan."""

from vibsim.results.structure import NUMBER, TEXT, WHOLE, Attribute, Dataset
from vibsim.results.trajectory_structure import PROVENANCE
from vibsim.sweeps.plan.sweep_plan import Plan
from vibsim.sweeps.statistics.columns import STATUS_FLAGS

COUNTS = ("points", "points_done", "points_failed")
ATTRIBUTES = [
    *PROVENANCE,
    *(Attribute(name, TEXT) for name in ("sweep_settings_json", "sweep_sha256", "method", "engine")),
    *(Attribute(name, WHOLE) for name in COUNTS),
    Attribute("complete", WHOLE, allowed=(0, 1)),
    Attribute("wall_time_s", NUMBER),
]


def datasets_of(plan: Plan) -> list[Dataset]:
    """The datasets of the points; a column that has no room for a single number is not written."""
    dims = dimensions(plan)
    numbers = [
        Dataset(name, "f8", (*dims, *filter(None, [column.dimension])), missing=True)
        for name, column in plan.columns.items()
        if 0 not in plan.shape_of(name)
    ]
    status = Dataset("status", "i1", dims, frozenset(STATUS_FLAGS.values()))
    return [*numbers, status, Dataset("sha256", "text", dims), Dataset("error", "text", dims)]


def dimensions(plan: Plan) -> tuple[str, ...]:
    """Names of the dimensions of a number per point."""
    return (*(axis.name for axis in plan.axes), "direction")


def scales_of(plan: Plan) -> list[Dataset]:
    """The scales of those dimensions."""
    types = [*("f8" if axis.numbers().dtype.kind == "f" else "i8" for axis in plan.axes), "i1"]
    return [Dataset(name, dtype, (name,)) for name, dtype in zip(dimensions(plan), types, strict=True)]


def lengths_of(plan: Plan) -> dict[str, int]:
    """Length of every dimension, by name."""
    further = {column.dimension for column in plan.columns.values() if column.dimension}
    return {
        **dict(zip(dimensions(plan), plan.shape, strict=True)),
        **{dimension: plan.length_of(dimension) for dimension in further},
    }
