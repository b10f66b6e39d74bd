"""Every command that reads or judges one run, on scenes of named parts."""

import csv
import json

import numpy as np
import pytest

from tests.command_line.made import call

CASE = "gallery/impact-damper"
MOTOR = """
name: shaker
bodies: {cart: 2 kg, rider: 0.5 kg}
links:
  spring: {between: [cart, ground], k: 800 N/m, c: 3 N s/m}
  tie: {between: [rider, cart], k: 300 N/m, c: 0.5 N s/m}
stops: {lid: {between: [rider, cart], gap: 1 mm, acts: compression, k: 20 kN/m}}
motor: {on: cart, m3: 0.03 kg, e: 0.05 m, J: 0.001 kg m^2, M0: 0.05 N m, Omega0: 6 Hz}
run: {t_end: 20 s, every: 5 ms}
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("parts")
    (folder / "shaker.yaml").write_text(MOTOR)
    words = ("--lyapunov", "all", "-o", folder / "damper.h5", "--t-end", "60 s")
    assert call("run", CASE, *words).exit_code == 0
    assert (
        call("run", CASE, "-o", folder / "again.h5", "--t-end", "60 s", "--method", "taylor").exit_code == 0
    )
    assert call("run", folder / "shaker.yaml", "-o", folder / "shaker.h5").exit_code == 0
    return folder


def test_analyse_tells_bodies_and_parts_by_name(folder):
    text = call("analyse", folder / "damper.h5", "--no-exponent", "-v").stdout
    lines = [line.strip() for line in text.splitlines()]
    assert any(line.startswith("impacts") and "left: every cycle: 1 per cycle" in line for line in lines)
    assert any(line.startswith("right: every cycle: 1 per cycle") for line in lines)
    assert any(line.startswith("words co 30; 1 in all") for line in lines)
    found = json.loads(call("--json", "analyse", folder / "damper.h5", "--no-exponent").stdout)
    assert found["impacts"].keys() == {"left", "right"}
    assert found["frequencies"].keys() == {"spring", "left"}
    assert found["frequencies"]["spring"]["lines"][0]["hz"] == pytest.approx(1.0, abs=1e-3)
    assert (found["capture"], found["drift"]) == (None, None)


def test_a_motor_among_named_parts_is_judged_like_the_paper_s(folder):
    found = json.loads(call("--json", "analyse", folder / "shaker.yaml", "--what", "capture").stdout)
    assert found["capture"]["no_load_speed_hz"] == pytest.approx(6.0)
    assert found["capture"]["verdict"] in ("captured", "escaped", "passed", "not met")
    names = {one["resonance"]["name"] for one in found["capture"]["passages"]}
    assert names <= {f"{kind} {i}" for kind in ("free", "bilinear", "half bilinear") for i in (1, 2)}


def test_compare_names_what_differs(folder):
    found = json.loads(call("--json", "compare", folder / "damper.h5", folder / "again.h5").stdout)
    assert found["verdict"] == "agree"
    assert "run.method" in {difference["key"] for difference in found["differences"]}


def test_exponents_and_counts_are_in_the_file(folder):
    found = json.loads(call("--json", "info", folder / "damper.h5").stdout)
    assert len(found["lyapunov_exponents"]) == 4
    # Liouville: away from the stops volumes shrink at c / m, and the balls' dampers add to that
    assert sum(found["lyapunov_exponents"]) < -1.26 / 10
    assert found["parts"]["left"]["impacts"] > 20
    assert "exponents" in call("info", folder / "damper.h5").stdout


def test_digits(folder):
    words = ("--t-end", "2 s", "--every", "0.1 s", "--digits", "30", "-o", folder / "digits.h5")
    found = json.loads(call("--json", "run", CASE, *words).stdout)
    assert found["digits_right"] >= 20


def test_export_has_a_column_for_every_body_and_part(folder):
    out = folder / "damper.csv"
    assert call("export", folder / "damper.h5", "-o", out, "--window", "59:60").exit_code == 0
    with open(out, encoding="utf-8", newline="") as file:
        head, *rows = csv.reader(file)
    assert [name.split(" ")[0] for name in head][:5] == ["time", "x_body", "v_body", "x_ball", "v_ball"]
    assert len(rows) == 501
    assert np.isfinite([float(row[3]) for row in rows]).all()


@pytest.mark.parametrize("name", ["damper.h5", "shaker.h5", "shaker.yaml"])
def test_kinds_of_pictures_that_fit_are_listed(folder, name):
    listed = json.loads(call("--json", "plot", folder / name, "--list").stdout)
    kinds = {kind["name"] for kind in listed}
    if name == "shaker.yaml":
        assert kinds == {"stiffness", "motor"}
    else:
        assert {"overview", "stroboscopic", "impact-velocity", "stiffness"} <= kinds
        assert "phase-drift-free" not in kinds  # springs hold every body
        assert ({"motor-speed", "displacement-frequency", "motor"} <= kinds) == (name == "shaker.h5")


def test_check_tells_what_the_numbers_imply(folder):
    text = call("check", "-v", folder / "shaker.yaml").stdout
    for name in ("open 1", "open 2", "closed 2", "bilinear 1", "run-up time constant", "full force"):
        assert f"  {name} " in text
