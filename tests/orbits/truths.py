"""Ten orbits of the paper's machine, known to 22 digits, as scenes and numbers."""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tests.scenes import harmonic, motor, scene

STORED = json.loads(Path(__file__).with_name("truths.json").read_text())["orbits"]


@dataclass(frozen=True)
class Truth:
    """state : by column, x2 = 0; unknowns : y, v1, v2 and phidot with a motor"""

    name: str
    n: int
    scene: object
    period: float
    state: dict
    unknowns: np.ndarray
    multipliers: list
    word: str


def truth(stored):
    numbers = {name: float(value) for name, value in stored["state"].items()}
    rates = {name: numbers[name] for name in ("v1", "v2", "phidot") if name in numbers}
    return Truth(
        stored["name"],
        stored["n"],
        scene_of(stored).as_parts(),
        float(stored["period"]),
        {"x1": numbers["y"], "x2": 0.0, **rates},
        np.array([numbers["y"], *rates.values()]),
        [complex(float(re), float(im)) for re, im in stored["multipliers"]],
        stored["sequence"],
    )


def scene_of(stored):
    values = stored["parameters"]
    if "A" in values:
        return scene(harmonic(float(stored["free_parameter"]["f"]), float(values["A"])))
    source = motor(5.0) | {"Omega0": float(values["Om0"])}
    return scene(source, c=float(values["c"]))


TRUTHS = {stored["name"]: truth(stored) for stored in STORED}


def landing(return_map, X, T):
    """Where the motion from X meets the section, near the time T."""
    for _ in range(5):
        end = return_map(X, T)
        if end.tilt is None:
            return end.image
        T -= end.ahead / end.tilt[1]
    return end.image
