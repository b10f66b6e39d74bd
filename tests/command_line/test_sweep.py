"""`vibsim sweep`: options, exit codes, what is printed, resuming."""

import json
import os

import numpy as np
import pytest

from tests.command_line.made import call, refused, told
from vibsim.results.simulation import open_result
from vibsim.sweeps.computations import COMPUTATIONS

SHORT = ("--t-end", "2s", "-j", "2")


pytestmark = pytest.mark.usefixtures("here")


def test_without_a_case_it_is_II_B_and_says_so():
    done = call("sweep", "--omega0", "3:4:0.5", *SHORT)
    assert (done.exit_code, done.stderr) == (0, "no case given: sweeping II-B\n")
    result = open_result("II-B-omega0.h5")
    assert result.case.name == "II-B" and result["omega0"].tolist() == [3.0, 3.5, 4.0]
    assert result.complete and np.isfinite(result["mean_speed"]).all()
    assert "3 of 3 done" in done.stdout and "II-B-omega0.h5 (" in done.stdout


def test_counts_of_one_are_in_the_singular():
    printed = told("sweep", "II-B", "--omega0", "3 Hz", "--section", "1", *SHORT)
    assert "3 Hz, 1 value" in printed
    assert "the last stroboscopic point of each" in printed


def test_81_values():
    done = call("sweep", "--omega0", "3:7:0.05", "--t-end", "0.2s", "--json", "-q")
    assert done.exit_code == 0 and json.loads(done.stdout)["points_done"] == 81
    assert open_result("II-B-omega0.h5")["omega0"][1] == 3.05


def test_a_harmonic_sweep_on_a_grid_of_a_changed_case():
    done = call(
        "sweep", "I-B", "--omega", "3, 4", "--param", "G=1:2/3 mm", "-s", "c=0.02", *SHORT, "-o", "grid.h5"
    )  # fmt: skip
    assert done.exit_code == 0
    result = open_result("grid.h5")
    assert [axis.name for axis in result.axes] == ["omega", "G"] and result["amplitude_x1"].shape == (2, 3, 1)
    assert result.case.number("c") == 0.02


def test_the_case_of_a_run():
    assert call("run", "II-C", "--t-end", "1s", "-s", "c=0.02").exit_code == 0
    assert call("sweep", "II-C.h5", "--omega0", "3,4", "-o", "again.h5").exit_code == 0
    assert open_result("again.h5").case.number("c") == 0.02
    assert call("run", "again.h5", "-s", "Omega0=4 Hz", "-o", "point.h5").exit_code == 0
    assert open_result("point.h5").attrs["case_sha256"] == open_result("again.h5")["sha256"][1, 0]


def test_a_finished_sweep_is_not_computed_again():
    options = ("sweep", "II-B", "--omega0", "3,4", *SHORT)
    assert call(*options).exit_code == 0
    written = os.stat("II-B-omega0.h5").st_mtime_ns
    assert "was complete: nothing to compute" in told(*options)
    assert os.stat("II-B-omega0.h5").st_mtime_ns == written


def test_another_sweep_in_the_file_is_refused():
    assert call("sweep", "II-B", "--omega0", "3,4", *SHORT).exit_code == 0
    said = refused("sweep", "II-B", "--omega0", "3,5", *SHORT, code=6)
    assert "excitation.Omega0: in the file 3, 4 Hz (2 values), here 3, 5 Hz (2 values)" in said
    assert call("sweep", "II-B", "--omega0", "3,5", *SHORT, "--force").exit_code == 0
    assert open_result("II-B-omega0.h5")["omega0"].tolist() == [3.0, 5.0]


def test_failed_points_end_in_exit_code_5():
    grid = ("--param", "t_end=1,100 s", "--param", "every=1e-9,1 s")
    options = ("sweep", "II-B", *grid, "-s", "every=1s", "-s", "t_end=1s")
    done = call(*options, "-o", "failed.h5", "-j", 1)
    assert done.exit_code == 5
    assert "1 of 4 points failed" in done.stderr and "t_end = 100 s, every = 1e-9 s" in done.stdout
    assert open_result("failed.h5").complete


