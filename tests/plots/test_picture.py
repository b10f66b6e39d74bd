"""Files: formats, fonts, sizes, names, pages of PDF, full disks, and what is refused."""

import struct
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from io import BytesIO

import matplotlib
import numpy as np
import pytest
from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.figure import Figure
from PIL import Image

import vibsim
from tests.command_line.made import call
from vibsim.plots import plot_run
from vibsim.plots.picture import draw_files
from vibsim.plots.sheet import LeanPages
from vibsim.plots.subject import PlotError, View
from vibsim.results import ResultFileError


def test_png_has_journal_width(runs, here):
    assert draw_files([runs["quiet"]], ["relative"], View(), "x.png") == ["x.png"]
    assert (here / "x.png").read_bytes().startswith(b"\x89PNG")
    draw_files([runs["quiet"]], ["relative"], View(width="page"), "wide.png")
    for name, width in (("x", 8.6), ("wide", 17.8)):
        (pixels,) = struct.unpack(">I", (here / f"{name}.png").read_bytes()[16:20])
        assert pixels == pytest.approx(width / 2.54 * 300, abs=1)


def test_pdf_embeds_truetype(runs, here):
    draw_files([runs["motor"]], ["motor-speed"], View(), "x.pdf")
    content = (here / "x.pdf").read_bytes()
    assert content.startswith(b"%PDF") and b"/FontFile2" in content
    assert not any(word in content for word in (b"/Type3", b"CreationDate"))


def test_svg_is_well_formed(runs, here):
    draw_files([runs["motor"]], ["relative"], View(), "x.svg")
    root = ElementTree.parse(here / "x.svg").getroot()
    assert root.tag.endswith("svg")
    words = ["".join(text.itertext()) for text in root.iter("{http://www.w3.org/2000/svg}text")]
    assert any("0–20 s" in word for word in words)  # text, which an editor finds and edits
    assert float(root.get("width").removesuffix("pt")) == pytest.approx(8.6 / 2.54 * 72, abs=0.01)


def test_png_is_opaque_and_says_who_drew_it(runs, here):
    draw_files([runs["quiet"]], ["relative"], View(), "x.png")
    with Image.open(here / "x.png") as picture:
        assert (picture.mode, picture.info["Software"]) == ("RGB", "vibsim")
        assert picture.info["dpi"] == pytest.approx((300, 300), abs=0.01)


@pytest.mark.parametrize("suffix", ["png", "pdf", "svg"])
def test_the_same_picture_is_the_same_file(runs, here, suffix):
    for name in ("a", "b"):
        draw_files([runs["motor"]], ["motor-speed"], View(), f"{name}.{suffix}")
    assert (here / f"a.{suffix}").read_bytes() == (here / f"b.{suffix}").read_bytes()


def test_default_names(runs, here):
    written = draw_files([runs["quiet"], runs["bare"]], ["phase", "relative"], View())
    assert written == ["quiet+bare-phase.png", "quiet+bare-relative.png"]
    assert sorted(path.name for path in here.iterdir()) == sorted(written)


def test_several_kinds_make_several_files_or_pages(runs, here):
    kinds = ["stiffness", "relative"]
    assert draw_files([runs["quiet"]], kinds, View(), "x.svg") == ["x-stiffness.svg", "x-relative.svg"]
    assert draw_files([runs["quiet"]], kinds, View(), "x.pdf") == ["x.pdf"]
    assert (here / "x.pdf").read_bytes().count(b"/Type /Page ") == 2


def test_cases_without_a_run(here):
    assert draw_files(["II-A", "II-B", "II-C"], ["motor"], View()) == ["II-A+II-B+II-C-motor.png"]
    assert draw_files(["I-A"], None, View(), "k.svg") == ["k.svg"]


def test_existing_pictures_are_kept(runs, here):
    (here / "x.png").write_text("mine")
    with pytest.raises(ResultFileError, match=r"x\.png: exists"):
        draw_files([runs["quiet"]], ["phase"], View(), "x.png")
    assert (here / "x.png").read_text() == "mine"
    draw_files([runs["quiet"]], ["phase"], View(), "x.png", force=True)
    assert (here / "x.png").read_bytes().startswith(b"\x89PNG")


def test_missing_folder(runs, here):
    with pytest.raises(ResultFileError, match="does not exist"):
        draw_files([runs["quiet"]], ["phase"], View(), "nowhere/x.png")


@pytest.mark.parametrize("out", ["x.jpg", "x", "x.h5"])
def test_unknown_suffix(runs, here, out):
    with pytest.raises(PlotError, match=r"pictures are \.png, \.pdf or \.svg"):
        draw_files([runs["quiet"]], ["phase"], View(), out)


def test_nothing_is_left_of_a_failed_picture(runs, here):
    with pytest.raises(PlotError):
        draw_files([runs["quiet"]], ["phase"], View(window=(900.0, 910.0)), "x.png")
    assert list(here.iterdir()) == []


