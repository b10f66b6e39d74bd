"""The gallery: each case loads, says where it comes from, and has the parameters of its source."""

import json

import h5py
import pytest

from tests.command_line.made import call
from tests.scenes import falling
from vibsim.cases import CaseError, gallery_case_names, load_case
from vibsim.cases.case import load_case_text
from vibsim.physics.parts import EXPONENTIAL, GROUND, HYPERBOLIC, Friction

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
def test_options_that_do_not_go_together(options, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "II-B.yaml").write_text("extends: II-B\n")
    assert call("cases", *options).exit_code == 2


def test_a_case_of_the_gallery_runs_from_the_command_line(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = call("run", "gallery/drifting-capsule", "--t-end", "2s")
    assert done.exit_code == 0
    for line in (
        "  bodies          hammer 0.1 kg, capsule 0.5 kg",
        "  parts           link spring, stop anvil, friction floor",
        "  source          force push on hammer: 0.5 N at 5 Hz (31.4159 rad/s)",
    ):
        assert line in done.stdout.splitlines()
    described = call("info", "drifting-capsule.h5").stdout
    assert "by part         anvil:" in described
    assert "  events          " in described
    assert call("export", "drifting-capsule.h5", "-o", "events.csv", "--events").exit_code == 0
    names, first, second, *_ = (tmp_path / "events.csv").read_text().splitlines()
    assert names == "t,kind,part,x_hammer,v_hammer,x_capsule,v_capsule,anvil,floor"
    assert first.startswith("0.0,start,none,")
    assert second.split(",")[1:3] == ["contact_begin", "anvil"]
    assert call("export", "drifting-capsule.h5", "-o", "run.mat").exit_code == 0
    again = call("--json", "run", "drifting-capsule.h5", "-o", "again.h5")
    assert json.loads(again.stdout)["parts"]["anvil"]["impacts"] > 0
    with h5py.File("drifting-capsule.h5") as one, h5py.File("again.h5") as other:
        assert all((one[name][:] == other[name][:]).all() for name in ("x_hammer", "v_capsule", "events/t"))
