"""What a trajectory file must hold, told from the columns of its scene."""

from math import inf

from vibsim.files.declarations import (
    EXTENDED,
    LIST,
    NUMBER,
    ROWS,
    TEXT,
    WHOLE,
    Attribute,
    Column,
    Dataset,
)
from vibsim.files.provenance import ENGINE, PROVENANCE
from vibsim.results.columns import TIMES, Tables
from vibsim.results.stored.orbit_structure import ATTRIBUTES as ORBIT_ATTRIBUTES

COUNTS = ("impacts", "sticks", "reversals", "steps", "evaluations")
STRUCK = ("transmitted", "chatters", "rests")  # of scenes with rigid stops
LEFT_OUT = ("chatter_time", "chatter_speed", "chatter_distance")
NUMBERS = ("rest_distance_needed", "wall_time_s", "taylor_tolerance", "lyapunov_volume_residual")

ATTRIBUTES = [
    *PROVENANCE,
    Attribute("method", TEXT),
    ENGINE,
    Attribute("t_end_s", NUMBER),
    Attribute("complete", WHOLE, allowed=(0, 1)),
    Attribute("t_reached_s", NUMBER, optional=True, where="complete"),
    Attribute("events", WHOLE, optional=True),
    *(Attribute(name, WHOLE, optional=True, where="events") for name in COUNTS),
    *(Attribute(name, WHOLE, optional=True) for name in STRUCK),
    *(Attribute(name, NUMBER, optional=True) for name in LEFT_OUT),
    Attribute("certified", WHOLE, optional=True, allowed=(0, 1)),
    Attribute("uncertified", WHOLE, optional=True, where="certified"),
    Attribute("first_uncertified_time", NUMBER, optional=True, where="uncertified"),
    Attribute("violations", WHOLE, optional=True),
    Attribute("first_violation_time", NUMBER, optional=True, where="violations"),
    Attribute("grazing_margin", NUMBER, optional=True, where="grazing_time"),
    Attribute("grazing_time", NUMBER, optional=True, where="grazing_margin"),
    Attribute("energy_residual", NUMBER, optional=True),
    Attribute("energy_residual_relative", NUMBER, optional=True, where="energy_residual"),
    Attribute("trust_horizon_s", NUMBER, optional=True),
    Attribute("trust_tolerance_m", NUMBER, optional=True, where="trust_horizon_s"),
    Attribute("error_estimate_max", NUMBER, optional=True, where="trust_horizon_s"),
    Attribute("trust_known_to_s", NUMBER, optional=True),
    Attribute("trust_unknown_why", TEXT, optional=True, where="trust_known_to_s"),
    Attribute("clearances_needed", LIST, optional=True),
    Attribute("taylor_order", WHOLE, optional=True),
    Attribute("digits", WHOLE, optional=True),
    Attribute("number_type", TEXT, optional=True, where="digits"),
    Attribute("digits_right", WHOLE, optional=True),
    Attribute("digits_right_from", TEXT, optional=True, where="digits_right"),
    Attribute("lyapunov_growth", ROWS, optional=True),
    Attribute("lyapunov_exponents", LIST, optional=True, where="lyapunov_growth"),
    Attribute("lyapunov_rank_losses", WHOLE, optional=True, where="lyapunov_growth"),
    Attribute("lyapunov_pieces", WHOLE, optional=True, where="lyapunov_growth"),
    Attribute("lyapunov_tangencies", WHOLE, optional=True, where="lyapunov_growth"),
    Attribute("lyapunov_closest_tangency", EXTENDED, optional=True, where="lyapunov_growth"),
    Attribute("lyapunov_closest_tangency_time", NUMBER, optional=True),
    Attribute("lyapunov_undefined_time", NUMBER, optional=True),
    *(Attribute(name, NUMBER, optional=True) for name in NUMBERS),
    *ORBIT_ATTRIBUTES,
]
ROUNDED = 1 + 4 * 2.0**-52  # the last sample and the end are rounded apart
SAMPLE, EVENT = "sample", "event"


def sample_datasets(tables: Tables, t_end: float = inf) -> list[Dataset]:
    """The datasets of the sampled columns, `time` first, of a run that ends at `t_end` [s] or before."""
    return [_dataset(name, name, column, SAMPLE, t_end) for name, column in tables.samples.items()]


def event_datasets(tables: Tables, t_end: float = inf) -> list[Dataset]:
    """The datasets of the table of events."""
    return [_dataset(f"events/{name}", name, column, EVENT, t_end) for name, column in tables.events.items()]


def digit_datasets(tables: Tables) -> list[Dataset]:
    """The texts of sampled states, and those of the table of events."""
    samples, events = digit_columns(tables)
    return [
        *(Dataset(f"digits/{name}", column, (SAMPLE,)) for name, column in samples.items()),
        *(Dataset(f"digits/events/{name}", column, (EVENT,)) for name, column in events.items()),
    ]


def digit_columns(tables: Tables) -> tuple[dict[str, Column], dict[str, Column]]:
    """What the texts of sampled states, and those of the table of events, are, by name."""
    return (
        {name: _written_out(tables.samples[name]) for name in tables.states},
        {name: _written_out(tables.events[name]) for name in ("t", *tables.states)},
    )


def _written_out(column: Column) -> Column:
    return Column(column.units, f"{column.long_name}, decimal digits", dtype="S")


def _dataset(path: str, name: str, column: Column, dimension: str, t_end: float) -> Dataset:
    if name in TIMES:
        return Dataset(path, column, (dimension,), ascending=True, span=(0.0, t_end * ROUNDED))
    return Dataset(path, column, (dimension,))
