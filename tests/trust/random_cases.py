"""Random cases in decimals, as YAML: their exact values are no doubles, as those of real cases.

`mixed` draws over all features; `driven_hard` drives against a stiff stop, where chaos is common.
"""

import random

from tests.trust.random_long_cases import _even, _spread
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