def test_plot_run(runs, here):
    assert plot_run(runs["quiet"], "a.pdf", kinds=["relative"]) == ["a.pdf"]
    with pytest.raises(ResultFileError):
        plot_run(runs["quiet"], "a.pdf", kinds=["relative"])
    assert plot_run(runs["quiet"], "a.pdf", kinds=["stiffness"], force=True) == ["a.pdf"]


def test_the_users_matplotlib_settings_do_not_matter(runs, here):
    draw_files([runs["quiet"]], ["phase"], View(), "a.png")
    with matplotlib.rc_context({"font.size": 20, "axes.grid": True, "lines.linewidth": 9}):
        draw_files([runs["quiet"]], ["phase"], View(), "b.png")
    assert (here / "a.png").read_bytes() == (here / "b.png").read_bytes()


@pytest.mark.parametrize("size", [(6.0, 4.0), (8.0, 5.0), (8.0, 6.0)])
def test_a_picture_without_room_is_refused(runs, here, size):
    """matplotlib warns, with lines of its source, and draws panels of no size over each other; or the solver
    of its layout gives up.
    """
    with pytest.raises(PlotError, match=r"^x\.png: too small for what it shows: make it larger"):
        draw_files([runs["quiet"]], ["overview"], View(size_cm=size), "x.png")
    assert list(here.iterdir()) == []


@pytest.mark.parametrize(
    ("kind", "view", "message"),
    [
        ("phase", View(detail=(0.1, 0.2)), "detail: kind phase has none; kinds that have: overview, displ"),
        ("stiffness", View(window=(0.1, 0.2)), "window: kind stiffness has none; kinds that have: overview"),
    ],
)
def test_spans_that_no_picture_would_show_are_refused(runs, here, kind, view, message):
    with pytest.raises(PlotError, match=message):
        draw_files([runs["quiet"]], [kind], view, "x.png")
    assert list(here.iterdir()) == []


# PDF files let go of the sheets on which their bitmaps were drawn, and are byte for byte matplotlib's.


METADATA = {"CreationDate": None}


def panels():
    figure = Figure(figsize=(4, 4))
    for axes in figure.subplots(2, 2).flat:
        axes.plot(np.sin(np.arange(50.0)), rasterized=True)
    return figure


def test_bitmaps_own_their_pixels():
    with LeanPages(BytesIO(), metadata=METADATA) as pages:
        pages.savefig(panels())
        images = [image for image, *_ in pages._file._images.values()]
        assert len(images) == 4 and all(image.base is None for image in images)


def test_the_bytes_are_those_of_matplotlib():
    files = []
    for kind in (PdfPages, LeanPages):
        files.append(BytesIO())
        with kind(files[-1], metadata=METADATA) as pages:
            pages.savefig(panels())
    assert files[0].getvalue() == files[1].getvalue()


# Pictures on a disk that fills up: one line, no picture, whatever the format and wherever the disk ends.


DRAW = """
import resource
from vibsim.command_line.main import main
for words in {commands}:
    for limit in (0, {limit}):  # no file grows beyond that
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, resource.RLIM_INFINITY))
        sys.argv[1:] = words
        try:
            main()
        except SystemExit as end:
            assert end.code == 6, words
"""
COMMANDS = [
    ["plot", "a.h5", "--kind", "motor", "-o", "p.pdf"],
    ["plot", "a.h5", "--kind", "motor", "-o", "p.svg"],
    ["plot", "a.h5", "--kind", "motor,stiffness", "-o", "p.pdf"],
    ["cases", "II-B", "--draw", "-o", "p.pdf"],
]


def test_no_picture_and_one_line(tmp_path):
    vibsim.simulate(vibsim.load_case("II-B", {"t_end": "2 s"})).save(tmp_path / "a.h5")
    program = "import sys" + DRAW.format(commands=COMMANDS, limit=6_000)
    done = subprocess.run([sys.executable, "-c", program], cwd=tmp_path, capture_output=True, text=True)
    lines = done.stderr.splitlines()
    assert done.returncode == 0 and len(lines) == 2 * len(COMMANDS), done.stderr
    assert all(line.startswith("Error: p.") and line.endswith(": disk full") for line in lines)
    assert [path.name for path in tmp_path.iterdir()] == ["a.h5"]


@pytest.mark.parametrize("length", [249, 260])
def test_a_name_that_is_too_long(here, length):
    """Longer than the system takes, and such that only NAME.partial is."""
    vibsim.simulate(vibsim.load_case("II-B", {"t_end": "1 s"})).save("a.h5")
    for words, suffix in (("plot a.h5 --kind motor -o", ".png"), ("run II-B --t-end 1s -o", ".hdf5")):
        name = "x" * (length - len(suffix)) + suffix
        done = call(*words.split(), name)
        assert (done.exit_code, done.stderr) == (6, f"Error: {name}: cannot write: File name too long\n")
