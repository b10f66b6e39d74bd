"""Formulas that say what a built-in law says make the scene that the keys of the law make, in every number
type; all others stay formulas.
"""

from fractions import Fraction

import pytest

from vibsim.cases.case import load_case_text
from vibsim.physics.parts import Scene

HEAD = """
bodies: {a: 1 kg, b: 2 kg}
links: {tie: {between: [a, ground], k: 90 N/m, c: 0.5 N s/m}, pair: {between: [a, b], k: 40 N/m}}
"""
PAIRS = {
    "a spring and a damper": (
        "links: {s: {between: [b, ground], force: 'k*d + c*v', k: 70 N/m, c: 0.3 N s/m}}",
        "links: {s: {between: [b, ground], k: 70 N/m, c: 0.3 N s/m}}",
    ),
    "a spring between two bodies, written out": (
        "links: {s: {between: [a, b], force: '2*d*(k + 3 N/m)/4 + v*(5 kg/s - 1 kg/s)', k: 70 N/m}}",
        "links: {s: {between: [a, b], k: 36.5 N/m, c: 4 N s/m}}",
    ),
    "an elastic stop that does not pull": (
        "stops: {s: {between: [a, ground], gap: 1 mm, acts: compression, release: force,"
        " force: 'K*p + C*pv', K: 1e4 N/m, C: 3 N s/m}}",
        "stops: {s: {between: [a, ground], gap: 1 mm, acts: compression, release: force,"
        " k: 1e4 N/m, c: 3 N s/m}}",
    ),
    "a load that is a constant": (
        "friction: {f: {between: [a, ground], N: 'm*g*cos_a', m: 1 kg, g: 9.81 m/s^2, cos_a: 0.5, mu: 0.3}}",
        "friction: {f: {between: [a, ground], N: 4.905 N, mu: 0.3}}",
    ),
    "a coefficient that is a constant": (
        "friction: {f: {between: [a, ground], N: 2 N, mu: 'm0*2', m0: 0.1, static: 1.5}}",
        "friction: {f: {between: [a, ground], N: 2 N, mu: 0.2, static: 1.5}}",
    ),
    "a harmonic force": (
        "forces: {f: {on: a, force: 'F*sin(w*t + p)', F: 2 N, w: 3 Hz, p: 30 deg}}",
        "forces: {f: {on: a, A: 2 N, omega: 3 Hz, phase: 30 deg}}",
    ),
    "a force in rad/s": (
        "forces: {f: {on: a, force: 'F*sin(w*t)', F: 2 N, w: 1.5 rad/s}}",
        "forces: {f: {on: a, A: 2 N, omega: 1.5 rad/s, phase: 0 deg}}",
    ),
    "a cosine, a mean and a term backwards": (
        "forces: {f: {on: b, force: 'F0 - (A*cos(w*t) + A/4*sin(-3*w*t))', F0: 1 N, A: 2 N, w: 3 Hz}}",
        "forces: {f: {on: b, F0: 1 N, terms: [{A: 2 N, omega: 3 Hz, phase: 270 deg},"
        " {A: 0.5 N, omega: 9 Hz, phase: 0 deg}]}}",
    ),
    "a constant force": (
        "forces: {f: {on: b, force: '-m*g', m: 2 kg, g: 9.81 m/s^2}}",
        "forces: {f: {on: b, F0: -19.62 N}}",
    ),
    "an unbalance": (
        "forces: {f: {on: b, force: 'm*e*w**2*sin(w*t)', m: 0.1 kg, e: 30 mm, w: 2 Hz}}",
        "forces: {f: {on: b, A: {rule: m3 e omega^2, m3: 0.1 kg, e: 30 mm}, omega: 2 Hz}}",
    ),
    "a base that shakes": (
        "base: {x: 'a*sin(w*t) + a/2*cos(2*w*t)', a: 1 mm, w: 4 Hz}\n"
        "links: {s: {between: [a, base], k: 10 N/m}}",
        "base: {terms: [{a: 1 mm, omega: 4 Hz}, {a: 0.5 mm, omega: 8 Hz, phase: 90 deg}]}\n"
        "links: {s: {between: [a, base], k: 10 N/m}}",
    ),
    "a motor by its torque": (
        "motor: {on: a, m3: 0.03 kg, e: 0.11 m, J: 1e-3 kg m^2, torque: 'M0*(1 - w/W)', M0: 5 N mm, W: 6 Hz}",
        "motor: {on: a, m3: 0.03 kg, e: 0.11 m, J: 1e-3 kg m^2, M0: 5 N mm, Omega0: 6 Hz}",
    ),
    "a motor by its voltage": (
        "parameters: {U: 9 V, Kt: 0.02 N m/A, Ke: 0.02 V s/rad, R: 4 ohm}\n"
        "motor: {on: a, m3: 0.03 kg, e: 0.11 m, J: 1e-3 kg m^2, M0: Kt*U/R, Omega0: U/Ke}",
        "motor: {on: a, m3: 0.03 kg, e: 0.11 m, J: 1e-3 kg m^2, M0: 45 N mm, Omega0: 450 rad/s}",
    ),
}
FORMULAS = {
    "a cubic spring": "links: {s: {between: [b, ground], force: 'k*d + q*d**3', k: 70 N/m, q: 1 N/m^3}}",
    "a spring that pushes away": "links: {s: {between: [b, ground], force: '-k*d', k: 70 N/m}}",
    "a damper that drives": "links: {s: {between: [b, ground], force: 'k*d - c*v', k: 7 N/m, c: 1 N s/m}}",
    "a spring with a preload": "links: {s: {between: [b, ground], force: 'k*d + F', k: 70 N/m, F: 1 N}}",
    "a spring that reads another body": "links: {s: {between: [b, ground], force: 'k*x_a', k: 70 N/m}}",
    "a spring that changes in time": (
        "links: {s: {between: [b, ground], force: 'k*(1 + sin(w*t))*d', k: 70 N/m, w: 1 Hz}}"
    ),
    "a stop that damps alone": (
        "stops: {s: {between: [a, ground], gap: 1 mm, acts: compression, force: 'C*pv', C: 3 N s/m}}"
    ),
    "a coefficient that rises": (
        "friction: {f: {between: [a, ground], N: 2 N, mu: '0.3 - 0.1*exp(-s/v)', v: 1 m/s}}"
    ),
    "a coefficient that falls, and holds more": (
        "friction: {f: {between: [a, ground], N: 2 N, mu: '0.3 + 0.1*exp(-s/v)', v: 1 m/s, static: 1.2}}"
    ),
    "a coefficient that falls with the square": (
        "friction: {f: {between: [a, ground], N: 2 N, mu: '0.3 + 0.1*exp(-(s/v)**2)', v: 1 m/s}}"
    ),
    "a load that varies": (
        "friction: {f: {between: [a, ground], N: 'N0 + k*x_b', N0: 2 N, k: 1 N/m, mu: 'm', m: 0.3}}"
    ),
    "a coefficient of its own under a constant load": (
        "friction: {f: {between: [a, ground], N: 'm*g', m: 1 kg, g: 9.81 m/s^2, mu: '0.3 + q*s', q: 1 s/m}}"
    ),
    "a chirp": "forces: {f: {on: a, force: 'F*sin(r*t**2)', F: 2 N, r: 1 rad/s^2}}",
    "a product of sines": "forces: {f: {on: a, force: 'F*sin(w*t)*sin(2*w*t)', F: 2 N, w: 1 Hz}}",
    "a negative sine with a phase in radians": (
        "forces: {f: {on: a, force: '-F*sin(w*t + 0.3)', F: 2 N, w: 1 Hz}}"
    ),
    "a base about another place": (
        "base: {x: 'a + a*sin(w*t)', a: 1 mm, w: 4 Hz}\nlinks: {s: {between: [a, base], k: 10 N/m}}"
    ),
    "a motor whose angle is read": (
        "motor: {on: a, m3: 0.03 kg, e: 0.11 m, J: 1e-3 kg m^2, torque: 'M0*(1 - w/W)', M0: 5 N mm, W: 6 Hz}"
        "\nforces: {f: {on: b, force: 'F*sin(phi/2)', F: 1 N}}"
    ),
    "a motor that is braked evenly": (
        "motor: {on: a, m3: 0.03 kg, e: 0.11 m, J: 1e-3 kg m^2, torque: '-b*w', b: 1e-5 N m s}"
    ),
}


