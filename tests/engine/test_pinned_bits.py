"""Random scenes of all parts, laws and requests have the bits that they have ever had.

`pinned_bits.txt` holds a line for each family and ten seeds: the beginnings of the SHA-256 of all columns and
totals that come of each. They were those of two engines, one in C and one in Python, that shared no code.
Where a number must move, `python -m tests.engine.test_pinned_bits` writes the file anew; CHANGELOG says why.
"""

import hashlib
import zlib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.engine import runs
from tests.engine.random_formulas import formula_scene
from tests.engine.random_parts import belted_scene, kinked_scene, part_scene, rigid_scene
from tests.random_scenes import Draws, two_blocks
from tests.scenes import paper
from vibsim.engine.errors import EngineError
from vibsim.engine.tangent.monodromy import Carrier
from vibsim.engine.tangent.tangent_space import dimension
from vibsim.engine.trajectory import open_trajectory
from vibsim.physics.parts import GROUND

FILE = Path(__file__).with_name("pinned_bits.txt")
SEEDS, PER_LINE, DIGITS = 40, 10, 12
MOST = 400  # events of a run; what comes behind them is left out, and the totals
SETTINGS = ((20, 2.0**-53), (12, 1e-9), (30, 2.0**-53), (8, 1e-6), (40, 1e-20))  # order, tolerance
LEDGERS = {"section": True, "ledger": True, "momentum": True}


# What comes of a scene: columns by name.


def run(scene, **options):
    """Samples, events, section and totals of a run."""
    try:
        found = runs.run(scene, most=MOST, **options)
    except EngineError as error:
        return ended(error)
    tables = {"samples": found.samples, "events": found.events, "section": found.section}
    if len(found.events["t"]) >= MOST:  # where a block ends is a matter of the clock
        last = found.events["t"][MOST - 1]
        tables["events"] = {name: column[:MOST] for name, column in found.events.items()}
        for name in ("samples", "section"):
            before = tables[name]["time"] < last
            tables[name] = {column: values[before] for column, values in tables[name].items()}
    else:
        tables["totals"] = found.totals
    return {
        f"{table}/{name}": column for table, columns in tables.items() for name, column in columns.items()
    }


def ended(error):
    """Where and why a run failed."""
    state = error.state
    return {"reason": error.reason.encode(), "state": [state.t, *state.x, *state.v, state.phase, state.w]}


def grown(scene, count=None):
    """A run with `count` exponents, or all."""
    return run(scene, ledger=True, tangent=min(count or 99, dimension(scene)))


def carried(scene):
    """The motion, all unit disturbances of its start, and what happened on the way."""
    rotor = (scene.motor.phi, scene.motor.phidot) if scene.motor is not None else ()
    start = [*(body.x for body in scene.bodies), *(body.v for body in scene.bodies), *rotor]
    try:
        end = Carrier(scene).carry(start, scene.t_end)
    except EngineError as error:
        return ended(error)
    numbers = {"margin": end.margin, "undefined_at": end.undefined_at, "uncertified": end.uncertified}
    columns = ("state", "rate", "vectors", "happened", "table")
    return numbers | {name: getattr(end, name) for name in columns}


def extreme(scene):
    """Extremes of all bodies against the ground by period, and of all."""
    pairs = [(i, GROUND) for i in range(len(scene.line))]
    pairs += [(stop.P, stop.Q) for stop in scene.stops if GROUND not in (stop.P, stop.Q)]
    trajectory = open_trajectory(scene, section=True, extremes=(pairs, scene.t_end / 3))
    try:
        rows = np.concatenate([block.extremes for block in trajectory.blocks()], axis=1)
    except EngineError as error:
        return ended(error)
    return {"by period": rows} | dict(zip(("least", "greatest", "gaps"), trajectory.extremes, strict=True))


