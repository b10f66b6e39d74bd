"""Bodies that move and bodies that turn in one scene or one picture: each number has its own unit."""

import h5py
import pytest

from tests.command_line.made import refused, told

BOTH = """
name: both
bodies: {mass: 1 kg, disc: 0.1 kg m^2, pin: 0.1 kg m^2}
links: {spring: {between: [mass, ground], k: 40 N/m, c: 1 N s/m}}
stops:
  dog: {between: [disc, pin], law: rigid, gap: 0.1 rad, acts: compression, e: 0.5}
forces:
  drive: {on: mass, A: 1 N, omega: 1 Hz}
  turn: {on: disc, force: "T - b*v_disc", T: 1 N m, b: 0.05 N m s/rad}
run: {t_end: 20 s, every: 10 ms}
"""
LINE = """
name: line
bodies: {mass: 1 kg}
links: {spring: {between: [mass, ground], k: 40 N/m, c: 1 N s/m}}
states: {u: {rate: "v_mass - r*u", start: 0 m, r: 1 1/s}}
forces: {drive: {on: mass, A: 1 N, omega: 1 Hz}}
run: {t_end: 2 s, every: 10 ms}
"""
SHAFT = """
name: shaft
bodies: {mass: 1 kg m^2}
links: {spring: {between: [mass, ground], k: 40 N m/rad, c: 1 N m s/rad}}
states: {u: {rate: "g*v_mass - r*u", start: 0 V, r: 1 1/s, g: 1 V/rad}}
forces: {drive: {on: mass, A: 1 N m, omega: 1 Hz}}
run: {t_end: 2 s, every: 10 ms}
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The three cases and their runs."""
    made = tmp_path_factory.mktemp("units")
    for name, text in (("both", BOTH), ("line", LINE), ("shaft", SHAFT)):
        (made / f"{name}.yaml").write_text(text)
        told("run", made / f"{name}.yaml", "-o", made / f"{name}.h5", "--no-trust")
    return made


def test_verdicts_on_a_disc_are_in_radians_beside_a_mass_in_metres(folder):
    """The drift, the speeds at impact and the vibration of what turns; the vibration of the mass is in m."""
    words = ("--no-exponent", "--window", "0:20", "--what", "impacts,frequencies")
    text = told("analyse", folder / "both.h5", *words)
    lines = [line for line in text.splitlines() if "Hz " in line or " at " in line]
    of_mass = next(line for line in lines if "spring:" in line)
    assert of_mass.rstrip().endswith("mm")
    assert not any(" m/s" in line for line in lines)
    assert any(" rad/s" in line for line in lines)


def test_a_sweep_has_the_unit_of_each_body_and_each_stop(folder):
    out = folder / "both-sweep.h5"
    told("sweep", folder / "both.yaml", "--param", "forces.turn.T=1,1.1 N m", "--t-end", "2s", "-o", out,
         "--compute", "impact-velocity,grazing")  # fmt: skip
    expected = {
        "x_mass_max": "m",
        "x_disc_max": "rad",
        "drift_rate_x_disc": "rad s-1",
        "amplitude_relative_dog": "rad",
        "grazing_margin": "rad",
        "impact_velocity_mean_dog": "rad s-1",
    }
    with h5py.File(out) as file:
        assert {name: file[name].attrs["units"] for name in expected} == expected


def test_statistics_of_two_runs_have_the_unit_of_their_body(folder):
    from vibsim.analysis.comparison import unit_of
    from vibsim.results.simulation import open_result

    scene = open_result(folder / "both.h5").case.scene()
    assert unit_of("amplitude of spring", scene) == "m"
    assert unit_of("amplitude of dog", scene) == "rad"
    assert unit_of("drift rate of disc", scene) == "rad/s"
    assert unit_of("impact rate", scene) == "1/s"


@pytest.mark.parametrize("kind", ["displacement", "phase", "states", "spectrum"])
def test_metres_and_radians_do_not_go_into_one_picture(folder, kind):
    said = refused("plot", folder / "line.h5", folder / "shaft.h5", "--kind", kind, "-o", folder / "no.png")
    other = "V" if kind == "states" else "rad"
    assert f"in m in {folder / 'line.h5'}, in {other} in {folder / 'shaft.h5'}" in said
    assert not (folder / "no.png").exists()


