"""What a sweep file holds, told from its plan."""

from vibsim.files.declarations import NUMBER, TEXT, WHOLE, Attribute, Column, Dataset
from vibsim.files.provenance import ENGINE, PROVENANCE
from vibsim.sweeps.plan.axis import Axis
from vibsim.sweeps.plan.members import Members
from vibsim.sweeps.plan.spread import Spread
from vibsim.sweeps.plan.sweep_plan import DIRECTION_FLAGS, Plan
from vibsim.sweeps.statistics.columns import STATUS_FLAGS

COUNTS = ("points", "points_done", "points_failed")
ATTRIBUTES = [
    *PROVENANCE,
    *(Attribute(name, TEXT) for name in ("sweep_settings_json", "sweep_sha256", "method")),
    ENGINE,
    *(Attribute(name, WHOLE) for name in COUNTS),
    Attribute("complete", WHOLE, allowed=(0, 1)),
    Attribute("wall_time_s", NUMBER),
]
DIRECTION, QUANTILE = "direction", "quantile"
FURTHER_SCALES = {
    "section": Column("1", "stroboscopic points, counted back from the last", dtype="i4"),
    "contact": Column("1", "beginnings of contact, counted back from the last", dtype="i4"),
    QUANTILE: Column("1", "share of the impacts that are not faster"),
    "multiplier": Column("1", "number of the multiplier, the largest first", dtype="i4"),
    "exponent": Column("1", "number of the exponent, the largest first", dtype="i4"),
}
STATUS = Column(None, "whether the point was computed", dtype="i1", flags=STATUS_FLAGS)
TEXTS = {
    "sha256": Column(None, "SHA-256 of the point's case", dtype="text"),
    "error": Column(None, "why a point failed", dtype="text"),
}


def datasets_of(plan: Plan) -> list[Dataset]:
    """All datasets; a column that has no room for a single number is not written."""
    return [*_scales(plan), *_drawn(plan), *_of_points(plan)]


def _scales(plan: Plan) -> list[Dataset]:
    """The scales of the axes, of the direction, and of further dimensions that are not empty."""
    way = Column(None, f"direction in which {plan.axes[0].name} was swept", dtype="i1", flags=DIRECTION_FLAGS)
    axes = [Dataset(axis.name, _values_of(axis), (axis.name,), gaps=True) for axis in plan.axes]
    further = [name for name in further_dimensions(plan) if plan.length_of(name)]
    return [
        *axes,
        Dataset(DIRECTION, way, (DIRECTION,)),
        *(Dataset(name, FURTHER_SCALES[name], (name,)) for name in further),
    ]


def _values_of(axis: Axis | Members) -> Column:
    key = {"key": axis.key}
    if isinstance(axis, Members):
        return Column(axis.unit or "1", "number of the member of the ensemble", dtype="i8", besides=key)
    return Column(axis.unit or "1", axis.key, besides=key)


def _drawn(plan: Plan) -> list[Dataset]:
    """What was drawn for each member of an ensemble, by its key."""
    drawn = [(axis, spread) for axis in plan.axes if isinstance(axis, Members) for spread in axis.spreads]
    return [
        Dataset(drawn_name(axis, spread), Column(spread.unit or "1", f"{spread.key}: {spread}"), (axis.name,))
        for axis, spread in drawn
    ]


def drawn_name(members: Members, spread: Spread) -> str:
    """Name of the dataset of what was drawn for a spread."""
    return f"{members.name}_{spread.name}"


def _of_points(plan: Plan) -> list[Dataset]:
    dims = dimensions(plan)
    numbers = [
        Dataset(name, column, (*dims, *filter(None, [column.dimension])), gaps=True)
        for name, column in plan.columns.items()
        if 0 not in plan.shape_of(name)
    ]
    texts = [Dataset(name, column, dims) for name, column in TEXTS.items()]
    return [*numbers, Dataset("status", STATUS, dims), *texts]


def dimensions(plan: Plan) -> tuple[str, ...]:
    """Names of the dimensions of a number per point."""
    return (*(axis.name for axis in plan.axes), DIRECTION)


def further_dimensions(plan: Plan) -> list[str]:
    """Names of the dimensions that only some columns have."""
    return list(dict.fromkeys(column.dimension for column in plan.columns.values() if column.dimension))


def lengths_of(plan: Plan) -> dict[str, int]:
    """Length of every dimension, by name."""
    return {
        **dict(zip(dimensions(plan), plan.shape, strict=True)),
        **{dimension: plan.length_of(dimension) for dimension in further_dimensions(plan)},
    }
