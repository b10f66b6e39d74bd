"""The written pages, README and those under docs/, and the code blocks in them."""

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
README = ROOT / "README.md"
WRITTEN = sorted(path for path in DOCS.rglob("*.md") if "generated" not in path.parts)
PAGES = [README, *WRITTEN]


def name_of(path):
    """A page's path from the top of the repository."""
    return str(path.relative_to(ROOT))


def blocks(path, language):
    """The code blocks of a language on a page, in order."""
    return re.findall(rf"```{language}\n(.*?)```", path.read_text(encoding="utf-8"), flags=re.DOTALL)


def commands(path):
    """(command, lines of output) of all console blocks of a page, in order."""
    pairs = []
    for line in "".join(blocks(path, "console")).splitlines():
        if line.startswith("$ "):
            pairs.append((line[2:].split("  #")[0].strip(), []))
        else:
            pairs[-1][1].append(line)
    return pairs


def files(path):
    """Name and text of the files that a page shows: YAML blocks whose first line is a comment with a name."""
    named = (re.match(r"# (\S+\.yaml)\n", text) for text in blocks(path, "yaml"))
    return {match[1]: match.string for match in named if match}
