"""The page of exit codes, from the table that the command ends by."""

from from_code.markdown import table, with_code
from vibsim.command_line.main import EXIT_CODES

HEAD = """# Exit codes

What the process of `vibsim` ends with, for scripts. With `--json` an error is an object on stdout too:
`{"error": {"message": ..., "exit_code": ...}}`.

Of a file that is not there: 3 where a case is asked for, 6 where a result is. Where either will do, the name
tells: one that ends in .h5 or .hdf5 is a result, any other a case.

"""


def page() -> str:
    """The page of exit codes."""
    rows = [(str(code), with_code(text)) for code, text in EXIT_CODES.items()]
    return HEAD + table(("code", "meaning"), rows)
