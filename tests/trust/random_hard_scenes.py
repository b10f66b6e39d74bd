"""Random scenes of named parts in decimals, as YAML, driven hard: forces of several newtons on light bodies,
rigid and elastic stops between bodies, walls and a shaken base, frictions of three laws.
"""

import random

from tests.trust.random_long_cases import _even, _section, _spread
from vibsim.cases import Case
from vibsim.cases.case import load_case_text

NAMES = ("ram", "tool", "anvil")


def hard_scene(seed) -> Case:
    """One to three bodies, each with a spring and near a stop, at least one of which is rigid; 10 s."""
    rng = random.Random(90_000 + seed)
    bodies = NAMES[: rng.choice([1, 2, 2, 3])]
    walls = rng.choice([["ground"], ["ground", "base"]])
    lines = [f"bodies: {{{', '.join(f'{body}: {_spread(rng, 0.2, 3)} kg' for body in bodies)}}}"]
    springs = [
        f"spring_{P}: {{between: [{P}, {_other(rng, bodies, i, walls)}], k: {_spread(rng, 40, 500)} N/m, "
        f"c: {_spread(rng, 0.01, 0.5)} N s/m}}"
        for i, P in enumerate(bodies)
    ]
    lines += _section("links", springs)
    kinds = ["rigid", *(rng.choice(["rigid", "elastic"]) for _ in range(len(bodies)))]
    stops = [_stop(rng, i, kind, bodies, walls) for i, kind in enumerate(kinds)]
    lines += _section("stops", stops)
    if rng.random() < 0.6:
        lines += _section("friction", [_friction(rng, bodies, walls)])
    lines += _section(
        "forces", [_force(rng, i, body) for i, body in enumerate(bodies) if i == 0 or rng.random() < 0.3]
    )
    if any("base]" in line for line in lines):
        lines.append(f"base: {{a: {_spread(rng, 0.5, 5)} mm, omega: {_spread(rng, 1, 6)} Hz}}")
    lines.append("run: {t_end: 10 s, every: 20 ms}")
    return load_case_text("\n".join(lines), name=f"hard {seed}")


def _other(rng, bodies, i, walls):
    """What a part of body i has at its other end: the body before it, or a wall."""
    return bodies[i - 1] if i and rng.random() < 0.5 else rng.choice(walls)


def _stop(rng, number, kind, bodies, walls):
    i = number % len(bodies)
    ends = f"between: [{bodies[i]}, {_other(rng, bodies, i, walls)}], gap: {_even(rng, 0, 15)} mm"
    place = f"{ends}, acts: {rng.choice(['extension', 'compression'])}"
    if kind == "rigid":
        return f"stop_{number}: {{{place}, law: rigid, e: {_even(rng, 0.3, 0.95)}}}"
    release = rng.choice(["gap", "force"])
    damper = _spread(rng, 0.1, 10)
    law = f"k: {_spread(rng, 3000, 3e4)} N/m, c: {damper} N s/m, release: {release}"
    return f"stop_{number}: {{{place}, {law}}}"


def _friction(rng, bodies, walls):
    i = rng.randrange(len(bodies))
    law = rng.choice(
        [
            f"mu: {_spread(rng, 0.02, 0.3)}",
            f"mu: {_spread(rng, 0.02, 0.3)}, static: 1.3",
            "law: stribeck exponential, mu_s: 0.208, mu_d: 0.099, v0: 0.0718 m/s",
        ]
    )
    ends = f"between: [{bodies[i]}, {_other(rng, bodies, i, walls)}]"
    return f"rub: {{{ends}, N: {_spread(rng, 0.3, 5)} N, {law}}}"


def _force(rng, number, body):
    first = f"{{A: {_spread(rng, 3, 20)} N, omega: {_spread(rng, 1.5, 9)} Hz}}"
    second = f", {{A: {_spread(rng, 1, 10)} N, omega: {_spread(rng, 1.5, 9)} Hz, phase: 90 deg}}"
    terms = first + (second if rng.random() < 0.4 else "")
    constant = rng.choice(["0", "0", _even(rng, -2, 2)])
    return f"force_{number}: {{on: {body}, terms: [{terms}], F0: {constant} N}}"
