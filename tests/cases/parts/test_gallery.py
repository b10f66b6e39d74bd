"""The gallery: each case loads, says where it comes from, and has the parameters of its source."""

import json
from math import cos, pi, sin

import h5py
import numpy as np
import pytest
from scipy.optimize import brentq

from tests.command_line.made import call, told
from tests.engine.runs import run
from tests.scenes import falling
from vibsim.cases import CaseError, gallery_case_names, load_case
from vibsim.cases.case import load_case_text
from vibsim.physics.parts import EVENT_KINDS, EXPONENTIAL, GROUND, HYPERBOLIC, Friction

NAMES = gallery_case_names()


def test_the_gallery_has_its_cases():
    assert len(NAMES) >= 21


@pytest.mark.parametrize("name", NAMES)
def test_a_case_of_the_gallery(name):
    case = load_case(name)
    assert case.is_long
    assert case.name == name.partition("/")[2]
    assert case.title
    assert "# Source: " in case.text
    assert "# What to look at: " in case.text
    assert load_case_text(case.long_text()).scene() == case.scene()


def only(parts):
    [part] = parts
    return part


def test_bilinear_oscillator_has_the_parameters_of_its_source():
    zeta, beta, f, omega = 0.01, 29.0, 0.9 * 0.8**2 / 1.26, 0.8
    scene = load_case("gallery/bilinear-oscillator").scene()
    body, link, stop, force = (only(p) for p in (scene.bodies, scene.links, scene.stops, scene.forces))
    assert (body.m, link.k, link.c, stop.k, stop.c, stop.gap) == (1.0, 1.0, 2 * zeta, beta, 0.0, 1.0)
    assert only(force.terms).amplitude == pytest.approx(f, rel=1e-15)
    assert only(force.terms).omega == omega


def test_friction_oscillator_has_the_parameters_of_its_source():
    scene = load_case("gallery/friction-oscillator").scene()
    link, friction, force = (only(p) for p in (scene.links, scene.frictions, scene.forces))
    assert (link.k, link.c, friction.forward, friction.backward) == (1.0, 2 * 0.05, 1.0, 1.0)
    assert (only(force.terms).amplitude, only(force.terms).omega, scene.bodies[0].v) == (1.5, 0.9, 5.0)


def test_blocks_on_belts_have_the_parameters_of_their_sources():
    scene = load_case("gallery/block-on-belt").scene()
    link, friction = only(scene.links), only(scene.frictions)
    assert (scene.bodies[0].m, link.k, link.c, friction.belt) == (1.0, 1.0, 0.0, 0.2)
    assert friction == falling(Friction("belt", 0, GROUND, 0.0, 0.0, 0.2), (HYPERBOLIC, 1.0, 3.0))
    scene = load_case("gallery/belt-oscillator").scene()
    friction = only(scene.frictions)
    assert (scene.bodies[0].m, only(scene.links).k, only(scene.links).c) == (1.0, 1.0, 2 * 0.05)
    assert friction == falling(Friction("belt", 0, GROUND, 0.5, 0.5, 1.5), (EXPONENTIAL, 0.5, 2.0))


def test_two_masses_have_the_parameters_of_their_source():
    scene = load_case("gallery/two-masses-with-friction").scene()
    assert [(link.P, link.Q, link.k, link.c) for link in scene.links] == [(0, -1, 1.0, 0.0), (0, 1, 1.0, 0.0)]
    assert (only(scene.frictions).P, only(scene.frictions).forward) == (1, 0.5)
    assert [(body.m, body.x) for body in scene.bodies] == [(1.0, 1.0), (1.0, 0.0)]


def test_forces_without_harmonics_are_called_constant():
    ball, damper = load_case("gallery/bouncing-ball"), load_case("gallery/impact-damper")
    assert (ball.source_kind, damper.source_kind) == ("constant", "harmonic")
    assert "(bouncing-ball: constant forces, 5 s every 2 ms)" in call("check", "gallery/bouncing-ball").stdout
    swept = call("sweep", "gallery/bouncing-ball", "--omega0", "1:2:1Hz")
    assert "bouncing-ball has no motor" in swept.stderr


def test_a_force_inside_the_capsule_has_its_reaction():
    scene = load_case("gallery/drifting-capsule").scene()
    push, reaction = (only(force.terms) for force in scene.forces)
    assert (push.amplitude, push.omega, push.phase) == (reaction.amplitude, reaction.omega, 0.0)
    assert reaction.phase == pytest.approx(3.141592653589793, rel=1e-15)


def test_loads_of_the_stack_are_the_weights_above():
    scene = load_case("gallery/stack-of-blocks").scene()
    masses = [body.m for body in scene.bodies]
    weights = [sum(masses[i:]) * 9.81 for i in range(3)]
    limits = [mu * weight for mu, weight in zip((0.35, 0.5, 0.1), weights, strict=True)]
    assert [friction.forward for friction in scene.frictions] == pytest.approx(limits, rel=1e-15)