def test_powers_of_both_go_into_one_picture(folder):
    told("plot", folder / "line.h5", folder / "shaft.h5", "--kind", "power", "-o", folder / "p.svg")


def test_two_columns_in_different_units_are_refused(folder):
    said = refused("plot", folder / "line.h5", folder / "shaft.h5", "--x", "u", "--y", "x_mass")
    assert "in m and m" in said and "in V and rad" in said


def test_errors_of_a_bench_are_in_radians_where_all_turns(folder):
    out = folder / "bench.h5"
    text = told("bench", folder / "shaft.yaml", "--t-end", "0.1s", "--methods", "taylor", "-o", out)
    assert "largest error [rad] until" in text
    assert " rad until" in text
    assert "[m]" not in text


# Pictures of a scene with both: what turns has panels of its own, in its own unit.


def labels_of(file, kind, direction="y"):
    """Labels of the panels of a picture along y or x, each once."""
    import matplotlib.pyplot as plt

    import vibsim

    axes = vibsim.plot(str(file), kind)
    panels = axes if isinstance(axes, list) else [axes]
    labels = [getattr(panel, f"get_{direction}label")() for panel in panels]
    plt.close("all")
    return list(dict.fromkeys(labels))


@pytest.mark.parametrize(
    ("kind", "labels"),
    [
        ("displacement", ["Displacement (mm)", "Angle (rad)"]),
        ("velocity", ["Velocity (mm/s)", "Angular velocity (rad/s)"]),
        ("spectrum", ["Amplitude (mm)", "Amplitude (mrad)"]),
        ("stiffness", ["Spring force (N)", "Spring torque (N m)"]),
        ("impact-velocity", ["Closing velocity (rad/s)", ""]),
    ],
)
def test_bodies_that_turn_have_panels_of_their_own(folder, kind, labels):
    assert labels_of(folder / "both.h5", kind) == labels


def test_phase_portraits_have_the_unit_of_their_body(folder):
    x, v = (labels_of(folder / "both.h5", "phase", direction) for direction in "xy")
    assert [label.rpartition(" (")[2] for label in x] == ["mm)", "rad)", "rad)"]
    assert [label.rpartition(" (")[2] for label in v] == ["mm/s)", "rad/s)", "rad/s)"]


def test_panels_of_a_sweep_have_the_unit_of_their_motion(folder):
    out = folder / "both-axis.h5"
    told("sweep", folder / "both.yaml", "--param", "forces.drive.omega=1,1.1,1.2 Hz", "-o", out)
    units = {"rad)": 0, "mrad)": 0, "mm)": 0}
    for label in labels_of(out, "amplitude"):
        units[label.rpartition(" (")[2]] += 1
    assert units["mm)"] == 1
    assert units["rad)"] + units["mrad)"] == 3


def test_a_wall_stands_in_the_panel_of_the_body_that_strikes_it(folder):
    import matplotlib.pyplot as plt

    import vibsim

    wall = "  wall: {between: [mass, ground], law: rigid, gap: 1 mm, acts: extension, e: 0.5}"
    case = vibsim.load_case(BOTH.replace("stops:", f"stops:\n{wall}"))
    above, below = vibsim.plot(vibsim.simulate(case), "displacement")[:2]
    names = [[line.get_gid() for line in axes.get_lines()] for axes in (above, below)]
    plt.close("all")
    assert "wall" in names[0]
    assert "wall" not in names[1]


def test_runs_with_a_body_of_one_name_and_unit_go_into_one_picture(folder):
    out = folder / "two.svg"
    told("plot", folder / "line.h5", folder / "both.h5", "--kind", "displacement", "-o", out)
    assert out.exists()


@pytest.mark.parametrize(("case", "unit"), [("line", "m"), ("shaft", "rad"), ("both", "1")])
def test_amplitudes_of_attractors_have_the_unit_of_the_bodies(folder, case, unit):
    out = folder / f"{case}-attractors.h5"
    at = "mass.x=1cm" if case != "shaft" else "mass.x=0.1rad"
    told("sweep", folder / f"{case}.yaml", "--ensemble", "2", "--spread", at, "--t-end", "20s",
         "--compute", "attractor", "-o", out)  # fmt: skip
    with h5py.File(out) as file:
        assert file["attractors/amplitude"].attrs["units"] == unit