def resumed(scene):
    """What follows an event in the midst of a run, and states behind it."""
    found = run(scene)
    if "reason" in found:
        return found
    t = found["events/t"]
    row = {name[7:]: column[len(t) // 2] for name, column in found.items() if name.startswith("events/")}
    if row["t"] >= scene.t_end:
        return found
    times = np.linspace(row["t"], min(scene.t_end, t[-1]), 7)[:-1].tolist()
    return run(scene, resume=row) | open_trajectory(scene, resume=row).state_at(times)


# Families: what is drawn, and what comes of it.


def by_taylor(scene):
    return replace(scene, method="taylor")


def by_either(draw, scene):
    return replace(scene, method=draw.sampled_from(("auto", "taylor")))


def by_settings(draw, scene):
    order, tol = draw.sampled_from(SETTINGS)
    return replace(scene, method="taylor", order=order, tol=tol)


def short(draw, t_end):
    """A scene with formulas, of t_end [s] at most."""
    scene = formula_scene(draw.integers(0, 10**6))
    return replace(scene, t_end=min(t_end, scene.t_end))


def many_hops(draw):
    """Rigid stops of three bodies, with friction or without, over a longer time."""
    scene = rigid_scene(draw, radians=10.0, bodies=3)
    return by_either(draw, scene if draw.booleans() else replace(scene, frictions=()))


FAMILIES = {
    "two blocks, closed form": lambda draw: run(
        replace(two_blocks(draw, ("none", "harmonic")), method="closed_form").as_parts(), **LEDGERS
    ),
    "two blocks, Taylor": lambda draw: run(by_taylor(two_blocks(draw)).as_parts(), **LEDGERS),
    "two blocks, restarts": lambda draw: resumed(two_blocks(draw).as_parts()),
    "parts": lambda draw: run(part_scene(draw, motor=False, radians=24.0), **LEDGERS),
    "parts, Taylor": lambda draw: run(by_taylor(part_scene(draw, radians=24.0)), **LEDGERS),
    "parts, orders and tolerances": lambda draw: run(by_settings(draw, part_scene(draw))),
    "parts, exponents": lambda draw: grown(by_either(draw, part_scene(draw)), draw.integers(1, 10)),
    "parts, disturbances": lambda draw: carried(by_either(draw, part_scene(draw))),
    "parts, extremes": lambda draw: extreme(by_either(draw, part_scene(draw))),
    "parts, restarts": lambda draw: resumed(by_either(draw, part_scene(draw))),
    "rigid stops": lambda draw: run(rigid_scene(draw, radians=4.0), **LEDGERS),
    "rigid stops, Taylor": lambda draw: run(by_taylor(rigid_scene(draw, radians=4.0)), **LEDGERS),
    "rigid stops, many hops": lambda draw: run(many_hops(draw), ledger=True, momentum=True),
    "rigid stops, dither": lambda draw: run(rigid_scene(draw), dither=draw.integers(1, 31)),
    "rigid stops, earlier ends": lambda draw: run(rigid_scene(draw), early=True),
    "rigid stops, exponents": lambda draw: grown(by_either(draw, rigid_scene(draw))),
    "rigid stops, disturbances": lambda draw: carried(by_either(draw, rigid_scene(draw))),
    "rigid stops, restarts": lambda draw: resumed(by_either(draw, rigid_scene(draw))),
    "belts": lambda draw: run(belted_scene(draw), **LEDGERS),
    "belts, disturbances": lambda draw: carried(belted_scene(draw)),
    "kinked bases": lambda draw: run(kinked_scene(draw), **LEDGERS),
    "kinked bases, rigid stops": lambda draw: run(kinked_scene(draw, rigid_scene), **LEDGERS),
    "kinked bases, disturbances": lambda draw: carried(kinked_scene(draw)),
    "formulas": lambda draw: run(short(draw, 0.5), **LEDGERS),
    "formulas, exponents": lambda draw: grown(short(draw, 0.1)),
    "formulas, disturbances": lambda draw: carried(short(draw, 0.1)),
    "formulas, extremes": lambda draw: extreme(short(draw, 0.2)),
    "formulas, restarts": lambda draw: resumed(short(draw, 0.3)),
}


def digest(columns):
    """Beginning of the SHA-256 of columns, of which 0 has no sign and what is not a number is alike."""
    sha = hashlib.sha256()
    for name, column in sorted(columns.items()):
        values = np.asarray(column)
        if values.dtype.kind == "f":
            values = np.where(np.isnan(values), np.nan, values + 0)
        sha.update(name.encode() + values.tobytes())
    return sha.hexdigest()[:DIGITS]


def digests(family):
    """Of the scenes of all seeds of a family."""
    first = zlib.crc32(family.encode())
    return [digest(FAMILIES[family](Draws(first + k))) for k in range(SEEDS)]


def pinned():
    """{family: digests} of the file."""
    lines = [line.rsplit(": ", 1) for line in FILE.read_text(encoding="ascii").splitlines()]
    found = {family: [] for family in FAMILIES}
    for title, row in lines:
        found[title.rsplit(" ", 1)[0]] += row.split()
    return found


def other(family):
    """Seeds of a family whose bits are not those of the file."""
    expected = pinned()[family]
    return [k for k, one in enumerate(digests(family)) if one != expected[k]]


@pytest.mark.parametrize("family", FAMILIES)
def test_bits_are_what_they_were(family):
    assert other(family) == []


def test_no_scene_is_another_one():
    """But for those few that move nothing."""
    every = [one for row in pinned().values() for one in row]
    assert len(every) == SEEDS * len(FAMILIES) and len(set(every)) > 0.99 * len(every)


def test_a_digest_sees_one_bit():
    columns = FAMILIES["parts"](Draws(1))
    name = next(name for name in columns if name.startswith("samples/x_"))
    other = columns | {name: np.nextafter(columns[name], 1.0)}
    assert digest(columns) != digest(other)
    assert digest({"a": [0.0, np.nan]}) == digest({"a": [-0.0, -np.nan]})


# The paper's cases: SHA-256 (its beginning) of samples and events over 20 s.


PAPER = {
    ("I-A", "closed_form"): "88ff0d711b8cc442",
    ("I-A", "taylor"): "c144d7f7725b31b2",
    ("I-B", "closed_form"): "5e56461727a958d5",
    ("I-B", "taylor"): "e80c2d20865766bd",
    ("I-C", "closed_form"): "0142ec79d41ddb46",
    ("I-C", "taylor"): "a54c1d4bc7145f0b",
    ("I-A-eq211", "closed_form"): "f758f1eb0db118f8",
    ("I-A-eq211", "taylor"): "6374514a3259d219",
    ("I-B-eq211", "closed_form"): "0413ea4165e0ff54",
    ("I-B-eq211", "taylor"): "bae710bed803f1f2",
    ("I-C-eq211", "closed_form"): "e64c6b664d38efef",
    ("I-C-eq211", "taylor"): "6a82af7030685af0",
    ("II-A", "taylor"): "9593cfd33793cd5d",
    ("II-B", "taylor"): "9f1864d6b82e9a3b",
    ("II-C", "taylor"): "0ed900c406f65ae9",
}


@pytest.mark.parametrize(("name", "method"), PAPER)
def test_papers_cases_are_bit_for_bit_what_they_were(name, method):
    result = runs.run(paper(name, method=method, t_end=20.0).as_parts())
    sha = hashlib.sha256()
    for table, besides in ((result.samples, ()), (result.events, ("part",))):
        for column, values in table.items():
            sha.update(b"" if column in besides else (values + 0).tobytes())
    assert sha.hexdigest()[:16] == PAPER[name, method]
    assert result.totals["impacts"] > 0 and result.totals["uncertified"] == 0


def write():
    """Write the file anew."""
    with FILE.open("w", encoding="ascii", newline="\n") as file:
        for family in FAMILIES:
            row = digests(family)
            for k in range(0, SEEDS, PER_LINE):
                print(f"{family} {k}: {' '.join(row[k : k + PER_LINE])}", file=file)


if __name__ == "__main__":
    write()
