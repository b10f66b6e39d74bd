"""Published models in formulas: states and events as SciPy's DOP853 has them.

The models are in published_models.yaml, with what their numbers come from.
"""

from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
import yaml

from tests.engine.bundles import assert_derivative
from tests.engine.runs import scene_of
from vibsim import EngineError, simulate
from vibsim.cases.case import load_case_text
from vibsim.engine.tangent.monodromy import Carrier

TOLERANCE = 2e-7  # of the larger of the two values of a column: four times what the solver may be off
EVENTS = ("contact_begin", "contact_end", "impact", "stick_begin", "stick_end", "reversal")


class Model(NamedTuple):
    """A model as a case, columns at half of the run and at its end, and the number of events."""

    name: str
    text: str
    values: dict[str, list[float]]
    events: int


def _read() -> list[Model]:
    text = (Path(__file__).parent / "published_models.yaml").read_text()
    return [Model(one["name"], one["case"], one["values"], one["events"]) for one in yaml.safe_load(text)]


MODELS = _read()


def case_of(model):
    return load_case_text(f"name: {model.name}\n{model.text}", name=model.name)


@pytest.mark.parametrize("model", MODELS, ids=[model.name for model in MODELS])
def test_a_published_model(model):
    run = simulate(case_of(model), trust=False)
    end = run.time[-1]
    at = run.at(np.array([end / 2, end]))
    for column, values in model.values.items():
        size = max(map(abs, values))
        assert at[column] == pytest.approx(values, rel=0, abs=TOLERANCE * size), column
    assert sum(kind in EVENTS for kind in run.events.words("kind")) == model.events


@pytest.mark.parametrize(
    ("name", "duration"), [("two-exciters-rigid", 1.0), ("hertz-max-link", 0.5), ("bouc-wen-n", 0.4)]
)
def test_disturbances_follow_difference_quotients(name, duration):
    """Rotors turn at blows on their body; slopes of powers at their zeros."""
    model = next(model for model in MODELS if model.name == name)
    scene = case_of(model).scene()
    shift = np.random.default_rng(1).uniform(-1e-3, 1e-3, (len(scene.bodies), 2))
    moved = [
        replace(body, x=body.x + dx, v=body.v + dv)
        for body, (dx, dv) in zip(scene.bodies, shift, strict=True)
    ]
    columns, _ = assert_derivative(replace(scene, bodies=tuple(moved), t_end=duration), doubles=1e-9)
    assert columns > 0


@pytest.mark.parametrize("belt", ["0.05 m/s", '"u*sin(w*t)", u: 0.1 m/s, w: 1 Hz'])
def test_disturbances_of_a_rotor_whose_body_begins_to_stick(belt):
    """The friction that stops a disturbed body a little earlier or later turns its rotor too."""
    text = f"""
bodies: {{a: 1 kg, c: 1 kg}}
links: {{l: {{between: [a, ground], k: 100 N/m, c: 0.5 N s/m}}, n: {{between: [c, base], k: 50 N/m}}}}
friction: {{f: {{between: [a, ground], N: 8 N, mu: 0.5, belt: {belt}}}}}
rotors: {{r: {{on: a, m: 0.1 kg, e: 0.1 m, J: 0.001 kg m^2, torque: "-m*g*e*cos(phi)", g: 9.81 m/s^2}}}}
base: {{x: "A*sin(w*t)", A: 2 mm, w: 2 Hz}}
initial: {{r: {{phi: -40 deg}}, a: {{v: 0.2 m/s}}}}
run: {{t_end: 0.15 s, every: 10 ms}}
"""
    scene = scene_of(text)
    assert assert_derivative(scene, doubles=1e-9)[0] > 3
    start = [*(body.x for body in scene.bodies), *(body.v for body in scene.bodies)]
    assert abs(Carrier(scene).carry(start, 0.15).vectors[0][5]) > 0.5


@pytest.mark.parametrize(
    ("base", "time"), [("where(t < T, 0, h)", 1.0), ("h*mod(t, T)/T", 1.0), ("h*step(t - 2*T)", 2.0)]
)
def test_a_base_that_jumps_is_refused_by_name(base, time):
    text = f"""
name: jump
bodies: {{m: 1 kg}}
links: {{s: {{between: [m, base], k: 100 N/m}}}}
base: {{x: "{base}", T: 1 s, h: 1 mm}}
run: {{t_end: 3 s, every: 5 ms}}
"""
    with pytest.raises(EngineError, match="the displacement of the base jumps") as caught:
        simulate(load_case_text(text, name="jump"))
    assert caught.value.state.t == time


