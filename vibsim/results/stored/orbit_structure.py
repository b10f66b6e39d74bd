"""What the file of a periodic orbit holds besides a run of one period: the group `orbit`, and attributes."""

from vibsim.files.declarations import EXTENDED, NUMBER, TEXT, WHOLE, Attribute, Column, Dataset

GROUP = "orbit"
ATTRIBUTES = [
    Attribute("orbit_periods", WHOLE, optional=True),
    Attribute("orbit_period_s", NUMBER, optional=True, where="orbit_periods"),
    Attribute("orbit_stable", WHOLE, optional=True, where="orbit_periods", allowed=(0, 1)),
    Attribute("orbit_events", TEXT, optional=True, where="orbit_periods"),
    Attribute("orbit_residual", NUMBER, optional=True, where="orbit_periods"),
    Attribute("orbit_sliding_margin", EXTENDED, optional=True, where="orbit_periods"),
    Attribute("orbit_digits", WHOLE, optional=True),
]
UNKNOWN, MULTIPLIER, RETURN = ("unknown",), ("multiplier",), ("return",)
DATASETS = [
    Dataset(f"{GROUP}/unknown", Column(None, "name of the unknown on the section", dtype="text"), UNKNOWN),
    Dataset(f"{GROUP}/units", Column(None, "unit of the unknown", dtype="text"), UNKNOWN),
    Dataset(f"{GROUP}/multiplier", Column("1", "number of the multiplier", dtype="i4"), MULTIPLIER),
    Dataset(f"{GROUP}/multiplier_real", Column("1", "real part of the Floquet multiplier"), MULTIPLIER),
    Dataset(f"{GROUP}/multiplier_imaginary", Column("1", "imaginary part of it"), MULTIPLIER),
    Dataset(f"{GROUP}/return", Column("1", "number of the return to the section", dtype="i4"), RETURN),
    Dataset(f"{GROUP}/points", Column(None, "unknowns at the returns"), (*RETURN, *UNKNOWN)),
    Dataset(f"{GROUP}/derivative", Column(None, "derivative of the return map"), (*UNKNOWN, *UNKNOWN)),
]
DIGITS = [
    Dataset(
        f"{GROUP}/digits_start", Column(None, "unknowns at the start, decimal digits", dtype="S"), UNKNOWN
    ),
    Dataset(f"{GROUP}/digits_real", Column(None, "real part, decimal digits", dtype="S"), MULTIPLIER),
    Dataset(
        f"{GROUP}/digits_imaginary", Column(None, "imaginary part, decimal digits", dtype="S"), MULTIPLIER
    ),
]


def orbit_datasets(group: object) -> list[Dataset]:
    """The datasets of a group `orbit`, by what is in it."""
    return DATASETS + (DIGITS if "digits_start" in group else [])  # type: ignore[operator]
