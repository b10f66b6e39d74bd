"""What can go wrong with a result file, said in one line."""

import os

from vibsim.files.disk_space import DISK_FULL


class ResultFileError(Exception):
    """A file that cannot be read or written: missing, foreign, damaged, too new, in the way, disk full.

    >>> import vibsim
    >>> try:
    ...     vibsim.open_result("none.h5")
    ... except vibsim.ResultFileError as error:
    ...     print(error)
    none.h5: No such file or directory
    """


def reason(error: BaseException) -> str:
    """The cause of an error in one line, without errno numbers and paths."""
    number = getattr(error, "errno", None)
    if number in DISK_FULL:
        return "disk full"
    said = error.args[0] if isinstance(error, KeyError) and error.args else error  # str() quotes a key
    text = os.strerror(number) if number else str(said) or type(error).__name__
    return text.strip().splitlines()[0]
