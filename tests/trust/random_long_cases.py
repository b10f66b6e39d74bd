"""Random scenes of named parts in decimals, as YAML: chains of bodies, parts of every kind, driven hard."""

import random
from math import exp, log

from vibsim.cases import Case
from vibsim.cases.case import load_case_text

NAMES = ("ram", "tool", "anvil", "cart")


def scene_of_parts(seed) -> Case:
    """One to four bodies; links, damped stops of both releases, frictions on ground, belt and bodies; forces,
    a shaken base or a motor; 10 or 20 s.
    """
    rng = random.Random(50_000 + seed)
    bodies = NAMES[: rng.choice([1, 2, 2, 3, 3, 4])]
    motor, base = rng.random() < 0.25, rng.random() < 0.35
    ends = ["base" if base and rng.random() < 0.6 else "ground", *bodies]
    base = base and ends[0] == "base"
    lines = [f"bodies: {{{', '.join(f'{body}: {_spread(rng, 0.1, 5)} kg' for body in bodies)}}}"]
    joints = [(bodies[i], ends[i]) for i in range(len(bodies))]
    lines += _section("links", _links(rng, joints))
    lines += _section("stops", _stops(rng, joints))
    lines += _section("friction", _frictions(rng, bodies))
    if motor:
        lines.append(_motor(rng, rng.choice(bodies)))
    if base:
        lines.append(f"base: {{a: {_spread(rng, 0.5, 8)} mm, omega: {_rate(rng)} Hz}}")
    if not (motor or base) or rng.random() < 0.4:
        lines += _section("forces", _forces(rng, bodies))
    if rng.random() < 0.5:
        states = [f"{body}: {{x: {_even(rng, -8, 8)} mm, v: {_even(rng, -0.2, 0.2)} m/s}}" for body in bodies]
        lines.append(f"initial: {{{', '.join(states)}}}")
    lines.append(f"run: {{t_end: {rng.choice([10, 20])} s, every: 20 ms}}")
    return load_case_text("\n".join(lines), name=f"parts {seed}")


def _section(name, parts):
    return [f"{name}: {{{', '.join(parts)}}}"] if parts else []


def _links(rng, joints):
    found = []
    for i, (P, Q) in enumerate(joints):
        if i == 0 or rng.random() < 0.6:
            damper = rng.choice(["0", _spread(rng, 1e-3, 0.3), _spread(rng, 1e-2, 1)])
            found.append(
                f"spring_{i}: {{between: [{P}, {Q}], k: {_spread(rng, 50, 500)} N/m, c: {damper} N s/m}}"
            )
    return found


def _stops(rng, joints):
    found = []
    for i, (P, Q) in enumerate(joints):
        senses = rng.choice([["compression"], ["extension"], ["compression", "extension"], []])
        for sense in senses:
            damper = rng.choice(["0", "0", _spread(rng, 0.1, 10)])
            release = rng.choice(["gap", "force"]) if damper != "0" else "gap"
            gap = rng.choice(["0", _even(rng, 0.1, 5), _even(rng, -0.3, 1)])
            found.append(
                f"stop_{i}{sense[0]}: {{between: [{P}, {Q}], gap: {gap} mm, acts: {sense}, "
                f"k: {_spread(rng, 3000, 5e4)} N/m, c: {damper} N s/m, release: {release}}}"
            )
    return found


def _frictions(rng, bodies):
    found = []
    for i, body in enumerate(bodies):
        if rng.random() < 0.5:
            other = bodies[i - 1] if i and rng.random() < 0.4 else "ground"
            belt = f", belt: {_even(rng, -0.1, 0.1)} m/s" if rng.random() < 0.2 else ""
            found.append(
                f"rub_{i}: {{between: [{body}, {other}], N: {_spread(rng, 1, 20)} N, "
                f"mu: {_spread(rng, 1e-3, 0.1)}{belt}}}"
            )
    return found


def _forces(rng, bodies):
    body, constant = rng.choice(bodies), rng.choice(["0", "0", _even(rng, -0.2, 0.2)])
    found = [f"drive: {{on: {body}, A: {_spread(rng, 0.5, 8)} N, omega: {_rate(rng)} Hz, F0: {constant} N}}"]
    if rng.random() < 0.25:
        found.append(
            f"other: {{on: {rng.choice(bodies)}, A: {_spread(rng, 0.2, 4)} N, omega: {_rate(rng)} Hz}}"
        )
    return found


def _motor(rng, body):
    rotor = f"m3: {_spread(rng, 0.02, 0.1)} kg, e: {_spread(rng, 0.03, 0.15)} m"
    inertia = f"J: {_spread(rng, 1e-4, 3e-3)} kg m^2, M0: {_spread(rng, 0.01, 0.1)} N m"
    return f"motor: {{on: {body}, {rotor}, {inertia}, Omega0: {_spread(rng, 3, 9)} Hz}}"


def _rate(rng):
    return _spread(rng, 1.5, 12)


def _even(rng, low, high):
    return f"{rng.uniform(low, high):.3g}"


def _spread(rng, low, high):
    """Three digits of a number whose logarithm is even between the limits."""
    return f"{exp(rng.uniform(log(low), log(high))):.3g}"
