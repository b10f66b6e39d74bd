"""Random scenes in decimals, as YAML, in which bodies come to rest on rigid stops by infinite sequences of
impacts, with friction and without.
"""

import random

from tests.trust.random_long_cases import _even, _section, _spread
from vibsim.cases import Case
from vibsim.cases.loading import load_case_text

NAMES = ("ram", "tool")


def chatter(seed) -> Case:
    """One or two bodies pressed to a wall that stands or shakes, or to each other; 1 s."""
    rng = random.Random(70_000 + seed)
    bodies = NAMES[: rng.choice([1, 2])]
    wall = rng.choice(["ground", "base"])
    lines = [f"bodies: {{{', '.join(f'{body}: {_spread(rng, 0.2, 3)} kg' for body in bodies)}}}"]
    pairs = [(bodies[0], wall), *((body, bodies[0]) for body in bodies[1:])]
    links = [
        f"spring_{P}: {{between: [{P}, {Q}], k: {_spread(rng, 20, 400)} N/m, "
        f"c: {_spread(rng, 1e-3, 1)} N s/m}}"
        for P, Q in pairs
        if rng.random() < 0.6
    ]
    stops = [
        f"stop_{P}: {{between: [{P}, {Q}], law: rigid, gap: {_even(rng, 0, 4)} mm, acts: compression, "
        f"e: {_even(rng, 0.3, 0.8)}}}"
        for P, Q in pairs
    ]
    frictions = [
        f"rub_{body}: {{between: [{body}, {rng.choice(['ground', *(o for o in bodies if o != body)])}], "
        f"N: 1 N, mu: {_spread(rng, 0.05, 1)}, static: {rng.choice([1, 1.3])}}}"
        for body in bodies
        if rng.random() < 0.6
    ]
    forces = [
        f"press_{body}: {{on: {body}, A: {_spread(rng, 0.2, 3)} N, omega: {_spread(rng, 0.8, 4)} Hz, "
        f"F0: {_spread(rng, 0.5, 4)} N}}"
        for body in bodies
    ]
    lines += _section("links", links) + _section("stops", stops)
    lines += _section("friction", frictions) + _section("forces", forces)
    if wall == "base":
        lines.append(f"base: {{a: {_spread(rng, 0.3, 3)} mm, omega: {_spread(rng, 0.8, 3)} Hz}}")
    places = sorted((_even(rng, -8, -5) for _ in bodies), key=float, reverse=True)  # the tool behind the ram
    states = [
        f"{body}: {{x: {x} mm, v: {_even(rng, -0.1, 0.1)} m/s}}"
        for body, x in zip(bodies, places, strict=True)
    ]
    lines.append(f"initial: {{{', '.join(states)}}}")
    lines.append("run: {t_end: 1 s, every: 10 ms}")
    return load_case_text("\n".join(lines), name=f"chatter {seed}")
