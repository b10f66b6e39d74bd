"""What can go wrong with a result file, said in one line."""


class ResultFileError(Exception):
    """A file that cannot be read or written: missing, foreign, damaged, too new, in the way, disk full."""
