"""The table of measured numbers on file, section by section, so that nothing is measured twice.

A section carries the fingerprint of what it was measured from: cases, settings and version. One whose
fingerprint is right is taken as it stands, whoever wrote it; the others are measured again.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from hashlib import sha256
from pathlib import Path
from typing import Any

from vibsim import __version__
from vibsim.files.output_file import output_file

Numbers = dict[str, Any]

MEASURES = 4  # goes up when what is measured of the same runs changes


class NumbersFile:
    """Sections by name in a JSON file, written whenever one is added.

    path : the file; one that is there and readable is taken up, unless `fresh`
    """

    def __init__(self, path: Path, fresh: bool = False):
        self.path = path
        self._stored = {} if fresh else _read(path)
        self.sections: dict[str, Any] = {}

    def section(self, name: str, made_of: object, measure: Callable[[], Any]) -> Any:
        """The section `name`: as stored where it was made of the same, else measured and stored."""
        print_of = fingerprint(made_of)
        stored = self._stored.get(name)
        if isinstance(stored, Mapping) and stored.get("fingerprint") == print_of and "numbers" in stored:
            self.sections[name] = stored["numbers"]
        else:
            self.sections[name] = measure()
            self._stored[name] = {"fingerprint": print_of, "numbers": self.sections[name]}
            self._write()
        return self.sections[name]

    def _write(self) -> None:
        with output_file(self.path, force=True, encoding="utf-8") as file:
            file.write(json.dumps(self._stored, indent=1, allow_nan=False, ensure_ascii=False) + "\n")


def fingerprint(made_of: object) -> str:
    """Of anything that JSON can hold, and of this version of vibsim and of what it measures."""
    text = json.dumps([__version__, MEASURES, made_of], sort_keys=True, default=str)
    return sha256(text.encode()).hexdigest()


def _read(path: Path) -> dict[str, Any]:
    """The sections on file; none where the file is missing or not one of these."""
    try:
        stored = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return stored if isinstance(stored, dict) else {}
