"""Moving pictures: positions are those of the run, gaps close when stops are struck, files hold frames."""

import json
import os
import re
import shutil
import subprocess
import sys

import numpy as np
import pytest
from PIL import Image

import vibsim
from tests.command_line.made import call, refused, told
from tests.plots.html_data import data_of, numbers
from vibsim.plots import style
from vibsim.plots.animated_machine import NOSE_CM, attached, channels_of, display_list, moving_shapes, sketch
from vibsim.plots.animation import SIZES, Film, FilmWish, animate, comfortable
from vibsim.plots.subject import PlotError, open_subject, subject_of

NAMES = ["II-B", "II-A", "gallery/drifting-capsule", "gallery/impact-damper", "gallery/impact-pair",
         "gallery/two-balls-and-a-spring", "gallery/pile-driver", "gallery/energy-sink"]  # fmt: skip


@pytest.fixture(scope="module")
def channels():
    """The channels of a case over its seconds 3 to 5, at 120 frames per second."""
    made = {}

    def channels(name):
        if name not in made:
            run = subject_of(vibsim.simulate(name, trust=False, overrides={"run.t_end": "5 s"}))
            made[name] = run, channels_of(run, (3.0, 5.0), 1 / 120, 1.0)
        return made[name]

    return channels


def column(channels, name):
    return channels.values[:, channels.names.index(name)]


@pytest.mark.parametrize("name", NAMES)
def test_shapes_follow_the_channels_as_the_drawing_does(channels, name):
    """The display list, made of differences, gives the very drawing at every frame."""
    _, film = channels(name)
    shapes = display_list(film)
    for number in (0, 37, len(film.times) - 1):
        at = dict(zip(film.names, film.values[number].tolist(), strict=True))
        drawn = moving_shapes(lambda axes, _, at=at: sketch(axes, film.stage, at), 0)
        for moving, direct in zip(shapes, drawn, strict=True):
            assert np.abs(moving.at(film.values[number]) - direct.shape.vertices).max() < 1e-12


@pytest.mark.parametrize("name", NAMES)
def test_bodies_move_as_in_the_run_and_to_one_scale(channels, name):
    run, film = channels(name)
    states = run.result.at(film.times)
    bodies = film.stage.bodies
    x = np.array([states[f"x{body}" if body.isdigit() else f"x_{body}"] for body in bodies])
    drawn = np.array([column(film, body) for body in bodies])
    apart, drawn_apart = x - x[0], drawn - drawn[0]  # an eye may follow a drift
    assert np.abs(drawn_apart - film.stage.scale * apart).max() <= 1e-9
    ground = column(film, "ground")
    assert np.abs((drawn - ground) - film.stage.scale * x).max() <= 1e-9 * max(1, np.abs(x).max())


@pytest.mark.parametrize("name", NAMES)
def test_bumpers_touch_plates_just_where_the_stop_is_closed(channels, name):
    """The distance drawn between bumper and plate (or lips and head) is the free gap, to scale."""
    run, film = channels(name)
    scene, stage = run.scene, film.stage
    stops = {f"stops.{stop.name}": stop for stop in scene.stops}
    assert len(stage.stops) == len(stops)
    for element, _, slot in stage.placed:
        if element.kind not in ("stop", "hook"):
            continue
        stop = stops[element.key]
        left = attached(stage, element, slot, -1) + column(film, element.left)
        right = attached(stage, element, slot, 1) + column(film, element.right)
        met = left + NOSE_CM if element.kind == "stop" else right - stage.bracket(element, slot)
        drawn = column(film, element.key) - met
        ends = {end: column(film, scene.end_name(end)) for end in (stop.P, stop.Q)}
        free = stage.scale * stop.gap - stop.sense * (ends[stop.Q] - ends[stop.P])
        assert np.abs(drawn - np.maximum(free, 0)).max() <= 1e-9, element.key


def test_stops_light_up_when_struck(channels):
    run, film = channels("II-B")
    contact = run.result.at(film.times)["contact"] == 1
    assert film.lit.shape == (len(film.times), 1) and film.lit[contact].all()
    impacts = run.result.events["t"][run.result.events["kind"] == 1]
    ago = np.array([t - impacts[impacts <= t].max(initial=-np.inf) for t in film.times])
    assert np.array_equal(film.lit[:, 0], contact | (ago <= 0.15))


def test_the_rotor_turns(channels):
    run, film = channels("II-B")
    phi = run.result.at(film.times)["phi"]
    assert np.abs(column(film, "cosine") - np.cos(phi)).max() < 1e-12
    mass = next(shape for shape in display_list(film) if shape.shape.key == "motor")
    arm = np.array([np.diff(mass.at(row), axis=0)[0] for row in film.values])
    length = np.hypot(*arm.T)
    assert np.allclose(arm / length[:, None], np.column_stack([np.cos(phi), np.sin(phi)]), atol=1e-12)


