"""What can be wrong with the wishes for a fit."""


class FitError(ValueError):
    """Statements, ranges or settings that cannot be used; the message says which, and what is allowed."""


class Interrupted(Exception):
    """The user has asked to stop; what was finished is on file."""
