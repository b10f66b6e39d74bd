"""What an HTML page holds, for the tests to read."""

import base64
import json
import re

import numpy as np


def data_of(path):
    """The data of a page, as its scripts read them."""
    text = path.read_text(encoding="utf-8")
    return json.loads(re.search(r'<script type="application/json" id="data">(.*?)</script>', text, re.S)[1])


def numbers(text, dtype):
    """An array in these data."""
    return np.frombuffer(base64.b64decode(text), f"<{dtype}")
