"""Pages that answer: what is in them, and in a headless browser zoom, hover, keys, two widths, no error."""

import re
import shlex
import shutil

import matplotlib
import numpy as np
import pytest
from matplotlib.colors import to_rgb

import vibsim
from tests.branches.made import CAPTURED, branch_of
from tests.command_line.made import call, refused, told
from tests.plots.html_data import data_of, numbers
from vibsim.plots.capture_pictures import grey_of
from vibsim.plots.html_pages import ROOM, thinned

AXES = {"Omega0": "5:6:0.5 Hz", "c": "0.01,0.03"}


@pytest.fixture(scope="module")
def folder(runs, tmp_path_factory):
    """Pages of a run with a motor, of one with rigid stops, and of a sweep."""
    folder = tmp_path_factory.mktemp("pages")
    overrides = {"run.t_end": "6 s", "title": "</script><b>bold</b>"}
    vibsim.sweep("II-B", AXES, section=3, jobs=1, out=folder / "sweep.h5", overrides=overrides)
    vibsim.simulate("gallery/impact-pair", overrides={"run.t_end": "5 s"}).save(folder / "rigid.h5")
    branch_of(CAPTURED, "4.8:5.9 Hz").save(folder / "branch.h5")
    shutil.copy(runs["motor"], folder / "run.h5")
    for name in ("run", "rigid", "sweep", "branch"):
        page = folder / f"{name}.html"
        assert told("plot", folder / f"{name}.h5", "-o", page) == f"{page}\n"
    return folder


def test_a_page_has_every_sample_and_every_event(folder, runs):
    data, result = data_of(folder / "run.html"), vibsim.open_result(runs["motor"])
    t, x1 = numbers(data["t"], "f8"), numbers(data["columns"]["x1"]["data"], "f8")
    assert len(t) == len(result) + len(result.events["t"]) and np.all(np.diff(t) >= 0)
    assert np.isin(result.time, t).all() and np.isin(result.events["t"], t).all()
    assert x1.max() == max(result["x1"].max(), result.events["x1"].max())
    assert np.array_equal(numbers(data["events"]["kind"], "i1"), result.events["kind"])
    assert data["horizon"] == result.trust_horizon and data["kinds"]["1"] == "contact_begin"


def test_velocities_jump_upright_at_rigid_stops(folder):
    data, result = data_of(folder / "rigid.html"), vibsim.open_result(folder / "rigid.h5")
    t = numbers(data["t"], "f8")
    assert len(t) == len(result) + 2 * len(result.events["t"])


def test_thinning_keeps_the_extremes_of_every_column():
    rng = np.random.default_rng(1)
    rows = {"time": np.arange(100_003.0), "x1": rng.normal(size=100_003), "v1": rng.normal(size=100_003)}
    thin = thinned(rows, 4000)  # and what is left over behind the last stretch, of 25 rows
    assert len(thin["time"]) <= 4000 + 25 and np.all(np.diff(thin["time"]) > 0)
    for name in ("x1", "v1"):
        assert thin[name].max() == rows[name].max() and thin[name].min() == rows[name].min()
        for part in range(0, 100_000, 1000):  # in every part, to the stretch of some 125 rows
            inside = (thin["time"] >= part) & (thin["time"] < part + 1000)
            assert thin[name][inside].max() >= rows[name][part : part + 1000].max()


def test_a_page_needs_nothing_from_elsewhere_and_obeys_no_text(folder):
    for name in ("run", "sweep"):
        text = (folder / f"{name}.html").read_text(encoding="utf-8")
        assert "default-src 'none'" in text
        assert not re.search(r"https?://|<link|<img|@import|fetch\(|XMLHttp", text)
        assert "<b>bold" not in text and text.count("</script>") == 2


def test_the_command_of_a_point_runs_it(folder, tmp_path, monkeypatch):
    monkeypatch.chdir(folder)
    commands, result = data_of(folder / "sweep.html")["commands"], vibsim.open_result("sweep.h5")
    assert len(commands) == 6
    program_name, *words = shlex.split(commands[3])
    assert program_name == "vibsim" and call(*words, "-q").exit_code == 0
    assert vibsim.open_result("point.h5").attrs["case_sha256"] == result["sha256"].ravel()[3]