def test_a_case_of_the_gallery_is_found_and_drawn(tmp_path):
    out = tmp_path / "damper.svg"
    assert call("cases", "gallery/impact-damper", "--draw", "-o", out).exit_code == 0
    assert "stops.left" in out.read_text()
    assert call("cases", "gallery/impact-damper", "--draw", "-o", out).exit_code == 6  # it exists
    assert call("cases", "gallery/impact-damper", "--draw", "-o", out, "--force").exit_code == 0
    with pytest.raises(CaseError, match=r"did you mean gallery/impact-damper\?"):
        load_case("gallery/impact-damber")


@pytest.mark.parametrize(
    "options",
    [
        ("--draw",),
        ("--draw", "--resolved", "II-B"),
        ("-o", "a.png", "II-B"),
        ("--draw", "-o", "a.png", "II-B", "II-A"),
        ("--draw", "-o", "a.gif", "II-B"),
        ("--draw", "II-B", "./II-B.yaml"),
    ],
)
def test_options_that_do_not_go_together(options, here):
    (here / "II-B.yaml").write_text("extends: II-B\n")
    assert call("cases", *options).exit_code == 2


def test_a_case_of_the_gallery_runs_from_the_command_line(here):
    shown = told("run", "gallery/drifting-capsule", "--t-end", "2s")
    for line in (
        "  bodies          hammer 0.1 kg, capsule 0.5 kg",
        "  parts           link spring, stop anvil, friction floor",
        "  source          force push on hammer: 0.5 N at 5 Hz (31.4159 rad/s)",
    ):
        assert line in shown.splitlines()
    described = call("info", "drifting-capsule.h5").stdout
    assert "by part         anvil:" in described
    assert "  events          " in described
    assert call("export", "drifting-capsule.h5", "-o", "events.csv", "--events").exit_code == 0
    names, first, second, *_ = (here / "events.csv").read_text().splitlines()
    assert names == "t,kind,part,x_hammer,v_hammer,x_capsule,v_capsule,anvil,floor"
    assert first.startswith("0.0,start,none,")
    assert second.split(",")[1:3] == ["contact_begin", "anvil"]
    assert call("export", "drifting-capsule.h5", "-o", "run.mat").exit_code == 0
    again = call("--json", "run", "drifting-capsule.h5", "-o", "again.h5")
    assert json.loads(again.stdout)["parts"]["anvil"]["impacts"] > 0
    with h5py.File("drifting-capsule.h5") as one, h5py.File("again.h5") as other:
        assert all((one[name][:] == other[name][:]).all() for name in ("x_hammer", "v_capsule", "events/t"))


# Cases of the gallery with rigid stops: what their motions meet besides the numbers on their pages, which
# tests/docs holds them to.


G = 9.81


def ran(name, **changes):
    """(events, columns of those of one kind by name) of a case of the gallery."""
    overrides = {key.replace("__", "."): value for key, value in changes.items()}
    return run(load_case(f"gallery/{name}", overrides).scene()).events


def of(events, kind, *names):
    rows = events["kind"] == EVENT_KINDS[kind]
    return [events[name][rows] for name in names]


def test_chattering_oscillator_is_let_go_where_the_force_turns():
    """Released from x = v = 0 at w t = pi/2 + 2 pi n; a free flight from there ends in the next impact."""
    w = 0.3
    events = ran("chattering-oscillator")
    released, x, v = of(events, "rest_end", "t", "x_mass", "v_mass")
    assert len(released) == 3
    assert released == pytest.approx([(pi / 2 + 2 * pi * n) / w for n in (1, 2, 3)], abs=1e-11)
    assert np.abs([x, v]).max() < 1e-14

    gamma, t0 = 1 / (1 - w * w), released[0]  # x = gamma (cos w t + w sin(t - t0)): cos w t0 = 0
    landing = brentq(lambda t: cos(w * t) + w * sin(t - t0), t0 + 6, t0 + 14, xtol=1e-14)
    speed = gamma * w * (cos(landing - t0) - sin(w * landing))
    t, before = of(events, "impact", "t", "before_v_mass")
    first = np.searchsorted(t, t0)
    assert t[first] == pytest.approx(landing, abs=1e-10)
    assert before[first] == pytest.approx(speed, abs=1e-10)


def test_three_balls_that_do_not_touch_pass_the_blow_on():
    end = {name: values[-1] for name, values in ran("three-balls", stops__second__gap="1 um").items()}
    assert [end[f"v_{name}"] for name in ("first", "middle", "last")] == pytest.approx([0, 0, 1], abs=1e-15)


def test_eytelwein_formula_without_rebound():
    """m^2 g h / ((m + M) (R - (m + M) g)), the ram resting on the pile."""
    x = ran("pile-driver", stops__head__e="0")["x_pile"]
    assert x[-1] == pytest.approx(250**2 * G / (1000 * (100e3 - 1000 * G)), rel=1e-12)


def test_blows_of_the_energy_sink_keep_momentum_and_restitution():
    events = ran("energy-sink", run__t_end="10 s")
    names = ("v_body", "v_ball", "before_v_body", "before_v_ball")
    body, ball, body_before, ball_before = of(events, "impact", *names)
    assert len(body) > 100
    assert 4 * body + 0.04 * ball == pytest.approx(4 * body_before + 0.04 * ball_before, abs=1e-14)
    assert ball - body == pytest.approx(-0.6 * (ball_before - body_before), abs=1e-14)