@pytest.mark.parametrize("gap", [10.7, 5.0])
def test_a_belt_carries_a_body_out_of_a_contact(gap):
    """It sticks and moves with the belt, x = x0 + u (t - t0), out of a contact with a power of the depth."""
    text = f"""
name: belt
bodies: {{a: 1 kg}}
links: {{l: {{between: [a, ground], force: "k*d", k: 10 N/m}}}}
stops: {{s: {{between: [a, ground], gap: {gap} mm, acts: extension, force: "K*p**1.5", K: 1e3 N/m^1.5}}}}
friction: {{f: {{between: [a, ground], N: 10 N, mu: 0.5, belt: 0.00719 m/s}}}}
initial: {{a: {{x: -15 mm}}}}
run: {{t_end: 2 s, every: 10 ms}}
"""
    run = simulate(load_case_text(text, name="belt"), trust=False)
    events = run.events
    assert list(events.words("kind")) == ["start", "stick_begin", "contact_end", "end"]
    _, sticks, leaves, _ = events["t"]
    assert leaves == pytest.approx(sticks + (-gap / 1000 - events["x_a"][1]) / 0.00719, abs=1e-14)


@pytest.mark.parametrize(("power", "gap"), [(1.5, 3.0), (1.5, 0.0), (0.5, 3.0), (2.5, -5.0)])
def test_a_belt_carries_a_body_into_a_contact(power, gap):
    """It sticks, x = x0 + u t, and a power of the depth grows on it up to mu N: (mu N / K)^(1/power) deep."""
    law = f'force: "K*p**{power}", K: 1e3 N/m^{power}'
    text = f"""
name: belt
bodies: {{a: 1 kg}}
stops: {{s: {{between: [a, ground], gap: {gap} mm, acts: compression, {law}}}}}
friction: {{f: {{between: [a, ground], N: 10 N, mu: 0.5, belt: 0.1 m/s}}}}
initial: {{a: {{x: -10 mm, v: 0.1 m/s}}}}
run: {{t_end: 1.3 s, every: 10 ms}}
"""
    run = simulate(load_case_text(text, name="belt"), trust=False)
    met, slips = (gap / 1000 + 0.01) / 0.1, (5 / 1e3) ** (1 / power) / 0.1
    assert list(run.events.words("kind"))[1:3] == ["contact_begin", "stick_end"]
    assert run.events["t"][1:3] == pytest.approx([met, met + slips], abs=1e-14)


def test_a_load_that_begins_with_a_root_moves_what_rests():
    """A (t - t1)^0.5 on a body that friction holds: it gives way at (mu N / A)^2 behind t1."""
    text = """
name: root
bodies: {a: 1 kg}
friction: {f: {between: [a, ground], N: 10 N, mu: 0.5}}
forces: {push: {on: a, force: "A*max(t - t1, 0)**0.5", A: 8 N/s^0.5, t1: 0.5 s}}
run: {t_end: 1 s, every: 10 ms}
"""
    run = simulate(load_case_text(text, name="root"), trust=False)
    assert list(run.events.words("kind"))[-2:] == ["stick_end", "end"]
    assert run.events["t"][-2] == pytest.approx(0.5 + (5 / 8) ** 2, abs=1e-14)


@pytest.mark.parametrize("law", ["K*p**0.5", "K*p**1.5", "K*p**2.5", "K*p**1.5*(1 + l*pv)", "K*p**2"])
def test_a_stop_that_must_not_pull_is_left_where_its_force_comes_to_zero(law):
    """None of these pulls: contact ends at the gap, as with `release: gap`."""
    power = law.split("**")[1].split("*")[0]
    numbers = f"K: 1e4 N/m^{power}" + (", l: 0.5 s/m" if "l*" in law else "")
    text = f"""
name: wall
bodies: {{a: 1 kg}}
stops: {{s: {{between: [a, ground], gap: 1 mm, acts: compression, force: "{law}", {numbers}}}}}
initial: {{a: {{v: 0.1 m/s}}}}
run: {{t_end: 1 s, every: 100 ms}}
"""
    runs = [
        simulate(load_case_text(text, overrides={"stops.s.release": release}), trust=False)
        for release in ("gap", "force")
    ]
    for run in runs:
        assert list(run.events.words("kind"))[1:] == ["contact_begin", "contact_end", "end"]
        assert run.attrs["uncertified"] == 0
    np.testing.assert_array_equal(runs[0].events["t"], runs[1].events["t"])


def test_a_stop_that_must_not_pull_lets_go_where_its_damper_would():
    """1 + l pv = 0 at -2 m/s, while the body is deep."""
    text = """
name: torn
bodies: {a: 1 kg}
stops: {s: {between: [a, ground], gap: 0 mm, acts: compression, force: "K*p**1.5*(1 + l*pv)", K: 1 N/m^1.5,
  l: 0.5 s/m, release: force}}
forces: {pull: {on: a, force: "-A*t**2", A: 1000 N/s^2}}
initial: {a: {v: 1 m/s}}
run: {t_end: 0.3 s, every: 100 ms}
"""
    run = simulate(load_case_text(text), trust=False)
    kinds, events = list(run.events.words("kind")), run.events
    assert kinds == ["start", "contact_end", "end"] and run.attrs["uncertified"] == 0
    assert events["v_a"][1] == pytest.approx(-2.0, abs=1e-12) and events["x_a"][1] > 1e-3
