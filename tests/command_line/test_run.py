"""vibsim run, inside this process."""

import json
from pathlib import Path

import numpy as np
import pytest

import vibsim
from tests.command_line.made import call
from vibsim.cases.ramps import no_load_speed
from vibsim.engine.errors import EngineError, State
from vibsim.engine.trajectory import open_trajectory

pytestmark = pytest.mark.usefixtures("here")


def files(folder="."):
    return sorted(path.name for path in Path(folder).iterdir())


def run(*words, code=0):
    done = call("run", *words)
    assert done.exit_code == code, done.output
    return done


SHORT = ("--t-end", "5s")


def test_the_summary_says_what_ran_and_what_came_of_it():
    text = run("II-B", *SHORT, "-v").stdout
    result = vibsim.open_result("II-B.h5")
    attrs = result.attrs
    assert text.startswith("II-B  Non-ideal source, motor constant 5.5 Hz\n")
    assert "5.5 Hz (34.5575 rad/s)" in text
    assert "5 s, a sample every 5 ms: 1001 samples" in text
    assert "taylor series of order 20, tolerance 1.1e-16" in text
    assert f"{attrs['impacts']} impacts, {attrs['sticks']} stick phases, {attrs['events']} events" in text
    assert f"needs {1000 * attrs['rest_distance_needed']:.4g} mm" in text
    assert f"at {attrs['grazing_time']:.3f} s" in text
    assert attrs["certified"] == 1
    assert "every stretch proved" in text
    assert attrs["case_sha256"] in text
    assert "II-B.h5 (" in text


TOUCHING = """
blocks: {m1: 1 kg, m2: fixed}
coupling: {k1: 100 N/m}
stop: {k2: 1000 N/m, G: 1 cm, acts: compression}
excitation: {kind: none}
initial: {x1: -1 cm}
run: {t_end: 2 s, every: 10 ms}
"""


def test_a_run_that_touches_the_stop_is_in_doubt():
    """Released from x1 = -G, block 1 swings to G exactly: whether it touches, no double can tell."""
    Path("touching.yaml").write_text(TOUCHING)
    text = run("touching.yaml").stdout
    attrs = vibsim.open_result("touching.h5").attrs
    assert attrs["certified"] == 0
    assert attrs["uncertified"] >= 1
    assert 0 <= attrs["first_uncertified_time"] <= 0.32  # half a period of the spring
    assert f"in doubt, the first from {attrs['first_uncertified_time']:.6g} s on" in text
    alike = "contact at stop: a touch so near that it cannot be distinguished from a miss"
    doubts = json.loads(call("info", "touching.h5", "--json").stdout)["doubts"]
    assert len(doubts) == attrs["uncertified"]
    assert {": ".join((*one["events"], one["reason"])) for one in doubts} == {alike}
    first, last = doubts[0]["time_s"], doubts[-1]["time_s"]
    assert f" {first:.6g} s: {alike} ({len(doubts)} times until {last:.6g} s)\n" in text


def test_the_texts_of_the_summary_stand_in_one_column():
    lines = run("I-A", *SHORT).stdout.splitlines()[1:]
    assert len(lines) >= 6
    assert all(line[:2] == "  " and line[17] == " " and line[18] != " " for line in lines)


def test_json_is_one_object_per_run_and_no_nan():
    done = run("I-A", "I-B", *SHORT, "--json")
    objects = [json.loads(line, parse_constant=pytest.fail) for line in done.stdout.splitlines()]
    assert [one["case_name"] for one in objects] == ["I-A", "I-B"]
    assert objects[0]["file"] == "I-A.h5"
    assert objects[0]["samples"] == 1001
    assert objects[0]["case"]["excitation"]["omega"] == "3.5 Hz"
    assert objects[0]["impacts"] == vibsim.open_result("I-A.h5").attrs["impacts"]


def test_quiet_prints_nothing():
    done = run("I-A", *SHORT, "-q")
    assert (done.stdout, done.stderr) == ("", "")
    assert files() == ["I-A.h5"]


def test_options_become_part_of_the_case():
    values = ("-s", "excitation.Omega0=6.5 Hz", "--set", "c = 0.03 N s/m")
    run("II-B", *values, *SHORT, "--every", "1ms", "--method", "taylor")
    case = vibsim.open_result("II-B.h5").case
    scene = case.two_blocks()
    assert scene.Omega0 == pytest.approx(2 * np.pi * 6.5, rel=1e-15)
    assert (scene.c, scene.t_end, scene.every_num / scene.every_den) == (0.03, 5.0, 0.001)
    assert scene.method == "taylor"


