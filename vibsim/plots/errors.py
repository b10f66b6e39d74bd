"""What a user can get wrong about a picture."""


class PlotError(Exception):
    """One line, ready to print: an unknown or unfit kind, a window outside the run, an unknown suffix."""
