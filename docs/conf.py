"""Sphinx settings of the site; `make docs` builds it, and takes warnings for errors.

Pages under docs/generated/ are written here, before the sources are read: from_code/ says what from.
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from from_code import write_pages
from from_code.docstrings import setup_docstrings
from from_code.layout import setup_layout
from from_code.mathml import setup_mathml
from from_code.page_runs import setup_page_runs
from vibsim import __version__

project = "vibsim"
author = copyright = "The vibsim developers"
version = release = __version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
myst_enable_extensions = ["dollarmath", "deflist", "colon_fence"]
myst_heading_anchors = 3
exclude_patterns = ["from_code/*", "article/*"]
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
html_static_path = ["_static"]


def setup(app):
    """Write the generated pages when the build begins."""
    app.connect("builder-inited", lambda app: write_pages(Path(app.srcdir)))
    setup_mathml(app)
    setup_docstrings(app)
    setup_page_runs(app)
    setup_layout(app)
