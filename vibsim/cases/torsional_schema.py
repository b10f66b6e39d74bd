"""The long form of a torsional scene: bodies turn, x is an angle [rad], forces are torques [N m].

The same sections and keys as those of bodies on a line, with other dimensions at their values.
"""

import types
from functools import cache
from typing import Annotated, Any, get_args, get_origin

from vibsim.cases.any_unit import INERTIA, PURE, RATE, TIME, TORQUE, Dimension, any_quantity, called, product
from vibsim.cases.part_schema import PartsFile
from vibsim.cases.problems import shown
from vibsim.cases.quantities import Quantity, QuantityError
from vibsim.cases.schema import CaseHead, Key, Section
from vibsim.cases.schema_kinds import Formula, Measured

TURNED = {
    "mass": "inertia",
    "length": "angle",
    "velocity": "angular rate",
    "inverse velocity": "inverse angular rate",
    "force": "torque",
    "stiffness": "torsional stiffness",
    "damping": "torsional damping",
}
UNITS: dict[str, tuple[str, str, Dimension]] = {  # SI unit, units in messages, dimension
    "inertia": ("kg m^2", "kg m^2, g m^2 or kg cm^2", INERTIA),
    "angle": ("rad", "rad, mrad, deg or turn", PURE),
    "angular rate": ("", "Hz, rpm, deg/s or rad/s", RATE),
    "inverse angular rate": ("s/rad", "s/rad", TIME),
    "torque": ("N m", "N m, mN m or kN m", TORQUE),
    "torsional stiffness": ("N m/rad", "N m/rad, kN m/rad or N m/deg", TORQUE),
    "torsional damping": ("N m s/rad", "N m s/rad or mN m s/rad", product(TORQUE, TIME)),
}
TEXTS = {
    "0 N/m": "0 N m/rad",
    "0 N s/m": "0 N m s/rad",
    "0 m/s": "0 rad/s",
    "0 N": "0 N m",
    "1e-6 m": "1e-6 rad",
    "1 um": "1e-6 rad",
    "1 mm": "1 mrad",
    "2 kg": "0.3 kg m^2",
    "{ram: 2 kg}": "{disc: 0.3 kg m^2}",
    "4 kN/m": "4 kN m/rad",
    "1 MN/m": "1 MN m/rad",
    "2 N s/m": "2 N m s/rad",
    "10 N": "10 N m",
    "3 N": "3 N m",
}  # defaults and examples
UNCHANGED = ("rotors", "motor")  # which no torsional scene has


def turning_quantity(measured: Measured, text: str) -> Quantity | Formula:
    """A quantity of a torsional scene, in any unit of its dimension, or a formula. Raises QuantityError."""
    si, units, dimension = UNITS[measured.dimension]
    article = "an" if measured.dimension[0] in "aei" else "a"
    allowed = f"must be {article} {measured.dimension} in {units}"
    try:
        quantity, own = any_quantity(text)
        if not quantity.text.partition(" ")[2] and (si or quantity.value == 0):
            quantity, own = any_quantity(f"{quantity.text} {si or 'rad/s'}")
    except QuantityError as error:
        from vibsim.cases.formula_keys import is_formula

        if measured.formula and is_formula(text):
            return Formula(text)
        raise QuantityError(f"{allowed}, got {shown(text)}; {error}") from None
    if own != dimension:
        why = " in a scene of bodies that turn" if own != PURE else ""
        raise QuantityError(f"{allowed}{why}, got {shown(text)}, which is {called(own)}")
    broken = measured.broken_bound(quantity.value)
    if broken:
        raise QuantityError(f"must be {broken}, got {shown(text)}")
    return quantity


@cache
def turning_file() -> type[CaseHead]:
    """The outermost section of a torsional scene."""
    turned: type[CaseHead] = _turned_section(PartsFile)
    return turned


def _turned_section(section: Any) -> Any:
    """The section with the dimensions of turning bodies."""
    turned: Any = type(section.__name__, (section,), {"__doc__": section.__doc__, "__annotations__": {}})
    turned.keys = {name: key if name in UNCHANGED else _turned_key(key) for name, key in section.keys.items()}
    return turned


def _turned_key(key: Key) -> Key:
    default = TEXTS.get(key.default, key.default) if isinstance(key.default, str) else key.default
    examples = [TEXTS.get(example, example) for example in key.examples]
    return Key(_turned(key.annotation), default, key.description, examples)


def _turned(annotation: Any) -> Any:
    """An annotation with other dimensions in it; the rule of an amplitude, m3 e omega^2, is left out."""
    if isinstance(annotation, type) and get_origin(annotation) is None:
        return _turned_section(annotation) if issubclass(annotation, Section) else annotation
    if get_origin(annotation) is Annotated:
        inner, *notes = get_args(annotation)
        measured = next((note for note in notes if isinstance(note, Measured)), None)
        if measured is not None:
            dimension = TURNED.get(measured.dimension, measured.dimension)
            if dimension not in UNITS:
                return annotation
            return Annotated[inner, measured._replace(dimension=dimension, alternative="", turning=True)]
        variants = [one for one in get_args(inner) if _measure_in(one) is not None]
        if variants:
            return _turned(variants[-1])
        return annotation
    if get_origin(annotation) is dict:
        key, value = get_args(annotation)
        return types.GenericAlias(dict, (key, _turned(value)))
    arguments = [one for one in get_args(annotation) if one is not type(None)]
    if len(arguments) == 1 and len(get_args(annotation)) == 2:
        return _turned(arguments[0]) | None
    return annotation


def _measure_in(annotation: Any) -> Measured | None:
    notes = getattr(annotation, "__metadata__", ())
    return next((note for note in notes if isinstance(note, Measured)), None)
