"""From a path, a shipped name or standard input to a case."""

from collections.abc import Mapping
from os import PathLike, fspath
from pathlib import Path

from vibsim.cases.case import Case
from vibsim.cases.reading.file_tree import read_tree
from vibsim.cases.reading.overrides import apply_overrides
from vibsim.cases.reading.sources import SourceText, case_name_from, decoded, find_source
from vibsim.cases.reading.validation import validated


def load_case(source: Case | str | PathLike[str], overrides: Mapping[str, object] | None = None) -> Case:
    """Read and check a case.

    Parameters
    ----------
    source : path of a YAML file, name of a shipped case, "-" for standard input, or a Case
    overrides : dotted (or unambiguous short) key -> text or number, e.g. {"excitation.Omega0": "6.5 Hz"};
        checked as if the file said so, with "overrides" as the file

    Raises CaseError with every problem found, TypeError for what is neither.

    >>> import vibsim
    >>> vibsim.load_case("II-B", {"Omega0": "6.5 Hz", "run.t_end": "20 s"})
    <Case II-B: 2 bodies, 1 stop, source motor at 6.5 Hz, 20 s>
    """
    if isinstance(source, Case):
        return source.with_values(overrides) if overrides else source
    if not isinstance(source, str | PathLike) or not isinstance(path := fspath(source), str):
        allowed = "a Case, the path of a case file or the name of a shipped case"
        raise TypeError(f"a case must be {allowed}, got {source!r:.60}")
    return _case(find_source(path), overrides or {})


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
