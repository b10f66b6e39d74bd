"""Whatever is cited is there: links and pictures of pages, and files that code, tests and pages name."""

import json
import re
import subprocess
from functools import cache

import pytest
import yaml

import vibsim
from tests.docs.pages import DOCS, PAGES, ROOT, name_of

LINKING = [*PAGES, ROOT / "CONTRIBUTING.md", *sorted((ROOT / ".github").glob("*.md"))]
LINK = re.compile(r"\]\(([^)\s]+)\)")
OUTSIDE = ("http://", "https://", "mailto:")
# a path with a folder and an ending of a text of ours; `NAME`, `*` and {braces} stand for others
PATH = re.compile(r"(?<![\w./~<{*-])((?:[a-z_]+/)+[A-Za-z0-9_-]+\.(?:md|py|c|h|yaml|json|png))(?![\w*])")
# folders of the repository that a cited path may start in, and what it is then relative to
TOP = ("vibsim", "tests", "docs", "cases", "shared", "notes")
ROOMS = ("physics", "engine", "cases", "files", "results", "sweeps", "analysis", "fitting", "evidence")
ROOMS += ("plots", "command_line", "orbits", "branches")
MADE = ("docs/generated/",)  # by the build of the site
USERS = {"cases/hammer.yaml"}  # what examples of commands call files that a user writes


@cache
def tracked():
    """Files of the repository; all that lie there where git is not."""
    command = ["git", "ls-files", "--cached", "--others", "--exclude-standard"]
    listed = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    if listed.returncode:
        return {str(path.relative_to(ROOT)) for path in ROOT.rglob("*") if path.is_file()}
    return {*listed.stdout.splitlines()}


def texts():
    """Source files and pages that may cite others."""
    endings = (".py", ".c", ".h", ".md", ".yaml", ".toml", ".yml")
    return sorted(
        name for name in tracked() if name.endswith(endings) or name in ("Makefile", ".ci/run", "setup.py")
    )


def test_the_repository_holds_texts_and_pictures():
    """What a compiler leaves behind, whole or empty, is no part of it."""
    contents = {name: (ROOT / name).read_bytes() for name in tracked() if (ROOT / name).is_file()}
    empty = {name for name, content in contents.items() if not content}
    assert {name for name in empty if not name.endswith(("__init__.py", "py.typed"))} == set()
    assert {name for name, content in contents.items() if b"\0" in content and name[-4:] != ".png"} == set()


def cited(text):
    """Paths that a text names as files of this repository."""
    for path in PATH.findall(text):
        first = path.partition("/")[0]
        if first in TOP or (first in ROOMS and path.endswith((".py", ".c", ".h"))):
            yield path


def is_there(path):
    """Whether a path is in the repository, from its top, vibsim/ or tests/; or made, or a placeholder."""
    if path.startswith(MADE) or path in USERS or "NAME" in path:
        return True
    return any(f"{folder}{path}" in tracked() for folder in ("", "vibsim/", "tests/"))


def missing(text):
    """Cited paths that are not in the repository."""
    return sorted({path for path in cited(text) if not is_there(path)})


@pytest.mark.parametrize("path", LINKING, ids=name_of)
def test_links_and_pictures_lead_somewhere(path):
    for target in LINK.findall(path.read_text(encoding="utf-8")):
        file = target.partition("#")[0]
        if target.startswith(OUTSIDE) or not file:
            continue
        place = (path.parent / file).resolve()
        assert place.is_relative_to(DOCS / "generated") or place.is_file(), target


FILE = re.compile(r"`(?:[a-z_]+/)*([A-Za-z0-9_]+\.(?:py|c|h|cpp))`")


@pytest.mark.parametrize("page", ["engine.md", "architecture.md"])
def test_pages_on_the_program_name_source_files_that_are_there(page):
    """By whatever part of their path."""
    names = {path.rpartition("/")[2] for path in tracked()}
    named = FILE.findall((DOCS / page).read_text(encoding="utf-8"))
    assert named and [name for name in named if name not in names] == []


def test_nothing_cites_a_file_that_is_not_in_the_repository():
    faults = {}
    for name in texts():
        if name == "tests/docs/test_references.py":
            continue
        text = (ROOT / name).read_text(encoding="utf-8")
        if absent := missing(text):
            faults[name] = absent
    assert faults == {}


@pytest.mark.parametrize(
    ("text", "absent"),
    [
        ("see shared/physics.md", ["shared/physics.md"]),
        ("see docs/nosuch.md, docs/engine.md", ["docs/nosuch.md"]),
        ("`results/structure.py`", ["results/structure.py"]),
        ("`engine/modes/rows.py` and `physics/parts.py`", []),
    ],
)
def test_what_is_missing_is_found(text, absent):
    assert missing(text) == absent


# Files about the project agree with each other: versions, authors, citations of the article.


FORMS = sorted((ROOT / ".github" / "ISSUE_TEMPLATE").glob("*.yml"))
BIBLIOGRAPHY = (DOCS / "article" / "paper.bib").read_text(encoding="utf-8")
ARTICLE = (DOCS / "article" / "paper.md").read_text(encoding="utf-8")
CITATION = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
CODEMETA = json.loads((ROOT / "codemeta.json").read_text(encoding="utf-8"))


def test_the_version_stands_in_one_place_and_elsewhere_the_same():
    project = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    assert '\ndynamic = ["version"]\n' in project
    assert '\nversion = { attr = "vibsim.__version__" }\n' in project
    assert '\nversion = "' not in project
    assert CITATION["version"] == CODEMETA["version"] == vibsim.__version__


def test_the_authors_of_the_paper_are_not_those_of_the_software():
    names = [author["familyName"] for author in CODEMETA["referencePublication"]["author"]]
    [paper] = CITATION["references"]
    assert [author["family-names"] for author in paper["authors"]] == names
    assert not set(names) & {author.get("family-names") for author in CITATION["authors"]}


def test_the_article_cites_what_its_bibliography_has():
    cited = set(re.findall(r"@(\w+)", ARTICLE.partition("---\n\n")[2]))
    assert cited == set(re.findall(r"^@\w+\{(\w+),", BIBLIOGRAPHY, flags=re.MULTILINE))


@pytest.mark.parametrize("key", re.findall(r"^@\w+\{(\w+),", BIBLIOGRAPHY, flags=re.MULTILINE))
def test_an_entry_of_the_bibliography_is_whole(key):
    entry = re.search(rf"\{{{key},\n(.*?)\n\}}", BIBLIOGRAPHY, flags=re.DOTALL)[1]
    assert {"author", "title", "year"} <= set(re.findall(r"^  (\w+) = ", entry, flags=re.MULTILINE))
    assert entry.count("{") == entry.count("}")


@pytest.mark.parametrize("form", FORMS, ids=lambda path: path.stem)
def test_an_issue_form_can_be_filled_in(form):
    content = yaml.safe_load(form.read_text(encoding="utf-8"))
    if form.stem == "config":
        assert content == {"blank_issues_enabled": True}
    else:
        assert content["name"] and content["description"]
        assert all(item["attributes"]["label"] for item in content["body"])