def test_several_cases_into_a_folder(here):
    (here / "out").mkdir()
    run("I-A", "II-A", *SHORT, "-o", "out")
    assert files("out") == ["I-A.h5", "II-A.h5"]
    run("I-B", *SHORT, "-o", "made/", "-q")
    assert files("made") == ["I-B.h5"]
    said = run("I-A", *SHORT, "-o", "no/folder/", code=6).stderr
    assert "no/folder: cannot make the folder: No such file" in said


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["I-A", "I-B", "-o", "one.h5"], "several cases need a folder, such as one/"),
        (["I-A", "I-A"], "two of the cases would be written to I-A.h5"),
        (["I-A", "I-B", "--plot", "a.png"], "--plot draws one run"),
        (["I-A", "-s", "c"], "'c' is not KEY=VALUE"),
        ([], "Missing argument 'CASE...'"),
    ],
)
def test_misuse(words, message):
    done = run(*words, code=2)
    assert message in done.stderr
    assert files() == []


def test_an_invalid_case_is_told_with_all_its_problems():
    Path("bad.yaml").write_text("blocks: {m1: -1 kg, m2: 1 s}\n")
    done = run("I-A", "bad.yaml", code=3)
    assert done.stderr.count("bad.yaml:1:") >= 2
    assert files() == ["bad.yaml"]  # nothing ran


def test_standard_input():
    text = Path(vibsim.load_case("I-A").source).read_text()
    done = call("run", "-", *SHORT, input=text)
    assert done.exit_code == 0
    assert files() == ["I-A.h5"]


def test_an_existing_output_is_kept_unless_forced():
    run("I-A", *SHORT)
    before = Path("I-A.h5").read_bytes()
    done = run("II-A", "I-A", *SHORT, code=6)
    assert done.stderr == "Error: I-A.h5: exists; kept (--force replaces it)\n"
    assert files() == ["I-A.h5"]  # II-A did not run either
    assert Path("I-A.h5").read_bytes() == before
    run("I-A", "--t-end", "6s", "--force")
    assert vibsim.open_result("I-A.h5").time[-1] == 6.0


@pytest.mark.parametrize("name", ["I-B", "II-B"])
def test_a_result_file_runs_again_bit_for_bit(name):
    run(name, *SHORT, "-s", "coupling.c=0.02 N s/m")
    run(f"{name}.h5", "-o", "again.h5")
    first, again = vibsim.open_result(f"{name}.h5"), vibsim.open_result("again.h5")
    for column in first:
        assert first[column].tobytes() == again[column].tobytes()
    for column in first.events:
        assert first.events[column].tobytes() == again.events[column].tobytes()
    for text in ("case_yaml", "case_resolved_json", "case_sha256"):
        assert first.attrs[text] == again.attrs[text]


def test_the_input_is_not_overwritten_by_its_own_run():
    run("I-A", *SHORT)
    before = Path("I-A.h5").read_bytes()
    run("I-A.h5")
    run("I-A.h5", "--force")
    assert Path("I-A.h5").read_bytes() == before
    again, one = vibsim.open_result("I-A-again.h5"), vibsim.open_result("I-A.h5")
    assert again["x1"].tobytes() == one["x1"].tobytes()
    assert "I-A-again.h5: exists; kept" in run("I-A.h5", code=6).stderr
    assert "I-A.h5: exists; kept" in run("I-A.h5", "-o", "I-A.h5", code=6).stderr


