"""PDF files that hold of their bitmaps what is drawn, and no more.

matplotlib draws the long lines of a picture as bitmaps, each on a sheet of the whole figure (57 MB at 600
dpi), cuts out what is drawn, and holds the cuts, views of their sheets, until the file is finished: half a
gigabyte for nine panels. A copy of a cut lets go of its sheet.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from matplotlib.backends.backend_pdf import PdfFile, PdfPages


class _File(PdfFile):
    """A file that copies bitmaps cut out of others."""

    def imageObject(self, image: Any) -> Any:
        return PdfFile.imageObject(self, image if image.base is None else image.copy())


class LeanPages(PdfPages):
    """Pages of a PDF, used as matplotlib's own."""

    def _ensure_file(self) -> PdfFile:
        if self._file is None:
            make: Callable[..., PdfFile] = _File
            self._file = make(self._filename, metadata=self._metadata)
        file: PdfFile = self._file
        return file
