"""The modules that write pages from the code live beside the pages."""

import sys

from tests.docs.pages import DOCS

sys.path.insert(0, str(DOCS))