def test_a_damaged_result_file_is_not_run_again():
    run("I-A", *SHORT)
    raw = Path("I-A.h5").read_bytes()
    Path("I-A.h5").write_bytes(raw[: len(raw) // 2])
    assert "I-A.h5: is truncated" in run("I-A.h5", "-o", "b.h5", code=6).stderr


def test_dry_run_prints_the_case_and_runs_nothing():
    done = run("II-B", "-s", "c=0.03 N s/m", "--dry-run")
    assert files() == []
    assert '"c": "0.03 N s/m"' in done.stdout
    assert "II-B.h5 (not written: dry run)" in done.stdout
    planned = json.loads(run("II-B", "--dry-run", "--json").stdout)
    assert planned["case"]["excitation"]["Omega0"] == "5.5 Hz"
    assert planned["file"] == "II-B.h5"


def test_a_picture_of_the_run():
    run("I-A", *SHORT, "--plot", "I-A.png")
    assert files() == ["I-A.h5", "I-A.png"]
    assert Path("I-A.png").read_bytes().startswith(b"\x89PNG")


def test_a_picture_in_the_way_is_noticed_before_the_run():
    Path("I-A.png").write_text("precious")
    run("I-A", *SHORT, "--plot", "I-A.png", code=6)
    assert files() == ["I-A.png"]


def test_a_run_that_fails_is_told_and_the_others_go_on(monkeypatch):
    def failing_in_case_2(scene, *arguments, **wishes):
        trajectory = open_trajectory(scene, *arguments, **wishes)
        blocks = trajectory.blocks

        def failing():
            yield from blocks()
            if scene.has_motor:
                raise EngineError("diverged", State(4.0, [0.0], [0.0], 0.0, 0.0, 0.0))

        trajectory.blocks = failing
        return trajectory

    monkeypatch.setattr("vibsim.results.recording.open_trajectory", failing_in_case_2)
    done = run("II-A", "I-A", "--t-end", "1s", code=4)
    assert "Error: II-A: t = 4.0 s: the state is no longer finite" in done.stderr
    assert "what came before is in II-A.h5.partial" in done.stderr
    assert files() == ["I-A.h5", "II-A.h5.partial"]
    partial = vibsim.open_result("II-A.h5.partial")
    assert (partial.complete, len(partial)) == (False, 201)


def test_violations_of_the_rest_distance_are_shown():
    words = ("I-A", "--t-end", "20s", "-s", "value=1 mm", "-s")
    warned = run(*words, "on_violation=warn").stdout
    attrs = vibsim.open_result("I-A.h5").attrs
    first = f"{attrs['violations']} violations, first at {attrs['first_violation_time']:.3f} s"
    assert f"has 1 mm: {first}" in warned
    stopped = run(*words, "on_violation=stop", "--force").stdout
    assert f"stopped         at {attrs['first_violation_time']:.6g} s, by the rest distance" in stopped


def test_too_coarse_an_output_is_told():
    text = run("I-A", "-s", "value=1 m", "-s", "on_violation=warn", "--every", "1s").stdout
    assert "unknown: the samples are too far apart, has 1 m" in text


# vibsim run --ramp, inside this process.


@pytest.mark.parametrize(
    ("more", "end"),
    [((), 2.0), (("--t-end", "3s"), 3.0), (("-s", "run.t_end=1 s"), 1.0), (("-s", "t_end=1 s"), 1.0)],
)
def test_the_ramp_ends_the_run_unless_told_otherwise(more, end):
    run("II-B", "--ramp", "Omega0=3:7Hz", "--over", "2s", *more)
    result = vibsim.open_result("II-B.h5")
    assert result.time[-1] == end
    assert no_load_speed(result.case, np.array([1.0, 5.0])) == pytest.approx([5, 7])


def test_there_and_back_takes_the_time_twice():
    run("II-B", "--ramp", "Omega0=3:7:3Hz", "--over", "2s", "-o", "both.h5")
    assert vibsim.open_result("both.h5").time[-1] == 4


def test_torque_and_no_load_speed_as_a_voltage_drives_them():
    run("II-B", "--ramp", "Omega0=2:6Hz", "--ramp", "M0=2:6 N mm", "--over", "2s")
    case = vibsim.open_result("II-B.h5").case
    assert str(case.quantity("M0_to")) == "6 N mm"
    assert no_load_speed(case, np.array([1.0])) == pytest.approx([4])


def test_a_run_from_a_file_gets_another_ramp():
    run("II-B", "--ramp", "Omega0=3:7Hz", "--over", "1s", "-o", "up.h5")
    run("up.h5", "--ramp", "Omega0=7:3Hz", "--over", "2s", "--t-end", "3s", "-o", "down.h5")
    down = vibsim.open_result("down.h5")
    assert down.time[-1] == 3
    assert no_load_speed(down.case, np.array([0.0, 2.0])) == pytest.approx([7, 3])


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--ramp", "Omega0=3:7Hz"), "--ramp needs --over"),
        (("--over", "3s"), "--over needs a --ramp"),
        (("--ramp", "Omega0=3:7Hz", "--over", "3 kg"), "--over must be a time in s"),
        (("--ramp", "Omega0", "--over", "3s"), "'Omega0' is not KEY=FROM:TO, such as Omega0=3:7Hz"),
        (("--ramp", "Omega0=3:3Hz", "--over", "3s"), "goes from a value to the same"),
        (("--ramp", "m1=3:4kg", "--over", "3s"), "blocks.m1 takes no formula; here these can have a ramp"),
        (("--ramp", "Omega0=3:4Hz", "--ramp", "Omega0=4:5Hz", "--over", "3s"), "Omega0 is given twice"),
        (("--ramp", "Omega0=3:4Hz", "-s", "excitation.Omega0=4 Hz", "--over", "3s"), "give one value"),
    ],
)
def test_what_is_refused(words, message, here):
    done = run("II-B", *words, code=2)
    assert message in " ".join(done.stderr.split())
    assert not list(here.iterdir())
