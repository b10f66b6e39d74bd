"""Pages of the gallery: their equations, their second pictures, and what they say to try."""

import re
import shlex

import pytest

from from_code.gallery import draw
from from_code.gallery_equations import equations
from from_code.gallery_studies import STUDIES
from tests.command_line.made import call
from vibsim import load_case
from vibsim.cases.sources import gallery_case_names
from vibsim.plots.registry import kind_named

CASES = [name.partition("/")[2] for name in gallery_case_names()]


def formulas(name):
    return re.findall(r"\$\$\n(.*)\n\$\$", equations(load_case(f"gallery/{name}").text))


def test_every_case_has_a_study():
    assert sorted(STUDIES) == CASES
    for study in STUDIES.values():
        assert kind_named(study.kind) and study.shows and study.tries


@pytest.mark.parametrize("name", CASES)
def test_equations_name_every_part(name):
    """One for each body, and every stop and friction stands in two: its own, and that of a body."""
    case = load_case(f"gallery/{name}")
    lines = formulas(name)
    accelerations = [line for line in lines if re.search(r"^\(?[mJ].*\\ddot\{(x|\\theta)\}", line)]
    assert len(accelerations) >= len(case.scene().bodies) - 2  # ground and base
    for section, letter in (("stops", "F"), ("friction", "R")):
        parts = re.search(rf"(?ms)^{section}:\n(.*?)^(?=\S)", case.text)
        for part in re.findall(r"(?m)^  (\w+):", parts[1] if parts else ""):
            symbol = f"{letter}_{{\\text{{{part.replace('_', ' ')}}}}}"
            assert sum(symbol in line for line in lines) >= 2, symbol
    for line in lines:
        assert line.count("{") == line.count("}") and "None" not in line


@pytest.mark.parametrize(
    ("name", "line"),
    [
        ("duffing-two-well",
         r"m\,\ddot{x} = - \left(k_{3}\,x^{3} - k\,x + c\,\dot{x}\right) + A \sin\omega t"),
        ("impact-oscillator", r"m\,\ddot{x} = - k\,x - F_{\text{wall}} + A \cos\omega t"),
        ("impact-pair", r"m\,\ddot{x} = F_{\text{left}} - F_{\text{right}}"),
        ("chain-with-gaps", r"m_{\text{two}}\,\ddot{x}_{\text{two}} = F_{\text{gap 1}} - F_{\text{gap 2}}"),
        ("captured-motor",
         r"(J + m_3 e^2)\,\ddot{\varphi} = m_3 e\,\ddot{x}_{1} \sin{\varphi} + K_{\text{t}}\,i"),
        ("dc-motor-start", r"J\,\ddot{\theta} = \left(k\,i\right) + \left(\left\{0 \;\text{if } t < t_{1},\; "
         r"\text{else } -T\right\}\right)"),
    ],
)  # fmt: skip
def test_equations_are_those_of_the_case(name, line):
    """Worked out by hand from the case files and docs/equations.md."""
    assert line in formulas(name)


@pytest.mark.parametrize("name", CASES)
def test_what_is_said_to_try_runs(name, tmp_path):
    for options, _ in STUDIES[name].tries:
        out = ("-o", tmp_path / "try.h5", "--force")
        done = call("run", f"gallery/{name}", *shlex.split(options), "--t-end", "0.02s", "-q", *out)
        assert done.exit_code == 0, done.output


def test_a_case_is_drawn(tmp_path):
    draw("three-balls", tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {
        f"three-balls{part}.png" for part in ("", "-machine", "-study")
    }
