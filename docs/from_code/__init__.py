"""Pages of the site that are made from the code, so that they cannot fall behind it."""

from pathlib import Path

from from_code import benchmarks, case_keys, commands, exit_codes, file_format
from from_code.gallery import write_gallery

PAGES = {
    "benchmarks": benchmarks.page,
    "case-keys": case_keys.page,
    "commands": commands.page,
    "exit-codes": exit_codes.page,
    "file-format": file_format.page,
}


def write_pages(docs: Path) -> None:
    """Write all generated pages below docs/generated."""
    folder = docs / "generated"
    folder.mkdir(exist_ok=True)
    for name, page in PAGES.items():
        write_if_changed(folder / f"{name}.md", page())
    write_gallery(folder / "gallery", write_if_changed)


def write_if_changed(path: Path, text: str) -> None:
    """Write a page unless it stands there already: what did not change is not built again."""
    path.parent.mkdir(parents=True, exist_ok=True)
    if not path.exists() or path.read_text(encoding="utf-8") != text:
        path.write_text(text, encoding="utf-8")
