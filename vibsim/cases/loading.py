"""From a path, a shipped name or standard input to a case."""

from collections.abc import Mapping
from os import PathLike, fspath
from pathlib import Path

from vibsim.cases.case import Case
from vibsim.cases.file_tree import read_tree
from vibsim.cases.overrides import apply_overrides
from vibsim.cases.sources import SourceText, case_name_from, decoded, find_source
from vibsim.cases.validation import validated


def load_case(source: str | PathLike[str], overrides: Mapping[str, object] | None = None) -> Case:
    """Read and check a case.

    Parameters
    ----------
    source : path of a YAML file, name of a shipped case, or "-" for standard input
    overrides : dotted (or unambiguous short) key -> text or number, e.g. {"excitation.Omega0": "6.5 Hz"};
        checked as if the file said so, with "--set" as the file

    Raises CaseError with every problem found.
    """
    return _case(find_source(fspath(source)), overrides or {})


def as_case(source: object) -> Case:
    """A case as it is, or the one that a path or a shipped name names. Raises CaseError, TypeError."""
    if isinstance(source, Case):
        return source
    if isinstance(source, str | PathLike):
        return load_case(source)
    raise TypeError(
        f"a case must be a Case, the path of a case file or the name of a shipped case, got {source!r:.60}"
    )


def load_case_text(text: str, overrides: Mapping[str, object] | None = None, name: str = "case") -> Case:
    """The same from YAML text; `name` stands for the file in messages, and is the case's name by default."""
    return _case(
        SourceText(name, name, decoded(text.encode("utf-8", "replace"), name), Path(), name), overrides or {}
    )


def _case(source: SourceText, overrides: Mapping[str, object]) -> Case:
    tree = read_tree(source)
    tree.values.setdefault("name", case_name_from(source.stem))
    apply_overrides(tree, overrides)
    return Case(validated(tree), source.text, source.shown)