def text_of(part: str) -> str:
    """A case of the head's bodies and the parts, links of both in one section."""
    lines = [line.strip() for line in (HEAD + part).splitlines() if line.strip()]
    links = [line.removeprefix("links: {").removesuffix("}") for line in lines if line.startswith("links: ")]
    others = [line for line in lines if not line.startswith("links: ")]
    return "\n".join([*others, f"links: {{{', '.join(links)}}}", "run: {t_end: 1 s}", ""])


def scene_of(part: str) -> Scene:
    return load_case_text(text_of(part)).scene()


def parts_of(scene: Scene) -> list[object]:
    return [scene.bodies, scene.links, scene.stops, scene.frictions, scene.forces, scene.base, scene.motor]


@pytest.mark.parametrize("formula, built_in", PAIRS.values(), ids=PAIRS)
def test_a_formula_makes_the_scene_of_the_built_in_law(formula, built_in):
    assert scene_of(formula) == scene_of(built_in)
    one, other = (load_case_text(text_of(part)) for part in (formula, built_in))
    near_pi = Fraction(355, 113)
    assert parts_of(one.exact_scene(Fraction, near_pi)) == parts_of(other.exact_scene(Fraction, near_pi))


@pytest.mark.parametrize("formula", FORMULAS.values(), ids=FORMULAS)
def test_another_formula_stays_one(formula):
    assert scene_of(formula).has_formulas
