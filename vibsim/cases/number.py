"""Numbers as messages, summaries and pages write them."""

import re

LEADING_ZEROS = re.compile(r"e([+-])0*(?=\d)")


def number(x: float, digits: int) -> str:
    """A number to so many significant digits, its exponent as short as can be: 0.0025, 1e-6, 2.3e8."""
    return LEADING_ZEROS.sub(lambda match: "e" + match[1].removeprefix("+"), f"{x:.{digits}g}")
