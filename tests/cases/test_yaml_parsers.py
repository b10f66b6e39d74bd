"""Case files are read alike whether PyYAML has libyaml or not."""

import random
from pathlib import Path

import pytest

from vibsim.cases import yaml_nodes
from vibsim.cases.yaml_nodes import BOTH_READ, FAST_PARSER, read_yaml

CASES = Path(__file__).parents[2] / "cases"
TEXTS = [path.read_text(encoding="utf-8") for path in sorted(CASES.rglob("*.yaml"))]
PUT = "abz019 :-.,#'\"[]{}?|>!&*%@`\n\t~=<>_/+\\()$;^\r\x00"

needs_libyaml = pytest.mark.skipif(FAST_PARSER is None, reason="PyYAML was built without libyaml")


def mutant(draw: random.Random) -> str:
    """A few lines of a shipped case, some characters put in, cut out or moved."""
    lines = draw.choice(TEXTS).splitlines(keepends=True)
    begin = draw.randrange(len(lines))
    text = "".join(lines[begin : begin + draw.randrange(1, 14)])
    for _ in range(draw.randrange(6)):
        at, other = draw.randrange(len(text) + 1), draw.randrange(len(text) + 1)
        cut = draw.randrange(4)
        changed = (
            text[:at] + draw.choice(PUT) * draw.choice((1, 1, 2, 3)) + text[at:],
            text[:at] + text[at + cut :],
            text[:at] + text[other : other + 4 * cut] + text[at:],
        )
        text = draw.choice(changed)
    return text


@needs_libyaml
def test_shipped_cases_are_read_by_libyaml(monkeypatch):
    def read(*_):
        raise AssertionError("read by Python")

    monkeypatch.setattr(yaml_nodes.yaml, "SafeLoader", read)
    plain = [text for text in TEXTS if "*" not in text]  # as in formulas, where Python reads
    assert len(plain) > 30
    for text in plain:
        assert BOTH_READ.fullmatch(text) and not read_yaml(text, "case")[1]


@needs_libyaml
@pytest.mark.parametrize("seed", range(4))
def test_what_libyaml_reads_python_reads_alike(seed, monkeypatch):
    draw, texts = random.Random(seed), []
    while len(texts) < 300:
        text = mutant(draw)
        if BOTH_READ.fullmatch(text):
            texts.append(text)
    with_libyaml = [read_yaml(text, "case") for text in texts]
    monkeypatch.setattr(yaml_nodes, "FAST_PARSER", None)
    assert with_libyaml == [read_yaml(text, "case") for text in texts]
    assert sum(not problems for _, problems in with_libyaml) > 100
