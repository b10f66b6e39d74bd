"""What a user can get wrong about a picture."""


class PlotError(Exception):
    """One line, ready to print: an unknown or unfit kind, a window outside the run, an unknown suffix.

    >>> import vibsim
    >>> try:
    ...     vibsim.plot("II-B", "phase-portrait")
    ... except vibsim.PlotError as error:
    ...     print(str(error).partition(":")[0])
    unknown kind 'phase-portrait'
    """
