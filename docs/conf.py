"""Sphinx settings of the site; `make docs` builds it, and takes warnings for errors.

Pages under docs/generated/ are written here, before the sources are read: from_code/ says what from.
"""

import re
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from from_code import write_pages
from from_code.mathml import setup_mathml
from vibsim import __version__

project = "vibsim"
author = copyright = "The vibsim developers"
version = release = __version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
myst_enable_extensions = ["dollarmath", "deflist", "colon_fence"]
myst_heading_anchors = 3
exclude_patterns = ["from_code/*"]
smartquotes = False  # --set is an option, not a dash
highlight_language = "none"

autodoc_typehints = "none"
autodoc_member_order = "bysource"
napoleon_google_docstring = False
napoleon_use_rtype = False

html_math_renderer = "mathml"
html_theme = "furo"
html_title = f"vibsim {release}"
html_theme_options = {"sidebar_hide_name": False}
html_copy_source = False


def as_rest(app, what, name, obj, options, lines):
    """Docstrings are plain text: |x| is a magnitude, and `Orbit`s a plural."""
    for i, line in enumerate(lines):
        if not line.lstrip().startswith((">>>", "...")):
            lines[i] = re.sub(r"`(\w+)`(?=\w)", r"``\1``\\ ", line).replace("|", r"\|")


def end_lists(app, what, name, obj, options, lines):
    """End lists of parameters before a paragraph that names none: napoleon waits for two blank lines."""
    for i in range(len(lines) - 1, 0, -1):
        heads_section = i + 1 < len(lines) and lines[i + 1].startswith("---")
        begins = not lines[i - 1] and lines[i][:1].strip()
        if begins and not heads_section and (" : " not in lines[i] or lines[i].startswith(">>>")):
            lines.insert(i, "")


def setup(app):
    """Write the generated pages when the build begins."""
    app.connect("builder-inited", lambda app: write_pages(Path(app.srcdir)))
    setup_mathml(app)
    app.connect("autodoc-process-docstring", as_rest)
    app.connect("autodoc-process-docstring", end_lists, priority=400)  # before napoleon, which has 500