def test_a_gif_has_its_frames(runs, tmp_path):
    out = tmp_path / "a.gif"
    said = told("animate", runs["motor"], "-o", out, "--window", "10:10.4", "--speed", "0.5")
    assert said == f"{out}: 17 frames, 2 times slower; --speed 0.08 makes it some 5 s long\n"
    with Image.open(out) as picture:
        assert picture.n_frames == 17 and picture.info["loop"] == 0 and picture.info["duration"] == 50
        first = np.asarray(picture.convert("RGB"), int)
        picture.seek(8)
        assert np.abs(np.asarray(picture.convert("RGB"), int) - first).max() > 100


def test_an_mp4_has_its_frames(runs, tmp_path):
    encoder = shutil.which("ffmpeg") or pytest.importorskip("imageio_ffmpeg").get_ffmpeg_exe()
    out = tmp_path / "a.mp4"
    told("animate", runs["motor"], "-o", out, "--window", "10:10.5", "--speed", "1", "-q")
    done = subprocess.run([encoder, "-i", str(out), "-f", "null", "-"], capture_output=True, text=True)
    assert "1280x720" in done.stderr and re.findall(r"frame=\s*(\d+)", done.stderr)[-1] == "16"


ENCODER = """#!/bin/sh
echo '[vost#0:0/libx264 @ 0x55] Error submitting a packet to the muxer: No space left on device' >&2
exit 228
"""


@pytest.mark.skipif(os.name != "posix", reason="needs a shell")
def test_a_full_disk_is_told_in_our_words(runs, tmp_path, monkeypatch):
    (tmp_path / "ffmpeg").write_text(ENCODER)
    (tmp_path / "ffmpeg").chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=os.pathsep)
    out = tmp_path / "a.mp4"
    done = call("animate", runs["motor"], "-o", str(out), "--window", "10:10.1", "-q")
    assert (done.exit_code, done.stderr) == (6, f"Error: {out}: cannot write: disk full\n")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["-o", "a.avi"], "a moving picture is .mp4, .gif or .html"),
        (["-o", "a.gif", "--window", "30:40"], "window 30:40 lies outside"),
        (["-o", "a.gif", "--speed", "0"], "0 is not in the range"),
        (["-o", "a.gif", "--speed", "0.00001"], "frames are too many, 60000 go"),
    ],
)
def test_what_cannot_be_shown_is_named(runs, words, message, here):
    done = call("animate", runs["motor"], *words)
    assert done.exit_code == 2 and message in done.stderr.lower()
    assert not list(here.iterdir())


