"""PDF files let go of the sheets on which their bitmaps were drawn, and are byte for byte matplotlib's."""

from io import BytesIO

import numpy as np
from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.figure import Figure

from vibsim.plots.sheet import LeanPages

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
