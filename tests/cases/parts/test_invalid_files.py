"""Every file in invalid/ gives exactly the problems that its first lines expect, all of them and no other."""

from pathlib import Path

import pytest

from tests.cases.test_invalid_files import expected_problems, problems_of

FOLDER = Path(__file__).parent / "invalid"
FILES = sorted(path.name for path in FOLDER.glob("*.yaml"))


@pytest.mark.parametrize("name", FILES)
def test_invalid_file_gives_its_problems(name, monkeypatch):
    monkeypatch.chdir(FOLDER)
    lines = [line.removeprefix(f"{name}:") for line in problems_of(name)]
    assert lines == expected_problems(FOLDER / name)


def test_each_invalid_file_expects_something():
    assert len(FILES) >= 20
    assert all(expected_problems(FOLDER / name) for name in FILES)


@pytest.mark.parametrize(
    ("overrides", "lines"),
    [
        ({"stops.anvil.k": "0 N/m"}, ["overrides stops.anvil.k: must be > 0, got 0 N/m"]),
        (
            {"stops.anvli.k": "1 N/m"},
            ["overrides stops.anvli.k: unknown key (did you mean stops.anvil.k?); "
             "a key is written like stops.wall.k or run.t_end"],
        ),
        (
            {"anvil.kk": "1 N/m"},
            ["overrides anvil.kk: unknown key (did you mean stops.anvil.k?); "
             "a key is written like stops.wall.k or run.t_end"],
        ),
        (
            {"excitation.omega": "1 Hz"},
            ["overrides excitation.omega: unknown key (did you mean forces.drive.omega?); "
             "a key is written like stops.wall.k or run.t_end"],
        ),
        (
            {"forces.chord.terms.3.A": "1 N"},
            ["overrides forces.chord.terms.3.A: unknown key (did you mean forces.chord.terms.2.A?); "
             "a key is written like stops.wall.k or run.t_end"],
        ),
        (
            {"mu": "0.3"},
            ["overrides mu: is short for several keys: friction.guide.mu, friction.weight.mu, "
             "friction.moon.plus.mu, friction.moon.minus.mu, friction.smooth.mu"],
        ),
        (
            {"links.spring.between": "[ram, tol]"},
            ["overrides links.spring.between: no body tol (did you mean tool?); "
             "allowed: ram, tool, ground, base"],
        ),
        ({"stops.anvil": "off"}, ["overrides stops.anvil: must be a mapping of between, gap, acts, law, "
                                  "k, c, release, e, force, or none; got off"]),
        ({"stops.anvil.e": "0.5"}, ["overrides stops.anvil.e: belongs to law: rigid; "
                                    "this stop has law: elastic"]),
        ({"run.method": "closed_form"}, ["overrides run.method: a motor has no closed form; with one, "
                                         "run.method must be auto or taylor, got closed_form"]),
    ],
)  # fmt: skip
def test_problems_of_overrides(overrides, lines):
    assert problems_of(FOLDER.parent / "valid/hammer.yaml", **overrides) == lines
