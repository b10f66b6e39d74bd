"""From a path, a shipped name or standard input to a case."""

from collections.abc import Mapping
from os import PathLike, fspath

from vibsim.cases.case import Case
from vibsim.cases.file_tree import read_tree
from vibsim.cases.overrides import apply_overrides
from vibsim.cases.sources import case_name_from, find_source
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
    found = find_source(fspath(source))
    tree = read_tree(found)
    tree.values.setdefault("name", case_name_from(found.stem))
    apply_overrides(tree, overrides or {})
    return Case(validated(tree), found.text, found.shown)