def test_the_command_of_a_carried_point_begins_where_it_began(here):
    case = vibsim.load_case("II-B", {"run.t_end": "4 s"})
    vibsim.sweep(case, {"Omega0": "5,6 Hz"}, carry_state=True, section=0, jobs=1, out="s.h5")
    told("plot", "s.h5", "-o", "s.html")
    words = shlex.split(data_of(here / "s.html")["commands"][1])
    told(*words[1:], "-q")
    assert vibsim.open_result("point.h5").attrs["case_sha256"] == vibsim.open_result("s.h5")["sha256"][1, 0]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--kind", "phase"], "a page shows everything of a result; leave out --kind"),
        (["--window", "1:2"], "a page shows everything of a result; leave out --kind"),
        (["II-B"], "a page shows one result; give one FILE"),
    ],
)
def test_what_a_page_does_not_take(folder, words, message, tmp_path):
    assert message in refused("plot", str(folder / "rigid.h5"), *words, "-o", str(tmp_path / "a.html"))
    assert not list(tmp_path.iterdir())
    assert "II-B is a case" in refused("plot", "II-B", "-o", str(tmp_path / "a.html"))


def test_a_page_of_a_branch_has_its_curve(folder):
    """Orbits between its points, which close as well as the line is drawn; it ends at special points."""
    data, branch = data_of(folder / "branch.html"), vibsim.open_result(folder / "branch.h5")
    stored = data["lines"]["columns"]
    columns = {name: numbers(one["data"], "f8").reshape(-1, one["width"]) for name, one in stored.items()}
    assert [bool(stable) for *_, stable in data["lines"]["pieces"]] == [True, False]
    assert len(columns["parameter"]) > 1.5 * len(branch)
    fold, torus = branch.special("F1"), branch.special("NS1")
    assert columns["parameter"].max() == fold.parameter
    (_, end, _), (begin, _, _) = data["lines"]["pieces"]
    assert columns["parameter"][end - 1, 0] == columns["parameter"][begin, 0] == torus.parameter
    family = branch.plan.family()
    for row in range(2, len(columns["parameter"]), 5):
        parameter, period = columns["parameter"][row, 0], columns["period"][row, 0]
        residual = family(family.unknowns(columns["state"][row], period, parameter)).residual
        assert np.abs(residual).max() < 1e-3  # a line of 1e-4 of the picture, times what the map makes of it
    jumps = np.abs(np.diff(columns["multiplier_re"], axis=0)).max()
    assert jumps < 0.25 < np.ptp(columns["multiplier_re"])  # each multiplier goes its own way
    assert data["marks"]["texts"]["label"] == [one.label for one in branch.specials]


def readout(browser):
    return browser.value("document.getElementById('readout').innerText")


def test_zoom_keys_and_hover_of_a_run(browser, folder, runs):
    result = vibsim.open_result(runs["motor"])
    impacts = result.events["t"][result.events["kind"] == 1]
    browser.open(folder / "run.html")
    browser.settle()
    assert (float(browser.shown()["from"]), float(browser.shown()["to"])) == (0, 20)
    assert int(browser.shown()["impacts"]) == len(impacts)
    x, y, width, height = browser.box("canvas")
    browser.mouse("Wheel", x + width / 2, y + height / 2, deltaX=0, deltaY=-600)
    wheel = browser.shown()
    assert 0 < float(wheel["from"]) < float(wheel["to"]) < 20
    browser.key("0")
    for number in range(3):
        browser.key("n")
        near = browser.shown()
        assert float(near["from"]) < impacts[number] < float(near["to"]) and int(near["impacts"]) >= 1
        assert "contact_begin of stop" in readout(browser)
    assert float(near["to"]) - float(near["from"]) < 0.1  # from 20 s to one impact
    value = float(re.search(r"x1\s+(\S+) (\S+)", readout(browser))[1])
    assert value == pytest.approx(1e3 * result.events["x1"][result.events["kind"] == 1][2], rel=1e-5)
    browser.key("ArrowRight")
    assert float(browser.shown()["from"]) > float(near["from"])
    browser.key("0")
    browser.mouse("Moved", x + width * 0.7, y + height / 2)
    assert re.search(r"t\s+1\d\.\d+ s", readout(browser)) and "motor speed" in readout(browser)
    assert browser.said == []


def test_between_rows_a_page_shows_the_motion(browser, folder, runs):
    """Its cubics are within what cubics leave: h^4/384 of the fourth derivative, h = 5 ms at 34 Hz: 0.4 %."""
    result = vibsim.open_result(runs["motor"])
    times = np.linspace(15, 16, 101) + 0.0025
    states = result.at(times)
    browser.open(folder / "run.html")
    for name, curve in (("x1", '{column: "x1", rate: "v1"}'), ("v1", '{column: "v1", of: "x1"}')):
        found = browser.value(f"{times.tolist()}.map((t) => valueAt({curve}, t))")
        assert np.abs(found - states[name]).max() <= (0.004 if name == "x1" else 0.03) * np.ptp(states[name])


