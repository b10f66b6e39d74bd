"""What can go wrong with a result file, said in one line."""


class ResultFileError(Exception):
    """A file that cannot be read or written: missing, foreign, damaged, too new, in the way, disk full.

    >>> import vibsim
    >>> try:
    ...     vibsim.open_result("none.h5")
    ... except vibsim.ResultFileError as error:
    ...     print(error)
    none.h5: No such file or directory
    """
