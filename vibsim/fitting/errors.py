"""What can be wrong with the wishes for a fit."""


class FitError(ValueError):
    """Statements, ranges or settings that cannot be used; the message says which, and what is allowed.

    >>> import vibsim
    >>> try:
    ...     vibsim.fit("II-B", {"c": "0.05:0 N s/m"}, ["mean_speed > 4 Hz"])
    ... except vibsim.FitError as error:
    ...     print(error)
    c=0.05:0 N s/m: a range must rise, got 0.05 to 0
    """


class Interrupted(Exception):
    """The user has asked to stop; what was finished is on file."""