@pytest.mark.parametrize("width", [pytest.param(1200, marks=pytest.mark.slow), 400])
@pytest.mark.parametrize("name", ["run", "rigid", "sweep", "branch"])
def test_both_widths_and_both_themes(browser, folder, name, width):
    browser.open(folder / f"{name}.html", width)
    browser.settle()
    assert browser.value("document.documentElement.scrollWidth") <= width
    count = browser.value("document.querySelectorAll('canvas').length")
    boxes = [browser.box("canvas", i) for i in range(count)]
    assert len(boxes) >= 2 and all(left >= 0 and left + w <= width and w > 100 for left, _, w, _ in boxes)
    before = browser.value("getComputedStyle(document.body).backgroundColor")
    browser.key("d")
    assert browser.value("getComputedStyle(document.body).backgroundColor") != before
    drawn = "(() => {const c = document.querySelector('canvas'), d = c.getContext('2d').getImageData("
    drawn += "0, 0, c.width, c.height).data; let n = 0; for (let i = 3; i < d.length; i += 4) n += d[i] > 0;"
    assert browser.value(drawn + " return n})()") > 1000
    assert browser.said == []


def test_a_point_tells_its_numbers_and_its_command(browser, folder):
    result = vibsim.open_result(folder / "sweep.h5")
    browser.open(folder / "sweep.html")
    browser.settle()
    browser.key("n")
    assert browser.shown()["chosen"] == "0" and "vibsim run sweep.h5 -s" in readout(browser)
    place = "[panels[0].px(columns.omega0.values[5]), panels[0].py(columns[y[0].value].values[5])]"
    dx, dy = browser.value(place)
    left, top, _, _ = browser.box("canvas")
    browser.mouse("Moved", left + dx + 2, top + dy + 2)
    assert browser.shown()["chosen"] == "5"
    assert "No-load speed\t6 Hz" in readout(browser) and "Damping\t0.03 N s/m" in readout(browser)
    told = float(re.search(r"mean motor speed\s+(\S+)", readout(browser))[1])
    assert told == pytest.approx(result["mean_speed"].ravel()[5], rel=1e-6)
    browser.value("(() => {const s = document.querySelectorAll('select')[1]; s.value = 'section_speed'; "
                  "s.dispatchEvent(new Event('change'))})()")  # fmt: skip
    assert browser.said == []


def test_values_spaced_by_ratio_stand_evenly(browser, tmp_path):
    axes = {"k2": "log 1e4:1e6/5 N/m", "Omega0": "5,6 Hz"}
    vibsim.sweep("II-B", axes, section=3, jobs=1, out=tmp_path / "log.h5", overrides={"run.t_end": "3 s"})
    told("plot", tmp_path / "log.h5", "-o", tmp_path / "log.html")
    names = [column["name"] for column in data_of(tmp_path / "log.html")["columns"] if column.get("log")]
    assert names == ["k2"]
    browser.open(tmp_path / "log.html")
    browser.settle()
    places = browser.value("[0, 2, 4, 6, 8].map((row) => panels[0].px(columns.k2.places[row]))")
    assert np.diff(places) == pytest.approx([np.ptp(places) / 4] * 4, rel=1e-9)
    ticks = browser.value("powersOf(...panels[0].x, 5).map(([, text]) => text)")
    assert ticks == ["10000", "1e5", "1e6"]
    left, top, _, _ = browser.box("canvas")
    dy = browser.value("panels[0].py(columns[y[0].value].places[5])")
    browser.mouse("Moved", left + places[2] + 1, top + dy + 1)
    assert browser.shown()["chosen"] == "5" and "Stiffness of the stop\t100000 N/m" in readout(browser)
    assert browser.said == []


def test_a_branch_is_a_line_with_marks(browser, folder):
    """Solid and dashed between points that are far apart; a special point tells itself."""
    browser.open(folder / "branch.html")
    browser.settle()
    lit = """(() => {
        const axes = panels[0], canvas = axes.canvas, ratio = canvas.width / axes.width;
        const pixels = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
        const xs = curve.columns.parameter.values, ys = curve.columns.period.values;
        return curve.pieces.map(([begin, end, stable]) => {
            let seen = 0, asked = 0;
            for (let row = begin; row + 1 < end; row++) for (let share = 0; share < 1; share += 0.025) {
                const x = Math.round(ratio * axes.px(xs[row] + (xs[row + 1] - xs[row]) * share));
                const y = Math.round(ratio * axes.py(ys[row] + (ys[row + 1] - ys[row]) * share));
                const at = 4 * (y * canvas.width + x);
                asked += 1; seen += pixels[at + 3] > 0 && pixels[at + 2] > pixels[at] + 20;
            }
            return [stable, seen / asked];
        });
    })()"""
    shares = dict(browser.value(lit))
    assert shares[1] > 0.8 > shares[0] > 0.2, shares
    row = browser.value("marks.texts.label.indexOf('F1')")
    left, top, _, _ = browser.box("canvas")
    dx = browser.value(f"panels[0].px(marks.columns.parameter.values[{row}])")
    dy = browser.value(f"panels[0].py(marks.columns.period.values[{row}])")
    browser.mouse("Moved", left + dx + 1, top + dy)
    fold = vibsim.open_result(folder / "branch.h5").special("F1")
    told = readout(browser)
    assert "label\tF1" in told and "kind\tfold" in told
    assert float(re.search(r"No-load speed\s+(\S+)", told)[1]) == pytest.approx(fold.parameter, rel=1e-11)
    assert "stable, unstable, fold" in browser.value("document.querySelector('canvas.signs').ariaLabel")
    assert browser.said == []


