"""Random cases in decimals, as YAML: their exact values are no doubles, as those of real cases.

`mixed` draws over all features; `driven_hard` drives against a stiff stop, where chaos is common.
"""

import random

from tests.trust.random_long_cases import _even, _section, _spread
from vibsim.cases import Case
from vibsim.cases.case import load_case_text


def mixed(seed) -> Case:
    """Any source or none, with or without stop, friction and a second block that moves; 12 to 40 s."""
    rng = random.Random(seed)
    source = rng.choice(["none", "harmonic", "harmonic", "motor", "motor"])
    fixed = rng.random() < 0.15
    strong = rng.random() < 0.6
    lines = [_blocks(rng, fixed, m2=(0.3, 6))]
    damping = rng.choice(["0", _spread(rng, 1e-3, 0.3), _spread(rng, 1e-3, 0.03)])
    lines.append(f"coupling: {{k1: {_spread(rng, 50, 500)} N/m, c: {damping} N s/m}}")
    if strong or rng.random() < 0.6:
        lines.append(_stop(rng, 1000, 3, 2))
    if not fixed and rng.random() < 0.7:
        lines.append(f"friction: {{mu: {_spread(rng, 5e-4, 0.05)}}}")
    if source == "harmonic":
        lines.append(_harmonic(rng, strong))
    elif source == "motor":
        lines.append(_motor(rng, (0.01, 0.1), (0.02, 0.15), (0.005, 0.05), (2.5, 8)))
    initial = _initial(rng, fixed, source)
    if source == "none" or rng.random() < 0.5:
        lines.append(initial)
    lines.append(f"run: {{t_end: {rng.choice([12, 20, 30, 40])} s, every: 20 ms}}")
    return load_case_text("\n".join(lines), name=f"mixed {seed}")


def driven_hard(seed) -> Case:
    """A strong source, a stiff stop, little damping, most often a wall; 20 or 40 s."""
    rng = random.Random(10_000 + seed)
    motor = rng.random() < 0.4
    fixed = rng.random() < 0.7
    lines = [_blocks(rng, fixed, m2=(0.3, 6))]
    lines.append(f"coupling: {{k1: {_spread(rng, 50, 400)} N/m, c: {_spread(rng, 1e-2, 0.3)} N s/m}}")
    lines.append(_stop(rng, 3000, 2, 5))
    if not fixed and rng.random() < 0.8:
        lines.append(f"friction: {{mu: {_spread(rng, 1e-3, 0.05)}}}")
    if motor:
        lines.append(_motor(rng, (0.02, 0.1), (0.05, 0.15), (0.01, 0.1), (4, 10)))
    else:
        force, rate = _spread(rng, 0.5, 6), _spread(rng, 3, 14)
        lines.append(f"excitation: {{kind: harmonic, A: {force} N, omega: {rate} Hz}}")
    lines.append(f"run: {{t_end: {20 if motor else 40} s, every: 20 ms}}")
    return load_case_text("\n".join(lines), name=f"driven hard {seed}")


def _blocks(rng, fixed, m2):
    m1 = _spread(rng, 0.1, 1)
    return f"blocks: {{m1: {m1} kg, m2: {'fixed' if fixed else _spread(rng, *m2) + ' kg'}}}"


def _stop(rng, softest, widest, usual):
    k2 = _spread(rng, softest, 5e4)
    gap = rng.choice(["0", _even(rng, -0.5, widest), _even(rng, 0.1, usual)])
    return f"stop: {{k2: {k2} N/m, G: {gap} mm, acts: {rng.choice(['extension', 'compression'])}}}"


def _harmonic(rng, strong):
    force = _spread(rng, 0.5, 6) if strong else _spread(rng, 0.03, 0.3)
    rate = _spread(rng, 1.5, 9)
    constant = rng.choice(["0"] * 3 + [_even(rng, -0.1, 0.1)])
    return f"excitation: {{kind: harmonic, A: {force} N, omega: {rate} Hz, F0: {constant} N}}"


def _motor(rng, m3, e, torque, rate):
    rotor = f"m3: {_spread(rng, *m3)} kg, e: {_spread(rng, *e)} m, J: {_spread(rng, 1e-4, 3e-3)} kg m^2"
    drive = f"M0: {_spread(rng, *torque)} N m, Omega0: {_spread(rng, *rate)} Hz"
    return f"excitation: {{kind: motor, {rotor}, {drive}}}"


def _initial(rng, fixed, source):
    state = [f"x1: {_even(rng, -20, 20)} mm", f"v1: {_even(rng, -0.2, 0.2)} m/s"]
    if not fixed:
        state += [f"x2: {_even(rng, -5, 5)} mm", f"v2: {_even(rng, -0.05, 0.05)} m/s"]
    if source == "motor":
        state.append(f"phi: {_even(rng, -3, 3)} rad")
    return f"initial: {{{', '.join(state)}}}"


# Random scenes of named parts in decimals, as YAML, driven hard: forces of several newtons on light bodies,
# rigid and elastic stops between bodies, walls and a shaken base, frictions of three laws.


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
    stops = [_hard_stop(rng, i, kind, bodies, walls) for i, kind in enumerate(kinds)]
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


def _hard_stop(rng, number, kind, bodies, walls):
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
