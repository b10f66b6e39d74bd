"""The page of exit codes, from the table that the command ends by."""

from from_code.markdown import table, with_code
from vibsim.command_line.errors import EXIT_CODES

HEAD = """# Exit codes

What the process of `vibsim` ends with, for scripts. With `--json` an error is an object on stdout too:
`{"error": {"message": ..., "exit_code": ...}}`.

"""


def page() -> str:
    """The page of exit codes."""
    rows = [(str(code), with_code(text)) for code, text in EXIT_CODES.items()]
    return HEAD + table(("code", "meaning"), rows)