def test_lines_of_a_panel_differ_in_dashes_where_they_are_no_bands(browser, folder):
    browser.open(folder / "run.html")
    browser.value(
        "window.dashes = []; window.own = CanvasRenderingContext2D.prototype.setLineDash;"
        "CanvasRenderingContext2D.prototype.setLineDash = function (d) {"
        "  dashes.push([axisOf(this), d.join()]); own.call(this, d); };"
        "window.axisOf = (g) => panels.findIndex((panel) => panel.axes.g === g); redraw()"
    )
    once = browser.value("dashes.filter(([k, d]) => k === 0 && d === '8,3').length")
    assert once == 1  # the name of x2 alone: its line is a band
    browser.value("dashes.length = 0; view.set(12, 12.5)")
    assert browser.value("dashes.filter(([k, d]) => k === 0 && d === '8,3').length") == 2
    assert browser.value("dashes.filter(([k, d]) => k === 2 && d === '8,3').length") == 0  # a lone line


def test_long_ticks_have_room_and_columns_the_names_of_pictures(browser, folder):
    browser.open(folder / "branch.html")
    assert browser.value("panels[1].xLabel") == "No-load speed (Hz)"
    assert browser.value("x.options[x.selectedIndex].text") == "No-load speed"
    assert browser.value("by.options[0].text") == "none"
    browser.value("view.set(view.range[0], view.range[0] + 2e-6)")  # ticks of many digits
    left, room = browser.value("[panels.map((axes) => axes.left), panels.map((axes) => axes.room())]")
    assert left[0] == left[1] == max(62, *room)
    browser.value("panels[0].y = [3.2885881, 3.2885882]; align(panels)")
    assert browser.value("panels.map((axes) => axes.left)") == [browser.value("panels[0].room()")] * 2
    assert browser.value("panels[0].room()") > 62


def test_up_and_down_differ_at_first_sight_and_columns_have_words(tmp_path):
    settings = {"section": 3, "jobs": 1, "carry_state": True, "direction": "both"}
    vibsim.sweep("II-B", AXES, out=tmp_path / "both.h5", overrides={"run.t_end": "6 s"}, **settings)
    told("plot", tmp_path / "both.h5", "-o", tmp_path / "both.html")
    data = data_of(tmp_path / "both.html")
    assert data["colour"] == "direction"
    titles = {column["name"]: column.get("title") for column in data["columns"]}
    assert titles["omega0"] == "No-load speed" and titles["c"] == "Damping"
    assert titles["mean_speed"] == "mean motor speed"
    assert titles["amplitude_x1"] == "amplitude of x1"
    assert titles["amplitude_relative_max"] == "greatest amplitude of relative"
    assert not any("$" in title or "_" in title for title in titles.values())


def test_the_motors_speed_is_read_off_its_angle_between_rows(folder):
    """As the rate of the cubic through angles and speeds; the angle has all its digits."""
    data = data_of(folder / "run.html")
    (panel,) = [panel for panel in data["panels"] if panel["label"] == "motor speed (Hz)"]
    (curve,) = panel["curves"]
    assert (curve["column"], curve["of"], curve["rate"]) == ("phidot", "phi", None)
    assert data["columns"]["phi"]["type"] == "f8"


def test_the_scale_of_many_values_rises_evenly_in_lightness():
    """The colours of the page are matplotlib's viridis."""
    script = (ROOM / "points.js").read_text(encoding="utf-8")
    colours = re.findall(r'"([0-9a-f]{6})"', script[script.index("VIRIDIS =") :].partition("]")[0])
    greys = [grey_of(f"#{colour}") for colour in colours]
    assert len(greys) == 10 and np.all(np.diff(greys) > 0.04)
    expected = [matplotlib.colormaps["viridis"](share)[:3] for share in np.linspace(0, 1, 10)]
    assert np.abs(np.array([to_rgb(f"#{c}") for c in colours]) - expected).max() < 0.01
