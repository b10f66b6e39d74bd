"""Packages that vibsim does without until something asks for them."""

from importlib import import_module
from typing import Any


class MissingExtra(ImportError):
    """A package that is not installed; the message names the extra of vibsim that brings it.

    >>> import vibsim
    >>> try:
    ...     table = vibsim.simulate("I-A", overrides={"t_end": "1 s"}).to_dataframe()
    ... except vibsim.MissingExtra as missing:
    ...     print(missing)
    """


def extra(package: str, name: str) -> Any:
    """The package, imported. Raises MissingExtra that names the extra `name`, which brings it."""
    try:
        return import_module(package)
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] != package.partition(".")[0]:
            raise  # the package is there, and one that it needs is not
        raise MissingExtra(
            f"this needs {package}, which is not installed: pip install 'vibsim[{name}]'"
        ) from None
