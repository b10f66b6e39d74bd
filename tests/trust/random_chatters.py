"""Random scenes in decimals, as YAML, in which bodies come to rest on rigid stops by infinite sequences of
impacts, with friction and without.
"""

import random
from decimal import Decimal

from tests.trust.exact_hops import GROUND, Line, Rub, Wall
from tests.trust.random_long_cases import _even, _section, _spread
from vibsim.cases import Case
from vibsim.cases.case import load_case_text

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


def crowded(seed) -> Case:
    """One to three bodies in a row, pressed to a wall and to each other; a quarter of the scenes without
    friction, the others with up to three of several laws, on each other, ground, base and belts; 0.15 s.
    """
    rng = random.Random(500_000 + seed)
    bodies = ("ram", "tool", "guide")[: rng.choice([1, 2, 2, 3])]
    wall = rng.choice(["ground", "base"])
    behind = [wall, *bodies]
    pairs = [(body, behind[i]) for i, body in enumerate(bodies)]
    lines = [f"bodies: {{{', '.join(f'{body}: {_spread(rng, 0.1, 5)} kg' for body in bodies)}}}"]
    links = [
        f"spring_{P}: {{between: [{P}, {rng.choice([Q, 'ground'])}], k: {_spread(rng, 20, 600)} N/m, "
        f"c: {rng.choice(['0', _spread(rng, 1e-3, 2)])} N s/m}}"
        for P, Q in pairs
        if rng.random() < 0.6
    ]
    stops = [
        f"stop_{P}: {{between: [{P}, {Q}], law: rigid, gap: {rng.choice(['0', _even(rng, -0.5, 1)])} mm, "
        f"acts: compression, e: {_even(rng, 0.05, 0.75)}}}"
        for P, Q in pairs
    ]
    frictions = []
    for i in range(rng.choice([0, 1, 2, 3])):
        on = rng.choice(bodies)
        against = rng.choice(["ground", wall, *(other for other in bodies if other != on)])
        belt = f", belt: {_even(rng, -0.2, 0.2)} m/s" if rng.random() < 0.3 else ""
        frictions.append(
            f"rub_{i}: {{between: [{on}, {against}], N: {_spread(rng, 0.3, 5)} N, {_law(rng)}{belt}}}"
        )
    forces = [
        f"press_{body}: {{on: {body}, A: {_spread(rng, 0.2, 3)} N, omega: {_spread(rng, 0.8, 6)} Hz, "
        f"phase: {_even(rng, 0, 360)} deg, F0: {_spread(rng, 0.3, 6)} N}}"
        for body in bodies
    ]
    lines += _section("links", links) + _section("stops", stops)
    lines += _section("friction", frictions) + _section("forces", forces)
    if wall == "base":
        lines.append(f"base: {{a: {_spread(rng, 0.2, 3)} mm, omega: {_spread(rng, 0.8, 4)} Hz}}")
    place, states = 0.0, []
    for body in bodies:  # each of them behind the one before, further than the gap
        place -= rng.uniform(0.6, 1)
        states.append(f"{body}: {{x: {place:.4g} mm, v: {_even(rng, -0.05, 0.2)} m/s}}")
    lines.append(f"initial: {{{', '.join(states)}}}")
    lines.append("run: {t_end: 0.15 s, every: 5 ms}")
    return load_case_text("\n".join(lines), name=f"crowded {seed}")


def _law(rng):
    """A law of friction, in the words of a case."""
    mu = _spread(rng, 0.05, 0.8)
    higher = f"{float(mu) * rng.uniform(1.1, 2):.3g}"
    return rng.choice(
        [
            f"mu: {mu}",
            f"mu: {mu}, static: {_even(rng, 1, 1.5)}",
            f"law: stribeck exponential, mu_s: {higher}, mu_d: {mu}, v0: {_spread(rng, 0.02, 0.3)} m/s",
            f"law: stribeck hyperbolic, mu_s: {higher}, mu_d: {mu}, d: {_spread(rng, 2, 50)} s/m",
        ]
    )


def pushed(seed) -> tuple[Case, Line]:
    """One or two bodies without springs, pushed by constant forces to a wall or to each other, with up to
    three Coulomb frictions or none, half of them on belts: the case, and the same for `exact_hops`; 0.3 s.
    """
    rng = random.Random(900_000 + seed)
    bodies = NAMES[: rng.choice([1, 2, 2, 2])]
    m, F = ([_spread(rng, *limits) for _ in bodies] for limits in ((0.1, 5), (0.3, 6)))
    walls = [("ram", "ground", _even(rng, 0, 8) if len(bodies) == 2 else "0")]
    walls += [("tool", "ram", rng.choice(["0", _even(rng, -0.5, 0.5)]))] if len(bodies) == 2 else []
    stops = [(*wall, _even(rng, 0.05, 0.85)) for wall in walls]
    if len(bodies) == 2 and rng.random() < 0.5:
        F[0] = "0"
    pairs = [(body, "ground") for body in bodies] + [("tool", "ram")] * (len(bodies) == 2)
    rubs = [
        (P, Q, _spread(rng, 0.1, 4), _spread(rng, 0.05, 0.9), rng.choice(["1", _even(rng, 1, 1.5)]), belt)
        for P, Q in pairs
        if rng.random() < 0.6
        for belt in ["0" if rng.random() < 0.5 else _even(rng, -0.3, 0.3)]
    ]
    x = [f"{-rng.uniform(0.3, 1) - 2.0 * i:.4g}" for i in range(len(bodies))]
    v = [_even(rng, -0.1, 0.4) for _ in bodies]
    lines = [f"bodies: {{{', '.join(f'{one}: {mass} kg' for one, mass in zip(bodies, m, strict=True))}}}"]
    lines += _section(
        "stops",
        [
            f"stop_{P}: {{between: [{P}, {Q}], law: rigid, gap: {gap} mm, acts: compression, e: {e}}}"
            for P, Q, gap, e in stops
        ],
    )
    lines += _section(
        "friction",
        [
            f"rub_{i}: {{between: [{P}, {Q}], N: {N} N, mu: {mu}, static: {static}, belt: {belt} m/s}}"
            for i, (P, Q, N, mu, static, belt) in enumerate(rubs)
        ],
    )
    lines += _section("forces", [f"push_{b}: {{on: {b}, F0: {f} N}}" for b, f in zip(bodies, F, strict=True)])
    states = [f"{b}: {{x: {a} mm, v: {c} m/s}}" for b, a, c in zip(bodies, x, v, strict=True)]
    lines += [f"initial: {{{', '.join(states)}}}", "run: {t_end: 0.3 s, every: 5 ms}"]
    number = {**{body: i for i, body in enumerate(bodies)}, "ground": GROUND}
    limits = [(P, Q, Decimal(N) * Decimal(mu), Decimal(s), belt) for P, Q, N, mu, s, belt in rubs]
    line = Line(
        [*map(Decimal, m)],
        [Decimal(one) / 1000 for one in x],
        [*map(Decimal, v)],
        [*map(Decimal, F)],
        [Rub(number[P], number[Q], slide, slide * s, Decimal(belt)) for P, Q, slide, s, belt in limits],
        [Wall(number[P], number[Q], Decimal(gap) / 1000, Decimal(e)) for P, Q, gap, e in stops],
    )
    return load_case_text("\n".join(lines), name=f"pushed {seed}"), line