def test_without_an_encoder_the_extra_is_named(runs, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    monkeypatch.setattr(shutil, "which", lambda name: None)
    assert "pip install 'vibsim[video]'" in refused("animate", runs["motor"], "-o", str(tmp_path / "a.mp4"))


def test_a_case_has_no_motion(tmp_path):
    with pytest.raises(PlotError, match="II-B is a case, and a moving picture shows a run"):
        animate("II-B", str(tmp_path / "a.gif"), FilmWish())


def test_a_page_holds_the_motion(runs, tmp_path):
    out = tmp_path / "a.html"
    told("animate", runs["motor"], "-o", out, "--window", "10:12", "-q")
    data, subject = data_of(out), open_subject(runs["motor"])
    times = data["begin"] + data["step"] * np.arange(data["count"])
    x1 = numbers(data["history"]["curves"][0]["data"], "f4")
    assert np.abs(x1 / 1e3 - subject.result.at(np.minimum(times, 12))["x1"]).max() < 1e-8
    assert len(numbers(data["values"], "f4")) == data["count"] * data["channels"]


@pytest.mark.parametrize("width", [pytest.param(1200, marks=pytest.mark.slow), 400])
def test_a_page_goes_stops_and_slows(browser, runs, tmp_path, width):
    told("animate", runs["motor"], "-o", tmp_path / "a.html", "--window", "10:12", "--speed", "1", "-q")
    browser.open(tmp_path / "a.html", width)
    browser.settle()
    if browser.shown()["going"] == "true":
        browser.key(" ")
    begun = float(browser.shown()["now"])
    browser.settle()
    assert float(browser.shown()["now"]) == begun
    browser.key("ArrowRight")
    assert float(browser.shown()["now"]) > begun
    browser.key("-")
    assert browser.shown()["speed"] == "0.5"
    browser.key(" ")
    browser.value("new Promise((done) => setTimeout(done, 300))")
    assert browser.shown()["going"] == "true" and float(browser.shown()["now"]) != begun
    assert browser.value("document.documentElement.scrollWidth") <= width
    assert browser.said == []


@pytest.fixture(scope="module")
def chain(tmp_path_factory):
    """A run of 0.04 s of a chain of bodies, on file."""
    return vibsim.simulate("gallery/chain-with-gaps").save(tmp_path_factory.mktemp("chain") / "chain.h5")


def test_a_film_that_is_too_short_says_how_to_make_it_longer(chain, here):
    """0.04 s of a chain of bodies are less than a frame in real time; 5 s of a film at 0.008."""
    vibsim.simulate("gallery/three-balls").save("balls.h5")
    done = call("animate", chain, "-o", "chain.gif", "--speed", "1")
    said = "chain.gif: 0.04 s are one frame at this speed; --speed 0.008 makes it some 5 s long"
    assert (done.exit_code, done.stderr) == (2, f"Error: {said}\n") and not (here / "chain.gif").exists()
    done = call("animate", "balls.h5", "-o", "balls.gif", "--speed", "1")
    assert done.stdout.startswith("balls.gif: 6 frames, real time; --speed 0.05 makes it some 5 s long")
    said = told("animate", "balls.h5", "-o", "b.html", "--speed", "0.05")
    assert re.fullmatch(r"b\.html: 3\d\d frames, 20 times slower\n", said)  # 6 s, 60 a second


@pytest.mark.parametrize(
    ("length", "slower"),
    [(0.04, 200), (0.3, 20), (1.0, 5), (2.5, 2), (4.9, 2), (5.0, 1), (300.0, 1), (0.0, 1), (5e-9, 1e9)],
)
def test_a_film_of_a_short_run_is_slowed_until_it_can_be_looked_at(length, slower):
    """To 5 s at least, and by one step of 1, 2, 5, 10 no more than that takes."""
    assert comfortable(length) == pytest.approx(1 / slower, rel=1e-12)
    if 0 < length < 5:
        assert 5 * (1 - 1e-12) <= length / comfortable(length) < 12.5


def test_a_short_film_is_slowed_unless_its_speed_is_given(chain, here):
    assert told("animate", chain, "-o", "chain.html").endswith(" frames, 200 times slower\n")
    data = data_of(here / "chain.html")
    assert data["speed"] == 0.005 and data["step"] <= 0.005 / 60 and data["decimals"] == 5
    said = json.loads(told("animate", chain, "-o", "b.html", "--json"))
    assert said == {"written": ["b.html"], "frames": data["count"], "speed": 0.005}
    told("animate", chain, "-o", "real.html", "--speed", "1")
    assert data_of(here / "real.html")["speed"] == 1


@pytest.mark.parametrize(
    ("command", "axes"), [("animate", "history_"), ("plot", "panels[0].axes")], ids=["film", "run"]
)
def test_a_narrow_page_names_all_of_many_bodies(browser, chain, tmp_path, command, axes):
    told(command, chain, "-o", tmp_path / "a.html", "-q")
    browser.open(tmp_path / "a.html", 400)
    browser.settle()
    ends = browser.value(
        f"(() => {{const a = {axes}, at = a._places(a.g); return a.legend.map(([name], i) => "
        "[name, at[i][0] + 28 + a.g.measureText(name).width, at[i][1]])})()"
    )
    assert [name for name, _, _ in ends] == [f"x_{n}" for n in ("one", "two", "three", "four", "five")]
    room, top = browser.value(f"[{axes}.width, {axes}.top]")
    assert all(end <= room for _, end, _ in ends) and ends[0][2] < ends[-1][2] < top
    browser.size(1200)
    browser.settle()
    assert browser.value(f"{axes}.rows") == 1 and browser.said == []


@pytest.mark.parametrize(("name", "speed"), [("chain-with-gaps", 0.01), ("energy-sink", 1.0)])
def test_words_of_a_film_fit_into_their_boxes_and_off_the_clock(name, speed):
    """However small a machine of many bodies is drawn."""
    subject = subject_of(vibsim.simulate(f"gallery/{name}", trust=False))
    channels = channels_of(subject, (0.0, min(1.0, subject.result.t_reached)), speed / 20, speed)
    with style.applied():
        film = Film(subject, channels, speed, *SIZES[".gif"])
        film.frame(0)
    words = {artist.get_text(): artist for artist in film._artists if hasattr(artist, "get_text")}
    machine, clock = film._machine.get_window_extent(), film._clock.get_window_extent()
    for box in channels.stage.plan.boxes:
        drawn = words[box.name].get_window_extent()
        width = box.width / (film._machine.get_xlim()[1] - film._machine.get_xlim()[0]) * machine.width
        assert drawn.width < width
    assert all(not artist.get_window_extent().overlaps(clock) for artist in words.values())
    assert machine.y1 <= clock.y0
