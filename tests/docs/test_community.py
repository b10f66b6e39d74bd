"""Files about the project agree with each other: versions, authors, citations of the article."""

import json
import re

import pytest
import yaml

import vibsim
from tests.docs.pages import DOCS, ROOT

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