@pytest.mark.parametrize(
    ("words", "code", "message"),
    [
        ((), 2, "nothing to sweep"),
        (("--omega0", "3:7"), 2, "has no step"),
        (("--omega", "3,4"), 2, "use --omega0 3,4"),
        (("--param", "Omega=3,4"), 2, "did you mean"),
        (("--param", "c"), 2, "is not KEY=RANGE"),
        (("--param", "c=-1,1"), 3, "--param coupling.c: must be >= 0"),
        (
            ("--omega0", "3,4", "--discard", "200%"),
            2,
            "'--discard': a fraction must be at least 0 and below 1",
        ),
        (("--omega0", "3,4", "--discard", "3s"), 2, "leaves nothing"),
        (("--omega0", "3,4", "--every", "soon"), 2, "time"),
        (("--omega0", "3,4", "-s", "nonsense=1"), 3, "nonsense"),
        (("--omega0", "3,4", "--compute", "powr"), 2, "did you mean power?"),
        (("--omega0", "3,4", "--spread", "x1=1mm"), 2, "needs an ensemble"),
        (("--omega0", "3,4", "--spread", "x1"), 2, "is not KEY=HOW"),
        (("--omega0", "3,4", "--seed", "1"), 2, "--seed draws the members of --ensemble, which is not given"),
        (("--ensemble", "3", "--spread", "x1=1kg"), 2, "must be a length"),
        (("--ensemble", "3", "--spread", "m1=1kg"), 3, "--spread blocks.m1: must be > 0"),
    ],
)
def test_what_is_refused(words, code, message, here):
    assert message in refused("sweep", "II-B", *SHORT, *words, code=code)
    assert list(here.iterdir()) == []


def test_fresh_directions_get_a_remark():
    done = call("sweep", "II-B", "--omega0", "3,4", "--direction", "both", *SHORT)
    assert done.exit_code == 0 and "--carry-state" in done.stderr
    assert open_result("II-B-omega0.h5").directions == (1, -1)


def test_info_describes_a_sweep():
    call("sweep", "II-B", "--omega0", "3,4", *SHORT)
    assert "2 of 2 done" in told("info", "II-B-omega0.h5")
    facts = json.loads(call("info", "II-B-omega0.h5", "--json").stdout)
    assert facts["vibsim_kind"] == "sweep" and facts["case"]["name"] == "II-B"


def test_an_ensemble_with_what_is_computed_besides():
    words = ["--omega0", "3,4", "--ensemble", 3, "--spread", "phi=0:360deg", "--spread", "x1=1mm"]
    shown = told("sweep", "II-B", *words, "--seed", 7, "--compute", "grazing,power", *SHORT, "-o", "e.h5")
    assert "3 members, seed 7: phi uniform from 0 to 360 deg; x1 uniform from -1 to 1 mm" in shown
    assert "power, grazing" in shown
    result = open_result("e.h5")
    assert result["power_source"].shape == (2, 3, 1) and result["member_x1"].shape == (3,)
    done = call("sweep", "II-B", *words, "--seed", 8, *SHORT, "-o", "e.h5")
    assert done.exit_code == 6 and "seed 7" in done.stderr and "seed 8" in done.stderr
    assert "compute: in the file power and grazing, here nothing" in done.stderr


def test_the_help_lists_everything_that_can_be_computed():
    said = " ".join(call("sweep", "--help").stdout.split())
    assert all(f" {name}" in said for name in COMPUTATIONS)


def test_what_can_be_computed_is_listed(here):
    done = call("sweep", "--list")
    lines = done.stdout.splitlines()
    assert done.exit_code == 0 and [line.split()[0] for line in lines] == list(COMPUTATIONS)
    assert lines[3] == "grazing            grazing margin after the transient: grazing_margin_late"
    listed = json.loads(call("sweep", "--list", "--json").stdout)
    assert listed["capture"]["columns"][0] == "capture" and list(here.iterdir()) == []


def test_a_scene_of_named_parts():
    told("sweep", "gallery/drifting-capsule", "--omega", "4:6:1", "--param", "anvil.k=2,5kN/m", *SHORT)
    result = open_result("drifting-capsule-push_omega-anvil_k.h5")
    assert result["push_omega"].tolist() == [4, 5, 6] and result["anvil_k"].tolist() == [2, 5]
    assert np.isfinite(result["amplitude_x_hammer"]).all()
    assert result.case_at((2, 0, 0)).number("forces.reaction.omega") == pytest.approx(12 * np.pi, rel=1e-15)
    described = call("info", "drifting-capsule-push_omega-anvil_k.h5")
    assert "push_omega      4 to 6 Hz in steps of 1, 3 values" in described.stdout


@pytest.mark.parametrize(
    ("case", "options", "said"),
    [
        ("gallery/drifting-capsule", ("--omega0", "3,4"), "is harmonic; use --omega 3,4"),
        ("gallery/stack-of-blocks", ("--omega0", "3,4"), "is moving base; use --omega 3,4"),
        ("gallery/chain-with-gaps", ("--omega", "3,4"), "chain-with-gaps has no harmonic force"),
        ("gallery/impact-damper", ("--param", "left.k=right.c=1,2"), "right.c"),
        ("gallery/impact-damper", ("--param", "left.q=1,2"), "unknown key"),
    ],
)
def test_what_a_scene_of_named_parts_has_not(case, options, said):
    done = call("sweep", case, *options)
    assert done.exit_code in (2, 3) and said in done.stderr


def test_a_key_named_twice_in_one_axis_is_refused():
    said = refused("sweep", "II-B", "--param", "c=coupling.c=0.01:0.02/2")
    assert "coupling.c is named twice in one axis" in said
